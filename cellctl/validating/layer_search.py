"""An order of one layer, sought part by part where the simple ones do not hold.

A beam search: a few partial orders are kept at each length, those that squeeze in the fewest parts
and strain the joints least. Partial orders of the same parts stand alike but for what their worst
step was, so only the better one is kept.
"""

from __future__ import annotations

from typing import NamedTuple

from cellctl.assembly import Cell
from cellctl.validating.layer_orders import gaps_left, is_between
from cellctl.validating.rules import Cells, lateral
from cellctl.validating.stability import Verdict
from cellctl.validating.stability.growth import Growth

_LARGE = 4000
"""Proofs times parts that stand, at most: each proof takes longer the more they are."""


class Search(NamedTuple):
    """How hard to search."""

    beam: int
    """Partial orders that are kept at each length."""
    branches: int
    """Most next parts that are proven for each of them."""
    proofs: int
    """Parts that are placed in all, at most: bounds the time."""


class Partial(NamedTuple):
    """The beginning of an order."""

    cells: tuple[Cell, ...]
    verdicts: tuple[Verdict, ...]
    growth: Growth
    tight: int

    @property
    def pull(self) -> float:
        """What the worst step needs, as a share of the magnets' force."""
        return max((1.0 / verdict.margin for verdict in self.verdicts), default=0.0)


def search_layer(
    layer: Cells, start: Growth, effort: Search, *, avoid_tight: bool
) -> Partial | None:
    """The best order that a bounded search finds; None if it finds none.

    Args:
        layer: the cells, all of one z.
        start: what stands before; it is left as it is.
        effort: how hard to search.
        avoid_tight: give up where a part would have to go between two others.
    """
    most_proofs = min(effort.proofs, _LARGE // max(1, len(start.cells)))
    if effort.beam * len(layer) > most_proofs:
        return None
    beam = [Partial((), (), start, 0)]
    proofs = 0
    for _ in range(len(layer)):
        longer: dict[frozenset[Cell], Partial] = {}
        for partial in beam:
            for cell in _next_cells(layer, partial, effort.branches, avoid_tight=avoid_tight):
                if proofs >= most_proofs:
                    return None
                proofs += 1
                growth = partial.growth.copy()
                verdict = growth.place(cell)
                if verdict.margin < start.physics.least_margin:
                    continue
                found = Partial(
                    (*partial.cells, cell),
                    (*partial.verdicts, verdict),
                    growth,
                    partial.tight + is_between(cell, partial.growth.cells),
                )
                key = frozenset(found.cells)
                if key not in longer or _price(found) < _price(longer[key]):
                    longer[key] = found
        beam = sorted(longer.values(), key=_price)[: effort.beam]
        if not beam:
            return None
    return beam[0]


def _price(partial: Partial) -> tuple[int, float, tuple[Cell, ...]]:
    return (partial.tight, round(partial.pull, 6), partial.cells)


def _next_cells(layer: Cells, partial: Partial, branches: int, *, avoid_tight: bool) -> list[Cell]:
    """Cells that may come next: those that leave no gap first, then those near support."""
    standing = partial.growth.cells
    ready = [
        cell
        for cell in layer - standing
        if cell.z == 0
        or cell.below() in standing
        or any(beside in standing for beside in lateral(cell))
    ]

    def price(cell: Cell) -> tuple[int, bool, Cell]:
        tight = is_between(cell, standing) + gaps_left(cell, standing, layer)
        return (tight, cell.z > 0 and cell.below() not in standing, cell)

    if avoid_tight:
        # What grows from one front meets no other; whoever begins at both ends closes a gap.
        begun = {cell for cell in partial.cells if cell in layer}
        ready = [c for c in ready if not begun or not begun.isdisjoint(lateral(c))]
        ready = [c for c in ready if not is_between(c, standing)]
        ready = [c for c in ready if not gaps_left(c, standing, layer)]
    return sorted(ready, key=price)[:branches]
