"""What changing over saves, and how parts come off: ``python -m benchmarks.changeover``.

Prints two tables for furniture of the paper's kind. First the moves from one object to the next
against clearing and building anew, with the time that the plan took. Then removals, on a floor that
grips and on a bare one: how many straight pulls would break or lift the rest in the order taken,
and the forces of the arm with pulls alone and with the gentlest way.
"""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections import Counter
from pathlib import Path

from cellctl.assembly import Cell
from cellctl.config import load_config
from cellctl.errors import PlanError
from cellctl.validating.access import Gripper
from cellctl.validating.changing import Removal, change_over
from cellctl.validating.changing.breaking import PULL, breakings
from cellctl.validating.changing.moves import Judge
from cellctl.validating.changing.preference import removal_cost
from cellctl.validating.changing.removal import pull_of
from cellctl.validating.rules import Cells
from cellctl.validating.stability import Physics

say = print
"""A program for people."""

CONFIG = load_config(Path(__file__).parents[1] / "config" / "sim.toml")


def _shelf(width: int, height: int, *tiers: int) -> Cells:
    return frozenset(
        Cell(x, y, z)
        for x, y, z in itertools.product(range(width), range(2), range(height))
        if x in (0, width - 1) or z in tiers
    )


def _on_legs(width: int, depth: int, height: int, legs: set[tuple[int, int]]) -> Cells:
    return frozenset(
        Cell(x, y, z)
        for x, y, z in itertools.product(range(width), range(depth), range(height))
        if z == height - 1 or (x, y) in legs
    )


OBJECTS = {
    "shelf 32": _shelf(5, 5, 2, 4),
    "shelf 40": _shelf(6, 6, 2, 5),
    "stool 30": _on_legs(4, 4, 4, {(0, 0), (2, 0), (0, 2), (2, 2), (3, 1)}) - {Cell(3, 3, 3)},
    "table 28": _on_legs(4, 4, 4, {(0, 0), (3, 0), (0, 3), (3, 3)}),
    "letter T 6": frozenset({*(Cell(1, 0, z) for z in range(4)), Cell(0, 0, 3), Cell(2, 0, 3)}),
}


def changes() -> None:
    """Moves for every pair."""
    physics, gripper = Physics.of(CONFIG), Gripper.of(CONFIG)
    say(f"{'from':<11} {'to':<11} {'anew':>5} {'moves':>6} {'saved':>6} {'kept':>5} {'time':>8}")
    moves = anew = 0
    for before, after in itertools.permutations(OBJECTS, 2):
        began_s = time.process_time()
        try:
            found = change_over(OBJECTS[before], OBJECTS[after], CONFIG.grid, physics, gripper)
        except PlanError as refusal:
            say(f"{before:<11} {after:<11} refused: {refusal.message[:60]}")
            continue
        took_s = time.process_time() - began_s
        total = found.moves + found.moves_saved
        moves, anew = moves + found.moves, anew + total
        share = found.moves_saved / total
        say(
            f"{before:<11} {after:<11} {total:>5} {found.moves:>6} {share:>6.0%} "
            f"{len(found.kept):>5} {took_s:>6.2f} s"
        )
    say(f"{'all':<23} {anew:>5} {moves:>6} {1 - moves / anew:>6.0%}\n")


def removals(*, grips: bool) -> None:
    """How each object comes apart, as far as it does."""
    physics = dataclasses.replace(Physics.of(CONFIG), floor_grips=grips)
    say("A floor that grips" if grips else "A bare floor")
    say(f"{'object':<11} {'taken':>8} {'pulls fail':>11} {'pull N':>12} {'gentlest N':>12}  ways")
    for name, cells in OBJECTS.items():
        judge = Judge(physics, Gripper.of(CONFIG))
        left, order = cells, list[Removal]()
        failing, pulls_n = 0, list[float]()
        while left:
            moves = (judge.remove(left, c) for c in sorted(left, key=removal_cost(left)))
            move = next((m for m in moves if m is not None), None)
            if move is None or move.removal is None:
                break
            failing += pull_of(left, move.cell, physics).removal is None
            ways = breakings(left, move.cell, physics)
            pulls_n += [way.force_n for way in ways if way.way == PULL]
            order.append(move.removal)
            left -= {move.cell}
        ways_taken = Counter(removal.how for removal in order)
        say(
            f"{name:<11} {len(order):>3} / {len(cells):>2} {failing:>11} {_span(pulls_n):>12} "
            f"{_span([removal.force_n for removal in order]):>12}  "
            + ", ".join(f"{count} {how}" for how, count in sorted(ways_taken.items()))
        )
    say()


def _span(forces_n: list[float]) -> str:
    return f"{min(forces_n):.0f} to {max(forces_n):.0f}" if forces_n else "-"


def main() -> None:
    """Print the tables."""
    changes()
    removals(grips=True)
    removals(grips=False)


if __name__ == "__main__":
    main()
