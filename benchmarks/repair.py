"""How much of a shape repair keeps: ``python -m benchmarks.repair [--solids N] [--verbose]``.

Makes random furniture, leaves out what can be built as it is, and prints how much of the rest is
kept, by the same measure, by the paper's rescaling and by the search, with the time of each.
"""

from __future__ import annotations

import argparse
import random
import statistics
import sys
import time
from functools import partial
from pathlib import Path

from cellctl.config import load_config
from cellctl.errors import PlanError
from cellctl.generating.boxes import mesh_of
from cellctl.validating.access import Gripper
from cellctl.validating.clean import Surface
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import Shape
from cellctl.validating.paper.policy import plan_paper
from cellctl.validating.repairing import FORMULA, Repaired, Wanted, repair_shape
from cellctl.validating.rules import Cells
from cellctl.validating.stability import Physics
from tests.validating.furniture import furniture

_CONFIG = load_config(Path(__file__).parents[1] / "config" / "sim.toml")


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solids", type=int, default=97, help="that need repair")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--budget-s", type=float, default=20.0)
    parser.add_argument("--verbose", action="store_true", help="print every solid")
    options = parser.parse_args()
    physics, gripper = Physics.of(_CONFIG), Gripper.of(_CONFIG)
    parts = _CONFIG.limits.inventory_parts
    # Probes of the physics and imports are made once a process.
    repair_shape(
        frozenset(_cells(random.Random(0))[1]),  # noqa: S311 - the same solids every time
        physics,
        gripper,
        parts=parts,
        grid=_CONFIG.grid,
        budget_s=options.budget_s,
    )
    rng = random.Random(options.seed)  # noqa: S311 - the same solids every time
    rows: list[tuple[float, float, float, float]] = []
    proven = refused = 0
    while len(rows) < options.solids:
        shape, cells = _cells(rng)
        start_s = time.perf_counter()
        rescaled = _rescaled(shape, parts)
        rescaling_s = time.perf_counter() - start_s
        start_s = time.perf_counter()
        found: Repaired | None = None
        try:
            found = repair_shape(
                cells,
                physics,
                gripper,
                parts=parts,
                grid=_CONFIG.grid,
                budget_s=options.budget_s,
                rescaled=partial(frozenset, rescaled),
            )
        except PlanError:
            refused += 1
        repair_s = time.perf_counter() - start_s
        if found is not None and not found.changes:
            continue
        kept = 0.0 if found is None else found.score
        proven += found is not None and found.proven
        rows.append((Wanted(cells).score(rescaled), kept, rescaling_s, repair_s))
        if options.verbose:
            size = Wanted(cells).size
            told = "refused" if found is None else f"{len(found.cells)} parts"
            sys.stdout.write(
                f"{size} {len(cells)} parts -> {told}: {kept:.3f} against {rows[-1][0]:.3f}, "
                f"{repair_s:.2f} s\n"
            )
    _print(rows, proven, refused)
    return 0


def _cells(rng: random.Random) -> tuple[Shape, Cells]:
    shape = Shape(Surface(*mesh_of(furniture(rng), 1.0)))
    return shape, discretise(shape)


def _rescaled(shape: Shape, parts: int) -> Cells:
    """What the paper's policy would build of it; nothing where it ends without an object that its
    own rules let pass, in mid-air for example."""
    try:
        return plan_paper(shape, _CONFIG.limits, parts).cells
    except PlanError:
        return frozenset()


def _print(rows: list[tuple[float, float, float, float]], proven: int, refused: int) -> None:
    both = [row for row in rows if row[0] > 0.0 and row[1] > 0.0]
    say = sys.stdout.write
    say(f"{FORMULA}\n")
    say(f"{len(rows)} solids that need repair; {proven} proven best, {refused} refused\n")
    for name, some in (("all of them (0 if refused)", rows), ("those that both build", both)):
        rescaled, kept = (statistics.fmean(row[i] for row in some) for i in (0, 1))
        say(
            f"{name}, {len(some)}: rescaling {rescaled:.3f}, search {kept:.3f}, "
            f"difference {kept - rescaled:+.3f}\n"
        )
    for name, column in (("rescaling", 2), ("search", 3)):
        times_s = [row[column] for row in rows]
        say(f"{name}: median {statistics.median(times_s):.2f} s, worst {max(times_s):.2f} s\n")


if __name__ == "__main__":
    sys.exit(main())
