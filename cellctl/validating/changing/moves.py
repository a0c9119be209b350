"""An order of removals and placements in which every state stands: a search with backtracking."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from cellctl.assembly import Cell, StepKind
from cellctl.errors import PlanError
from cellctl.validating.access import Access
from cellctl.validating.changing.preference import placing_cost, removal_cost
from cellctl.validating.changing.removal import Removal, assess_removal
from cellctl.validating.rules import Cells, lateral, supported
from cellctl.validating.stability import Physics, Verdict, assess
from cellctl.validating.words import named, parts

_ATTEMPTS_A_MOVE = 3
"""How many removals and placements are judged for each that is made, before a search ends."""

_COMFORTABLE = 1.05
"""A removal with this many times the least margin is made at once; others only where there is no
such one. A part on a column comes off with a little more: its joint is like those beneath it, and
only the weight tells them apart."""

_NO_ROOM = "the arm has no room to take it off"


class Move(NamedTuple):
    """One part taken or put."""

    kind: StepKind
    cell: Cell
    margin: float
    """Of the structure, while it is done and after."""
    removal: Removal | None = None
    """How the part comes off, where it is taken."""


class Belt(NamedTuple):
    """Where parts come from and go to."""

    parts: int
    """How many lie on it."""
    capacity: int
    """How many it has room for."""


@dataclass
class Judge:
    """Says which single moves a structure bears; remembers states that were asked about.

    Args:
        physics: what holds parts.
        gripper: what must fit beside parts that stand higher.
    """

    physics: Physics
    gripper: Access
    limit: int | None = None
    """How many moves are judged at most; None for no limit but that of each search."""
    judged: int = 0
    """How many moves were judged by the linear programme."""
    refusals: dict[Cell, str] = field(default_factory=dict)
    """Why each part could not be moved when it was last tried."""
    _resting: dict[Cells, Verdict] = field(default_factory=dict)

    def rests(self, cells: Cells) -> Verdict:
        """How a state stands when nothing happens."""
        found = self._resting.get(cells)
        if found is None:
            found = self._resting[cells] = assess(cells, self.physics)
        return found

    def remove(self, cells: Cells, cell: Cell) -> Move | None:
        """Taking a part; None if it is covered, or the rest does not bear it."""
        left = cells - {cell}
        if blocking := self.gripper.blockers(cell, left):
            self.refusals[cell] = f"{named(blocking)} in the way of the gripper"
            return None
        self.judged += 1
        found = assess_removal(cells, cell, self.physics, self.rests(left), self.gripper)
        if found.removal is None:
            self.refusals[cell] = _NO_ROOM if found.barred else _reason(found.verdict)
            return None
        return Move(StepKind.REMOVE, cell, found.removal.margin, found.removal)

    def place(self, cells: Cells, cell: Cell) -> Move | None:
        """Putting a part; None if nothing carries it, it is covered, or it would not hold."""
        if cell in cells:
            return None
        if not supported(cell, cells) and not any(b in cells for b in lateral(cell)):
            return None
        if self.gripper.blockers(cell, cells):
            return None
        self.judged += 1
        verdict = assess(cells | {cell}, self.physics, cell)
        if verdict.margin < self.physics.least_margin:
            self.refusals[cell] = _reason(verdict)
            return None
        return Move(StepKind.PLACE, cell, verdict.margin)


def find_moves(
    start: Cells, removing: Cells, placing: Cells, judge: Judge, belt: Belt | None = None
) -> tuple[Move, ...]:
    """An order of all removals and placements, removals first wherever they can be.

    Args:
        start: what stands.
        removing: which of it goes; the rest is not touched.
        placing: what comes.
        judge: of single moves.
        belt: where parts come from and go to; None if it is always ready for both.

    Raises:
        PlanError: there is no such order, or none was found.
    """
    total = len(removing) + len(placing)
    budget = judge.judged + _ATTEMPTS_A_MOVE * total + 40
    if judge.limit is not None:
        budget = min(budget, judge.limit)
    dead: set[tuple[Cells, Cells]] = set()
    made: list[Move] = []
    state = _State(start, removing, placing, belt)
    path = [(state, _moves(state, judge))]
    deepest = state
    while True:
        state, options = path[-1]
        if not state.removing and not state.placing:
            return tuple(made)
        following = next(options, None) if judge.judged < budget else None
        if following is None:
            if judge.judged >= budget or len(path) == 1:
                raise _stuck(deepest, judge)
            dead.add((state.removing, state.placing))
            path.pop()
            made.pop()
            continue
        after = state.after(following)
        if (after.removing, after.placing) in dead:
            continue
        made.append(following)
        path.append((after, _moves(after, judge)))
        if len(after.removing) + len(after.placing) < len(deepest.removing) + len(deepest.placing):
            deepest = after
            judge.refusals.clear()


class _State(NamedTuple):
    """Between two moves."""

    cells: Cells
    removing: Cells
    placing: Cells
    belt: Belt | None

    def after(self, move: Move) -> _State:
        belt = self.belt
        if move.kind is StepKind.REMOVE:
            if belt is not None:
                belt = belt._replace(parts=belt.parts + 1)
            return _State(self.cells - {move.cell}, self.removing - {move.cell}, self.placing, belt)
        if belt is not None:
            belt = belt._replace(parts=belt.parts - 1)
        return _State(self.cells | {move.cell}, self.removing, self.placing - {move.cell}, belt)


def _moves(state: _State, judge: Judge) -> Iterator[Move]:
    """What can be done next, the best first; each is judged when its turn comes."""
    cells, belt = state.cells, state.belt
    if belt is None or belt.parts < belt.capacity:
        bare: list[Move] = []
        comfortable = _COMFORTABLE * judge.physics.least_margin
        for cell in sorted(state.removing, key=removal_cost(cells)):
            if (move := judge.remove(cells, cell)) is None:
                continue
            if move.margin >= comfortable:
                yield move
            else:
                bare.append(move)
        yield from sorted(bare, key=lambda move: -round(move.margin, 6))
    if belt is None or belt.parts > 0:
        goal = (cells - state.removing) | state.placing
        for cell in sorted(state.placing, key=placing_cost(cells, goal)):
            if (move := judge.place(cells, cell)) is not None:
                yield move


def _stuck(state: _State, judge: Judge) -> PlanError:
    """Why the search ended, as seen from the state nearest to the goal."""
    belt, left = state.belt, state.removing or state.placing
    if belt is not None and state.removing and belt.parts >= belt.capacity:
        return PlanError(
            f"The belt is full; {parts(len(left), 'has', 'have')} to come off and no room on it.",
            "Take parts off the belt and count them first.",
        )
    ordered = sorted(left, key=lambda c: (-c.z, c.x, c.y))
    tried = [cell for cell in ordered if cell in judge.refusals]
    reasons = "; ".join(f"{list(cell)}: {judge.refusals[cell]}" for cell in tried[:3])
    what, hint = (
        ("taken away", "Take them away by hand, holding what they are joined to.")
        if state.removing
        else ("placed", "Clear the workspace and plan the object anew, or ask for another one.")
    )
    found = f"{parts(len(left))} cannot be {what} so that every state stands."
    return PlanError(f"{found} {reasons}." if reasons else found, hint)


def _reason(verdict: Verdict) -> str:
    if verdict.weakest is not None:
        return (
            f"the joint {verdict.weakest.describe()} would give way first "
            f"(margin {verdict.margin:.2f})"
        )
    return f"{named(sorted(verdict.moving))} would fall"


def removal_order(
    standing: Cells,
    physics: Physics,
    gripper: Access,
    keep: Cells = frozenset(),
    belt: Belt | None = None,
) -> tuple[Removal, ...]:
    """In which order, and how, parts come off until only those to keep are left.

    Every state stands with the least margin, while a part comes off and after.

    Args:
        standing: what stands.
        physics: what holds it.
        gripper: what must fit beside parts that stand higher.
        keep: what stays, and is never moved.
        belt: where the parts go; None if it has room for all.

    Raises:
        PlanError: there is no such order, or none was found; it names the parts and joints.
    """
    if strangers := keep - standing:
        raise PlanError(f"{named(sorted(strangers))} cannot be kept: nothing stands there.")
    moves = find_moves(standing, standing - keep, frozenset(), Judge(physics, gripper), belt)
    return tuple(move.removal for move in moves if move.removal is not None)
