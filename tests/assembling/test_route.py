"""Routes: every cell in reach, heights, what must not be touched, one configuration."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from cellctl.assembling.arm import JointWaypoint, Waypoint
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import Kinematics, as_joints, same_configuration
from cellctl.assembling.poses import to_matrix, to_pose
from cellctl.assembling.route import Route, RoutePlanner, Stance
from cellctl.assembly import Cell
from cellctl.config import CellConfig, Pose, load_config
from cellctl.errors import PlanError

CONFIGS = Path(__file__).resolve().parents[2] / "config"


@pytest.fixture
def planner(config: CellConfig) -> RoutePlanner:
    return RoutePlanner(config)


def heights_m(config: CellConfig, route: Route) -> list[float]:
    frames = Frames(config)
    return [frames.height_m(to_matrix(waypoint.pose)) for waypoint in route.path]


def slab(nx: int, ny: int, layers: int) -> list[Cell]:
    return [Cell(*c) for c in itertools.product(range(nx), range(ny), range(layers))]


def test_every_cell_of_the_workspace_is_reachable(either_cell: CellConfig) -> None:
    planner = RoutePlanner(either_cell)
    cells = [Cell(*c) for c in itertools.product(*map(range, either_cell.grid))]
    assert len(cells) == 6 * 5 * 6
    assert [cell for cell in cells if not planner.reachable(cell)] == []


@pytest.mark.parametrize("name", ["ur10.toml", "ur10e.toml"])
def test_real_cells_reach_the_corners_of_their_workspace(name: str) -> None:
    planner = RoutePlanner(load_config(CONFIGS / name))
    corners = itertools.product((0, 5), (0, 4), (0, 5))
    assert all(planner.reachable(Cell(*corner)) for corner in corners)
    planner.to_pick(planner.home, ())


def test_the_last_layer_can_be_built_over_all_others(either_cell: CellConfig) -> None:
    planner = RoutePlanner(either_cell)
    below = slab(6, 5, 5)
    beside = Cell(4, 0, 5)
    assert planner.to_cell(beside, below).crossing_height_m == pytest.approx(0.63, abs=0.02)
    for cell in (Cell(0, 0, 5), Cell(5, 4, 5), Cell(0, 4, 5)):
        route = planner.to_cell(cell, [*below, beside])
        assert planner.to_pick(route.end, [*below, beside, cell]).path
    over = planner.to_cell(Cell(5, 0, 5), [*below, beside])
    assert over.crossing_height_m == pytest.approx(0.73, abs=0.1)


def test_crosses_what_stands_with_clearance_and_not_much_higher(
    planner: RoutePlanner, config: CellConfig
) -> None:
    low = planner.to_cell(Cell(2, 2, 0), ()).crossing_height_m
    station_m = config.feeder.frame[2] + config.robot.clearance_m
    assert station_m - 1e-3 <= low < station_m + config.voxel.pitch_m
    for layers in (1, 2, 4):
        route = planner.to_cell(Cell(2, 2, layers), slab(6, 5, layers))
        least_m = 0.1 * layers + config.voxel.pitch_m + config.robot.clearance_m
        assert least_m - 1e-3 <= route.crossing_height_m < max(station_m, least_m) + 0.15


def test_a_tower_aside_does_not_raise_the_crossing(planner: RoutePlanner) -> None:
    tower = [Cell(5, 0, z) for z in range(6)]
    low = planner.to_cell(Cell(0, 4, 0), ())
    assert planner.to_cell(Cell(0, 4, 0), tower).crossing_height_m == low.crossing_height_m
    in_the_way = [Cell(0, 2, z) for z in range(6)]
    over = planner.to_cell(Cell(5, 4, 0), [*in_the_way, *(Cell(0, 3, z) for z in range(6))])
    assert over.crossing_height_m > low.crossing_height_m + 0.2


def test_the_last_stretch_is_slow_and_a_parts_first(
    planner: RoutePlanner, config: CellConfig
) -> None:
    robot = config.robot
    fetching = planner.to_pick(planner.place_stance(Cell(3, 2, 0)), [Cell(3, 2, 0)])
    for route in (planner.to_cell(Cell(3, 2, 0), ()), fetching):
        heights = heights_m(config, route)
        assert heights[-2] - heights[-1] == pytest.approx(robot.approach_height_m, abs=1e-6)
        took_s = turning_s(config, route.path[-2].pose, route.path[-1])
        least_s = robot.approach_height_m / robot.approach_speed_m_s
        # The turn that leads there from a slope may be slower still.
        assert 0.98 * least_s <= took_s <= (1.4 if route is fetching else 1.02) * least_s
        leaving_m = heights[0] - (0.3 if route.path[0].pose[1] < 0.3 else 0.1)
        if route is fetching:
            assert leaving_m > robot.approach_height_m  # it was felt that nothing holds the gripper
        else:
            assert leaving_m == pytest.approx(robot.approach_height_m / 2, abs=1e-6)


@pytest.mark.parametrize("path", ["blended", "square"])
def test_what_was_found_for_carrying_holds_where_an_empty_gripper_touches_too(
    config: CellConfig, path: str
) -> None:
    def told(**limits: float) -> list[tuple[list[float], list[float]]]:
        robot = config.robot.model_copy(update={"path": path, **limits})
        planner = RoutePlanner(config.model_copy(update={"robot": robot}))
        fetching = planner.to_pick(planner.home, ())
        return [
            paces_of(route)
            for route in (fetching, planner.to_seat(Cell(2, 2, 0), fetching.end, ()))
        ]

    # Less than the slow stretch is told by itself.
    speed, rate = config.robot.approach_speed_m_s / 2, config.robot.approach_acceleration_m_s2 / 4
    (fetch, fetch_rates), (bring, bring_rates) = told()
    (careful, careful_rates), (carried, carried_rates) = told(
        carrying_speed_m_s=speed, carrying_acceleration_m_s2=rate
    )
    assert careful[:-2] == fetch[:-2]
    assert careful_rates[:-2] == fetch_rates[:-2]
    assert careful[-1] <= 0.51 * fetch[-1]
    assert careful_rates[-1] <= 0.26 * fetch_rates[-1]
    assert all(one < 0.6 * other for one, other in zip(carried, bring, strict=True))
    assert all(one < 0.6 * other for one, other in zip(carried_rates, bring_rates, strict=True))


def paces_of(route: Route) -> tuple[list[float], list[float]]:
    """Speeds and accelerations of the legs, of the TCP or of the joints."""
    paces = [
        (point.speed_rad_s, point.acceleration_rad_s2)
        if isinstance(point, JointWaypoint)
        else (point.speed_m_s, point.acceleration_m_s2)
        for point in route.path
    ]
    return [speed for speed, _ in paces], [rate for _, rate in paces]


def test_an_empty_gripper_leaves_and_comes_on_a_slope_unless_something_near_is_higher(
    planner: RoutePlanner,
) -> None:
    cell, start = Cell(3, 2, 0), planner.place_stance(Cell(3, 2, 0))
    beside = [cell._replace(x=2), cell._replace(x=4), cell._replace(y=1), cell._replace(y=3)]

    def aside_m(route: Route, at: int, end: Pose) -> float:
        return math.dist(route.path[at].pose[:2], end[:2])

    level = planner.to_pick(start, [cell, *beside])
    station = level.end.tcp_pose
    assert aside_m(level, 0, start.tcp_pose) > 0.02
    assert aside_m(level, -3, station) > 0.02
    assert aside_m(level, -2, station) < 1e-6  # where it is slow, straight down
    walled = planner.to_pick(start, [cell, *beside, *(one._replace(z=1) for one in beside)])
    assert aside_m(walled, 0, start.tcp_pose) < 1e-6
    assert walled.duration_s > level.duration_s
    carried = planner.to_seat(cell, level.end, beside)
    assert aside_m(carried, 0, station) < 1e-6
    assert aside_m(carried, -3, carried.end.tcp_pose) < 1e-6


def test_wherever_an_empty_gripper_stops_it_goes_on_and_retreats(
    planner: RoutePlanner, config: CellConfig
) -> None:
    placed = slab(3, 3, 2)
    start = planner.freed(Cell(1, 1, 1))
    route = planner.to_pick(start, placed)
    poses = [start.tcp_pose, *(point.pose for point in route.path)]
    stops = [
        stopped_at(config, leg, share) for leg in itertools.pairwise(poses) for share in (0.4, 0.9)
    ]
    assert len(stops) >= 10
    for stop in stops:
        onward = planner.to_pick(stop, placed).end.tcp_pose
        assert math.dist(onward[:3], route.end.tcp_pose[:3]) < 0.001
        assert planner.retreat(stop, placed, carrying=False).duration_s >= 0.0
        assert planner.to_home(stop, placed, carrying=False).joints is None


def stopped_at(config: CellConfig, leg: tuple[Pose, Pose], share: float) -> Stance:
    """At a share of one leg of a path, on which the joints go straight."""
    home, frames, kinematics = config.robot.home_rad, Frames(config), Kinematics("ur10e")
    one, other = (kinematics.inverse(frames.flange(to_matrix(pose)), home) for pose in leg)
    assert one is not None
    assert other is not None
    joints = as_joints(np.add(one, share * np.subtract(other, one)))
    return Stance(to_pose(frames.tcp(kinematics.forward(joints))), joints)


def turning_s(config: CellConfig, start: Pose, end: Waypoint | JointWaypoint) -> float:
    """How long the way to a corner takes at its speed, without speeding up or braking."""
    assert isinstance(end, JointWaypoint)
    home = config.robot.home_rad
    frames, kinematics = Frames(config), Kinematics(config.robot.model)
    a, b = (kinematics.inverse(frames.flange(to_matrix(p)), home) for p in (start, end.pose))
    assert a is not None
    assert b is not None
    return max(abs(one - two) for one, two in zip(a, b, strict=True)) / end.speed_rad_s


def test_goes_straight_down_on_its_cell(planner: RoutePlanner) -> None:
    goal = planner.place_stance(Cell(4, 1, 0)).tcp_pose
    *_, above, near, last = planner.to_cell(Cell(4, 1, 0), ()).path
    assert last.pose == pytest.approx(goal)
    for waypoint in (above, near):
        assert waypoint.pose[:2] == pytest.approx(goal[:2], abs=1e-9)
        assert waypoint.pose[3:] == pytest.approx(goal[3:], abs=1e-9)


def test_a_part_is_pressed_on_a_column_and_on_nothing_else(
    planner: RoutePlanner, config: CellConfig
) -> None:
    start, depth_m = planner.pick_stance(), config.robot.touch_depth_m
    for placed, cell, below_m in (
        ((), Cell(2, 2, 0), depth_m),
        ((Cell(2, 2, 0),), Cell(2, 2, 1), depth_m),
        ((Cell(1, 2, 0), Cell(1, 2, 1)), Cell(2, 2, 1), 0.0),
    ):
        end = planner.to_seat(cell, start, placed).end
        seat = planner.place_stance(cell).tcp_pose
        assert np.subtract(seat, end.tcp_pose)[:3] == pytest.approx((0, 0, below_m), abs=1e-9)
    with pytest.raises(PlanError, match="already occupied"):
        planner.to_seat(Cell(2, 2, 0), start, [Cell(2, 2, 0)])


def test_a_covered_cell_is_refused(planner: RoutePlanner) -> None:
    with pytest.raises(PlanError, match=r"would touch the part at \[2, 2, 1\]"):
        planner.to_cell(Cell(2, 2, 0), [Cell(2, 2, 1)])


def test_an_occupied_cell_is_refused(planner: RoutePlanner) -> None:
    with pytest.raises(PlanError, match="already occupied"):
        planner.to_cell(Cell(2, 2, 0), [Cell(2, 2, 0)])


def test_a_cell_outside_the_workspace_is_refused(planner: RoutePlanner) -> None:
    with pytest.raises(PlanError, match="outside the workspace of 6 x 5 x 6"):
        planner.place_stance(Cell(6, 0, 0))
    assert not planner.reachable(Cell(0, 0, -1))


def test_a_slot_between_two_neighbours_takes_a_part(planner: RoutePlanner) -> None:
    assert planner.to_cell(Cell(2, 2, 0), [Cell(1, 2, 0), Cell(3, 2, 0)]).path


def test_a_wider_gripper_does_not_fit_into_a_slot(config: CellConfig) -> None:
    tool = config.tool.model_copy(update={"width_m": 0.13})
    planner = RoutePlanner(config.model_copy(update={"tool": tool}))
    tall = [Cell(1, 2, 0), Cell(1, 2, 1)]
    with pytest.raises(PlanError, match=r"would touch the part at \[1, 2, 1\]"):
        planner.to_cell(Cell(2, 2, 0), tall)


def test_out_of_reach_is_refused(config: CellConfig) -> None:
    base = config.base.model_copy(update={"frame": (0.3, -1.2, 0.35, 0.0, 0.0, 0.0)})
    planner = RoutePlanner(config.model_copy(update={"base": base}))
    assert not planner.reachable(Cell(0, 4, 0))


def test_a_deep_hole_takes_a_part_until_the_wrist_is_in_the_way(planner: RoutePlanner) -> None:
    def around_a_hole(layers: int) -> list[Cell]:
        return [cell for cell in slab(6, 5, layers) if cell[:2] != (2, 2)]

    assert planner.to_cell(Cell(2, 2, 0), around_a_hole(2)).path
    with pytest.raises(PlanError, match="wrist would come too close to the part"):
        planner.to_cell(Cell(2, 2, 0), around_a_hole(3))


def test_blends_do_not_overlap(planner: RoutePlanner) -> None:
    route = planner.to_cell(Cell(5, 4, 2), slab(6, 5, 2))
    poses = [planner.pick_stance().tcp_pose, *(w.pose for w in route.path)]
    blends = [0.0, *(w.blend_radius_m for w in route.path)]
    for (a, b), (r, s) in zip(itertools.pairwise(poses), itertools.pairwise(blends), strict=True):
        assert r + s <= math.dist(a[:3], b[:3])
    assert route.path[-1].blend_radius_m == 0.0


def test_one_arm_configuration_all_the_way(planner: RoutePlanner) -> None:
    stance = planner.home
    placed: list[Cell] = []
    for cell in (Cell(0, 0, 0), Cell(5, 4, 0), Cell(2, 2, 0)):
        for route in (planner.to_pick(stance, placed), planner.to_cell(cell, placed)):
            assert same_configuration(route.end.joints_rad, planner.home.joints_rad)
            stance = route.end
        placed.append(cell)
    assert planner.to_home(stance, placed, carrying=False).end.tcp_pose == pytest.approx(
        planner.home.tcp_pose, abs=1e-6
    )


def test_a_step_names_its_height_and_duration(planner: RoutePlanner) -> None:
    first = planner.step(Cell(2, 2, 0), ())
    assert first.duration_s == pytest.approx(
        planner.to_pick(planner.home, ()).duration_s
        + planner.to_seat(Cell(2, 2, 0), planner.pick_stance(), ()).duration_s
        + planner.closing_s
        + planner.placing_s(Cell(2, 2, 0), ())
    )
    higher = planner.step(Cell(2, 2, 4), slab(6, 5, 4), Cell(2, 1, 3))
    assert higher.clearance_m > first.clearance_m


def test_goes_on_from_anywhere_with_its_part(planner: RoutePlanner, config: CellConfig) -> None:
    whole = planner.to_cell(Cell(3, 3, 1), slab(6, 5, 1))
    half_way = whole.path[1].pose
    below_the_crossing: Pose = (*half_way[:2], half_way[2] + 0.05, *half_way[3:])
    flange = Frames(config).flange(to_matrix(below_the_crossing))
    joints_rad = Kinematics("ur10e").inverse(flange, whole.end.joints_rad)
    assert joints_rad is not None
    start = Stance(below_the_crossing, joints_rad)
    route = planner.to_cell(Cell(3, 3, 1), slab(6, 5, 1), start)
    assert route.path[-1].pose == whole.path[-1].pose


def test_there_already_is_no_movement(planner: RoutePlanner) -> None:
    route = planner.to_pick(planner.pick_stance(), ())
    assert route.path == ()
    assert route.duration_s == 0.0


def test_retreat_clears_everything_that_stands(planner: RoutePlanner, config: CellConfig) -> None:
    placed = [Cell(2, 2, 0), *(Cell(4, 4, z) for z in range(4))]
    route = planner.retreat(planner.place_stance(Cell(2, 2, 0)), placed, carrying=False)
    assert heights_m(config, route)[-1] == pytest.approx(0.43, abs=1e-6)
    with_part = planner.retreat(planner.place_stance(Cell(2, 2, 1)), placed, carrying=True)
    assert heights_m(config, with_part)[-1] == pytest.approx(0.53, abs=1e-6)


def line_to(pose: Pose, speed_m_s: float = 0.2) -> tuple[Waypoint, ...]:
    return (Waypoint(pose=pose, speed_m_s=speed_m_s, acceleration_m_s2=20.0),)


def test_an_operators_path_meets_the_same_checks(planner: RoutePlanner) -> None:
    start = planner.place_stance(Cell(0, 0, 1))
    goal = planner.place_stance(Cell(5, 0, 1)).tcp_pose
    between = [Cell(3, 0, 1)]
    assert planner.check(start, line_to(goal), (), carrying=True).tcp_pose == goal
    with pytest.raises(PlanError, match=r"part it carries would touch the part at \[3, 0, 1\]"):
        planner.check(start, line_to(goal), between, carrying=True)
    raised = planner.rise(start, frozenset(between), carrying=False).end
    higher: Pose = (*goal[:2], raised.tcp_pose[2], *goal[3:])
    assert planner.check(raised, line_to(higher), between, carrying=False).tcp_pose == higher
    with pytest.raises(PlanError, match="too fast for the arm's joints"):
        planner.check(start, line_to(goal, 3.0), (), carrying=False)
    floor: Pose = (goal[0], goal[1], goal[2] - 0.25, *goal[3:])
    with pytest.raises(PlanError, match="would touch the floor"):
        planner.check(start, line_to(floor), (), carrying=False)
    with pytest.raises(PlanError, match="does not reach"):
        planner.check(start, line_to((0.0, 1.6, 0.0, *goal[3:])), (), carrying=False)


def test_the_belt_and_the_pedestal_are_in_the_way(planner: RoutePlanner) -> None:
    station = planner.pick_stance()
    x, y, z, *turn = station.tcp_pose
    below: Pose = (x, y, z - 0.12, turn[0], turn[1], turn[2])
    with pytest.raises(PlanError, match=r"would touch the (belt|part)"):
        planner.check(station, line_to(below), (), carrying=False)
    beside: Pose = (0.12, 0.10, -0.2, turn[0], turn[1], turn[2])
    with pytest.raises(PlanError):
        planner.check(station, line_to(beside), (), carrying=False)


def test_turning_the_joints_is_checked_too(planner: RoutePlanner) -> None:
    high = planner.to_pick(planner.home, ()).end
    assert planner.check_joint_move(planner.home, planner.home.joints_rad, (), carrying=False) == 0
    lowered = planner.place_stance(Cell(1, 1, 0))
    assert planner.check_joint_move(lowered, planner.home.joints_rad, (), carrying=False) > 0.1
    wall = [Cell(x, y, z) for x in (0, 1) for y in range(5) for z in range(6) if (x, y) != (1, 1)]
    with pytest.raises(PlanError, match="would touch"):
        planner.check_joint_move(lowered, high.joints_rad, wall, carrying=False)
