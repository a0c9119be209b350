"""The robot's controller, through ur_rtde. Lives in the arm process only.

ur_rtde is not made for what a cell needs when things go wrong, so this module keeps to a narrow
path through it (version 1.6.5):

- One thread uses it, with asynchronous movements only: commands from two threads erase each other,
  and a blocking movement cannot be stopped or watched.
- After a lost connection its objects are broken for good (endless reconnects, stale values, an
  abort at exit), so they are never repaired: the process ends without running their destructors.
- ``isConnected`` is not to be trusted; only a controller time that advances is.
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
from collections.abc import Callable, Generator, Sequence
from typing import Any, NamedTuple

import rtde_control
import rtde_io
import rtde_receive

from cellctl.assembling.arm import ArmState, Waypoint
from cellctl.config import Joints, Pose, RobotSection, Vector
from cellctl.errors import CellFault

PLAYING = 2
"""``runtime_state`` of a running program."""
STOPPED = 1
RUNNING = 7
"""``robot_mode`` of an arm with power on and brakes released."""
GATE_OPEN_FRACTION = 0.01
"""A speed slider below this is the gate, not somebody's choice: the pendant's ends at 1 %."""

STOP_DECELERATION_M_S2 = 3.0
"""For a stop on request; from 1 m/s it takes 0.17 m."""
REST_M_S = 0.002
_KICK_PERIOD_S = 0.02
_POLL_S = 0.005
_LOST_AFTER_S = 1.0
"""A controller time that stands still for so long (wall time) means a lost controller."""
_GATE_TIMEOUT_S = 1.0
"""For the controller to show the speed slider (wall time)."""
_OUTPUT_TIMEOUT_S = 1.0
_READ_BACK_TIMEOUT_S = 1.0
_PROGRAM_GRACE_S = 0.1
"""A stop's safety bits may follow this much later than the program's end (wall time)."""
JOINT_ACCELERATION_RAD_S2 = 1.0
_TOLERANCE = 1e-4
"""TCP (m, rad) and payload (kg, m) read back may differ by rounding only."""

_VARIABLES = [
    "timestamp",
    "actual_q",
    "actual_qd",
    "actual_TCP_pose",
    "actual_TCP_speed",
    "actual_digital_input_bits",
    "actual_digital_output_bits",
    "robot_mode",
    "runtime_state",
    "safety_status_bits",
    "target_speed_fraction",
    "payload",
]

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

    def state(self) -> ArmState:
        """In the words of the rest of the cell."""
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
            moving=not self.at_rest,
            program_running=self.runtime_state == PLAYING,
            safety=safety,  # type: ignore[arg-type]  # one of the names above
            powered=self.robot_mode == RUNNING,
            digital_inputs=self.inputs & 0xFF,
            digital_outputs=self.outputs & 0xFF,
        )


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

    def _read(self) -> Sample:
        receive = self._receive
        return Sample(
            robot_time_s=receive.getTimestamp(),
            joints_rad=_six(receive.getActualQ()),
            joint_speed_rad_s=max(abs(speed) for speed in receive.getActualQd()),
            tcp_pose=_six(receive.getActualTCPPose()),
            tcp_speed_m_s=sum(v * v for v in receive.getActualTCPSpeed()[:3]) ** 0.5,
            inputs=receive.getActualDigitalInputBits(),
            outputs=receive.getActualDigitalOutputBits(),
            robot_mode=receive.getRobotMode(),
            runtime_state=receive.getRuntimeState(),
            safety_bits=receive.getSafetyStatusBits(),
            speed_fraction=receive.getTargetSpeedFraction(),
        )


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
        self._not_playing_since_s: float | None = None
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
        if len(read_tcp) != 6 or max(map(abs, map(_minus, read_tcp, tcp))) > _TOLERANCE:
            raise CellFault("robot_mismatch", f"TCP set to {list(tcp)}, read back {read_tcp}.")
        self._control.setPayload(payload_kg, list(cog_m))
        if not self._receiver.wait(lambda _: self._has_payload(payload_kg), _READ_BACK_TIMEOUT_S):
            raise CellFault(
                "robot_mismatch",
                f"Payload set to {payload_kg} kg, read back {self._receiver.payload_kg()} kg.",
            )

    def _has_payload(self, payload_kg: float) -> bool:
        return abs(self._receiver.payload_kg() - payload_kg) < _TOLERANCE

    def guard(self) -> None:
        """Arm the controller's watchdog, which a program upload drops, and kick it."""
        self._control.setWatchdog(self._robot.watchdog_hz)
        self._kick(time.monotonic())

    def tick(self) -> Sample:
        """Take the newest state, and kick the watchdog when it is time.

        Raises:
            CellFault: ``robot_lost``.
        """
        sample = self._receiver.refresh()
        now_s = time.monotonic()
        if sample.runtime_state == PLAYING:
            self._not_playing_since_s = None
            if now_s - self._kicked_at_s >= _KICK_PERIOD_S:
                self._kick(now_s)
        elif self._not_playing_since_s is None:
            self._not_playing_since_s = now_s
        return sample

    def check(self) -> None:
        """Raise what keeps the arm from moving.

        Raises:
            CellFault: a stop of the robot's own, or ``program_stopped``.
        """
        if (fault := safety_fault(self.sample)) is not None:
            raise fault
        since_s = self._not_playing_since_s
        if since_s is not None and time.monotonic() - since_s > _PROGRAM_GRACE_S:
            raise CellFault("program_stopped")

    def close_gate(self) -> Generator[None, None, None]:
        """Put the speed slider to 0 and wait until the controller shows it.

        Raises:
            CellFault: ``motion_timeout`` when it does not; nothing has moved then.
        """
        if self.sample.speed_fraction >= GATE_OPEN_FRACTION:
            self.speed_fraction = self.sample.speed_fraction
        self._slide(0.0)
        deadline_s = time.monotonic() + _GATE_TIMEOUT_S
        while self.sample.speed_fraction >= GATE_OPEN_FRACTION:
            if time.monotonic() > deadline_s:
                self._slide(self.speed_fraction)
                raise CellFault("motion_timeout", "The speed slider does not go to 0.")
            yield

    def open_gate(self) -> None:
        """Put the speed slider back to where it was before the gate was closed."""
        self._slide(self.speed_fraction)

    def start_path(self, path: Sequence[Waypoint]) -> None:
        """Upload a path and start it behind the closed gate, then arm the watchdog.

        Raises:
            CellFault: ``program_stopped`` when the controller does not take it.
        """
        assert self.sample.speed_fraction < GATE_OPEN_FRACTION, "the gate must be closed"
        rows = [
            [*point.pose, point.speed_m_s, point.acceleration_m_s2, point.blend_radius_m]
            for point in path
        ]
        if not self._control.moveL(rows, True):
            raise self._refused("path")
        self.guard()

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

    def brake(self) -> None:
        """Begin to stop on the line; nothing where no program runs, as then nothing moves."""
        # Not the last round's state: a path's upload stops the program for a moment.
        if self._receiver.refresh().runtime_state == PLAYING:
            self._control.stopL(STOP_DECELERATION_M_S2, True)

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


def _six(values: Sequence[float]) -> tuple[float, float, float, float, float, float]:
    a, b, c, d, e, f = values
    return (a, b, c, d, e, f)


def _minus(a: float, b: float) -> float:
    return a - b
