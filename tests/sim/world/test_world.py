"""What the world judges, each provoked by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cellctl.assembly import Cell
from cellctl.sim.world import BOND_LIFT_M, World
from cellctl.sim.world_geometry import rotation
from cellctl.sim.world_grip import HEIGHT_TOLERANCE_M, LATERAL_TOLERANCE_M
from cellctl.sim.world_values import Imperfections, Violation, ViolationKind, Where

from .hand import PARTS, Hand, emulated_config

PITCH_M = 0.1


@pytest.fixture
def hand() -> Hand:
    return Hand(World(emulated_config()))


def test_a_careful_hand_builds_what_it_places_and_nothing_is_held_against_it(hand: Hand) -> None:
    cells = [(1, 1, 0), (2, 1, 0), (1, 2, 0), (2, 2, 0), (1, 1, 1), (2, 1, 1), (3, 1, 1)]
    for cell in cells:
        hand.place(*cell)
    assert hand.world.violations == []
    assert hand.world.built == {Cell(*cell) for cell in cells}
    assert hand.world.counts()[Where.BELT] == PARTS - len(cells)


def test_a_part_fits_between_its_neighbours(hand: Hand) -> None:
    for cell in [(0, 1, 0), (2, 1, 0), (1, 0, 0), (1, 2, 0), (1, 1, 0)]:
        hand.place(*cell)
    assert hand.world.violations == []


def test_a_part_let_go_above_its_seat_falls(hand: Hand) -> None:
    hand.place(2, 2, 0, off_m=(0.0, 0.0, HEIGHT_TOLERANCE_M + 0.001))
    assert hand.kinds() == [ViolationKind.RELEASED_IN_MID_AIR]
    assert hand.world.counts()[Where.FALLEN] == 1
    assert hand.world.built == frozenset()


@pytest.mark.parametrize("height_m", [0.03, 0.06, 0.25])
def test_mid_air_is_mid_air_at_every_height(hand: Hand, height_m: float) -> None:
    hand.place(2, 2, 0, off_m=(0.0, 0.0, height_m))
    assert hand.kinds() == [ViolationKind.RELEASED_IN_MID_AIR]


def test_what_is_within_the_tolerances_snaps_to_its_cell(hand: Hand) -> None:
    near_m = LATERAL_TOLERANCE_M - 0.001
    hand.place(2, 2, 0, off_m=(near_m, 0.0, HEIGHT_TOLERANCE_M - 0.001))
    assert hand.world.violations == []
    assert hand.world.built == {Cell(2, 2, 0)}


def test_a_part_let_go_beside_its_cell_falls(hand: Hand) -> None:
    hand.place(2, 2, 0, off_m=(0.0, LATERAL_TOLERANCE_M + 0.001, 0.0))
    assert hand.kinds() == [ViolationKind.RELEASED_MISALIGNED]


@pytest.mark.parametrize(("yaw_rad", "tilt_rad"), [(0.1, 0.0), (0.0, 0.1)])
def test_a_part_let_go_askew_falls(hand: Hand, yaw_rad: float, tilt_rad: float) -> None:
    hand.pick()
    hand.carry(2, 2, 0, off_m=(0.0, 0.0, HEIGHT_TOLERANCE_M - 0.001))
    hand.turn(yaw_rad, tilt_rad)
    hand.open()
    assert hand.kinds()[-1] is ViolationKind.RELEASED_MISALIGNED


def test_quarter_turns_are_as_good_as_none(hand: Hand) -> None:
    hand.pick()
    hand.turn(math.pi / 2)
    hand.carry(2, 2, 0)
    hand.open()
    assert hand.world.violations == []
    assert hand.world.built == {Cell(2, 2, 0)}


def test_a_part_that_touches_nothing_falls(hand: Hand) -> None:
    hand.place(0, 0, 0)
    hand.place(1, 1, 1)  # an edge of the first part is no face
    assert hand.kinds() == [ViolationKind.RELEASED_UNSUPPORTED]
    assert hand.world.violations[0].cell == (1, 1, 1)


def test_a_face_beside_is_enough(hand: Hand) -> None:
    for cell in [(0, 0, 0), (0, 0, 1), (1, 0, 1)]:
        hand.place(*cell)
    assert hand.world.violations == []


def test_a_part_let_go_outside_the_workspace_falls(hand: Hand) -> None:
    hand.place(-1, 2, 0)
    assert hand.kinds() == [ViolationKind.RELEASED_OUTSIDE]


def test_a_cantilever_of_three_holds_and_with_the_fourth_it_breaks_off(hand: Hand) -> None:
    for cell in [(0, 0, 0), (0, 0, 1), (1, 0, 1), (2, 0, 1), (3, 0, 1)]:
        hand.place(*cell)
    assert hand.world.violations == []
    hand.place(4, 0, 1)
    assert [(v.kind, v.cell) for v in hand.world.violations] == [
        (ViolationKind.COLLAPSED, (x, 0, 1)) for x in (1, 2, 3, 4)
    ]
    assert hand.world.violations[0].message == (
        "The part at cell (1, 0, 1) fell: the joint between cells (0, 0, 1) and (1, 0, 1) does not "
        "bear the weight on it."
    )
    assert hand.world.built == {Cell(0, 0, 0), Cell(0, 0, 1)}
    assert hand.world.counts()[Where.FALLEN] == 4


def test_a_lone_column_of_five_stands_and_the_sixth_part_pushes_it_over(hand: Hand) -> None:
    for z in range(5):
        hand.place(2, 2, z)
    assert hand.world.violations == []
    hand.place(2, 2, 5)
    assert {v.kind for v in hand.world.violations} == {ViolationKind.COLLAPSED}
    assert hand.world.violations[0].message == (
        "The part at cell (2, 2, 0) fell: the joint between the floor and cell (2, 2, 0) does not "
        "bear the push of the placement."
    )
    assert hand.world.built == frozenset()


def test_a_column_with_another_beside_it_grows_higher(hand: Hand) -> None:
    for z in range(5):
        hand.place(2, 2, z)
        hand.place(3, 2, z)
    assert hand.world.violations == []


def test_parts_that_hold_and_parts_that_do_not_are_a_matter_of_the_magnets() -> None:
    config = emulated_config()
    weak = config.stability.model_copy(
        update={"magnet_force_n": 5.0, "placement_side_n": 0.5, "placement_down_n": 0.0}
    )
    hand = Hand(World(config.model_copy(update={"stability": weak})))
    for cell in [(0, 0, 0), (0, 0, 1), (1, 0, 1), (2, 0, 1)]:
        hand.place(*cell)
    assert [(v.kind, v.cell) for v in hand.world.violations] == [
        (ViolationKind.COLLAPSED, (1, 0, 1)),
        (ViolationKind.COLLAPSED, (2, 0, 1)),
    ]


def test_on_a_bare_floor_what_leans_too_far_tips_over() -> None:
    config = emulated_config()
    bare = config.stability.model_copy(
        update={"floor": "bare", "placement_side_n": 0.5, "placement_down_n": 0.5}
    )
    hand = Hand(World(config.model_copy(update={"stability": bare})))
    for cell in [(0, 0, 0), (0, 0, 1), (1, 0, 1)]:
        hand.place(*cell)
    assert hand.world.built == {Cell(0, 0, 0), Cell(0, 0, 1), Cell(1, 0, 1)}
    hand.place(2, 0, 1)
    assert hand.world.built == frozenset()


def test_a_visitor_who_takes_one_end_of_a_bridge_lets_the_rest_break_off(hand: Hand) -> None:
    ends = [(0, 0, 0), (5, 0, 0), (0, 0, 1), (5, 0, 1)]
    for cell in [*ends, (1, 0, 1), (4, 0, 1), (2, 0, 1), (3, 0, 1)]:
        hand.place(*cell)
    assert hand.world.violations == []
    hand.world.take_placed_part(Cell(0, 0, 1))
    assert [(v.kind, v.cell) for v in hand.world.violations] == [
        (ViolationKind.COLLAPSED, (x, 0, 1)) for x in (1, 2, 3, 4)
    ]


def test_a_part_that_is_picked_from_under_others_lets_them_fall(hand: Hand) -> None:
    for cell in [(0, 0, 0), (0, 0, 1), (1, 0, 1)]:
        hand.place(*cell)
    hand.open()
    hand.over(0.05, 0.05, 0.2)
    hand.close()
    assert hand.kinds() == []
    hand.go(0.05, 0.05, 0.25)
    assert [(v.kind, v.cell) for v in hand.world.violations] == [
        (ViolationKind.LOST_SUPPORT, (1, 0, 1))
    ]
    assert hand.world.counts()[Where.GRIPPER] == 1


def test_a_collision_of_the_held_part_is_told_once_and_names_the_part(hand: Hand) -> None:
    hand.place(2, 2, 0)
    struck = next(p.part for p in hand.world.parts() if p.where is Where.PLACED)
    hand.pick()
    hand.over(0.05, 0.25, 0.15)  # the held part hangs beside the placed one, half as high
    hand.go(0.25, 0.25, 0.15)
    assert [(v.kind, v.part, v.cell) for v in hand.world.violations] == [
        (ViolationKind.COLLISION, struck, (2, 2, 0))
    ]
    assert "held part" in hand.world.violations[0].message


def test_a_collision_of_the_gripper_is_seen_between_two_far_poses(hand: Hand) -> None:
    hand.place(2, 2, 0)
    hand.jump((0.05, 0.25, 0.9))
    hand.jump((0.05, 0.25, 0.05))
    hand.jump((0.55, 0.25, 0.05))
    assert hand.kinds() == [ViolationKind.COLLISION]
    assert "gripper" in hand.world.violations[0].message


def test_a_turn_that_sweeps_a_part_is_a_collision_though_both_its_ends_are_free(
    hand: Hand,
) -> None:
    hand.place(2, 2, 0)
    above_m, low_m = (0.25, 0.25, 0.8), (0.25, 0.25, 0.17)
    # The tool's z axis nearly level, to one side and to the other; upright in between, where the
    # gripper's body hangs down into the part.
    sides = [rotation(np.array([0.0, side * math.radians(85), 0.0])) for side in (1.0, -1.0)]
    for turn in sides:
        hand.jump(above_m, turn)
        hand.jump(low_m, turn)
        hand.jump(above_m, turn)
    assert hand.world.violations == []
    hand.jump(low_m, sides[1])
    hand.jump(low_m, sides[0])
    assert hand.kinds() == [ViolationKind.COLLISION]


def test_the_floor_is_an_obstacle(hand: Hand) -> None:
    hand.go(0.3, 0.25, 0.0)
    assert hand.world.violations == []
    hand.go(0.3, 0.25, -0.01)
    assert [v.message for v in hand.world.violations] == ["The gripper ran into the floor."]


def test_the_pedestal_is_an_obstacle(hand: Hand) -> None:
    hand.over(0.3, -0.1, 0.2)
    hand.go(0.3, -0.35, 0.2)
    assert [v.message for v in hand.world.violations] == ["The gripper ran into the pedestal."]


def test_parts_on_the_belt_are_obstacles(hand: Hand) -> None:
    hand.index_belt()
    x_m, y_m, z_m = hand.station_m
    hand.over(x_m - 0.2, y_m + 0.2, z_m - 0.05)
    hand.go(x_m - 0.2, y_m, z_m - 0.05)
    assert set(hand.kinds()) == {ViolationKind.COLLISION}
    assert {v.message for v in hand.world.violations} == {
        "The gripper ran into the part on the belt."
    }


def test_the_block_under_a_raised_belt_is_an_obstacle() -> None:
    config = emulated_config()
    feeder = config.feeder.model_copy(update={"frame": (-0.40, -0.20, 0.40, 0.0, 0.0, 0.0)})
    hand = Hand(World(config.model_copy(update={"feeder": feeder})))
    hand.over(-0.6, 0.1, 0.1)
    hand.go(-0.6, -0.15, 0.1)
    assert [v.message for v in hand.world.violations] == ["The gripper ran into the belt."]


def test_closing_beside_a_part_picks_nothing(hand: Hand) -> None:
    hand.index_belt()
    hand.open()
    x_m, y_m, z_m = hand.station_m
    hand.over(x_m, y_m + LATERAL_TOLERANCE_M + 0.001, z_m)
    hand.close()
    assert hand.kinds() == [ViolationKind.PICKED_NOTHING]
    assert hand.world.counts()[Where.PICK_STATION] == 1


def test_closing_at_an_empty_station_picks_nothing(hand: Hand) -> None:
    hand.world.empty_belt()
    hand.open()
    hand.over(*hand.station_m)
    hand.close()
    assert hand.kinds() == [ViolationKind.PICKED_NOTHING]


def test_closing_in_free_air_is_no_attempt_to_pick(hand: Hand) -> None:
    hand.open()
    hand.close()
    assert hand.world.violations == []


def test_a_yawed_part_cannot_be_picked_until_it_is_straightened(hand: Hand) -> None:
    hand.world.turn_next_part(0.26)
    hand.pick()
    assert hand.kinds() == [ViolationKind.PICKED_NOTHING]
    hand.world.straighten_parts()
    hand.pick()
    assert hand.world.held_part == 0


def test_a_part_can_be_put_back_at_the_station(hand: Hand) -> None:
    hand.pick()
    hand.over(*hand.station_m)
    hand.open()
    assert hand.world.violations == []
    assert hand.world.counts()[Where.PICK_STATION] == 1


def test_a_sticky_part_comes_off_when_it_is_lifted_straight(hand: Hand) -> None:
    hand.world.stick_next_part()
    hand.pick()
    assert hand.world.violations == []
    assert hand.world.parts_on_belt == PARTS - 1


def test_a_sticky_part_drags_its_neighbour_when_moved_aside_too_soon(hand: Hand) -> None:
    hand.world.stick_next_part()
    hand.index_belt()
    hand.open()
    x_m, y_m, z_m = hand.station_m
    hand.over(x_m, y_m, z_m)
    hand.close()
    hand.go(x_m, y_m, z_m + BOND_LIFT_M / 2)
    hand.go(x_m + 0.05, y_m, z_m + BOND_LIFT_M / 2)
    assert hand.kinds() == [ViolationKind.DRAGGED_NEIGHBOUR]
    assert hand.world.counts()[Where.FALLEN] == 1


def test_the_sensor_sees_the_part_until_it_is_lifted_out(hand: Hand) -> None:
    hand.index_belt()
    hand.open()
    x_m, y_m, z_m = hand.station_m
    hand.over(x_m, y_m, z_m)
    hand.close()
    assert hand.world.part_at_pick()
    hand.go(x_m, y_m, z_m + PITCH_M)
    assert not hand.world.part_at_pick()


def test_violations_are_told_as_they_happen_with_their_cell_time() -> None:
    told: list[Violation] = []
    hand = Hand(World(emulated_config(), on_violation=told.append))
    hand.world.advance(12.5)
    hand.world.empty_belt()
    hand.open()
    hand.jump(hand.station_m)
    hand.close()
    assert told == hand.world.violations
    assert [v.cell_time_s for v in told] == [12.5]


def test_people_move_parts_too_and_none_is_lost(hand: Hand) -> None:
    for cell in [(0, 0, 0), (0, 0, 1)]:
        hand.place(*cell)
    assert hand.world.hand_over() == 2
    assert hand.world.counts()[Where.HANDED_OVER] == 2
    hand.place(1, 1, 0)
    assert hand.world.clear_workspace() == 1
    assert hand.world.refill_belt() == 3
    assert hand.world.counts()[Where.BELT] == PARTS
    assert hand.world.refill_belt() == 0


def test_a_visitor_takes_a_part_along_and_what_it_held_falls(hand: Hand) -> None:
    for cell in [(0, 0, 0), (0, 0, 1), (1, 1, 0)]:
        hand.place(*cell)
    hand.world.take_placed_part(Cell(1, 1, 0))
    assert hand.world.violations == []
    assert hand.world.counts()[Where.HANDED_OVER] == 1
    hand.world.take_placed_part(Cell(0, 0, 0))
    assert hand.world.built == frozenset()
    assert [violation.kind for violation in hand.world.violations] == [ViolationKind.LOST_SUPPORT]
    with pytest.raises(ValueError, match="no part stands"):
        hand.world.take_placed_part(Cell(0, 0, 0))


def test_the_same_seed_gives_the_same_world() -> None:
    rough = Imperfections(
        belt_slip=0.3, pitch_drift_m=0.01, yawed_share=0.2, missing_share=0.1, sticky_share=0.2
    )

    def life(seed: int) -> tuple[object, ...]:
        hand = Hand(World(emulated_config(), seed, rough))
        for cell in [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)]:
            hand.place(*cell)
        return (hand.world.parts(), tuple(hand.world.violations))

    assert life(7) == life(7)
    assert life(7) != life(8)
