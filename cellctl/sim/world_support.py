"""Which placed parts cannot stay where they are, by the paper's counts.

A cell is *supported* when it stands on the floor or on a placed part. From each supported cell one
walks outward along +x, -x, +y and -y, counting unsupported cells until a supported cell or a gap:
more than the limit does not hold. Parts that touch nothing which leads down to the floor do not
hold either.
"""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from cellctl.assembly import Cell

_OUTWARD = ((1, 0), (-1, 0), (0, 1), (0, -1))


def supported(cell: Cell, placed: AbstractSet[Cell]) -> bool:
    """Whether the cell stands on the floor or on a placed part."""
    return cell.z == 0 or cell.below() in placed


def overhangs(placed: AbstractSet[Cell], limit: int) -> list[tuple[Cell, ...]]:
    """Runs of unsupported cells that are longer than ``limit``, each in walking order."""
    runs = []
    for cell in sorted(placed):
        if not supported(cell, placed):
            continue
        for dx, dy in _OUTWARD:
            run = []
            step = Cell(cell.x + dx, cell.y + dy, cell.z)
            while step in placed and not supported(step, placed):
                run.append(step)
                step = Cell(step.x + dx, step.y + dy, step.z)
            if len(run) > limit:
                runs.append(tuple(run))
    return runs


def adrift(placed: AbstractSet[Cell]) -> set[Cell]:
    """Cells that no chain of shared faces joins to the floor."""
    pending = [cell for cell in placed if cell.z == 0]
    joined = set(pending)
    while pending:
        for neighbour in pending.pop().neighbours():
            if neighbour in placed and neighbour not in joined:
                joined.add(neighbour)
                pending.append(neighbour)
    return set(placed) - joined


def falling(placed: AbstractSet[Cell], limit: int, newest: Cell | None) -> set[Cell]:
    """Cells that drop at once; ask again without them, until none does.

    Of a run that is too long, the newest part drops if it is in the run, because before it came
    the run held; otherwise everything past the limit drops.
    """
    drops: set[Cell] = set()
    for run in overhangs(placed, limit):
        drops.update([newest] if newest is not None and newest in run else run[limit:])
    return drops
