"""From what stands to the next object, keeping what can stay: fewest moves, every state proven."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from cellctl.assembly import Cell, StepKind
from cellctl.errors import PlanError
from cellctl.validating.access import Access
from cellctl.validating.changing.alignment import (
    Alignment,
    Grid,
    Transform,
    alignments,
    without,
)
from cellctl.validating.changing.moves import Belt, Judge, Move, find_moves
from cellctl.validating.order import find_order
from cellctl.validating.rules import Cells
from cellctl.validating.stability import Physics
from cellctl.validating.words import counted, parts

_PLACES = 6
"""How many places of the wanted object are worked out before the best so far is taken."""
_ATTEMPTS_A_PART = 12
"""How many moves are judged, over all places, for each part of both objects."""


class ChangeOver(NamedTuple):
    """What leads from one object to the next."""

    steps: tuple[Move, ...]
    wanted_cells: Cells
    """The next object where it will stand."""
    kept: Cells
    """Parts that stay, and are never touched."""
    moves: int
    """How many steps there are."""
    moves_saved: int
    """How many more it would take to clear everything and build anew."""
    transform: Transform
    """How the wanted object was put down."""


def change_over(
    standing: Cells,
    wanted: Cells,
    grid: Grid,
    physics: Physics,
    gripper: Access,
    *,
    mirrors: bool = False,
    belt: Belt | None = None,
    reachable: Callable[[Cell], bool] | None = None,
) -> ChangeOver:
    """Fewest moves found, over all places of the wanted object in the grid.

    Args:
        standing: what stands.
        wanted: the next object, anywhere; it may be shifted, and turned by quarters.
        grid: cells of the workspace along x, y and z.
        physics: what holds parts.
        gripper: what must fit beside parts that stand higher.
        mirrors: whether the wanted object's mirror image serves as well.
        belt: where parts come from and go to; None if it is always ready for both.
        reachable: whether the arm can put a part there; every cell, if None.

    Raises:
        PlanError: it does not fit, or there is no order of moves in which every state stands.
    """
    if not wanted:
        raise PlanError("There are no cells to change to.", "Name at least one cell.")
    if belt is not None and len(wanted) > belt.parts + len(standing):
        stand = counted(len(standing), "stands", "stand")
        lie = counted(belt.parts, "lies", "lie")
        raise PlanError(
            f"The next object takes {parts(len(wanted))}; {stand} and {lie} on the belt.",
            "Put parts on the belt, or ask for a smaller object.",
        )
    places = alignments(standing, wanted, grid, mirrors=mirrors, reachable=reachable)
    if not places:
        raise PlanError(
            "The next object does not fit the workspace, or the arm does not reach all of it.",
            "Make it smaller.",
        )
    attempts = _ATTEMPTS_A_PART * (len(standing) + len(wanted)) + 200
    judge = Judge(physics, gripper, limit=attempts)
    best: ChangeOver | None = None
    refused: PlanError | None = None
    # What the gripper must not meet counts before the order does.
    places = tuple(_attainable(place, standing, gripper) for place in places)
    for place in sorted(places, key=lambda one: one.moves(standing))[:_PLACES]:
        if best is not None and place.moves(standing) >= best.moves:
            break
        try:
            found = _at(place, standing, judge, belt)
        except PlanError as error:
            refused = refused or error
            continue
        if best is None or found.moves < best.moves:
            best = found
    if best is None:
        assert refused is not None
        raise refused
    return best


def _at(place: Alignment, standing: Cells, judge: Judge, belt: Belt | None) -> ChangeOver:
    """The change-over to one place, keeping ever fewer parts until there is an order.

    Raises:
        PlanError: there is none even if nothing is kept.
    """
    refused: PlanError | None = None
    while True:
        try:
            steps = _steps(place, standing, judge, belt)
        except PlanError as error:
            refused = refused or error
            if not place.kept:
                raise refused from error
            place = _attainable(_fewer(place, judge), standing, judge.gripper)
            continue
        saved = len(standing) + len(place.wanted) - len(steps)
        return ChangeOver(steps, place.wanted, place.kept, len(steps), saved, place.transform)


def _steps(place: Alignment, standing: Cells, judge: Judge, belt: Belt | None) -> tuple[Move, ...]:
    """All removals and then all placements, or else both mixed.

    Raises:
        PlanError: neither was found.
    """
    going, coming = standing - place.kept, place.wanted - place.kept
    if judge.rests(place.kept).margin < judge.physics.least_margin:
        return find_moves(standing, going, coming, judge, belt)
    try:
        removals = find_moves(standing, going, frozenset(), judge, belt)
        order = find_order(place.wanted, judge.physics, judge.gripper, place.kept)
    except PlanError:
        return find_moves(standing, going, coming, judge, belt)
    placements = (
        Move(StepKind.PLACE, cell, verdict.margin)
        for cell, verdict in zip(order.cells, order.verdicts, strict=True)
    )
    return (*removals, *placements)


def _attainable(place: Alignment, standing: Cells, gripper: Access) -> Alignment:
    """The same place without keeping what would be in the gripper's way at some move."""
    while True:
        moved = (standing | place.wanted) - place.kept
        blocking = {one for cell in moved for one in gripper.blockers(cell, place.kept)}
        if not blocking:
            return place
        place = without(place, frozenset(blocking))


def _fewer(place: Alignment, judge: Judge) -> Alignment:
    """The same place keeping less: not what cannot stand alone, else not the highest layer."""
    kept = place.kept
    verdict = judge.rests(kept)
    falling = verdict.moving if verdict.margin < judge.physics.least_margin else frozenset()
    if not falling:
        falling = kept
    top = max(cell.z for cell in falling)
    return without(place, frozenset(cell for cell in falling if cell.z == top))
