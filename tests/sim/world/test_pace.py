"""Cell time follows wall time, whatever the machine does."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cellctl.sim.pace import SLICE_WALL_S, STALL_S, SimClock

waits = st.lists(st.floats(0.0, 0.1), max_size=50)


def catch_up(clock: SimClock, wall_s: float) -> list[float]:
    """All slices that are due."""
    slices = clock.slices(wall_s)
    while clock.behind:
        slices += clock.slices(wall_s)
    return slices


@given(st.floats(0.1, 50.0), waits)
def test_cell_time_is_wall_time_multiplied_by_the_rate(rate: float, steps: list[float]) -> None:
    clock, wall_s, total_s = SimClock(rate, 100.0), 100.0, 0.0
    for step_s in steps:
        wall_s += step_s
        slices = catch_up(clock, wall_s)
        total_s += sum(slices)
        assert all(0.0 < slice_s <= 1.5001 * SLICE_WALL_S * rate for slice_s in slices)
    assert clock.now_s == pytest.approx(total_s) == pytest.approx((wall_s - 100.0) * rate)
    assert clock.lost_s == 0.0


def test_a_long_stall_is_left_out_and_counted() -> None:
    clock = SimClock(2.0, 0.0)
    assert sum(catch_up(clock, STALL_S + 5.0)) == pytest.approx(STALL_S * 2.0)
    assert clock.lost_s == pytest.approx(10.0)


def test_one_burst_leaves_the_rest_for_later() -> None:
    clock = SimClock(100.0, 0.0)
    first = clock.slices(0.9)
    assert clock.behind
    assert sum(first) + sum(catch_up(clock, 0.9)) == pytest.approx(90.0)


def test_a_clock_that_goes_back_stands_still() -> None:
    clock = SimClock(1.0, 10.0)
    assert clock.slices(9.0) == []


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_a_rate_must_be_positive(rate: float) -> None:
    with pytest.raises(ValueError, match="greater than 0"):
        SimClock(rate, 0.0)
