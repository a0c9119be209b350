"""How fast the arm builds the paper's four objects: ``python -m benchmarks.motion``.

Every route of every object goes through the emulated controller's own motion in process, with the
emulated world as judge; the time of a part is what its two movements take there, and what the arm
stands meanwhile as it is told (latch, setting out). Beside it stands the bound: each joint as fast
as it can from pick to place and back, nothing in the way, and the latch's travel; and the same with
what the rules of placing cost at least. ``--wire`` builds
objects through the whole cell as well, with daemon, sockets and boards, at real speed, and compares
what was told with what it took. ``--model`` takes the other arm. Where each second of a part goes
tells ``python -m benchmarks.phases``.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import JOINT_SPEEDS_RAD_S, Kinematics
from cellctl.assembling.poses import to_matrix
from cellctl.assembling.route import RoutePlanner, Stance
from cellctl.assembly import Cell, PartOutcome
from cellctl.cli.daemon_process import running_daemon, wait_idle
from cellctl.client import CellClient
from cellctl.config import CellConfig, Joints, load_config
from cellctl.messages import PartData
from cellctl.sim.client import SimClient
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from cellctl.validating.paper.objects import OBJECTS
from cellctl.validating.paper.workbench import Worked
from cellctl.validating.plan import plan_cells
from tests.assembling.executed import Bench, Executed

CONFIG = Path(__file__).parents[1] / "config" / "sim.toml"
LATCH_TRAVEL_S = 0.35
"""Of the emulated latch, each way."""
STRAIGHT_LIFT_M = 0.03
"""As far as a joint to the next part on the belt reaches, in the emulated cell."""
PAPER_S_A_PART = {"stool": 7.2, "shelf": 9.75, "letter t": 9.3, "table": 11.05}
PACES: dict[str, dict[str, Any]] = {
    "square, 2 m/s, 1 m/s2": {
        "path": "square",
        "travel_speed_m_s": 2.0,
        "travel_acceleration_m_s2": 1.0,
    },
    "1 m/s": {"travel_speed_m_s": 1.0, "travel_acceleration_m_s2": 20.0},
    "joint limits": {"travel_speed_m_s": 3.0, "travel_acceleration_m_s2": 20.0},
    "1 m/s2": {"travel_speed_m_s": 2.0, "travel_acceleration_m_s2": 1.0},
}
_PATIENCE_S = 1200.0
_NEAR_M = 0.005


@dataclass(frozen=True)
class Built:
    """One object at one pace."""

    parts: int
    seconds: float
    """From the first fetch to the last part, without the way home."""
    told_s: float
    worst: float
    """By what share the part took longer or shorter that was told worst."""
    planning_s: float
    """Processor time of planning its routes."""
    seen: Executed


def orders(config: CellConfig) -> dict[str, list[Cell]]:
    """The paper's objects as it built them, in the order of this cell's plan."""
    found = {}
    for subject in OBJECTS:
        cells = Worked(subject, config).complete.found.cells
        plan = plan_cells(cells, config, title=subject.name)
        found[subject.title.lower()] = [step.cell for step in plan.steps]
    return found


def paced(config: CellConfig, pace: str) -> CellConfig:
    """The cell at a pace."""
    return config.model_copy(update={"robot": config.robot.model_copy(update=PACES[pace])})


def build(config: CellConfig, order: list[Cell]) -> Built:
    """Carry out every route in process."""
    began_s = time.process_time()
    planner = RoutePlanner(config)
    told_s: list[float] = []
    placed: list[Cell] = []
    for cell, before in zip(order, [None, *order], strict=False):
        told_s.append(planner.step(cell, placed, before).duration_s)
        placed.append(cell)
    planning_s = time.process_time() - began_s
    bench = Bench(config)
    seen = bench.build(order)
    standing_s = [
        planner.closing_s + planner.placing_s(cell, order[:i]) for i, cell in enumerate(order)
    ]
    took_s = np.add(bench.parts_s, standing_s)
    worst = float(np.abs(took_s / told_s - 1.0).max())
    # Rising a little from a part that was let go is told as part of the standing.
    seconds = bench.building_s - bench.rising_s + sum(standing_s)
    return Built(len(order), seconds, sum(told_s), worst, planning_s, seen)


def direct_s(config: CellConfig, a: Joints, b: Joints) -> float:
    """From one joint position to another, each joint as fast as it can."""
    rate = config.robot.joint_acceleration_rad_s2
    way, most = np.abs(np.subtract(a, b)), np.array(JOINT_SPEEDS_RAD_S)
    cruising = way / most + most / rate
    return float(np.max(np.where(way > most**2 / rate, cruising, 2.0 * np.sqrt(way / rate))))


def bound_s(config: CellConfig, order: list[Cell]) -> float:
    """No arm with these joints is quicker."""
    planner = RoutePlanner(config)
    pick = planner.pick_stance().joints_rad
    at, total_s = planner.home.joints_rad, 0.0
    for cell in order:
        there = planner.place_stance(cell).joints_rad
        total_s += direct_s(config, at, pick) + direct_s(config, pick, there) + 2.0 * LATCH_TRAVEL_S
        at = there
    return total_s


def ruled_bound_s(config: CellConfig, order: list[Cell]) -> float:
    """No arm is quicker that stands as long as told for latch and feeling, is slow where parts
    touch, lifts a part straight off its neighbour on the belt, and brings it straight down beside
    others; corners, clearances and what the joints have to spare cost nothing here."""
    planner, robot = RoutePlanner(config), config.robot
    slow_m_s, rate = robot.approach_speed_m_s, robot.approach_acceleration_m_s2
    touching_s = robot.approach_height_m / slow_m_s + slow_m_s / rate / 2.0
    pick = planner.pick_stance()
    lifting_s = straight_s(config, pick, 0.0, STRAIGHT_LIFT_M)
    at, total_s = planner.home.joints_rad, 0.0
    for i, cell in enumerate(order):
        there = planner.place_stance(cell)
        total_s += direct_s(config, at, pick.joints_rad) + direct_s(
            config, pick.joints_rad, there.joints_rad
        )
        total_s += lifting_s + 2.0 * touching_s
        total_s += planner.closing_s + planner.placing_s(cell, order[:i])
        if any(abs(o.x - cell.x) + abs(o.y - cell.y) == 1 and o.z == cell.z for o in order[:i]):
            deep_m = config.voxel.pitch_m - robot.approach_height_m
            total_s += straight_s(config, there, slow_m_s, deep_m)
        at = there.joints_rad
    return total_s


def straight_s(config: CellConfig, stance: Stance, begun_m_s: float, way_m: float) -> float:
    """Straight up (or down, backwards) as fast as the joints may be accelerated there."""
    above = (*stance.tcp_pose[:2], stance.tcp_pose[2] + _NEAR_M, *stance.tcp_pose[3:])
    frames, arm = Frames(config), Kinematics(config.robot.model)
    joints_rad = arm.inverse(frames.flange(to_matrix(above)), stance.joints_rad)
    assert joints_rad is not None, "it is within reach"
    turned = np.abs(np.subtract(joints_rad, stance.joints_rad)).max() / _NEAR_M
    rate = config.robot.joint_acceleration_rad_s2 / turned
    return float((np.sqrt(begun_m_s**2 + 2.0 * rate * way_m) - begun_m_s) / rate)


def by_wire(config: CellConfig, cells: list[Cell], console: Console) -> None:
    """One object through the whole cell, at real speed."""
    policy = config.policy.model_copy(update={"confirmation": "waived"})
    config = config.model_copy(update={"policy": policy})
    rows = "[" + ",".join(f"[{c.x},{c.y},{c.z}]" for c in cells) + "]"
    content = f'{{"cells": {rows}, "pitch_m": {config.voxel.pitch_m}}}'.encode()
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        own = isolated(config, Path(name), 1.0)
        assert own.emulation is not None, "an emulated cell says where it is controlled"
        with (
            emulated_cell(own, 1.0),
            running_daemon(own, Path(name)) as daemon,
            CellClient.for_role(own) as client,
            SimClient(own.emulation.control) as world,
        ):
            wait_idle(client, daemon)
            client.subscribe()
            client.build("object.json", content)
            outcomes = parts_of(client)
            told_s = sum(outcome.predicted_s or 0.0 for outcome in outcomes)
            took_s = sum(outcome.seconds - outcome.waited_s for outcome in outcomes)
            console.print(
                f"  through the cell: {len(outcomes)} parts, {took_s / len(outcomes):.2f} s a "
                f"part, told {told_s / len(outcomes):.2f}, off by {took_s / told_s - 1.0:+.1%}; "
                f"waited for the belt {sum(o.waited_s for o in outcomes):.2f} s, the latch "
                f"{sum(o.latch_s for o in outcomes):.1f} s, routes "
                f"{sum(o.route_s for o in outcomes):.2f} s, feeling "
                f"{sum(o.touch_s for o in outcomes):.2f} s; "
                f"{len(world.truth().violations)} violations"
            )


def parts_of(client: CellClient) -> list[PartOutcome]:
    """What became of each part, until the job has ended."""
    outcomes: list[PartOutcome] = []
    deadline_s = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline_s:
        for message in client.messages(0.2):
            data = message.payload()
            if isinstance(data, PartData):
                outcomes.append(data.outcome)
        now = client.snapshot()
        if now.fault.entry is not None:
            raise SystemExit(f"Not built: {now.fault.entry.code}: {now.fault.detail}")
        if now.job is not None and now.job.outcome:
            return outcomes
    raise TimeoutError("the object was not finished in time")


def main() -> None:
    """Run it and print tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", choices=["ur10", "ur10e"], default="ur10e")
    parser.add_argument("--wire", nargs="*", default=[], help="objects to build through the cell")
    parser.add_argument("--pace", choices=list(PACES), default="1 m/s", help="of those")
    arguments = parser.parse_args()
    config = load_config(CONFIG)
    robot = config.robot.model_copy(
        update={
            "model": arguments.model,
            "rtde_frequency_hz": 500 if arguments.model == "ur10e" else 125,
        }
    )
    config = config.model_copy(update={"robot": robot})
    console = Console(width=110)
    objects = orders(config)
    table = Table("seconds a part", "paper", *PACES, "bound", "by the rules", title=arguments.model)
    built = {
        (name, pace): build(paced(config, pace), order)
        for (name, order), pace in itertools.product(objects.items(), PACES)
    }
    bounds = {name: bound_s(config, order) for name, order in objects.items()}
    ruled = {
        name: ruled_bound_s(paced(config, "joint limits"), order) for name, order in objects.items()
    }
    for name, order in objects.items():
        cells = [f"{built[name, pace].seconds / len(order):.2f}" for pace in PACES]
        paper = f"{PAPER_S_A_PART[name]:.2f}"
        least = [f"{bound[name] / len(order):.2f}" for bound in (bounds, ruled)]
        table.add_row(f"{name} {len(order)}", paper, *cells, *least)
    total = {pace: sum(built[name, pace].seconds for name in objects) for pace in PACES}
    table.add_row(
        "in all, s",
        "",
        *(f"{total[p]:.0f}" for p in PACES),
        *(f"{sum(bound.values()):.0f}" for bound in (bounds, ruled)),
    )
    console.print(table)
    square = next(iter(PACES))
    for pace in PACES:
        ones = [built[name, pace] for name in objects]
        quicker = [built[name, square].seconds / built[name, pace].seconds for name in objects]
        violations = sum(len(one.seen.violations) for one in ones)
        planning_s = sum(one.planning_s for one in ones) / sum(one.parts for one in ones)
        told = sum(one.told_s for one in ones) / total[pace] - 1.0
        worst = max(one.worst for one in ones)
        fastest, hardest = (
            max(getattr(one.seen, name) for one in ones) for name in ("fastest", "hardest")
        )
        console.print(
            f"{pace}: {total[square] / total[pace]:.2f}x the square path's pace (least "
            f"{min(quicker):.2f}x), {total[pace] / sum(bounds.values()):.2f} of the bound; told "
            f"{told:+.1%}, the worst part {worst:.1%} off; joints at {fastest:.0%} of their speed, "
            f"{hardest:.0%} of their acceleration; {violations} violations; "
            f"{planning_s * 1e3:.0f} ms of planning a part"
        )
    for name in arguments.wire:
        console.print(f"{name} at {arguments.pace}")
        by_wire(paced(config, arguments.pace), objects[name], console)


if __name__ == "__main__":
    main()
