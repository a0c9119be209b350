"""Orders proven at every step: ``python -m benchmarks.planning_order [--most N] [--budget S]``.

For shelves of 8 to 1000 parts it prints how long an order takes to find with its proof, how long
the exact proof of all its states takes, which share of them is proven within the budget, and the
least margin; beside it the paper's algorithm 4, grown from one corner, as the baseline, judged with
the same physics. Times are of the processor, so that other work on the machine does not show.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from cellctl.assembly import Cell
from cellctl.config import load_config
from cellctl.errors import PlanError
from cellctl.validating.access import Gripper
from cellctl.validating.layer_orders import tight_fits
from cellctl.validating.order import find_order, sketch_order
from cellctl.validating.rules import Cells
from cellctl.validating.stability import Physics, walk_order

CONFIG = Path(__file__).parents[1] / "config" / "sim.toml"
SIZES = (
    (2, 1, 4),
    (4, 1, 6),
    (6, 2, 6),
    (6, 3, 6),
    (9, 4, 9),
    (11, 4, 9),
    (16, 5, 12),
    (21, 6, 15),
)
"""Width, depth and height of the shelves, in cells."""

PROVEN_WHILE_SOUGHT = 250
"""Larger shelves get an order that is sketched without statics, and then proven as far as the
budget goes."""


def shelf(width: int, depth: int, height: int) -> Cells:
    """Walls at the sides and every fifth cell, tiers every third layer."""
    return frozenset(
        Cell(x, y, z)
        for x in range(width)
        for y in range(depth)
        for z in range(height)
        if x % 5 == 0 or x == width - 1 or z % 3 == 2
    )


def algorithm_4(cells: Cells) -> tuple[Cell, ...]:
    """The paper's order: by layer, and in it always the cell nearest to a placed one."""
    order: list[Cell] = []
    for z in sorted({cell.z for cell in cells}):
        left = sorted(cell for cell in cells if cell.z == z)
        near = dict.fromkeys(left, math.inf)
        for cell in left:
            below = cell.below()
            if z == 0 or below in cells:
                near[cell] = 1.0
        if z == 0:
            near = dict.fromkeys(left, math.inf)
            near[left[0]] = 0.0
        while left:
            # Of several at the same distance the first by x, then y: it grows from a corner.
            best = min(left, key=lambda c: (near[c], c))
            left.remove(best)
            order.append(best)
            for cell in left:
                near[cell] = min(near[cell], float(abs(cell.x - best.x) + abs(cell.y - best.y)))
    return tuple(order)


def prove(order: Sequence[Cell], physics: Physics, budget_s: float) -> tuple[float, float, float]:
    """Seconds, share of the states that were judged in time, and the least margin of these."""
    start_s = time.process_time()
    margin, judged = math.inf, 0
    for verdict in walk_order(order, physics):
        margin, judged = min(margin, verdict.margin), judged + 1
        if time.process_time() - start_s > budget_s:
            break
    return time.process_time() - start_s, judged / len(order), margin


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=1000, help="parts of the largest shelf")
    parser.add_argument("--budget", type=float, default=10.0, help="seconds for one proof")
    options = parser.parse_args()
    config = load_config(CONFIG)
    physics, gripper = Physics.of(config), Gripper.of(config)
    sys.stdout.write(
        "          cellctl: order and    exact       within  least  tight | algorithm 4:   least"
        "  tight\n"
        "  parts   quick proof, s     proof, s  the budget margin   fits |       proven  margin"
        "   fits\n"
    )
    for size in SIZES:
        cells = shelf(*size)
        if len(cells) > options.most:
            break
        start_s = time.process_time()
        try:
            if len(cells) <= PROVEN_WHILE_SOUGHT:
                order = find_order(cells, physics, gripper).cells
            else:
                order = sketch_order(cells, gripper)
        except PlanError as error:
            spent_s = time.process_time() - start_s
            sys.stdout.write(f"{len(cells):7d} {spent_s:16.3f}   {error.message}\n")
            continue
        found_s = time.process_time() - start_s
        proof_s, share, margin = prove(order, physics, options.budget - min(found_s, 1.0))
        naive = algorithm_4(cells)
        _, naive_share, naive_margin = prove(naive, physics, options.budget)
        sys.stdout.write(
            f"{len(cells):7d} {found_s:16.3f} {proof_s:12.3f} {share:10.0%} {margin:7.2f}"
            f" {len(tight_fits(order)):6d} | {naive_share:11.0%} {naive_margin:7.2f}"
            f" {len(tight_fits(naive)):6d}\n"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
