"""In which order the parts are placed.

Layer by layer from the floor: the gripper never works beside or beneath a part that stands higher,
and the arm crosses as low as it can. Within a layer several orders are tried (layer_orders.py), and
each is proven part by part. Of those that hold, the one with the fewest parts that go between two
others is taken, and of these the one with the largest margin. Where none holds, or all squeeze a
part in, a search goes from part to part.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from cellctl.assembly import Cell
from cellctl.errors import PlanError
from cellctl.validating.access import Access
from cellctl.validating.layer_orders import LayerOrder, distinct, layer_orders, tight_fits
from cellctl.validating.layer_search import Search, search_layer
from cellctl.validating.rules import Cells, pieces
from cellctl.validating.stability import Physics, Verdict, assess
from cellctl.validating.stability.growth import GOOD_MARGIN, Growth
from cellctl.validating.words import named

_TRIED = 4
"""Most orders of one layer that are proven, of those that squeeze in the fewest parts, and again of
those that reach out least, if none of the first holds."""
_SAFE_REACH = 2
"""How far a row over nothing reaches out that holds with room to spare."""
_PROOFS = 100
"""Parts placed on trial after which the best order that holds is good enough."""
_SEARCH_TO_HOLD = Search(beam=2, branches=4, proofs=160)
_SEARCH_TO_AVOID = Search(beam=1, branches=3, proofs=50)
"""How hard an order is sought that holds, and one without tight fits where one with them holds."""


_ADVICE = "Support these cells from beneath, let them reach out less far, or make them fewer."


class Order(NamedTuple):
    """An order that is proven to stand at every step."""

    cells: tuple[Cell, ...]
    verdicts: tuple[Verdict, ...]
    """One a step: margins that are proven; ``assess_order`` gives the least of them exactly."""
    tight: tuple[Cell, ...]
    """The parts that go between two others."""

    @property
    def margin(self) -> float:
        """The least of all steps; infinite without any."""
        return min((verdict.margin for verdict in self.verdicts), default=math.inf)


def order_cells(
    cells: Cells, physics: Physics, gripper: Access, given: Cells = frozenset()
) -> tuple[Cell, ...]:
    """As ``find_order``, without the proof."""
    return find_order(cells, physics, gripper, given).cells


def find_order(
    cells: Cells, physics: Physics, gripper: Access, given: Cells = frozenset()
) -> Order:
    """An order of all cells but those that stand, with the verdict of each step.

    Args:
        cells: what shall stand in the end.
        physics: what holds it.
        gripper: what comes down with each part.
        given: what stands already.

    Raises:
        PlanError: no order was found in which every part is held by others, can be reached from
            above and stands; the message names the rule and the cells.
    """
    final = assess(cells | given, physics)
    if final.margin < physics.least_margin:
        raise PlanError(
            "It breaks the rule of stability: the finished object would not stand. "
            f"{_lacking(final, physics)}",
            _ADVICE,
            rule="stability",
            cells=tuple(sorted(final.moving)),
        )
    return lay_all(cells, physics, gripper, given)


def lay_all(cells: Cells, physics: Physics, gripper: Access, given: Cells = frozenset()) -> Order:
    """As ``find_order``, of cells that are known to stand when they are all there."""
    growth = Growth(physics, given, thorough=False)
    order: list[Cell] = []
    verdicts: list[Verdict] = []
    wanted = cells - given
    for z in sorted({cell.z for cell in wanted}):
        layer = frozenset(cell for cell in wanted if cell.z == z)
        for piece in sorted(pieces(layer), key=min):
            laid = _lay(piece, growth, gripper)
            order += laid.cells
            verdicts += laid.verdicts
            growth = laid.growth
    return Order(tuple(order), tuple(verdicts), tight_fits(order, given))


def sketch_order(cells: Cells, gripper: Access, given: Cells = frozenset()) -> tuple[Cell, ...]:
    """An order that is held and reached at every step, but not proven to stand.

    For objects so large that a proof of every trial takes too long: prove it with ``walk_order`` as
    far as the time goes. No layer reaches out further than two parts while it is laid, where that
    can be helped; then as few parts as possible go between two others.

    Raises:
        PlanError: some part cannot be placed from above.
    """
    standing = set(given)
    order: list[Cell] = []
    wanted = cells - given
    for z in sorted({cell.z for cell in wanted}):
        for piece in sorted(pieces(c for c in wanted if c.z == z), key=min):
            candidates = _reachable(piece, frozenset(standing), gripper)
            best = min(candidates, key=lambda c: (max(0, c.reach - _SAFE_REACH), *c))
            order += best.cells
            standing |= piece
    return tuple(order)


class Laid(NamedTuple):
    """A layer that was laid."""

    cells: tuple[Cell, ...]
    verdicts: tuple[Verdict, ...]
    growth: Growth
    tight: int
    holds: bool
    whole: LayerOrder
    """The order that was to be laid."""

    @property
    def margin(self) -> float:
        return min(verdict.margin for verdict in self.verdicts)


def _lay(layer: Cells, growth: Growth, gripper: Access) -> Laid:
    """The best order of a layer on what stands."""
    candidates = _reachable(layer, growth.cells, gripper)
    careful = sorted(candidates, key=lambda c: (c.reach, c.reach_sum, c.tight, c.cells))
    best = _best(candidates[:_TRIED], growth, None)
    if not best.holds:
        left = [candidate for candidate in careful if candidate not in candidates[:_TRIED]]
        best = _best(left[:_TRIED], growth, best)
    if not best.holds or best.tight:
        effort = _SEARCH_TO_AVOID if best.holds else _SEARCH_TO_HOLD
        # Growing from one front strains the joints: only exact proofs show that it holds.
        start = growth.copy(thorough=best.holds)
        found = search_layer(layer, start, effort, avoid_tight=best.holds)
        if found is not None:
            after = found.growth.copy(thorough=False)
            return Laid(found.cells, found.verdicts, after, found.tight, True, best.whole)
    if not best.holds:
        # What the quick proofs could not show is shown exactly, or refuted.
        best = _best([best.whole, careful[0]], growth.copy(thorough=True), None)
    if not best.holds:
        raise _refusal(best, growth, growth.physics)
    return best


def _reachable(layer: Cells, standing: Cells, gripper: Access) -> list[LayerOrder]:
    """Orders of a layer that comes down freely on what stands; the most promising first."""
    for cell in sorted(layer):
        if blockers := gripper.blockers(cell, standing):
            raise PlanError(
                f"It breaks the rule of access: the part at {list(cell)} cannot come down past "
                f"{named(blockers)}.",
                "Take these away first.",
                rule="access",
                cells=(cell, *blockers),
            )
    candidates = layer_orders(layer, standing)
    if not candidates:
        raise PlanError(
            "It breaks the rule of access: no part of their layer or beneath carries some of "
            f"{named(sorted(layer))} when their turn comes.",
            "Set something beneath them, or beside them in their layer.",
            rule="access",
            cells=tuple(sorted(layer)),
        )
    return candidates


def _best(candidates: Sequence[LayerOrder], growth: Growth, best: Laid | None) -> Laid:
    """The best of these and of one that is known."""
    proofs = 0
    for candidate in distinct(candidates, growth.cells):
        enough = best is not None and (best.tight < candidate.tight or proofs >= _PROOFS)
        if best is not None and best.holds and enough:
            break
        laid = _prove(candidate, growth, best)
        proofs += len(laid.verdicts)
        best = laid if best is None else max(best, laid, key=_worth)
        if best.holds and best.margin >= min(GOOD_MARGIN, growth.worst_margin):
            break
    assert best is not None, "there is a candidate, or a best one"
    return best


def _worth(laid: Laid) -> tuple[bool, int, float]:
    """What counts: that it holds, then that nothing is squeezed in, then the margin."""
    return (laid.holds, -laid.tight, laid.margin)


def _prove(candidate: LayerOrder, start: Growth, best: Laid | None) -> Laid:
    """Lay a layer in an order; ends early where it fails, or is no better than another."""
    growth = start.copy()
    least = growth.physics.least_margin
    verdicts = []
    for cell in candidate.cells:
        verdict = growth.place(cell)
        verdicts.append(verdict)
        if verdict.margin < least:
            done = candidate.cells[: len(verdicts)]
            return Laid(done, tuple(verdicts), growth, candidate.tight, False, candidate)
        if best is not None and best.holds and verdict.margin <= best.margin:
            break
    whole = len(verdicts) == len(candidate.cells)
    done = candidate.cells[: len(verdicts)]
    return Laid(done, tuple(verdicts), growth, candidate.tight, whole, candidate)


def _refusal(best: Laid, start: Growth, physics: Physics) -> PlanError:
    """Which part fails in the best order that was tried, and why."""
    verdict = assess(start.cells.union(best.cells), physics, best.cells[-1])
    return PlanError(
        "It breaks the rule of stability: no order was found in which every step stands. As the "
        f"part at {list(best.cells[-1])} is placed: {_lacking(verdict, physics)}",
        _ADVICE,
        rule="stability",
        cells=tuple(sorted(verdict.moving)),
    )


def _lacking(verdict: Verdict, physics: Physics) -> str:
    """What a state lacks, in words."""
    places = named(sorted(verdict.moving))
    if verdict.weakest is None:
        return f"nothing holds the cells {places}, however strong the magnets are."
    factor = physics.least_margin / verdict.margin
    return (
        f"The joint {verdict.weakest.describe()} would have to be {factor:.2f} times as strong to "
        f"hold the cells {places}."
    )
