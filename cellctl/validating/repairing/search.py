"""The best object of any size: which sizes to solve, in which order, and when to stop.

Best first. Every size has a bound that no object of it exceeds: at first a relaxed one that costs
microseconds, then what the solver proves. The size with the highest bound is worked on; once it
has an object whose score equals its bound, that object is judged. One that stands is the best of
all, for no other size can exceed it. One that collapses teaches a mechanism, and its size is solved
anew. So few sizes are solved and very few objects judged, which is what costs time.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from cellctl.validating.repairing.bound import relaxed_bound
from cellctl.validating.repairing.collapse import Collapses, Mechanism, Stands
from cellctl.validating.repairing.model import SAME, Effort, Model
from cellctl.validating.repairing.score import Size, Wanted
from cellctl.validating.repairing.symmetry import Symmetry, symmetries
from cellctl.validating.rules import Cells, pieces

Judge = Callable[[Cells], Stands | Collapses]
"""Whether connected cells that are accessible from above stand at every step of some order."""

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

_STEPS = 0.1
"""The part of the budget that the solver may spend in its own deterministic time: so little that
wall time hardly ever ends a search, and its outcome does not depend on the machine."""

_STEPS_AT_ONCE = 0.3
"""The part of that for one call, lest one size takes everything."""


@dataclass(frozen=True)
class Rules:
    """What a repaired object must satisfy."""

    parts: int
    grid: Size
    reach: int
    """The most steps, side by side, from a part to one of its layer that rests on something."""
    floor_grips: bool
    judge: Judge
    known: tuple[Mechanism, ...] = ()
    """Mechanisms of collapse that are known beforehand."""


@dataclass(frozen=True)
class Found:
    """The best object that was found, and how good any could be."""

    cells: Cells
    """Empty if none was found."""
    score: float
    bound: float
    """No object has a higher score."""
    stands: Stands | None
    collapses: tuple[Collapses, ...]
    """What was learnt from objects that would have been closer, the closest first."""

    @property
    def proven(self) -> bool:
        """Whether this is the best object that there is."""
        return bool(self.cells) and self.score >= self.bound - SAME


@dataclass
class _Candidate:
    size: Size
    bound: float
    cells: Cells = frozenset()
    """The best of this size, as far as it is known."""
    model: Model | None = None
    learnt: int = 0
    """How many of the mechanisms the model knows."""
    rounds: int = 0
    exhausted: bool = False
    """Whether the solver could not settle it with the effort that is due; it keeps its bound."""


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
    workers: int = 1,
    fallback: Cells = frozenset(),
) -> Found:
    """Find the object that keeps most of the wanted shape.

    Args:
        wanted: the shape.
        rules: what the object must satisfy.
        budget_s: wall time; the best object so far is returned then.
        workers: of the solver.
        fallback: an object that satisfies the rules but may collapse; it is judged when the search
            was not finished in time.
    """
    return _Search(wanted, rules, budget_s, workers).run(fallback)


class _Search:
    def __init__(self, wanted: Wanted, rules: Rules, budget_s: float, workers: int) -> None:
        self._wanted = wanted
        self._rules = rules
        self._workers = workers
        now_s = time.monotonic()
        self._end_s = now_s + budget_s
        self._improve_until_s = now_s + budget_s * (1.0 - _FOR_SAFETY)
        self._steps = self._most_steps = budget_s * _STEPS
        self._kept = symmetries(wanted.cells, wanted.size)
        self._state = _State(mechanisms=[t for m in rules.known for t in m.turned()])
        self._aside: list[_Candidate] = []

    def run(self, fallback: Cells) -> Found:
        state = self._state
        bounds = {
            size: relaxed_bound(self._wanted.terms(size), self._rules.parts)
            for size in self._sizes()
        }
        candidates = [_Candidate(size, bound) for size, bound in sorted(bounds.items())]
        while time.monotonic() < self._improve_until_s:
            lead = max(candidates, key=self._known_score)
            known = self._known_score(lead)
            top = max(
                (candidate for candidate in candidates if not candidate.exhausted),
                key=lambda candidate: candidate.bound,
                default=None,
            )
            if top is not None and self._steps <= 0.0:
                top = None
            if top is not None and top.bound > max(known, state.score) + SAME:
                self._solve(top, max(known, state.score), self._improve_until_s)
            elif known > state.score + SAME:
                self._judge(lead)
            else:
                break
        bound = max([state.score, state.doubted, *(c.bound for c in candidates)])
        if state.score < bound - SAME:
            self._safely(candidates, fallback)
        return Found(
            state.best,
            state.score,
            max(bound, state.score),
            state.stands,
            tuple(state.collapses),
        )

    def _known_score(self, candidate: _Candidate) -> float:
        """Of its best object that is still to be judged; 0 if it is not known any more."""
        if candidate.learnt < len(self._state.mechanisms):
            return 0.0
        return self._wanted.score(candidate.cells)

    def _sizes(self) -> list[Size]:
        """Those of the wanted size or less that keep its symmetry and are within the grid."""
        square = any(symmetry.square for symmetry in self._kept)
        most = [min(a, b) for a, b in zip(self._wanted.size, self._rules.grid, strict=True)]
        return [
            (nx, ny, nz)
            for nx in range(1, most[0] + 1)
            for ny in range(1, most[1] + 1)
            for nz in range(1, most[2] + 1)
            if not square or nx == ny
        ]

    def _judge(self, candidate: _Candidate) -> None:
        state = self._state
        verdict = self._rules.judge(candidate.cells)
        if isinstance(verdict, Stands):
            score = self._wanted.score(candidate.cells)
            if score > state.score:
                state.best, state.score, state.stands = candidate.cells, score, verdict
            return
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

    def _solve(self, candidate: _Candidate, target: float, until_s: float) -> None:
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
            effort = Effort(self._workers, left_s, steps)
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

    def _model(self, candidate: _Candidate) -> Model:
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

    def _safely(self, left: list[_Candidate], fallback: Cells) -> None:
        """Without time to find the best: the given object, or one whose every part rests."""
        state = self._state
        if fallback and self._wanted.score(fallback) > state.score + SAME:
            verdict = self._rules.judge(fallback)
            if isinstance(verdict, Stands):
                state.best, state.stands = fallback, verdict
                state.score = self._wanted.score(fallback)
        if not state.best:
            self._end_s = max(self._end_s, time.monotonic() + _GRACE_S)
        for candidate in sorted(left, key=lambda c: (-c.bound, c.size))[:_SAFE_SIZES]:
            if state.score >= candidate.bound or time.monotonic() > self._end_s:
                return
            self._rest(candidate)

    def _rest(self, candidate: _Candidate) -> None:
        """Find an object of a size all of whose parts rest on parts below, and that stands."""
        resting = _Candidate(candidate.size, candidate.bound)
        resting.model = Model(
            self._wanted.terms(candidate.size),
            self._rules.parts,
            0,
            self._kept_in(candidate.size),
        )
        while resting.rounds < _MOST_ROUNDS and time.monotonic() < self._end_s:
            self._solve(resting, self._state.score, self._end_s)
            if not resting.cells:
                return
            self._judge(resting)
            if resting.cells:
                return
