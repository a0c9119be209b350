"""The row of parts on the belt."""

from __future__ import annotations

import random

import pytest

from cellctl.sim.world_belt import SENSOR_TOLERANCE_M, BeltRow
from cellctl.sim.world_values import Imperfections

PITCH_M = 0.1
PERFECT = Imperfections()


def row_of(count: int, imperfections: Imperfections = PERFECT) -> BeltRow:
    row = BeltRow(PITCH_M, random.Random(3))  # noqa: S311 - repeatable
    row.lay(list(range(count)), imperfections)
    return row


def positions(row: BeltRow) -> list[float]:
    return [round(item.position_m, 9) for item in row.parts]


def test_parts_lie_one_pitch_apart_and_the_first_one_pitch_before_the_stop() -> None:
    assert positions(row_of(3)) == [-0.1, -0.2, -0.3]


def test_the_stop_holds_the_first_part_and_the_others_queue_up_behind_it() -> None:
    row = row_of(3)
    row.move(0.25, slip=0.0)
    assert positions(row) == [0.0, -0.1, -0.2]


@pytest.mark.parametrize(
    ("distance_m", "seen"),
    [
        (PITCH_M - SENSOR_TOLERANCE_M - 0.001, False),
        (PITCH_M - SENSOR_TOLERANCE_M + 0.001, True),
        (PITCH_M, True),
    ],
)
def test_the_sensor_sees_a_part_close_to_the_stop(distance_m: float, seen: bool) -> None:
    row = row_of(2)
    row.move(distance_m, slip=0.0)
    assert (row.at_stop() is not None) is seen


def test_the_belt_takes_parts_back() -> None:
    row = row_of(2)
    row.move(0.1, slip=0.0)
    row.move(-0.1, slip=0.0)
    assert positions(row) == [-0.1, -0.2]


def test_slip_shortens_each_movement_by_at_most_its_share() -> None:
    row = row_of(1)
    row.move(0.05, slip=0.4)
    assert -0.1 + 0.05 * 0.6 <= row.parts[0].position_m < -0.05


def test_drift_only_ever_widens_the_gaps() -> None:
    row = row_of(50, Imperfections(pitch_drift_m=0.02))
    gaps = [a.position_m - b.position_m for a, b in zip(row.parts, row.parts[1:], strict=False)]
    assert min(gaps) >= PITCH_M
    assert max(gaps) > PITCH_M + 0.01


def test_a_missing_part_leaves_its_place_empty() -> None:
    row = BeltRow(PITCH_M, random.Random(3))  # noqa: S311 - repeatable
    left_out = row.lay(list(range(20)), Imperfections(missing_share=0.3))
    assert 0 < len(left_out) < 20
    assert positions(row) == [
        round(-PITCH_M * (part + 1), 9) for part in range(20) if part not in left_out
    ]


def test_only_a_part_that_touches_can_stick() -> None:
    row = row_of(3, Imperfections(sticky_share=1.0))
    assert row.take(0)[1] is row.parts[0]
    apart = row_of(3, Imperfections(sticky_share=1.0))
    apart.parts[0].position_m += 0.01
    assert apart.take(0)[1] is None


def test_what_is_not_on_the_belt_cannot_be_taken() -> None:
    with pytest.raises(KeyError):
        row_of(2).take(5)


def test_a_part_can_be_put_back_only_where_there_is_room() -> None:
    row = row_of(2)
    row.move(0.1, slip=0.0)
    assert not row.has_room_at_stop()
    row.take(0)
    assert row.has_room_at_stop()
    row.put_back(0)
    assert positions(row) == [0.0, -0.1]
