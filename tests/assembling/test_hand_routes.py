"""An operator's hand moves: single steps, straight up, home from wherever the arm was led."""

from __future__ import annotations

import asyncio
import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cellctl.assembling.arm import JointWaypoint, Waypoint
from cellctl.assembling.frames import Frames
from cellctl.assembling.hand_routes import HAND_SPEED_M_S, JOG_M, JOG_RAD
from cellctl.assembling.kinematics import Kinematics, same_configuration
from cellctl.assembling.links import links
from cellctl.assembling.poses import Matrix, to_matrix, to_pose
from cellctl.assembling.route import Route, RoutePlanner, Stance
from cellctl.assembling.travel import travel
from cellctl.assembly import Cell
from cellctl.config import CellConfig, Joints, Vector
from cellctl.errors import CellctlError, PlanError
from tests.assembling.conftest import cell
from tests.assembling.emulator import Emulator
from tests.assembling.test_arm import connected, stance

CONFIG = cell("ur10e")
FRAMES = Frames(CONFIG)
KINEMATICS = Kinematics("ur10e")
PLANNER = RoutePlanner(CONFIG)
TOWER = frozenset(Cell(2, 2, z) for z in range(4))
STEPS: list[Vector] = [
    (0.05, 0.0, 0.0),
    (-0.05, 0.0, 0.0),
    (0.0, 0.05, 0.0),
    (0.0, -0.05, 0.0),
    (0.0, 0.0, 0.05),
    (0.0, 0.0, -0.05),
]


def at(x_m: float, y_m: float, z_m: float, near: Joints | None = None) -> Stance:
    """The TCP at a point of the cell frame, pointing down."""
    tcp = FRAMES.cell_from_base @ FRAMES.place_tcp(Cell(0, 0, 0))
    tcp[:3, 3] = (x_m, y_m, z_m)
    pose = FRAMES.base_from_cell @ tcp
    joints_rad = KINEMATICS.inverse(FRAMES.flange(pose), near or PLANNER.home.joints_rad)
    assert joints_rad is not None
    return Stance(to_pose(pose), joints_rad)


def in_cell(here: Stance) -> Matrix:
    return FRAMES.cell_from_base @ to_matrix(here.tcp_pose)


def position_m(here: Stance) -> Vector:
    x, y, z = (float(value) for value in in_cell(here)[:3, 3])
    return (x, y, z)


def jogged(
    start: Stance,
    delta_m: Vector,
    placed: frozenset[Cell] = frozenset(),
    *,
    turn_rad: float = 0.0,
    carrying: bool = False,
) -> Route:
    return PLANNER.jog(start, placed, delta_m, turn_rad, carrying=carrying)


@pytest.mark.parametrize("delta_m", STEPS)
def test_a_jog_is_slow_and_straight_along_an_axis_of_the_cell(delta_m: Vector) -> None:
    start = at(0.3, 0.3, 0.4)
    route = jogged(start, delta_m)
    assert len(route.path) == 1
    assert isinstance(route.path[0], Waypoint)
    assert route.path[0].speed_m_s <= HAND_SPEED_M_S
    assert route.duration_s > 0.05 / HAND_SPEED_M_S
    assert np.subtract(position_m(route.end), position_m(start)) == pytest.approx(delta_m, abs=1e-6)
    assert in_cell(route.end)[:3, :3] == pytest.approx(in_cell(start)[:3, :3], abs=1e-6)


def test_a_turn_is_about_the_vertical_through_the_tcp() -> None:
    start = at(0.3, 0.3, 0.4)
    route = jogged(start, (0.0, 0.0, 0.0), turn_rad=0.4)
    assert position_m(route.end) == pytest.approx(position_m(start), abs=1e-9)
    turn = in_cell(route.end)[:3, :3] @ in_cell(start)[:3, :3].T
    assert to_pose(np.block([[turn, np.zeros((3, 1))], [0, 0, 0, 1]]))[3:] == pytest.approx(
        (0.0, 0.0, 0.4)
    )


@pytest.mark.parametrize(
    ("delta_m", "turn_rad", "message"),
    [
        ((0.0, 0.0, 0.0), 0.0, "one at a time"),
        ((0.01, 0.01, 0.0), 0.0, "one at a time"),
        ((0.01, 0.0, 0.0), 0.1, "one at a time"),
        ((0.0, JOG_M + 0.01, 0.0), 0.0, r"0\.1 m at most"),
        ((0.0, 0.0, 0.0), -JOG_RAD - 0.01, "30 degrees at most"),
        ((math.nan, 0.0, 0.0), 0.0, "finite"),
        ((0.0, 0.0, 0.0), math.inf, "finite"),
    ],
)
def test_what_is_no_single_short_step_is_refused(
    delta_m: Vector, turn_rad: float, message: str
) -> None:
    with pytest.raises(PlanError, match=message):
        jogged(at(0.3, 0.3, 0.4), delta_m, turn_rad=turn_rad)


def test_a_step_keeps_its_distance_to_what_stands() -> None:
    # The gripper's side is 50 mm from the tower's.
    beside = at(0.3 + 0.095, 0.25, 0.3)
    with pytest.raises(PlanError, match=r"empty gripper would come closer to the part at \[2, 2,"):
        jogged(beside, (-0.03, 0.0, 0.0), TOWER)
    assert jogged(beside, (-0.01, 0.0, 0.0), TOWER).path
    with pytest.raises(PlanError, match="part it carries would come closer"):
        jogged(beside, (-0.02, 0.0, 0.0), TOWER, carrying=True)


def test_an_arm_that_stands_too_close_is_let_out_but_not_in() -> None:
    close = at(0.3 + 0.055, 0.25, 0.3)  # 10 mm between gripper and tower
    assert jogged(close, (0.1, 0.0, 0.0), TOWER).path
    assert jogged(close, (0.0, 0.05, 0.0), TOWER).path
    with pytest.raises(PlanError, match="closer to the part"):
        jogged(close, (-0.002, 0.0, 0.0), TOWER)
    with pytest.raises(PlanError, match="closer to the part"):
        jogged(close, (0.0, 0.0, 0.0), TOWER, turn_rad=0.3)


def test_what_is_touched_is_left_and_not_dragged_along() -> None:
    inside = at(0.3 + 0.035, 0.25, 0.3)  # 10 mm deep in the tower's side
    assert jogged(inside, (0.05, 0.0, 0.0), TOWER).path
    assert jogged(inside, (0.0, 0.0, 0.05), TOWER).path
    with pytest.raises(PlanError, match="would drag along"):
        jogged(inside, (0.0, 0.05, 0.0), TOWER)
    on_top = at(0.25, 0.25, 0.4)
    with pytest.raises(PlanError, match=r"touches the part at \[2, 2, 3\] and would drag"):
        jogged(on_top, (0.05, 0.0, 0.0), TOWER)
    assert jogged(on_top, (0.0, 0.0, 0.05), TOWER).path
    placed_beside = at(0.35, 0.25, 0.1)  # a part in its cell, face to face with the tower
    assert jogged(placed_beside, (0.0, 0.0, 0.1), TOWER, carrying=True).path


def apart_m(here: Vector, part: Cell) -> list[float]:
    """Along x, y and z, between the empty gripper, a box 90 mm wide and 150 mm high, and a part."""
    low = (here[0] - 0.045, here[1] - 0.045, here[2])
    high = (here[0] + 0.045, here[1] + 0.045, here[2] + 0.15)
    return [
        max(index * 0.1 - above, below - (index + 1) * 0.1)
        for index, below, above in zip(part, low, high, strict=True)
    ]


def gap_m(here: Vector, part: Cell) -> float:
    """Between the two, negative where they overlap: by hand."""
    apart = apart_m(here, part)
    outside = math.hypot(*(max(value, 0.0) for value in apart))
    return outside or max(apart)


@settings(max_examples=25, deadline=None)
@given(
    st.floats(0.1, 0.5), st.floats(0.15, 0.45), st.floats(0.06, 0.5), st.sampled_from(range(1, 5))
)
def test_no_step_leads_closer_and_there_is_always_one_that_leads_on(
    x_m: float, y_m: float, z_m: float, height: int
) -> None:
    tower = frozenset(Cell(2, 2, z) for z in range(height))
    start = at(x_m, y_m, z_m)
    # Where the gripper were deeper in a part than that, no part can be: the books are wrong.
    assume(min(gap_m(position_m(start), part) for part in tower) > -0.02)
    open_ways = 0
    for delta_m in STEPS:
        try:
            jogged(start, delta_m, tower)
        except PlanError:
            continue
        open_ways += 1
        for part, share in itertools.product(tower, np.linspace(0.0, 1.0, 11)):
            there = [a + share * b for a, b in zip(position_m(start), delta_m, strict=True)]
            before_m = gap_m(position_m(start), part)
            after_m = gap_m((there[0], there[1], there[2]), part)
            # Straight up past a part that it overlaps at the side, no deeper than it does there.
            aside_m = max(apart_m(position_m(start), part)[:2])
            least_m = min(before_m, -0.002, aside_m if aside_m > -0.02 else 0.0)
            beside = delta_m[2] > 0.0 and after_m >= least_m - 2e-4
            assert beside or after_m > min(before_m, CONFIG.robot.clearance_m) - 2e-4
    assert open_ways


def test_rising_ends_above_everything_that_stands_or_waits() -> None:
    low = at(0.45, 0.25, 0.1)
    assert position_m(PLANNER.rise(low, TOWER, carrying=False).end)[2] == pytest.approx(0.43)
    assert position_m(PLANNER.rise(low, TOWER, carrying=True).end)[2] == pytest.approx(0.53)
    assert position_m(PLANNER.rise(low, frozenset(), carrying=False).end)[2] == pytest.approx(0.33)
    assert PLANNER.rise(at(0.3, 0.3, 0.5), TOWER, carrying=False).path == ()


def test_rising_goes_as_high_as_the_arm_reaches() -> None:
    far = at(0.55, 0.45, 0.3)
    wall = frozenset(Cell(0, 0, z) for z in range(12))
    route = PLANNER.rise(far, wall, carrying=False)
    assert 0.6 < position_m(route.end)[2] < 1.23


def test_rising_under_something_is_refused_by_name() -> None:
    roof = frozenset([Cell(2, 2, 4)])
    with pytest.raises(PlanError, match=r"closer to the part at \[2, 2, 4\]"):
        PLANNER.rise(at(0.25, 0.25, 0.24), roof, carrying=False)


def home_of(start: Stance, placed: frozenset[Cell] = frozenset()) -> Route:
    route = PLANNER.to_home(start, placed, carrying=False)
    assert route.end.joints_rad == pytest.approx(PLANNER.home.joints_rad, abs=0.02)
    return route


def test_home_is_reached_along_a_path_where_there_is_one() -> None:
    route = home_of(PLANNER.place_stance(Cell(1, 1, 0)), TOWER)
    assert route.path
    assert route.joints is None


def other_wrist(here: Stance) -> Stance:
    """The same TCP pose with the wrist on its other side."""
    *arm, wrist_1, wrist_2, wrist_3 = here.joints_rad
    guess = (arm[0], arm[1], arm[2], wrist_1 + math.pi, -wrist_2, wrist_3 - math.pi)
    joints_rad = KINEMATICS.inverse(FRAMES.flange(to_matrix(here.tcp_pose)), guess)
    assert joints_rad is not None
    assert not same_configuration(joints_rad, here.joints_rad)
    return Stance(here.tcp_pose, joints_rad)


def test_another_configuration_is_left_by_turning_the_joints_at_the_end() -> None:
    route = home_of(other_wrist(at(0.3, 0.3, 0.45)))
    assert route.joints == PLANNER.home.joints_rad
    assert 0.0 < route.joint_speed_rad_s <= 0.2
    assert route.duration_s > math.pi / route.joint_speed_rad_s


def test_a_joint_that_is_a_turn_away_is_turned_back() -> None:
    *others, wrist_3 = PLANNER.home.joints_rad
    a, b, c, d, e = others
    route = home_of(Stance(PLANNER.home.tcp_pose, (a, b, c, d, e, wrist_3 - 2 * math.pi)))
    assert route.path == ()
    assert route.joints == PLANNER.home.joints_rad


def test_an_arm_that_touches_something_goes_straight_up_first() -> None:
    route = home_of(at(0.3 + 0.035, 0.25, 0.3), TOWER)  # 10 mm deep in the tower
    start_m, first = position_m(at(0.335, 0.25, 0.3)), route.path[0]
    above_m = position_m(Stance(first.pose, route.end.joints_rad))
    assert above_m[:2] == pytest.approx(start_m[:2], abs=1e-6)
    assert above_m[2] > 0.42
    assert isinstance(first, Waypoint)
    assert first.speed_m_s <= HAND_SPEED_M_S
    assert len(route.path) > 1


def test_a_tool_that_was_tilted_by_hand_comes_home() -> None:
    tcp = to_matrix(at(0.3, 0.3, 0.4).tcp_pose) @ to_matrix((0.0, 0.0, 0.0, 0.3, 0.2, 0.0))
    joints_rad = KINEMATICS.inverse(FRAMES.flange(tcp), PLANNER.home.joints_rad)
    assert joints_rad is not None
    assert home_of(Stance(to_pose(tcp), joints_rad)).path


def test_no_way_home_says_what_is_in_the_way() -> None:
    # A room around the gripper: walls, and a roof above it.
    walls = [
        Cell(x, y, z)
        for x in range(1, 4)
        for y in range(1, 4)
        for z in range(5)
        if (x, y) != (2, 2)
    ]
    with pytest.raises(PlanError, match=r"part at \[2, 2, 4\]") as caught:
        PLANNER.to_home(at(0.25, 0.25, 0.2), frozenset([*walls, Cell(2, 2, 4)]), carrying=False)
    assert "jog the arm clear" in caught.value.hint


def test_turning_the_joints_keeps_the_elbow_clear_too() -> None:
    start, above = at(0.3, 0.3, 0.45), PLANNER.home.joints_rad
    elbow_m = links(np.array([start.joints_rad]), "ur10e").centres[0, 9]
    x, y, z = (FRAMES.cell_from_base @ np.array([*elbow_m, 1.0]))[:3] / CONFIG.voxel.pitch_m
    at_the_elbow = Cell(math.floor(x), math.floor(y), math.floor(z))
    assert PLANNER.check_joint_move(start, above, (), carrying=False) > 0.1
    with pytest.raises(PlanError, match=r"bring the (upper arm|elbow|forearm) to the part"):
        PLANNER.check_joint_move(start, above, [at_the_elbow], carrying=False)


def test_the_places_to_look_at_are_one_pitch_above(config: CellConfig) -> None:
    planner = RoutePlanner(config)
    station = planner.to_above_station(planner.home, (), carrying=False)
    gripping_m = position_m(planner.pick_stance())
    assert np.subtract(position_m(station.end), gripping_m) == pytest.approx((0, 0, 0.1), abs=1e-6)
    above = planner.to_above_cell(Cell(5, 4, 0), station.end, (), carrying=False)
    assert position_m(above.end) == pytest.approx((0.55, 0.45, 0.2), abs=1e-6)
    with pytest.raises(CellctlError, match="outside the workspace"):
        planner.to_above_cell(Cell(6, 0, 0), station.end, (), carrying=False)


def test_a_slowed_route_is_the_same_way() -> None:
    route = PLANNER.to_cell(Cell(3, 2, 0), ())
    slow = route.slowed(0.1)
    assert [w.pose for w in slow.path] == [w.pose for w in route.path]
    for before, after in zip(route.path, slow.path, strict=True):
        assert isinstance(before, JointWaypoint)
        assert isinstance(after, JointWaypoint)
        assert after.speed_rad_s == pytest.approx(0.1 * before.speed_rad_s)
    assert slow.duration_s == pytest.approx(10.0 * route.duration_s)


@pytest.mark.wire
def test_the_arm_goes_home_from_another_configuration(config: CellConfig) -> None:
    """Against the emulated controller, which follows lines and joints by code of its own."""
    led_away = other_wrist(at(0.3, 0.3, 0.45))

    async def scenario(emulator: Emulator) -> None:
        async with connected(emulator.config) as arm:
            await arm.move_joints(led_away.joints_rad, 1.0)
            route = PLANNER.to_home(stance(arm), frozenset(), carrying=False)
            assert route.joints is not None
            await travel(arm, route)
            assert stance(arm).joints_rad == pytest.approx(PLANNER.home.joints_rad, abs=2e-3)
            await travel(arm, PLANNER.jog(stance(arm), frozenset(), (0, 0, 0.02), 0, carrying=True))
            risen_m = position_m(stance(arm))[2] - position_m(PLANNER.home)[2]
            assert risen_m == pytest.approx(0.02, abs=1e-3)

    with Emulator(config, "--clock-rate", "20") as emulator:
        asyncio.run(scenario(emulator))
        assert emulator.truth()["counters"]["protective_stops"] == 0
