"""What the arm process does for each order, as generators.

Every ``yield`` hands control back to the one loop that reads the robot, kicks the watchdog and
listens to the daemon, and is resumed a few milliseconds later with a fresh state.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator

from cellctl.assembling.arm import ArmCheck
from cellctl.assembling.arm_dashboard import Dashboard
from cellctl.assembling.arm_link import JOINT_ACCELERATION_RAD_S2, Link
from cellctl.assembling.arm_messages import Follow, MoveJoints, Prepare, WaitInput
from cellctl.assembling.arm_receiver import Sample
from cellctl.assembling.arm_rtde import TOOL_VOLTAGE, read_integer
from cellctl.assembling.poses import distance
from cellctl.config import RobotSection
from cellctl.errors import CellFault

_ARRIVED_M = 0.0015
_CLOSEST_M = 0.00015
"""A short path has arrived within a tenth of its length, but never closer than this."""
_ARRIVED_RAD = 0.002
_HELD_BACK_M = 0.012
"""An arm that presses on something is less than this off the target that it has reached."""
_STALLED_S = 0.5
"""At rest away from the target for so long: the movement has ended early."""
_STOP_TIMEOUT_S = 5.0
"""For coming to rest after a stop."""
_SETTLED_S = 0.02
"""A state this much younger (robot time) than an order shows what came of it."""
_TIMEOUT_MARGIN_S = 2.0


class _Patience:
    """Runs out when both the robot's clock and this computer's have run for so long.

    So neither an emulated robot that is faster than time nor a computer that was held up ends a
    movement that is well.
    """

    def __init__(self, link: Link, limit_s: float) -> None:
        self._link = link
        self._limit_s = limit_s
        self.renew()

    def renew(self) -> None:
        """Begin again."""
        self._robot_s = self._link.sample.robot_time_s
        self._wall_s = time.monotonic()

    @property
    def over(self) -> bool:
        """Whether it has run out."""
        robot_s = self._link.sample.robot_time_s - self._robot_s
        return min(robot_s, time.monotonic() - self._wall_s) > self._limit_s


def prepare(link: Link, order: Prepare) -> Generator[None, None, None]:
    """Start a path behind the gate, and leave the gate closed.

    Raises:
        CellFault: whatever keeps the arm from moving.
    """
    link.check()
    yield from link.close_gate()
    link.start_path(order.path)


def follow(link: Link, order: Follow, timeout_factor: float) -> Generator[None, None, None]:
    """Start a path behind the gate, unless it was prepared, open the gate, and wait for the end;
    switch an output just before it where that was ordered.

    Raises:
        CellFault: whatever keeps the arm from arriving.
    """
    link.check()
    if link.prepared != order.path:
        yield from link.close_gate()
        link.start_path(order.path)
    link.open_gate()
    target = order.path[-1].pose
    length_m, _ = distance(link.sample.told_pose, target)
    within_m = max(_CLOSEST_M, min(_ARRIVED_M, 0.1 * length_m))

    def arrived(sample: Sample) -> bool:
        # Where something is in the way, the arm comes to rest without being quite there.
        apart_m, apart_rad = distance(sample.told_pose, target)
        off_m, _ = distance(sample.tcp_pose, sample.told_pose)
        return apart_m < within_m and apart_rad < _ARRIVED_RAD and off_m < _HELD_BACK_M

    arriving = _arrive(link, arrived, order.planned_duration_s * timeout_factor)
    if order.switch is None:
        yield from arriving
        return
    switching: Generator[None, None, None] | None = None
    for _ in arriving:
        near, _ = distance(link.sample.tcp_pose, target)
        if switching is None and near < order.switch.within_m:
            switching = link.set_output(order.switch.line, order.switch.high)
        if switching is not None:
            next(switching, None)
        yield
    yield from switching or link.set_output(order.switch.line, order.switch.high)


def move_joints(
    link: Link, order: MoveJoints, timeout_factor: float
) -> Generator[None, None, None]:
    """Turn the joints and wait for the end.

    Raises:
        CellFault: whatever keeps the arm from arriving.
    """

    def apart_rad(sample: Sample) -> float:
        return max(
            abs(target - joint)
            for target, joint in zip(order.target_rad, sample.joints_rad, strict=True)
        )

    link.check()
    if link.prepared is not None:
        yield from stop(link)
    planned_s = apart_rad(link.sample) / order.speed_rad_s
    planned_s += order.speed_rad_s / JOINT_ACCELERATION_RAD_S2
    link.start_joints(order.target_rad, order.speed_rad_s)
    yield from _arrive(
        link, lambda sample: apart_rad(sample) < _ARRIVED_RAD, planned_s * timeout_factor
    )


def stop(link: Link) -> Generator[None, None, None]:
    """Brake and wait until nothing moves; leaves the gate open.

    Raises:
        CellFault: ``motion_timeout`` when the arm does not come to rest.
    """
    braked = link.brake()
    begun_s = link.sample.robot_time_s
    patience = _Patience(link, _STOP_TIMEOUT_S)
    # The newest state may be older than the order to brake, and show an arm that still stands.
    # And a path that was prepared must be gone before the gate opens.
    while (
        link.sample.robot_time_s - begun_s < _SETTLED_S
        or not link.sample.at_rest
        or (link.prepared is not None and (link.under_way() or not (braked or link.ended)))
    ):
        if patience.over:
            raise CellFault("motion_timeout", "The arm does not come to rest.")
        yield
        # Right after an upload the newest state may still be one without a program.
        if not braked and (braked := link.brake()):
            begun_s = link.sample.robot_time_s
    link.open_gate()


def verify(
    link: Link, dashboard: Dashboard, robot: RobotSection
) -> Generator[None, None, ArmCheck]:
    """Read back what the robot has set.

    Raises:
        CellFault: a stop of the robot's own, ``robot_mismatch``, ``local_control`` or
            ``robot_lost``.
    """
    link.check()
    identity = yield from dashboard.identifying(robot.model)
    tool_voltage_v = yield from read_integer(robot.host, TOOL_VOLTAGE)
    link.check()
    return link.read_back(identity, tool_voltage_v)


def wait_input(link: Link, order: WaitInput) -> Generator[None, None, bool]:
    """Wait for a level; returns False on time-out."""
    begun_s = link.sample.robot_time_s
    while bool(link.sample.inputs >> order.line & 1) != order.high:
        if link.sample.robot_time_s - begun_s > order.timeout_s:
            return False
        yield
    return True


def _arrive(
    link: Link, arrived: Callable[[Sample], bool], timeout_s: float
) -> Generator[None, None, None]:
    """Wait until the arm rests at its target."""
    begun_s = link.sample.robot_time_s
    whole = _Patience(link, timeout_s + _TIMEOUT_MARGIN_S)
    stalled = _Patience(link, _STALLED_S)
    while True:
        yield
        sample = link.sample
        if sample.at_rest and arrived(sample) and sample.robot_time_s - begun_s > _SETTLED_S:
            return
        link.check()
        if not sample.at_rest or link.under_way():
            stalled.renew()
        elif stalled.over:
            raise CellFault("program_stopped", "The arm came to rest before its target.")
        if whole.over:
            raise CellFault("motion_timeout")
