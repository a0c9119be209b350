"""Where an emulated arm is, and where its controller wants it."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from cellctl.sim.plant import Floats
from cellctl.sim.ur.motion import JointSpeed
from cellctl.sim.ur.options import FOLLOWING_S, UrOptions
from cellctl.sim.ur.robot import Robot


class Pushing:
    """A plant that pushes at the tool."""

    def __init__(self) -> None:
        self.force_n = np.zeros(3)

    def robot_moved(self, flange: Floats, joints_rad: Floats, dt_s: float) -> None: ...

    def commanded(self, speed_m_s: float, acceleration_m_s2: float) -> None: ...

    def tcp_force_n(self) -> Floats:
        return self.force_n

    def outputs_changed(self, bits: int) -> None: ...

    def inputs(self) -> int:
        return 0


def lag_m(robot: Robot, times: int = 50) -> Floats:
    """From where the TCP is wanted to where it is told to be, in the mean of some states."""
    lags = []
    for _ in range(times):
        robot.advance(0.008)
        shown = robot.registers
        lags.append(np.subtract(shown.actual_TCP_pose, shown.target_TCP_pose)[:3])
    return np.asarray(np.mean(lags, axis=0))


@pytest.mark.parametrize(
    ("model", "pushed_n", "off_mm"),
    [("ur10", 14.0, 0.7), ("ur10", -15.0, -0.75), ("ur10", 400.0, 7.5), ("ur10e", 14.0, 0.0)],
)
def test_only_an_arm_without_a_sensor_gives_way(
    model: Literal["ur10", "ur10e"], pushed_n: float, off_mm: float
) -> None:
    plant = Pushing()
    robot = Robot(UrOptions(model=model), plant, lambda: 0.0)
    assert lag_m(robot) * 1000 == pytest.approx(np.zeros(3), abs=0.02)
    plant.force_n = np.array([0.0, 0.0, pushed_n])
    assert lag_m(robot) * 1000 == pytest.approx([0.0, 0.0, off_mm], abs=0.02)


def test_an_arm_that_moves_is_behind_its_target_by_its_speed() -> None:
    robot = Robot(UrOptions(model="ur10"), Pushing(), lambda: 0.0)
    turning = JointSpeed((0.2, 0.0, 0.0, 0.0, 0.0, 0.0))
    robot.arm.start(turning)
    robot.advance(0.008)
    behind_m = np.linalg.norm(lag_m(robot, 20))
    assert behind_m == pytest.approx(robot.arm.tcp_speed_m_s * FOLLOWING_S["ur10"], rel=0.05)
