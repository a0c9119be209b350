"""Where each second of a part goes: ``python -m benchmarks.phases [--pace "1 m/s"]``.

Seconds a part, as planned, of each stretch of the two movements, curves with the stretch that they
lead to, and of what the arm stands.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.motion import CONFIG, PACES, orders, paced
from cellctl.assembling.arm import Path
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import Kinematics
from cellctl.assembling.limits import timing_of
from cellctl.assembling.poses import to_matrix
from cellctl.assembling.route import Route, RoutePlanner, Stance
from cellctl.assembling.route_check import RouteChecker
from cellctl.assembly import Cell
from cellctl.config import CellConfig, Pose, load_config

PHASES = (
    "to the station: up",
    "to the station: across",
    "to the station: down",
    "to the station: touch",
    "latch closes, setting out",
    "to the cell: lift off",
    "to the cell: up",
    "to the cell: across",
    "to the cell: down",
    "to the cell: touch",
    "feel the seat, latch opens, feel free",
)
_ASIDE_M = 0.01


def phases(config: CellConfig, order: list[Cell]) -> dict[str, float]:
    """Seconds of each phase, of all parts together."""
    planner = RoutePlanner(config)
    checker = RouteChecker(config, Frames(config), Kinematics(config.robot.model))
    found = dict.fromkeys(PHASES, 0.0)
    placed: list[Cell] = []
    stance = planner.home
    for cell in order:
        fetch = planner.to_pick(stance, placed)
        bring = planner.to_seat(cell, fetch.end, placed)
        for name, start, route in (
            ("to the station", stance, fetch),
            ("to the cell", fetch.end, bring),
        ):
            for kind, seconds in stretches(checker, start, route, config):
                found[f"{name}: {kind}"] += seconds
        found["latch closes, setting out"] += planner.closing_s
        found["feel the seat, latch opens, feel free"] += planner.placing_s(cell, placed)
        stance = bring.end
        placed.append(cell)
    return found


def stretches(
    checker: RouteChecker, start: Stance, route: Route, config: CellConfig
) -> Iterator[tuple[str, float]]:
    """What each piece of a route is, and how long it takes."""
    timing = timing_of(checker.course(start, route.path), route.path)
    kinds = list(legs(start, route.path, config))
    for piece, seconds in zip(timing.pieces, timing.seconds, strict=True):
        yield kinds[piece.leg + 1 if piece.arc else piece.leg], seconds


def legs(start: Stance, path: Path, config: CellConfig) -> Iterator[str]:
    """What each leg of a path is."""
    slow_m = config.robot.approach_height_m + 0.002
    heights = [(Frames(config).cell_from_base @ to_matrix(p))[:3, 3] for p in poses(start, path)]
    for index, (here, there) in enumerate(itertools.pairwise(heights)):
        way = there - here
        short = abs(way[2]) < slow_m
        if np.hypot(way[0], way[1]) > _ASIDE_M:
            yield "across"
        elif way[2] > 0.0:
            yield "lift off" if short and index == 0 else "up"
        else:
            yield "touch" if short and index + 2 == len(heights) else "down"


def poses(start: Stance, path: Path) -> list[Pose]:
    """The corners of a path, its start included."""
    return [start.tcp_pose, *(point.pose for point in path)]


def main() -> None:
    """Run it and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pace", choices=[p for p in PACES if "square" not in p], default="1 m/s")
    arguments = parser.parse_args()
    config = paced(load_config(CONFIG), arguments.pace)
    built = {name: (phases(config, order), len(order)) for name, order in orders(config).items()}
    table = Table("seconds a part", *built, title=arguments.pace)
    for phase in PHASES:
        table.add_row(phase, *(f"{found[phase] / parts:.3f}" for found, parts in built.values()))
    table.add_row(
        "in all", *(f"{sum(found.values()) / parts:.2f}" for found, parts in built.values())
    )
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
