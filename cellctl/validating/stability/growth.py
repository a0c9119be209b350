"""The stability of a structure that grows part by part, from proofs that build on each other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import tee
from typing import NamedTuple, Self

import numpy as np

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells
from cellctl.validating.stability.assess import STANDS, Verdict, assess, to_verdict
from cellctl.validating.stability.hanging import least_pull
from cellctl.validating.stability.joints import Floats, Ints
from cellctl.validating.stability.loads import SIDES, placement_pushes
from cellctl.validating.stability.physics import Physics
from cellctl.validating.stability.programme import Solution
from cellctl.validating.stability.surroundings import piece_of, surroundings
from cellctl.validating.stability.witness import Region, Witness

GOOD_MARGIN = 1.5
"""A margin that is proven to be at least this is not determined more exactly."""
_ENOUGH = 0.5
"""Share of the needed pull that is no matter below which a witness of a push is not improved."""
_THRIFT = 0.01
"""Cost of shear where a region is balanced anew: a witness that strains no joint without need
leaves more to those who build on it."""
_SAME = 1.0 + 1e-9
"""Pulls that differ by less are the same."""


class _Surroundings(NamedTuple):
    """What is around a cell that is placed."""

    region: Region
    whole: bool
    """Whether it is all that the cell is joined to."""
    guesses: Floats | None
    """What its joints might bear under each push, (pushes, m, 6); None if it does not hold."""


class _Found(NamedTuple):
    """How the joints of a region bear a push."""

    region: Region
    pull: float
    """What the most strained joint needs, of the region or outside of it."""
    wrenches: Floats
    """(m, 6)."""
    solution: Solution | None = None
    """By which they were found; None for a guess."""
    exact: bool = False
    """Whether no forces need less."""


class Growth:
    """A structure and a witness of its equilibrium; ``place`` adds a part and judges the state.

    Four facts save most of the work; what balances is a proof, however it was found:

    - A part on a column down to the floor needs no magnets at rest: its weight goes straight down,
      and presses the column's joints together.
    - While it is pushed aside, the column's joints can bear that on top of what they bear at rest.
      What they need then is a sum.
    - Where a part hangs, the forces are balanced anew in its surroundings only. If it holds while
      it is pressed down, it holds at rest: that load is a mean of the load with the press and the
      load before, weighted by weight and press.
    - Springs in place of the joints show in no time how the surroundings might bear it. The linear
      programme is asked where they strain a joint more than any was before.

    Without ``thorough`` the region is never widened to the whole structure: all that is said to
    hold does, but what is said to fail may hold.

    Each of these yields an upper bound of the needed pull. Only where it exceeds what the order
    needs elsewhere, and ``GOOD_MARGIN``, is the region widened, at last to the whole structure.
    """

    def __init__(
        self, physics: Physics, given: Iterable[Cell] = (), *, thorough: bool = True
    ) -> None:
        self.physics = physics
        self._thorough = thorough
        self._witness = Witness(physics)
        self._rooted: set[Cell] = set()
        self._pull = 1.0 / max(GOOD_MARGIN, physics.least_margin)
        """Up to this the needed pull is no matter."""
        self.worst_margin = math.inf
        """The least of all verdicts so far."""
        self._balanced = True
        """Whether the witness balances the weights; not where something is adrift."""
        for cell in sorted(given, key=lambda c: (c.z, c.x, c.y)):
            self._add(cell)
        if self._witness.cells:
            self._balance()

    def copy(self, *, thorough: bool | None = None) -> Self:
        """An independent one, as thorough as this one if not said otherwise."""
        other = type(self).__new__(type(self))
        other.physics = self.physics
        other._thorough = self._thorough if thorough is None else thorough
        other._witness = self._witness.copy()
        other._rooted = set(self._rooted)
        other._pull = self._pull
        other.worst_margin = self.worst_margin
        other._balanced = self._balanced
        return other

    @property
    def cells(self) -> Cells:
        """What stands."""
        return frozenset(self._witness.cells)

    def place(self, cell: Cell) -> Verdict:
        """Add a part; the worst of the state at rest and while the part is pressed in.

        Returns:
            A margin that is proven, with the joint that is strained most. It is exact where it is
            less than ``GOOD_MARGIN`` and less than every one before.
        """
        self._add(cell)
        if not self._balanced:
            verdict = self._start_anew(cell)
        elif cell in self._rooted:
            verdict = self._place_on_column(cell)
        else:
            verdict = self._place_hanging(cell)
        self.worst_margin = min(self.worst_margin, verdict.margin)
        return verdict

    def _add(self, cell: Cell) -> None:
        self._witness.add(cell)
        above = cell
        while above in self._witness.cells and (above.z == 0 or above.below() in self._rooted):
            self._rooted.add(above)
            above = Cell(above.x, above.y, above.z + 1)

    def _start_anew(self, cell: Cell) -> Verdict:
        verdict = assess(self.cells, self.physics, cell)
        if verdict.margin > 0.0:
            self._balance()
        return verdict

    def _balance(self) -> None:
        """Make the witness balance all weights."""
        witness = self._witness
        self._balanced = True
        hanging = witness.cells - self._rooted
        if not hanging:
            for cell in self._rooted:
                rows = witness.column(cell)
                wrenches = witness.wrenches(rows)
                wrenches[:, 2] += self.physics.weight_n
                witness.bear(rows, wrenches)
            return
        cell = min(hanging)
        region = witness.region(witness.cells)
        solution = region.solve(cell, np.zeros(6))
        if math.isinf(solution.pull):
            self._balanced = False
            return
        witness.bear(region.rows, solution.wrenches)

    def _place_on_column(self, cell: Cell) -> Verdict:
        """Weight, press and push go straight down the column, if its joints can bear them."""
        witness, physics = self._witness, self.physics
        rows = witness.column(cell)
        rest = witness.wrenches(rows)
        rest[:, 2] += physics.weight_n
        pushed = rest + _down_the_column(len(rows), physics)
        needs = witness.needs_with(rows, pushed).max(axis=1)
        witness.bear(rows, rest)
        at_rest = witness.need
        pull = max(at_rest, float(needs.max()))
        if pull <= self._pull:
            return self._bounded(pull, rows, witness.needs_with(rows, pushed).max(axis=0))
        worst = self._at_rest(cell)
        for verdict, _, _ in self._pushed(cell):
            worst = min(worst, verdict, key=lambda v: v.margin)
        return worst

    def _place_hanging(self, cell: Cell) -> Verdict:
        """Balance the surroundings anew, for each push."""
        witness, physics = self._witness, self.physics
        worst = STANDS
        found: list[tuple[Ints, Floats]] = []
        for verdict, rows, wrenches in self._pushed(cell):
            worst = min(worst, verdict, key=lambda v: v.margin)
            if verdict.margin == 0.0:
                self._balanced = False
                return worst
            found.append((rows, wrenches))
        # The mean of the pushes is a press down; mixed with the state before, the state at rest.
        share = physics.weight_n / (physics.weight_n + physics.placement_down_n)
        every = np.unique(np.concatenate([rows for rows, _ in found]))
        rest = (1.0 - share) * witness.wrenches(every)
        for rows, wrenches in found:
            each = witness.wrenches(every)
            each[np.searchsorted(every, rows)] = wrenches
            rest += share / len(found) * each
        witness.bear(every, rest)
        return min(worst, self._at_rest(cell), key=lambda v: v.margin)

    def _at_rest(self, cell: Cell) -> Verdict:
        """The state at rest, by the witness; exactly where that says too little."""
        witness = self._witness
        pull = witness.need
        if pull > self._pull and self._thorough:
            piece = witness.region(piece_of(cell, witness.cells))
            solution = piece.solve(cell, np.zeros(6))
            if math.isinf(solution.pull):
                self._balanced = False
                return to_verdict(solution, list(piece.cells))
            witness.bear(piece.rows, solution.wrenches)
            pull = witness.need
            if solution.pull > max(self._pull, witness.need_outside(piece.rows)):
                return to_verdict(solution, list(piece.cells))
        return self._bounded(pull, np.empty(0, dtype=np.int64), np.empty(0))

    def _pushed(self, cell: Cell) -> Iterator[tuple[Verdict, Ints, Floats]]:
        """The state under each push of its placement, and what which joints bear then."""
        pushes = tuple(placement_pushes(cell, self._witness.cells, self.physics))
        wider = self._surroundings(cell, pushes)
        for number in range(len(pushes)):
            wider, these = tee(wider)
            yield self._withstand(cell, pushes, number, these)

    def _withstand(
        self,
        cell: Cell,
        pushes: Sequence[Floats],
        number: int,
        wider: Iterable[_Surroundings],
    ) -> tuple[Verdict, Ints, Floats]:
        """The state under one of the pushes, and what which joints bear then."""
        push = pushes[number]
        # A guess that strains nothing more than it has been is not improved on.
        known = max(self.worst_margin, self.physics.least_margin)
        fair = max(_ENOUGH * self._pull, 1.0 / known)
        found: _Found | None = None
        for around in wider:
            guess = self._guess(around, number)
            if guess is None and not around.whole:
                continue  # nothing in it holds the cell
            if found is None and (guess is None or guess.pull > fair):
                least = least_pull(cell, push, self._witness.cells, self.physics)
                fair = max(fair, least * _SAME)
            settled = around.region.determinate and not around.whole
            if guess is None or (guess.pull > fair and not settled):
                found = self._solve(around, cell, push)
            else:
                found = guess
            if found.pull <= max(self._pull, fair):
                break
        if found is None:
            return Verdict(0.0, None, frozenset()), np.empty(0, dtype=np.int64), np.empty((0, 6))
        failed = found.pull > max(self._pull, fair)
        self._pull = min(max(self._pull, found.pull), 1.0 / self.physics.least_margin)
        rows, wrenches = found.region.rows, found.wrenches
        if found.solution is not None and (math.isinf(found.pull) or (failed and found.exact)):
            return to_verdict(found.solution, list(found.region.cells)), rows, wrenches
        needs = self._witness.needs_with(rows, wrenches)
        return self._bounded(found.pull, rows, needs), rows, wrenches

    def _guess(self, around: _Surroundings, number: int) -> _Found | None:
        """What is needed if the joints around give like springs under one of the pushes."""
        if around.guesses is None:
            return None
        region, wrenches = around.region, around.guesses[number]
        needs = self._witness.needs_with(region.rows, wrenches)
        pull = max(float(needs.max()), self._witness.need_outside(region.rows))
        return _Found(region, pull, wrenches)

    def _solve(self, around: _Surroundings, cell: Cell, push: Floats) -> _Found:
        """The least that is needed if only the joints around bear a push."""
        region, outside = around.region, self._witness.need_outside(around.region.rows)
        thrift = 0.0 if around.whole else _THRIFT
        solution = region.solve(cell, push, _ENOUGH * self._pull, thrift)
        exact = around.whole and solution.pull >= outside
        pull = max(solution.pull, outside)
        return _Found(region, pull, solution.wrenches, solution, exact)

    def _surroundings(self, cell: Cell, pushes: Sequence[Floats]) -> Iterator[_Surroundings]:
        """Ever larger ones."""
        witness = self._witness
        for around in surroundings(cell, witness.cells, self._rooted):
            region = witness.region(around)
            yield _Surroundings(region, False, region.spread(cell, pushes))
        if self._thorough:
            piece = witness.region(piece_of(cell, witness.cells))
            yield _Surroundings(piece, True, piece.spread(cell, pushes))

    def _bounded(self, pull: float, rows: Ints, needs: Floats) -> Verdict:
        """A verdict by a witness: its most strained joint is the weakest that is known."""
        if pull <= 0.0:
            return STANDS
        if needs.max(initial=0.0) < self._witness.need_outside(rows):
            weakest = self._witness.most_strained()
        else:
            weakest = self._witness.joint(int(rows[needs.argmax()]))
        return Verdict(1.0 / pull, weakest, frozenset())


def _down_the_column(height: int, physics: Physics) -> Floats:
    """What the joints of a column bear of a push at its top, from above: (4 sides, h, 6)."""
    lever_m = physics.pitch_m * np.arange(1, height + 1)
    wrenches = np.zeros((len(SIDES), height, 6))
    wrenches[:, :, 2] = physics.placement_down_n
    for side, (x, y) in enumerate(SIDES):
        wrenches[side, :, 0] = -x * physics.placement_side_n
        wrenches[side, :, 1] = -y * physics.placement_side_n
        wrenches[side, :, 3] = y * physics.placement_side_n * lever_m
        wrenches[side, :, 4] = -x * physics.placement_side_n * lever_m
    return wrenches
