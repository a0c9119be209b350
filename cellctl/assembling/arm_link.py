"""The robot's controller, through ur_rtde. Lives in the arm process only.

ur_rtde is not made for what a cell needs when things go wrong, so this module keeps to a narrow
path through it (version 1.6.5):

- One thread uses it, with asynchronous movements only: commands from two threads erase each other,
  and a blocking movement cannot be stopped or watched.
- After a lost connection its objects are broken for good (endless reconnects, stale values, an
  abort at exit), so they are never repaired: the process ends without running their destructors.
- ``stopL`` is used asynchronously only: its synchronous form brakes the joints, not the line.
- A path call waits for the program without a time limit, and a constructor for up to 5 s, holding
  the interpreter. The daemon watches the arm process and kills it if it does not come back.

The gate
--------
A path movement uploads a new program. The upload drops the controller's watchdog, and the program
moves before the client can arm it again: whoever is killed in that gap leaves an arm that goes on
to the end of its path. So every path starts behind a gate, the speed slider. It is put to 0 and
seen there by the controller, then the path is uploaded and started, which moves nothing; then the
watchdog is armed and kicked; and only then does the slider go back to where it was. Whoever dies
before leaves an arm at rest; whoever dies after leaves one that the watchdog stops.
"""

from __future__ import annotations

import time
from collections.abc import Generator
from typing import Any

import rtde_control
import rtde_io

from cellctl.assembling.arm import ArmCheck, ArmIdentity, JointWaypoint, Path
from cellctl.assembling.arm_receiver import (
    GATE_OPEN_FRACTION,
    PLAYING,
    Receiver,
    Sample,
    safety_fault,
)
from cellctl.config import Joints, Pose, RobotSection, Vector
from cellctl.errors import CellFault

STOP_DECELERATION_M_S2 = 3.0
"""For a stop on request; from 1 m/s it takes 0.17 m."""
_KICK_PERIOD_S = 0.02
_GATE_TIMEOUT_S = 1.0
"""For the controller to show the speed slider (wall time)."""
_OUTPUT_TIMEOUT_S = 1.0
_READ_BACK_TIMEOUT_S = 1.0
_PROGRAM_GRACE_S = 0.1
"""A stop's safety bits may follow this much later than the program's end (wall time)."""
JOINT_ACCELERATION_RAD_S2 = 1.0
READ_BACK_TOLERANCE = 1e-4
"""TCP (m, rad) and payload (kg, m) read back may differ by rounding only."""


class Link:
    """A connected controller with the control program running.

    Args:
        robot: which controller.
        receiver: its state.
        speed_fraction: where the speed slider goes if it is found at 0.

    Raises:
        CellFault: ``local_control``, ``robot_lost`` or ``program_stopped``.
    """

    def __init__(self, robot: RobotSection, receiver: Receiver, speed_fraction: float) -> None:
        self._robot = robot
        self._receiver = receiver
        found = receiver.sample.speed_fraction
        self.speed_fraction = found if found >= GATE_OPEN_FRACTION else speed_fraction
        self._kicked_at_s = 0.0
        self._longest_pause_s = 0.0
        self._not_playing_since_s: float | None = None
        self.prepared: Path | None = None
        """The path that waits behind the closed gate."""
        try:
            self._io: Any = rtde_io.RTDEIOInterface(robot.host)
            self._control: Any = rtde_control.RTDEControlInterface(
                robot.host, float(robot.rtde_frequency_hz)
            )
        except RuntimeError as error:
            raise _refusal(error) from error

    @property
    def sample(self) -> Sample:
        """The newest state."""
        return self._receiver.sample

    def describe_tool(self, tcp: Pose, payload_kg: float, cog_m: Vector) -> None:
        """Set TCP and payload and read them back.

        Raises:
            CellFault: ``robot_mismatch``.
        """
        self._control.setTcp(list(tcp))
        read_tcp = self._control.getTCPOffset()
        if len(read_tcp) != 6 or max(map(abs, map(_minus, read_tcp, tcp))) > READ_BACK_TOLERANCE:
            raise CellFault("robot_mismatch", f"TCP set to {list(tcp)}, read back {read_tcp}.")
        self._control.setPayload(payload_kg, list(cog_m))
        wanted = [payload_kg, *cog_m]
        if not self._receiver.wait(
            lambda _: max(map(abs, map(_minus, self._payload(), wanted))) < READ_BACK_TOLERANCE,
            _READ_BACK_TIMEOUT_S,
        ):
            raise CellFault(
                "robot_mismatch",
                f"Payload and its centre set to {wanted} (kg, m), read back {self._payload()}.",
            )

    def _payload(self) -> list[float]:
        return [self._receiver.payload_kg(), *self._receiver.payload_cog_m()]

    def read_back(self, identity: ArmIdentity, tool_voltage_v: int) -> ArmCheck:
        """What the controller has set, beside what others found out.

        Raises:
            CellFault: ``robot_lost`` when it does not tell its TCP.
        """
        # The only question here that the control program answers: some controllers' state does
        # not have the TCP.
        tcp = self._control.getTCPOffset()
        if len(tcp) != 6:
            raise CellFault("robot_lost", "The controller does not tell its TCP.")
        x, y, z, rx, ry, rz = tcp
        return ArmCheck(
            identity=identity,
            tcp=(x, y, z, rx, ry, rz),
            payload_kg=self._receiver.payload_kg(),
            payload_cog_m=self._receiver.payload_cog_m(),
            tool_voltage_v=tool_voltage_v,
            safety_mode=self._receiver.safety_mode(),
            digital_outputs=self.sample.outputs & 0xFF,
        )

    def guard(self) -> None:
        """Arm the controller's watchdog, which a program upload drops, and kick it."""
        self._control.setWatchdog(self._robot.watchdog_hz)
        self._kicked_at_s = time.monotonic()
        self._longest_pause_s = 0.0
        # What was seen of the program before its upload means nothing any more.
        self._not_playing_since_s = None
        self._kick(self._kicked_at_s)

    def tick(self) -> Sample:
        """Take the newest state, and kick the watchdog when it is time.

        Raises:
            CellFault: ``robot_lost``.
        """
        sample = self._receiver.refresh()
        now_s = time.monotonic()
        if sample.runtime_state == PLAYING:
            self._not_playing_since_s = None
        elif self._not_playing_since_s is None:
            self._not_playing_since_s = now_s
        # On a busy computer the newest state may still be from before an upload has ended: a
        # program counts as ended, and is fed no more, only when it is seen so for a while.
        if now_s - self._kicked_at_s >= _KICK_PERIOD_S and not self.ended:
            self._kick(now_s)
        return sample

    @property
    def ended(self) -> bool:
        """Whether no program runs at the controller any more."""
        since_s = self._not_playing_since_s
        return since_s is not None and time.monotonic() - since_s > _PROGRAM_GRACE_S

    def check(self) -> None:
        """Raise what keeps the arm from moving.

        Raises:
            CellFault: a stop of the robot's own, or ``program_stopped``.
        """
        if (fault := safety_fault(self.sample)) is not None:
            raise fault
        if self.ended:
            raise CellFault(
                "program_stopped",
                f"The longest pause in feeding its watchdog was {self._longest_pause_s:.3f} s.",
            )

    def close_gate(self) -> Generator[None, None, None]:
        """Put the speed slider to 0 and wait until the controller shows it.

        Raises:
            CellFault: ``motion_timeout`` when it does not; a stop opens the gate again.
        """
        if self.sample.speed_fraction >= GATE_OPEN_FRACTION:
            self.speed_fraction = self.sample.speed_fraction
        self._slide(0.0)
        deadline_s = time.monotonic() + _GATE_TIMEOUT_S
        while self.sample.speed_fraction >= GATE_OPEN_FRACTION:
            if time.monotonic() > deadline_s:
                raise CellFault("motion_timeout", "The speed slider does not go to 0.")
            yield
            # Somebody may have moved it a moment before, which no state had shown yet.
            if self.sample.speed_fraction >= GATE_OPEN_FRACTION:
                self.speed_fraction = self.sample.speed_fraction

    def open_gate(self) -> None:
        """Put the speed slider back to where it was before the gate was closed."""
        self.prepared = None
        self._slide(self.speed_fraction)

    def gate_was_opened(self) -> bool:
        """Whether somebody has moved the speed slider on the pendant, and with it the gate that a
        path waits behind. Where they put it counts from now on."""
        opened = self.prepared is not None and self.sample.speed_fraction >= GATE_OPEN_FRACTION
        if opened:
            self.speed_fraction = self.sample.speed_fraction
        return opened

    def start_path(self, path: Path) -> None:
        """Upload a path and start it behind the closed gate, then arm the watchdog.

        Raises:
            CellFault: ``program_stopped`` when the controller does not take it.
        """
        assert self.sample.speed_fraction < GATE_OPEN_FRACTION, "the gate must be closed"
        script = rtde_control.Path()
        entry = rtde_control.PathEntry
        for point in path:
            if isinstance(point, JointWaypoint):
                kind, pace = entry.MoveJ, [point.speed_rad_s, point.acceleration_rad_s2]
            else:
                kind, pace = entry.MoveL, [point.speed_m_s, point.acceleration_m_s2]
            row = [*point.pose, *pace, point.blend_radius_m]
            script.addEntry(entry(kind, entry.PositionTcpPose, row))
        if not self._control.movePath(script, True):
            raise self._refused("path")
        self.guard()
        self.prepared = path

    def start_joints(self, target_rad: Joints, speed_rad_s: float) -> None:
        """Start a movement in joint space. It uploads nothing, so the watchdog stays armed.

        Raises:
            CellFault: ``program_stopped`` when the controller does not take it.
        """
        if not self._control.moveJ(list(target_rad), speed_rad_s, JOINT_ACCELERATION_RAD_S2, True):
            raise self._refused("joint movement")

    def under_way(self) -> bool:
        """Whether the control program still works on a movement."""
        return bool(self._control.getAsyncOperationProgressEx().isAsyncOperationRunning())

    def brake(self) -> bool:
        """Begin to stop on the line; False where no program runs, as then nothing moves."""
        # Not the last round's state: a path's upload stops the program for a moment.
        playing = self._receiver.refresh().runtime_state == PLAYING
        if playing:
            self._control.stopL(STOP_DECELERATION_M_S2, True)
        return playing

    def set_output(self, line: int, high: bool) -> Generator[None, None, None]:
        """Switch a standard digital output and wait until the controller shows it.

        Raises:
            CellFault: ``robot_lost`` when it does not.
        """
        if not self._io.setStandardDigitalOut(line, high):
            raise CellFault("robot_lost", f"Output {line} could not be written.")
        deadline_s = time.monotonic() + _OUTPUT_TIMEOUT_S
        while bool(self.sample.outputs >> line & 1) != high:
            if time.monotonic() > deadline_s:
                raise CellFault("robot_lost", f"Output {line} does not follow its command.")
            yield

    def end_program(self) -> None:
        """Stop the control program, so that it does not run into its watchdog."""
        self._control.stopScript()

    def _slide(self, fraction: float) -> None:
        if not self._io.setSpeedSlider(fraction):
            raise CellFault("robot_lost", "The speed slider could not be written.")

    def _kick(self, now_s: float) -> None:
        self._control.kickWatchdog()
        self._longest_pause_s = max(self._longest_pause_s, now_s - self._kicked_at_s)
        self._kicked_at_s = now_s

    def _refused(self, what: str) -> CellFault:
        """Why the controller did not take a movement."""
        self._receiver.refresh()
        return safety_fault(self.sample) or CellFault(
            "program_stopped", f"The controller did not take the {what}."
        )


def _refusal(error: RuntimeError) -> CellFault:
    text = str(error)
    if "remote control" in text:
        return CellFault("local_control")
    if "already in use" in text:
        return CellFault("robot_lost", "Another client has hold of the controller's registers.")
    if "control script" in text:
        return CellFault("program_stopped", "The controller did not start the control program.")
    return CellFault("robot_lost", text)


def _minus(a: float, b: float) -> float:
    return a - b
