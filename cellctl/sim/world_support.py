"""What a placed part rests on, and what nothing joins to the floor."""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from cellctl.assembly import Cell


def supported(cell: Cell, placed: AbstractSet[Cell]) -> bool:
    """Whether the cell stands on the floor or on a placed part."""
    return cell.z == 0 or cell.below() in placed


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
