"""In which order the parts are placed.

Layer by layer from the floor, so that the gripper never works beside or beneath a part that stands
higher. Within a layer, every part rests on something or touches a part of its layer that is already
there, and each connected stretch of the layer grows from one front, so that no part has to be
pushed between two others where that can be avoided.
"""

from __future__ import annotations

from cellctl.assembly import Cell, Check
from cellctl.errors import PlanError
from cellctl.validating.rules import Cells, lateral, pieces, reach_steps, supported


def sequence(cells: Cells, overhang_limit: int) -> tuple[Cell, ...]:
    """An order of all cells in which each is grounded or touches one before it.

    Args:
        cells: satisfying the rules of connectivity and access.
        overhang_limit: how far an unfinished layer may hang out before its far side is begun too.

    Raises:
        PlanError: some cells cannot be placed from above.
    """
    order: list[Cell] = []
    for z in range(max((cell.z for cell in cells), default=-1) + 1):
        layer = frozenset(cell for cell in cells if cell.z == z)
        # Smaller pieces last: their columns are the ones that are easiest to reach over.
        for piece in sorted(pieces(layer), key=lambda p: min((c.x, c.y) for c in p)):
            order += _grow(piece, cells, overhang_limit)
    return tuple(order)


def _grow(piece: frozenset[Cell], cells: Cells, overhang_limit: int) -> list[Cell]:
    """One connected stretch of a layer, part by part."""
    resting = {cell for cell in piece if supported(cell, cells)}
    if not resting:
        named = ", ".join(str(list(cell)) for cell in sorted(piece))
        raise PlanError(f"No part carries the cells {named} when their turn comes.")
    placed: set[Cell] = set()
    overhang: dict[Cell, int] = {}
    order: list[Cell] = []

    def reach(cell: Cell) -> int:
        """How far out the cell would hang if it were placed now."""
        if cell in resting:
            return 0
        return 1 + min(overhang[beside] for beside in reach_steps(cell, placed | {cell}))

    def cost(cell: Cell) -> tuple[int, int, int, int, int, int]:
        attached = any(beside in placed for beside in lateral(cell))
        out = reach(cell)
        return (
            max(0, out - overhang_limit),
            _slots(cell, placed, piece),
            int(bool(placed) and not attached),
            out,
            cell.x,
            cell.y,
        )

    while len(order) < len(piece):
        ready = [
            cell
            for cell in piece - placed
            if cell in resting or any(beside in placed for beside in lateral(cell))
        ]
        best = min(ready, key=cost)
        overhang[best] = reach(best)
        placed.add(best)
        order.append(best)
    return order


def _slots(cell: Cell, placed: set[Cell], piece: frozenset[Cell]) -> int:
    """How many tight fits placing a cell now makes: its own, and gaps of one cell it leaves."""
    x, y, z = cell
    count = 0
    for dx, dy in ((1, 0), (0, 1)):
        if {Cell(x + dx, y + dy, z), Cell(x - dx, y - dy, z)} <= placed:
            count += 1
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        gap, far = Cell(x + dx, y + dy, z), Cell(x + 2 * dx, y + 2 * dy, z)
        if gap in piece and gap not in placed and far in placed:
            count += 1
    return count


def tight_fits(order: tuple[Cell, ...]) -> tuple[Cell, ...]:
    """Cells that are placed between two parts that already stand on opposite sides of them."""
    placed: set[Cell] = set()
    found = []
    for cell in order:
        x, y, z = cell
        across = (
            {Cell(x + 1, y, z), Cell(x - 1, y, z)},
            {Cell(x, y + 1, z), Cell(x, y - 1, z)},
        )
        if any(pair <= placed for pair in across):
            found.append(cell)
        placed.add(cell)
    return tuple(found)


def check_order(order: tuple[Cell, ...]) -> Check:
    """Every part is grounded or touches a placed one, and none goes beneath another."""
    placed: set[Cell] = set()
    tops: dict[tuple[int, int], int] = {}
    wrong = []
    for cell in order:
        held = cell.z == 0 or any(beside in placed for beside in cell.neighbours())
        covered = tops.get((cell.x, cell.y), -1) > cell.z
        if not held or covered or cell in placed:
            wrong.append(cell)
        placed.add(cell)
        tops[cell.x, cell.y] = max(cell.z, tops.get((cell.x, cell.y), -1))
    tight = len(tight_fits(order))
    message = (
        f"{len(wrong)} parts would float, or go beneath another."
        if wrong
        else "Every part rests on the floor or touches one before it; "
        f"{tight or 'none'} go{'es' if tight == 1 else ''} between two others."
    )
    return Check(name="order", passed=not wrong, message=message, cells=tuple(wrong))
