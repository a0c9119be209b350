"""The best object of any size: which sizes to solve, in which order, and when to stop.

Best first. Every size has a bound that no object of it exceeds: at first a quick one, then, once it
is the highest, a relaxed one that costs a millisecond, then what the solver proves. The size with
the highest bound is worked on; once it has an object whose score equals its bound, that object is
judged. One that stands is the best of all, for no other size can exceed it. One that collapses
teaches a mechanism, and its size is solved anew. So few sizes are solved and very few objects
judged, which is what costs time.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from cellctl.validating.repairing.collapse import Collapses, Mechanism, Stands
from cellctl.validating.repairing.frontier import Candidate, Frontier
from cellctl.validating.repairing.model import SAME, Effort, Model
from cellctl.validating.repairing.resized import resized
from cellctl.validating.repairing.score import Size, Wanted
from cellctl.validating.repairing.symmetry import Symmetry, symmetries
from cellctl.validating.repairing.task import Found, Rules
from cellctl.validating.rules import Cells, pieces

_LEAST_STEPS = 0.05
"""A call with less is not worth making."""

_GRACE_S = 2.0
"""How far the budget may be exceeded where there is no object at all yet."""

_GUESS = 0.8
"""How much of a bound is tried first. Too much asks for an object of few cells that costs little,
which is hard to find and of no use; too little costs a round."""

_SAFE_SIZES = 3
"""How many sizes are tried for an object that surely stands."""

_MOST_ROUNDS = 60
"""Most times that one size is solved; beyond it keeps its bound and is set aside."""

_FOR_SAFETY = 0.35
"""The part of the budget that is kept for an object that surely stands."""

_STEPS = 0.045
"""The part of the budget that the solver may spend in its own deterministic time: so little that
wall time hardly ever ends a search, and its outcome does not depend on the machine."""

_STEPS_AT_ONCE = 0.3
"""The part of that for one call, lest one size takes everything."""

_FOR_BOUNDS = 0.3
"""The part of the budget after which no more sizes are opened; the rest keep their quick bound."""

_CELLS_A_SECOND = 100
"""Boxes of more cells than this a second of the budget are not given to the solver: to tell it of
them takes most of the budget."""

_LEAST_CELLS = 300
"""Boxes of no more cells are given to it in any case."""

_LARGE = 60
"""To judge objects of more parts takes seconds: where there can be any, something that stands is
found before anything closer is sought."""

_FOR_LARGE = 0.4
"""The part of the budget that this may take."""

_PARTS_A_SECOND = 25
"""Objects of more parts than this a second cannot be judged in the time that is left."""


@dataclass
class _State:
    best: Cells = frozenset()
    score: float = 0.0
    stands: Stands | None = None
    mechanisms: list[Mechanism] = field(default_factory=list)
    collapses: list[Collapses] = field(default_factory=list)
    doubted: float = 0.0
    """The highest score of what was given up because of one order of building."""


def search(
    wanted: Wanted,
    rules: Rules,
    budget_s: float,
    fallback: Callable[[], Cells] = frozenset,
) -> Found:
    """Find the object that keeps most of the wanted shape, of those that keep its symmetry.

    Args:
        wanted: the shape.
        rules: what the object must satisfy.
        budget_s: wall time; the best object so far is returned then.
        fallback: an object that satisfies the rules but may collapse; it is asked for and judged
            when the search was not finished in time.
    """
    kept = symmetries(wanted.cells, wanted.size)
    return _Search(wanted, rules, budget_s, kept).run(fallback)


def search_beyond(wanted: Wanted, rules: Rules, budget_s: float, above: float) -> Found:
    """As ``search``, of all objects, symmetric or not, whose score exceeds one; none if none does.

    Nothing else is tried where time ends it, and ``bound`` is at least ``above``.
    """
    return _Search(wanted, rules, budget_s, (), above).improve()


class _Search:
    def __init__(
        self,
        wanted: Wanted,
        rules: Rules,
        budget_s: float,
        kept: tuple[Symmetry, ...],
        above: float = 0.0,
    ) -> None:
        self._wanted = wanted
        self._rules = rules
        now_s = time.monotonic()
        self._end_s = now_s + budget_s
        self._improve_until_s = now_s + budget_s * (1.0 - _FOR_SAFETY)
        self._open_until_s = now_s + budget_s * _FOR_BOUNDS
        self._steps = self._most_steps = budget_s * _STEPS
        self._kept = kept
        self._state = _State(score=above, mechanisms=[t for m in rules.known for t in m.turned()])
        nx, ny, nz = map(min, zip(wanted.size, rules.grid, strict=True))
        square = any(symmetry.square for symmetry in kept)
        self._sizes = Frontier(
            wanted,
            (nx, ny, nz),
            square,
            rules.parts,
            most_cells=max(_LEAST_CELLS, budget_s * _CELLS_A_SECOND),
        )

    def run(self, fallback: Callable[[], Cells]) -> Found:
        """The best object, or one that surely stands where there is no time for it."""
        if self._sizes.beyond > 0.0:
            # The solver is not given the sizes that matter most, and judging takes long.
            self._end_s += _GRACE_S
            self._resize(self._end_s)
        elif min(self._rules.parts, len(self._wanted.cells)) > _LARGE:
            now_s = time.monotonic()
            until_s = now_s + (self._end_s - now_s) * _FOR_LARGE
            self._resize(until_s)
            if not self._state.best and (given := fallback()):
                self._try(given, until_s)
        found = self.improve()
        if found.score < found.bound - SAME:
            self._safely(fallback())
        return self._found(found.bound)

    def improve(self) -> Found:
        """The best object that is found and judged in the time for it."""
        state = self._state
        while time.monotonic() < self._improve_until_s:
            lead = max(self._sizes.opened, key=self._known_score, default=None)
            known = 0.0 if lead is None else self._known_score(lead)
            most = max(known, state.score)
            top = self._sizes.top(most, self._open_until_s) if self._steps > 0.0 else None
            if top is not None and top.bound > most + SAME:
                self._solve(top, most, self._improve_until_s)
            elif lead is not None and known > state.score + SAME:
                if not self._judge(lead, self._improve_until_s):
                    break
            else:
                break
        return self._found(max(state.doubted, self._sizes.bound))

    def _found(self, bound: float) -> Found:
        state = self._state
        return Found(
            state.best,
            state.score,
            max(bound, state.score),
            state.stands,
            tuple(state.collapses),
        )

    def _known_score(self, candidate: Candidate) -> float:
        """Of its best object that is still to be judged; 0 if it is not known any more."""
        if candidate.learnt < len(self._state.mechanisms):
            return 0.0
        return self._wanted.score(candidate.cells)

    def _judge(self, candidate: Candidate, until_s: float) -> bool:
        """Whether there was time to judge the best object of a size, and to learn from it."""
        state = self._state
        verdict = self._rules.judge(candidate.cells, until_s)
        if verdict is None:
            return False
        if isinstance(verdict, Stands):
            self._take(candidate.cells, verdict)
            return True
        state.collapses.append(verdict)
        mechanism = Mechanism.of(verdict, candidate.cells)
        if not mechanism.exact:
            state.doubted = max(state.doubted, self._wanted.score(candidate.cells))
        state.mechanisms += mechanism.turned()
        if candidate.model is not None:
            # Whatever was learnt, the same object must not come again.
            candidate.model.exclude(candidate.cells)
        candidate.cells = frozenset()
        candidate.exhausted = candidate.rounds >= _MOST_ROUNDS
        return True

    def _take(self, cells: Cells, stands: Stands) -> None:
        score = self._wanted.score(cells)
        if score > self._state.score:
            self._state.best, self._state.score, self._state.stands = cells, score, stands

    def _solve(self, candidate: Candidate, target: float, until_s: float) -> None:
        """Raise the score of the best known object of a size until none is better.

        This is Dinkelbach's method: each round asks for the object that shares most beyond the last
        one's score times what it covers.
        """
        model = self._model(candidate)
        candidate.cells = frozenset()
        required = target > 0.0
        score = min(target, candidate.bound) if required else candidate.bound * _GUESS
        while candidate.rounds < _MOST_ROUNDS:
            left_s = until_s - time.monotonic()
            if left_s <= 0.0:
                return
            candidate.rounds += 1
            steps = max(min(self._steps, self._most_steps * _STEPS_AT_ONCE), _LEAST_STEPS)
            effort = Effort(left_s, steps)
            answer = model.beat(score, effort, required=required)
            self._steps -= answer.steps
            candidate.bound = min(candidate.bound, answer.bound)
            if not answer.cells:
                candidate.exhausted = not answer.proven
                return
            if len(pieces(answer.cells)) > 1:
                model.join(answer.cells)
                if not required:
                    score *= _GUESS
                continue
            candidate.cells = answer.cells
            score = self._wanted.score(answer.cells)
            required = True
            if not answer.proven:
                candidate.exhausted = True
                return
        candidate.exhausted = True

    def _model(self, candidate: Candidate) -> Model:
        mechanisms = self._state.mechanisms
        if candidate.model is None:
            candidate.model = Model(
                self._wanted.terms(candidate.size),
                self._rules.parts,
                self._rules.reach,
                self._kept_in(candidate.size),
            )
        candidate.model.forbid(mechanisms[candidate.learnt :], self._rules.floor_grips)
        candidate.learnt = len(mechanisms)
        return candidate.model

    def _kept_in(self, size: Size) -> tuple[Symmetry, ...]:
        return tuple(s for s in self._kept if not s.square or size[0] == size[1])

    def _safely(self, fallback: Cells) -> None:
        """Without time to find the best: the given object, or one whose every part rests."""
        state = self._state
        if fallback and self._wanted.score(fallback) > state.score + SAME:
            self._try(fallback, self._end_s)
        if not state.best:
            self._end_s = max(self._end_s, time.monotonic() + _GRACE_S)
            if self._sizes.beyond == 0.0:
                self._resize(self._end_s)
        left = sorted(self._sizes.opened, key=lambda c: (-c.bound, c.size))
        for candidate in left[:_SAFE_SIZES]:
            if state.score >= candidate.bound or time.monotonic() > self._end_s:
                return
            self._rest(candidate)

    def _resize(self, end_s: float) -> None:
        """The wanted shape at the closest size at which it stands and can be judged in time."""
        now_s = time.monotonic()
        left_s = end_s - now_s
        parts = min(self._rules.parts, int(left_s * _PARTS_A_SECOND))
        until_s = now_s + left_s * _FOR_BOUNDS
        for cells in resized(self._wanted, self._sizes.all(), parts, until_s):
            if self._state.best or time.monotonic() > end_s:
                return
            self._try(cells, end_s)

    def _try(self, cells: Cells, until_s: float) -> None:
        verdict = self._rules.judge(cells, until_s)
        if isinstance(verdict, Stands):
            self._take(cells, verdict)

    def _rest(self, candidate: Candidate) -> None:
        """Find an object of a size all of whose parts rest on parts below, and that stands."""
        resting = Candidate(candidate.size, candidate.bound)
        resting.model = Model(
            self._wanted.terms(candidate.size),
            self._rules.parts,
            0,
            self._kept_in(candidate.size),
        )
        while resting.rounds < _MOST_ROUNDS and time.monotonic() < self._end_s:
            self._solve(resting, self._state.score, self._end_s)
            if not resting.cells or not self._judge(resting, self._end_s) or resting.cells:
                return
