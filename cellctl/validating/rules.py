"""What an assembly must satisfy to be built by this cell, each rule a check with its cells.

Parts and unsupported stack are counts, after the paper's section 3.3; connectivity and access from
above are what building part by part needs besides. Whether it stands is another room's matter
(stability).
"""

from __future__ import annotations

from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from functools import lru_cache

from cellctl.assembly import Cell, Check
from cellctl.validating import words

Cells = frozenset[Cell]

_LATERAL = ((1, 0), (-1, 0), (0, 1), (0, -1))
_DIAGONAL = ((1, 1), (1, -1), (-1, 1), (-1, -1))


def size_of(cells: Cells) -> tuple[int, int, int]:
    """Extent in cells along x, y and z, of at least one cell."""
    spans = [max(axis) - min(axis) + 1 for axis in zip(*cells, strict=True)]
    return (spans[0], spans[1], spans[2])


def to_corner(cells: Iterable[Cell]) -> Cells:
    """The same cells, moved to [0, 0, 0]: a shape that floats is set on the floor."""
    all_of = list(cells)
    low = [min(axis) for axis in zip(*all_of, strict=True)]
    return frozenset(Cell(c.x - low[0], c.y - low[1], c.z - low[2]) for c in all_of)


def supported(cell: Cell, cells: AbstractSet[Cell]) -> bool:
    """Whether a cell rests on the floor or on another part."""
    return cell.z == 0 or cell.below() in cells


@lru_cache(maxsize=16384)
def lateral(cell: Cell) -> tuple[Cell, Cell, Cell, Cell]:
    """The four cells beside this one, in its layer."""
    x, y, z = cell
    return (Cell(x + 1, y, z), Cell(x - 1, y, z), Cell(x, y + 1, z), Cell(x, y - 1, z))


def reach_steps(cell: Cell, cells: Cells | set[Cell]) -> list[Cell]:
    """Cells of the same layer that are one step of overhang away.

    Beside it, or across a corner around which a part connects the two.
    """
    x, y, z = cell
    steps = [beside for beside in lateral(cell) if beside in cells]
    for dx, dy in _DIAGONAL:
        across = Cell(x + dx, y + dy, z)
        if across in cells and (Cell(x + dx, y, z) in cells or Cell(x, y + dy, z) in cells):
            steps.append(across)
    return steps


def steps_from(cells: AbstractSet[Cell], resting: AbstractSet[Cell]) -> dict[Cell, int]:
    """Steps to the nearest cell that rests on something, of all that are joined to one."""
    steps = dict.fromkeys(sorted(resting), 0)
    front = list(steps)
    while front:
        following = []
        for cell in front:
            for beside in lateral(cell):
                if beside in cells and beside not in steps:
                    steps[beside] = steps[cell] + 1
                    following.append(beside)
        front = following
    return steps


def pieces(cells: Iterable[Cell]) -> list[frozenset[Cell]]:
    """Sets of cells that hang together by faces, the largest first."""
    left = set(cells)
    found = []
    while left:
        start = min(left, key=lambda c: (c.z, c.x, c.y))
        left.discard(start)
        piece, front = {start}, [start]
        while front:
            for beside in front.pop().neighbours():
                if beside in left:
                    left.discard(beside)
                    piece.add(beside)
                    front.append(beside)
        found.append(frozenset(piece))
    return sorted(found, key=len, reverse=True)


def unsupported_stacks(cells: Cells, limit: int) -> tuple[int, frozenset[Cell]]:
    """Longest run of cells on top of each other without a lateral neighbour, and all too long."""
    longest = 0
    beyond: set[Cell] = set()
    lone = {cell for cell in cells if not any(beside in cells for beside in lateral(cell))}
    for cell in lone:
        if cell.below() in lone:
            continue
        run = [cell]
        while (above := Cell(cell.x, cell.y, run[-1].z + 1)) in lone:
            run.append(above)
        longest = max(longest, len(run))
        if len(run) > limit:
            beyond.update(run)
    return longest, frozenset(beyond)


def check_count(cells: Cells, parts: int) -> Check:
    """No more parts than there are."""
    passed = len(cells) <= parts
    message = f"{words.parts(len(cells))}; {words.counted(parts, 'is', 'are')} there."
    return Check(name="count", passed=passed, message=message, cells=() if passed else _all(cells))


def check_stack(cells: Cells, limit: int) -> Check:
    """No free-standing column higher than the limit."""
    longest, beyond = unsupported_stacks(cells, limit)
    message = (
        f"The highest column without a neighbour is {words.parts(longest)} high; "
        f"the limit is {limit}."
        if longest
        else "No column is without a neighbour."
    )
    return Check(name="stack", passed=not beyond, message=message, cells=_all(beyond))


def check_connectivity(cells: Cells) -> Check:
    """All parts hang together by faces."""
    found = pieces(cells)
    loose = frozenset[Cell]().union(*found[1:])
    message = (
        "All parts hang together."
        if len(found) == 1
        else f"It falls into {len(found)} pieces that share no face."
    )
    return Check(name="connectivity", passed=not loose, message=message, cells=_all(loose))


def check_grounded(cells: Cells) -> Check:
    """Something stands on the floor."""
    feet = sum(1 for cell in cells if cell.z == 0)
    standing = words.parts(feet, "stands", "stand")
    message = f"{standing} on the floor." if feet else "Nothing stands on the floor."
    return Check(
        name="grounded", passed=feet > 0, message=message, cells=() if feet else _all(cells)
    )


def hanging(cells: Cells) -> frozenset[Cell]:
    """Cells that could only hang from a part above them: no part of their layer that they are
    joined to rests on anything, so they cannot be placed from above in time."""
    found: set[Cell] = set()
    for z in {cell.z for cell in cells}:
        for piece in pieces(cell for cell in cells if cell.z == z):
            if not any(supported(cell, cells) for cell in piece):
                found |= piece
    return frozenset(found)


def check_access(cells: Cells) -> Check:
    """Every layer can be laid from above on the layer below it."""
    cut_off = hanging(cells)
    message = (
        "Every part can be placed from above."
        if not cut_off
        else f"{words.parts(len(cut_off))} would have to hang from what is above."
    )
    return Check(name="access", passed=not cut_off, message=message, cells=_all(cut_off))


def _all(cells: Iterable[Cell]) -> tuple[Cell, ...]:
    return tuple(sorted(cells, key=lambda c: (c.z, c.x, c.y)))
