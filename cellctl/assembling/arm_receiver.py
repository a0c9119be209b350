"""What the robot's controller says of itself, through ur_rtde. Lives in the arm process only.

After a lost connection ur_rtde's getters return the last values for ever, and ``isConnected`` is
not to be trusted; only a controller time that advances is.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import rtde_receive

from cellctl.assembling.arm import ArmState
from cellctl.config import Joints, Pose, RobotSection, Vector
from cellctl.errors import CellFault

PLAYING = 2
"""``runtime_state`` of a running program."""
STOPPED = 1
RUNNING = 7
"""``robot_mode`` of an arm with power on and brakes released."""
REST_M_S = 0.002
GATE_OPEN_FRACTION = 0.01
"""A speed slider below this is the gate, not somebody's choice: the pendant's ends at 1 %."""
_LOST_AFTER_S = 1.0
"""A controller time that stands still for so long (wall time) means a lost controller."""
_POLL_S = 0.005
_READ_AGAIN = 3

_VARIABLES = [
    "timestamp",
    "actual_q",
    "actual_qd",
    "actual_TCP_pose",
    "actual_TCP_speed",
    "actual_TCP_force",
    "target_TCP_pose",
    "actual_digital_input_bits",
    "actual_digital_output_bits",
    "robot_mode",
    "runtime_state",
    "safety_status_bits",
    "target_speed_fraction",
    "payload",
    "payload_cog",
    "safety_mode",
]

_SAFETY_MODES = {
    1: "normal",
    2: "reduced",
    3: "protective stop",
    4: "recovery",
    5: "safeguard stop",
    6: "system emergency stop",
    7: "robot emergency stop",
    8: "violation",
    9: "fault",
}
"""RTDE's ``safety_mode``."""
_PROTECTIVE, _SAFEGUARD = 1 << 2, 1 << 4
_EMERGENCY = 1 << 5 | 1 << 6 | 1 << 7
VIOLATION = 1 << 8 | 1 << 9


class Sample(NamedTuple):
    """One state of the controller."""

    robot_time_s: float
    joints_rad: Joints
    joint_speed_rad_s: float
    """Of the fastest joint."""
    tcp_pose: Pose
    tcp_speed_m_s: float
    tcp_force_n: Vector
    told_pose: Pose
    """Where the controller wants the TCP."""
    inputs: int
    outputs: int
    robot_mode: int
    runtime_state: int
    safety_bits: int
    speed_fraction: float

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves."""
        return self.tcp_speed_m_s < REST_M_S and self.joint_speed_rad_s < REST_M_S

    def state(self, chosen_fraction: float) -> ArmState:
        """In the words of the rest of the cell.

        Args:
            chosen_fraction: where somebody put the speed slider, for while a path waits and this
                cell holds it at 0.
        """
        held = self.speed_fraction < GATE_OPEN_FRACTION
        safety = "normal"
        for bits, name in (
            (_PROTECTIVE, "protective"),
            (_SAFEGUARD, "safeguard"),
            (VIOLATION, "fault"),
            (_EMERGENCY, "emergency"),
        ):
            if self.safety_bits & bits:
                safety = name
        return ArmState(
            robot_time_s=self.robot_time_s,
            joints_rad=self.joints_rad,
            tcp_pose=self.tcp_pose,
            tcp_speed_m_s=self.tcp_speed_m_s,
            tcp_force_n=self.tcp_force_n,
            tcp_lag_m=self._lag_m(),
            moving=not self.at_rest,
            program_running=self.runtime_state == PLAYING,
            safety=safety,  # type: ignore[arg-type]  # one of the names above
            powered=self.robot_mode == RUNNING,
            digital_inputs=self.inputs & 0xFF,
            digital_outputs=self.outputs & 0xFF,
            speed_fraction=chosen_fraction if held else self.speed_fraction,
        )

    def _lag_m(self) -> Vector:
        x, y, z = (self.tcp_pose[i] - self.told_pose[i] for i in range(3))
        return (x, y, z)


def safety_fault(sample: Sample) -> CellFault | None:
    """The stop of the robot's own that a sample shows, the strongest first."""
    bits = sample.safety_bits
    if bits & _EMERGENCY:
        return CellFault("emergency_stop")
    if bits & VIOLATION:
        return CellFault("protective_stop", "The controller reports a safety violation or fault.")
    if bits & _PROTECTIVE:
        return CellFault("protective_stop")
    if bits & _SAFEGUARD:
        return CellFault("safeguard_stop")
    return None


class Receiver:
    """The controller's state.

    Args:
        robot: which controller.

    Raises:
        CellFault: ``robot_lost``.
    """

    def __init__(self, robot: RobotSection) -> None:
        try:
            self._receive: Any = rtde_receive.RTDEReceiveInterface(
                robot.host, float(robot.rtde_frequency_hz), _VARIABLES
            )
        except RuntimeError as error:
            raise CellFault("robot_lost", f"No state from {robot.host}: {error}.") from error
        self._changed_at_s = time.monotonic()
        self.sample = self._read()

    def refresh(self) -> Sample:
        """Take the newest state.

        Raises:
            CellFault: ``robot_lost``, when the controller's time stands still.
        """
        before, self.sample = self.sample, self._read()
        now_s = time.monotonic()
        if self.sample.robot_time_s != before.robot_time_s:
            self._changed_at_s = now_s
        elif now_s - self._changed_at_s > _LOST_AFTER_S:
            raise CellFault("robot_lost", f"No new state for {_LOST_AFTER_S:.0f} s.")
        return self.sample

    def wait(self, wanted: Callable[[Sample], bool], timeout_s: float) -> bool:
        """Wait, without kicking any watchdog, for a state; False on time-out (wall time).

        Raises:
            CellFault: ``robot_lost``.
        """
        deadline_s = time.monotonic() + timeout_s
        while not wanted(self.refresh()):
            if time.monotonic() > deadline_s:
                return False
            time.sleep(_POLL_S)
        return True

    def payload_kg(self) -> float:
        """The payload that the controller reckons with."""
        return float(self._receive.getPayload())

    def payload_cog_m(self) -> Vector:
        """Its centre of gravity in the flange frame."""
        x, y, z = self._receive.getPayloadCog()
        return (x, y, z)

    def safety_mode(self) -> str:
        """In words; a number that is not known stays a number."""
        number = int(self._receive.getSafetyMode())
        return _SAFETY_MODES.get(number, str(number))

    def _read(self) -> Sample:
        """One state. The library takes in packets meanwhile: what was read across two of them is
        read again, for the arm may not seem to be off its target by what it moved in between."""
        for _ in range(_READ_AGAIN):
            before_s = self._receive.getTimestamp()
            sample = self._read_once(before_s)
            if self._receive.getTimestamp() == before_s:
                break
        return sample

    def _read_once(self, robot_time_s: float) -> Sample:
        receive = self._receive
        return Sample(
            robot_time_s=robot_time_s,
            joints_rad=_six(receive.getActualQ()),
            joint_speed_rad_s=max(abs(speed) for speed in receive.getActualQd()),
            tcp_pose=_six(receive.getActualTCPPose()),
            tcp_speed_m_s=sum(v * v for v in receive.getActualTCPSpeed()[:3]) ** 0.5,
            tcp_force_n=_six(receive.getActualTCPForce())[:3],
            told_pose=_six(receive.getTargetTCPPose()),
            inputs=receive.getActualDigitalInputBits(),
            outputs=receive.getActualDigitalOutputBits(),
            robot_mode=receive.getRobotMode(),
            runtime_state=receive.getRuntimeState(),
            safety_bits=receive.getSafetyStatusBits(),
            speed_fraction=receive.getTargetSpeedFraction(),
        )


def _six(values: Sequence[float]) -> tuple[float, float, float, float, float, float]:
    a, b, c, d, e, f = values
    return (a, b, c, d, e, f)
