"""The stability of a structure that grows part by part, from proofs that build on each other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import tee
from typing import Self

import numpy as np

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells
from cellctl.validating.stability.assess import STANDS, Verdict, assess, to_verdict
from cellctl.validating.stability.joints import Floats, Ints
from cellctl.validating.stability.loads import SIDES, placement_pushes
from cellctl.validating.stability.physics import Physics
from cellctl.validating.stability.witness import Region, Witness

GOOD_MARGIN = 1.5
"""A margin that is proven to be at least this is not determined more exactly."""
_ENOUGH = 0.5
"""Share of the needed pull that is no matter below which a witness of a push is not improved."""
_THRIFT = 0.01
"""Cost of shear where a region is balanced anew: a witness that strains no joint without need
leaves more to those who build on it."""
_REACHES = (1, 3, 5)
"""Cells beyond the nearest support within which forces are balanced anew, before all are, which
takes a second where they are many."""


class Growth:
    """A structure and a witness of its equilibrium; ``place`` adds a part and judges the state.

    Three facts save most of the work, and none of them guesses:

    - A part on a column down to the floor needs no magnets at rest: its weight goes straight down,
      and presses the column's joints together.
    - While it is pushed aside, the column's joints can bear that on top of what they bear at rest.
      What they need then is a sum.
    - Where a part hangs, the forces are balanced anew in its surroundings only. If it holds while
      it is pressed down, it holds at rest: that load is a mean of the load with the press and the
      load before, weighted by weight and press.

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
        regions = self._regions(cell)
        for push in placement_pushes(cell, self.cells, physics):
            regions, these = tee(regions)
            verdict, _, _ = self._withstand(cell, push, these)
            worst = min(worst, verdict, key=lambda v: v.margin)
        return worst

    def _place_hanging(self, cell: Cell) -> Verdict:
        """Balance the surroundings anew, for each push."""
        witness, physics = self._witness, self.physics
        worst = STANDS
        found: list[tuple[Ints, Floats]] = []
        regions = self._regions(cell)
        for push in placement_pushes(cell, self.cells, physics):
            regions, these = tee(regions)
            verdict, rows, wrenches = self._withstand(cell, push, these)
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
            piece = witness.region(self._piece(cell))
            solution = piece.solve(cell, np.zeros(6))
            if math.isinf(solution.pull):
                self._balanced = False
                return to_verdict(solution, list(piece.cells))
            witness.bear(piece.rows, solution.wrenches)
            pull = witness.need
            if solution.pull > max(self._pull, witness.need_outside(piece.rows)):
                return to_verdict(solution, list(piece.cells))
        return self._bounded(pull, np.empty(0, dtype=np.int64), np.empty(0))

    def _withstand(
        self, cell: Cell, push: Floats, regions: Iterable[tuple[Region, bool]]
    ) -> tuple[Verdict, Ints, Floats]:
        """The state while a cell is pushed, and what which joints bear then."""
        witness = self._witness
        for region, whole in regions:
            rows = region.rows
            solution = region.solve(
                cell, push, _ENOUGH * self._pull, thrift=0.0 if whole else _THRIFT
            )
            pull = max(solution.pull, witness.need_outside(rows))
            if pull <= self._pull:
                verdict = self._bounded(pull, rows, witness.needs_with(rows, solution.wrenches))
                return verdict, rows, solution.wrenches
        self._pull = min(max(self._pull, pull), 1.0 / self.physics.least_margin)
        exact = self._thorough and solution.pull >= witness.need_outside(rows)
        if exact or math.isinf(pull):
            return to_verdict(solution, list(region.cells)), rows, solution.wrenches
        verdict = self._bounded(pull, rows, witness.needs_with(rows, solution.wrenches))
        return verdict, rows, solution.wrenches

    def _regions(self, cell: Cell) -> Iterator[tuple[Region, bool]]:
        """Ever larger surroundings of a cell, and whether they are all that it is joined to."""
        distance = self._support_distance(cell)
        size = 0
        for reach in _REACHES:
            around = self._around(cell, distance + reach)
            if len(around) > size:
                size = len(around)
                yield self._witness.region(around), False
        if self._thorough:
            yield self._witness.region(self._piece(cell)), True

    def _support_distance(self, cell: Cell) -> int:
        """Steps through joints to the nearest cell that stands on a column."""
        seen, front, steps = {cell}, [cell], 0
        while front and not any(c in self._rooted for c in front):
            near = {beside for one in front for beside in one.neighbours()}
            front = list((near & self._witness.cells) - seen)
            seen.update(front)
            steps += 1
        return steps

    def _around(self, cell: Cell, steps: int) -> set[Cell]:
        """Cells within so many steps through joints, and those beneath them."""
        cells = self._witness.cells
        seen, front = {cell}, {cell}
        for _ in range(steps):
            near = {beside for one in front for beside in one.neighbours()}
            front = {one for one in near & cells if one.z >= cell.z - 1} - seen
            seen |= front
        for one in list(seen):
            below = one.below()
            while below in cells:
                seen.add(below)
                below = below.below()
        return seen

    def _piece(self, cell: Cell) -> set[Cell]:
        """All cells that hang together with one."""
        cells = self._witness.cells
        seen, front = {cell}, [cell]
        while front:
            for beside in front.pop().neighbours():
                if beside in cells and beside not in seen:
                    seen.add(beside)
                    front.append(beside)
        return seen

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
