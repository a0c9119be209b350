"""What is around a part, among which forces are balanced anew when it is placed."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet

from cellctl.assembly import Cell

_REACHES = (1, 3, 5)
"""Cells beyond the nearest support within which forces are balanced anew, before all are, which
takes a second where they are many."""


def surroundings(
    cell: Cell, cells: AbstractSet[Cell], rooted: AbstractSet[Cell]
) -> Iterator[set[Cell]]:
    """Ever larger ones.

    Args:
        cell: what was placed.
        cells: what stands, it included.
        rooted: those of them that stand on a column down to the floor.
    """
    distance = _support_distance(cell, cells, rooted)
    size = 0
    for reach in _REACHES:
        around = _around(cell, distance + reach, cells)
        if len(around) > size:
            size = len(around)
            yield around


def piece_of(cell: Cell, cells: AbstractSet[Cell]) -> set[Cell]:
    """All cells that hang together with one."""
    seen, front = {cell}, [cell]
    while front:
        for beside in front.pop().neighbours():
            if beside in cells and beside not in seen:
                seen.add(beside)
                front.append(beside)
    return seen


def _support_distance(cell: Cell, cells: AbstractSet[Cell], rooted: AbstractSet[Cell]) -> int:
    """Steps through joints to the nearest cell that stands on a column."""
    seen, front, steps = {cell}, [cell], 0
    while front and not any(one in rooted for one in front):
        near = {beside for one in front for beside in one.neighbours()}
        front = list((near & cells) - seen)
        seen.update(front)
        steps += 1
    return steps


def _around(cell: Cell, steps: int, cells: AbstractSet[Cell]) -> set[Cell]:
    """Cells within so many steps through joints, and those beneath them."""
    seen, front = {cell}, {cell}
    for _ in range(steps):
        near = {beside for one in front for beside in one.neighbours()}
        front = {one for one in near & cells if one.z >= cell.z - 1} - seen
        seen |= front
    for one in list(seen):
        below = one.below()
        while below in cells:
            seen.add(below)
            below = below.below()
    return seen
