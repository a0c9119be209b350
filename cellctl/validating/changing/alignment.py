"""Where the next object goes, so that most of what stands can stay."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import NamedTuple

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells

Grid = tuple[int, int, int]


class Transform(NamedTuple):
    """How the wanted object is put down: mirrored, then turned, then shifted."""

    mirrored: bool
    """In the plane x = 0: left becomes right."""
    turns: int
    """Quarter turns about the vertical, counter-clockwise seen from above."""
    shift: tuple[int, int]
    """Of the minimum corner after that, from the workspace's, in cells along x and y."""

    def applied(self, cells: Iterable[Cell]) -> Cells:
        """The cells where they come to stand; the lowest ones on the floor."""
        turned = _turned(frozenset(cells), self.turns, mirrored=self.mirrored)
        dx, dy = self.shift
        return frozenset(Cell(c.x + dx, c.y + dy, c.z) for c in turned)

    def describe(self) -> str:
        """In words; empty where it is put down as it was drawn."""
        said = [f"turned by {self.turns * 90} degrees"] if self.turns else []
        return " and ".join([*said, *(["mirrored"] if self.mirrored else [])])


class Alignment(NamedTuple):
    """One place for the wanted object, and what could stay there."""

    transform: Transform
    wanted: Cells
    """As placed."""
    kept: Cells
    """What can stay, as far as access from above goes."""

    def moves(self, standing: Cells) -> int:
        """Fewest removals and placements from what stands to this."""
        return len(standing) + len(self.wanted) - 2 * len(self.kept)


def alignments(
    standing: Cells,
    wanted: Cells,
    grid: Grid,
    *,
    mirrors: bool = False,
    reachable: Callable[[Cell], bool] | None = None,
) -> tuple[Alignment, ...]:
    """Every place of the wanted object in the grid, the one with fewest moves first.

    Args:
        standing: what stands.
        wanted: the next object, anywhere.
        grid: cells of the workspace along x, y and z.
        mirrors: whether its mirror image serves as well. A symmetric object is its own.
        reachable: whether the arm can put a part there; every cell, if None.
    """
    columns = _columns(standing)
    found = []
    seen: set[Cells] = set()
    for mirrored in (False, True) if mirrors else (False,):
        for turns in range(4):
            turned = _turned(wanted, turns, mirrored=mirrored)
            size = [max(axis) + 1 for axis in zip(*turned, strict=True)]
            if size[2] > grid[2]:
                continue
            for dx in range(grid[0] - size[0] + 1):
                for dy in range(grid[1] - size[1] + 1):
                    transform = Transform(mirrored, turns, (dx, dy))
                    placed = frozenset(Cell(c.x + dx, c.y + dy, c.z) for c in turned)
                    if placed in seen:
                        continue
                    seen.add(placed)
                    if reachable is None or all(map(reachable, placed)):
                        kept = _agreeing(columns, _columns(placed))
                        found.append(Alignment(transform, placed, kept))
    room = (grid[0] - 1, grid[1] - 1)

    def rank(one: Alignment) -> tuple[int, bool, int, int, tuple[int, int]]:
        spans = list(zip(*one.wanted, strict=True))[:2]
        aside = sum(
            abs(min(span) + max(span) - middle) for span, middle in zip(spans, room, strict=True)
        )
        turns, mirrored = one.transform.turns, one.transform.mirrored
        return (one.moves(standing), mirrored, turns, aside, one.transform.shift)

    return tuple(sorted(found, key=rank))


def without(alignment: Alignment, dropped: Cells) -> Alignment:
    """The same place without keeping some cells, nor any that are above them."""
    lowest: dict[tuple[int, int], int] = {}
    for cell in dropped:
        lowest[cell.x, cell.y] = min(cell.z, lowest.get((cell.x, cell.y), cell.z))
    kept = frozenset(
        cell
        for cell in alignment.kept
        if (cell.x, cell.y) not in lowest or cell.z < lowest[cell.x, cell.y]
    )
    return alignment._replace(kept=kept)


def _agreeing(
    standing: dict[tuple[int, int], set[int]], placed: dict[tuple[int, int], set[int]]
) -> Cells:
    """Cells of both, column by column up to the first height at which they differ.

    Whatever differs is moved from above, so nothing above it can stay.
    """
    kept: set[Cell] = set()
    for place, heights in standing.items():
        others = placed.get(place, set())
        first = min(heights ^ others, default=None)
        kept.update(Cell(*place, z) for z in heights & others if first is None or z < first)
    return frozenset(kept)


def _columns(cells: Cells) -> dict[tuple[int, int], set[int]]:
    columns: dict[tuple[int, int], set[int]] = defaultdict(set)
    for cell in cells:
        columns[cell.x, cell.y].add(cell.z)
    return columns


def _turned(cells: Cells, turns: int, *, mirrored: bool) -> Cells:
    """Mirrored, then turned, with the minimum corner at the origin."""
    points = [(-c.x if mirrored else c.x, c.y, c.z) for c in cells]
    for _ in range(turns % 4):
        points = [(-y, x, z) for x, y, z in points]
    low = [min(axis) for axis in zip(*points, strict=True)]
    return frozenset(Cell(x - low[0], y - low[1], z - low[2]) for x, y, z in points)
