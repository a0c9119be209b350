"""What the rest of the cell may ask of a robot arm."""

from __future__ import annotations

from typing import Literal, Protocol

from cellctl.assembly import Value
from cellctl.config import Joints, Pose, Vector


class Waypoint(Value):
    """One corner of a path, reached on a straight line of the TCP. Speeds hold on the way to it;
    the blend radius rounds it."""

    pose: Pose
    """TCP pose in the robot's base frame."""
    speed_m_s: float
    acceleration_m_s2: float
    blend_radius_m: float = 0.0
    """0 stops at the corner; the last waypoint of a path always stops."""


class JointWaypoint(Value):
    """One corner of a path to which the joints go straight, all at once. The controller finds the
    joints for the pose by its own calibrated kinematics, near to where they are."""

    pose: Pose
    """TCP pose in the robot's base frame."""
    speed_rad_s: float
    """Of the joint that turns farthest, on the way there."""
    acceleration_rad_s2: float
    blend_radius_m: float = 0.0
    """Measured at the TCP; 0 stops at the corner."""


Path = tuple[Waypoint | JointWaypoint, ...]
"""Corners in turn, all of one kind: from one kind to the other there is no blend."""


class ArmIdentity(Value):
    """What the robot says it is, read back after connecting."""

    model: Literal["ur10", "ur10e"]
    controller_version: str
    serial_number: str = ""


class ArmCheck(Value):
    """What the robot has set, read back while it stands still."""

    identity: ArmIdentity
    tcp: Pose
    """TCP in the flange frame."""
    payload_kg: float
    payload_cog_m: Vector
    """In the flange frame."""
    tool_voltage_v: int
    """Supply of the tool's connector."""
    safety_mode: str
    """``normal`` where the robot may move as planned."""
    digital_outputs: int
    """Bits 0-7: the standard outputs."""


class ArmState(Value):
    """The newest thing the robot said about itself."""

    robot_time_s: float
    """The controller's own clock: cell time, on real and emulated robots alike."""
    joints_rad: Joints
    tcp_pose: Pose
    tcp_speed_m_s: float
    tcp_force_n: Vector
    """What acts on the tool from outside, in the base frame: measured by an e-Series, reckoned from
    the joints' currents by a CB3."""
    tcp_lag_m: Vector = (0.0, 0.0, 0.0)
    """From where the controller wants the TCP to where it is, in the base frame."""
    moving: bool
    program_running: bool
    safety: Literal["normal", "protective", "safeguard", "emergency", "fault"]
    powered: bool
    digital_inputs: int
    """Bits 0-7: the standard inputs."""
    digital_outputs: int
    speed_fraction: float = 1.0
    """Where somebody put the speed slider."""

    @property
    def told_pose(self) -> Pose:
        """Where the controller wants the TCP; not quite where it is if something is in the way."""
        at = [here - lag for here, lag in zip(self.tcp_pose[:3], self.tcp_lag_m, strict=True)]
        return (at[0], at[1], at[2], *self.tcp_pose[3:])


class Switch(Value):
    """A standard digital output that is switched when a movement is all but at its end."""

    line: int
    high: bool
    within_m: float
    """Of the end of the path, in a straight line."""


class Arm(Protocol):
    """A robot arm. Every method raises ``CellFault`` with a code of the catalogue."""

    @property
    def identity(self) -> ArmIdentity | None:
        """What the connected robot says it is."""
        ...

    @property
    def checked(self) -> ArmCheck | None:
        """What was last read back by ``verify``, whether or not it was as it should be."""
        ...

    async def connect(self) -> ArmIdentity:
        """Connect, check the model, set TCP and payload and read them back; safe to repeat."""
        ...

    async def verify(self) -> ArmCheck:
        """Read back, at rest, everything that the configuration and past orders have set, and
        compare: model, serial number and software, TCP, payload, tool voltage, safety mode and
        every digital output that was ordered. Moves and changes nothing; takes less than 0.3 s.

        Raises ``robot_mismatch``, which says what is and what should be.
        """
        ...

    def state(self) -> ArmState | None:
        """The newest state; None before the first one arrived. Never blocks."""
        ...

    async def follow(
        self, path: Path, planned_duration_s: float, switch: Switch | None = None
    ) -> None:
        """Move the TCP along a path and return when the arm has come to rest at its end.

        Args:
            path: where to go.
            planned_duration_s: how long that should take.
            switch: what is switched on the way. A movement that ends early may have switched it, or
                not: the outputs tell.
        """
        ...

    async def prepare(self, path: Path) -> None:
        """Have a path ready at the controller, so that ``follow`` with the same path begins at
        once. Moves nothing; a stop or another movement drops it."""
        ...

    async def move_joints(self, target_rad: Joints, speed_rad_s: float) -> None:
        """Move in joint space, for homing; returns when at rest."""
        ...

    async def stop(self) -> None:
        """Brake now; returns when at rest. A ``follow`` under way raises ``CancelledError``."""
        ...

    async def set_output(self, line: int, high: bool) -> None:
        """Switch one standard digital output; returns when the controller shows it."""
        ...

    async def wait_input(self, line: int, high: bool, timeout_s: float) -> bool:
        """Wait until a standard digital input has that level; False on time-out (cell time)."""
        ...

    async def recover(self) -> None:
        """Leave a stop of the robot's own: close popups, unlock, power on, release brakes and
        start the control program again. Moves nothing."""
        ...

    async def close(self) -> None:
        """Let go of the robot; a moving arm is stopped first."""
        ...
