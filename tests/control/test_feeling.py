"""What counts as touching, by a sensor and by staying behind."""

from __future__ import annotations

from typing import Any

import pytest

from cellctl.assembling.arm import ArmState
from cellctl.control.feeling import ByForce, ByMotion, feeling_of
from tests.cell.harness import cell_config

UR10 = {"model": "ur10", "rtde_frequency_hz": 125}


def state(**values: Any) -> ArmState:
    told: dict[str, Any] = {
        "robot_time_s": 0.0, "joints_rad": (0.0,) * 6, "tcp_pose": (0.1, 0.2, 0.3, 0.0, 3.1, 0.0),
        "tcp_speed_m_s": 0.0, "tcp_force_n": (0.0, 0.0, 0.0), "moving": False,
        "program_running": True, "safety": "normal", "powered": True,
        "digital_inputs": 0, "digital_outputs": 0,
    }  # fmt: skip
    return ArmState.model_validate(told | values)


def test_each_robot_feels_by_what_it_has() -> None:
    assert isinstance(feeling_of(cell_config()), ByForce)
    assert isinstance(feeling_of(cell_config(robot=UR10)), ByMotion)


def test_a_force_is_read_along_the_vertical_and_told_in_newtons() -> None:
    feeling = feeling_of(cell_config())
    assert feeling.upward(state(tcp_force_n=(3.0, 4.0, 14.0))) == pytest.approx(14.0)
    assert feeling.told(14.0) == "pressed up with 14.0 N"
    assert feeling.told(-15.04) == "pulled down with 15.0 N"


def test_a_lag_is_read_along_the_vertical_and_told_in_millimetres() -> None:
    feeling = feeling_of(cell_config(robot=UR10))
    pressed = state(tcp_lag_m=(0.0001, 0.0, 0.0007))
    assert feeling.upward(pressed) == pytest.approx(0.0007)
    assert feeling.touches < feeling.upward(pressed) < feeling.early
    assert pressed.told_pose == pytest.approx((0.0999, 0.2, 0.2993, 0.0, 3.1, 0.0))
    assert feeling.told(0.0007) == "held 0.70 mm above where the arm is told to be"
    assert feeling.told(-0.0007) == "held 0.70 mm below where the arm is told to be"


def test_an_arm_that_is_only_on_its_way_meets_nothing() -> None:
    feeling = feeling_of(cell_config(robot=UR10))
    # At 1 m/s it is 8 mm behind, 8 ms after its target.
    falling = state(tcp_lag_m=(0.0, 0.0, 0.008), tcp_speed_m_s=1.0, moving=True)
    assert feeling.upward(falling) - feeling.slack(falling) < feeling.early
    stopped = state(tcp_lag_m=(0.0, 0.0, 0.004), tcp_speed_m_s=0.05, moving=True)
    assert feeling.upward(stopped) - feeling.slack(stopped) > feeling.early


def test_an_arm_shows_on_its_way_across_how_far_it_is_behind() -> None:
    feeling = feeling_of(cell_config(robot=UR10))

    def excused_m(speed_m_s: float) -> float:
        """How much farther than it is by itself, 8 ms, it may be behind."""
        return feeling.slack(state(tcp_speed_m_s=speed_m_s)) - 0.008 * speed_m_s

    unknown_m = excused_m(0.54)
    assert unknown_m == pytest.approx(0.0043, abs=1e-4)
    feeling.begin()
    feeling.watch(state(tcp_lag_m=(0.0008, 0.0, 0.0), tcp_speed_m_s=0.05))  # says little
    assert excused_m(0.54) == unknown_m
    for lag_m, speed_m_s in ((0.0024, 0.3), (0.0081, 1.0)):
        feeling.watch(state(tcp_lag_m=(0.0, lag_m, 0.0), tcp_speed_m_s=speed_m_s))
    assert 0.0 < excused_m(0.54) < 0.3 * unknown_m
    feeling.watch(state(tcp_lag_m=(0.0, 0.03, 0.0), tcp_speed_m_s=1.0))  # never more than is told
    assert excused_m(0.54) == pytest.approx(unknown_m)
    feeling.begin()
    assert excused_m(0.54) == unknown_m
