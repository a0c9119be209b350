"""What a judgement of the emulated world costs: ``python -m benchmarks.world_physics``.

The world judges once for each part that is let go, in the loop that emulates the robot's
controller. Two kinds of structures of each size are judged: shelves while they are built, layer by
layer, and random ones with few feet, which no single load path proves (``quick`` counts those that
one proves). Milliseconds are processor time. Run it with OPENBLAS_NUM_THREADS=1, as the emulated
cell is run.
"""

from __future__ import annotations

import argparse
import random
import statistics
import time
from collections.abc import Iterator
from pathlib import Path

from cellctl.assembly import Cell
from cellctl.config import load_config
from cellctl.sim.physics import Material, collapse
from cellctl.sim.physics.load_path import unproven

_SIZES = (10, 40, 60, 200)
_LATEST = 20
"""Of a shelf's placements the last ones are judged: the costliest."""

State = tuple[frozenset[Cell], Cell]


def main() -> None:
    """Judge, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=30, help="random structures of each size")
    options = parser.parse_args()
    material = Material.of(load_config(Path(__file__).parents[1] / "config" / "sim.toml"))
    _line("structure", "parts", "judged", "quick", "median ms", "worst ms")
    for parts in _SIZES:
        _report("shelf", parts, _shelf_states(parts), material)
        _report("random", parts, _random_states(parts, options.random), material)


def _report(name: str, parts: int, states: Iterator[State], material: Material) -> None:
    spent_ms, quick = [], 0
    for cells, newest in states:
        quick += not unproven(cells, material, newest)
        begin_s = time.process_time()
        collapse(cells, material, newest)
        spent_ms.append((time.process_time() - begin_s) * 1e3)
    median_ms, worst_ms = statistics.median(spent_ms), max(spent_ms)
    _line(name, parts, len(spent_ms), quick, f"{median_ms:.1f}", f"{worst_ms:.1f}")


def _line(*columns: object) -> None:
    print("".join(f"{column!s:>11}" for column in columns))  # noqa: T201 - a program for people


def _shelf_states(parts: int) -> Iterator[State]:
    """The last placements of two side panels with boards between them."""
    depth = 1 if parts < 20 else 2 if parts < 100 else 4
    order = [
        Cell(x, y, z)
        for z in range(30)
        for y in range(depth)
        for x in (range(6) if z % 3 == 2 else (0, 5))
    ][:parts]
    for count in range(max(1, parts - _LATEST), parts + 1):
        yield frozenset(order[:count]), order[count - 1]


def _random_states(parts: int, count: int) -> Iterator[State]:
    """Grown part by part; the highest part is the newest."""
    size = 6 if parts <= 60 else 10
    for seed in range(count):
        chance = random.Random(seed)  # noqa: S311 - repeatable chance
        cells = {Cell(size // 2, size // 2, 0)}
        while len(cells) < parts:
            near = chance.choice(chance.choice(sorted(cells)).neighbours())
            inside = 0 <= near.x < size and 0 <= near.y < size and 0 <= near.z < 8
            if inside and (near.z > 0 or chance.random() < 0.3):
                cells.add(near)
        yield frozenset(cells), max(cells, key=lambda cell: (cell.z, cell))


if __name__ == "__main__":
    main()
