"""The best object of one size, by an exact solver.

A variable says whether a cell is filled; cells that the shape's symmetry ties together share one.
What must hold of any object stands in the model from the start:

- no more parts than there are, and something at every side of the box (else it were another size);
- access from above: in its layer, every part is within ``reach`` steps of one that rests on
  something and can be placed first. A cell's variable of level d is true only if such a part is at
  most d steps away;
- outlines: a pixel is filled if any cell behind it is.

What is rarely violated is added when it is: a piece that stands apart, and mechanisms of collapse.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from cellctl.assembly import Cell
from cellctl.validating.repairing.collapse import Mechanism
from cellctl.validating.repairing.rows import broken_rows
from cellctl.validating.repairing.score import VIEWS, Size, Terms
from cellctl.validating.repairing.symmetry import Symmetry, orbits
from cellctl.validating.rules import Cells, lateral, pieces

if TYPE_CHECKING:
    from ortools.sat.python import cp_model

SAME = 1e-5
"""Scores closer than this are equal."""

_SCALE = 100_000_000
"""Objective coefficients are integers: this many are 1."""

_SEED = 1

_LEAST_COVERED = 2.0
"""Volume and outlines each cover at least what is wanted."""


class Effort(NamedTuple):
    """What the solver may spend on one call."""

    seconds: float
    """Wall time, which the budget of a plan is in."""
    steps: float
    """The solver's deterministic time, about as many seconds. It is what ends a search that takes
    too long, if there is no haste; so the outcome does not depend on the machine."""


class Answer(NamedTuple):
    """What the solver found."""

    cells: Cells
    """Empty if nothing is better than what was asked to be beaten, or nothing was found in time."""
    bound: float
    """No object of this size has a higher score."""
    proven: bool
    """Whether the bound is the best one's score, or says that none beats it."""
    steps: float
    """What was spent, in deterministic time."""


class Model:
    """Objects of one size.

    Args:
        terms: what each cell counts; they say the size, too.
        parts: the most cells.
        reach: the most steps, side by side, from a cell to one of its layer that rests on
            something.
        kept: the symmetries that the object must have.
    """

    def __init__(self, terms: Terms, parts: int, reach: int, kept: tuple[Symmetry, ...]) -> None:
        from ortools.sat.python import cp_model  # noqa: PLC0415 - heavy

        self.size: Size = terms.size
        self._terms = terms
        self._model = cp_model.CpModel()
        self._of = orbits(self.size, kept)
        self._orbits: dict[Cell, list[Cell]] = {}
        for cell in sorted(self._of):
            self._orbits.setdefault(self._of[cell], []).append(cell)
        self._filled = {cell: self._model.new_bool_var("") for cell in self._orbits}
        self._volume = {
            cell: float(sum(terms.volume[c] for c in orbit)) for cell, orbit in self._orbits.items()
        }
        # The whole box, and the whole of each of its sides.
        self._most_covered = terms.cell * math.prod(self.size) + sum(
            area * self.size[a] * self.size[b]
            for area, (a, b) in zip(terms.pixels, VIEWS, strict=True)
        )
        self._pixels: list[tuple[cp_model.IntVar, float, float]] = []
        self._holds: dict[tuple[Cell, Cells], cp_model.IntVar] = {}
        self._props = {
            cell: [(c, c.below(), self._of[c]) for c in (cell, *lateral(cell)) if c in self._of]
            for cell in self._of
        }
        self._rests: dict[Cell, cp_model.IntVar] = {}
        self._hint: Cells = frozenset()
        self._add_count(parts)
        self._add_sides()
        self._add_access(reach)
        self._add_outlines()
        self._add_rows()

    def _at(self, cell: Cell) -> cp_model.IntVar:
        return self._filled[self._of[cell]]

    def _add_count(self, parts: int) -> None:
        self._model.add(
            sum(len(orbit) * self._filled[cell] for cell, orbit in self._orbits.items()) <= parts
        )

    def _add_sides(self) -> None:
        seen = set()
        for axis in range(3):
            for end in (0, self.size[axis] - 1):
                side = frozenset(self._of[cell] for cell in self._of if cell[axis] == end)
                if side not in seen:
                    seen.add(side)
                    self._model.add_bool_or([self._filled[cell] for cell in sorted(side)])

    def _add_access(self, reach: int) -> None:
        model = self._model
        above = [cell for cell in self._orbits if cell.z > 0]
        self._starts = {cell: model.new_bool_var("") for cell in above}
        for cell, flag in self._starts.items():
            model.add_implication(flag, self._filled[cell])
            model.add_implication(flag, self._at(cell.below()))
        levels = [self._starts]
        levels += [{c: model.new_bool_var("") for c in above} for _ in range(reach - 1)]
        for below, level in pairwise(levels):
            for cell, flag in level.items():
                model.add_implication(flag, self._filled[cell])
                model.add_bool_or([flag.negated(), *self._near(cell, below)])
        for cell in above:
            near = self._near(cell, levels[-1]) if reach else [self._starts[cell]]
            model.add_bool_or([self._filled[cell].negated(), *near])

    def _near(self, cell: Cell, level: dict[Cell, cp_model.IntVar]) -> list[cp_model.IntVar]:
        """A cell and those beside it, at that level."""
        beside = {self._of[c] for c in lateral(cell) if c in self._of}
        return [level[c] for c in sorted(beside | {cell})]

    def _add_outlines(self) -> None:
        found: dict[frozenset[Cell], list[float]] = {}
        for (a, b), outline, area in zip(
            VIEWS, self._terms.outlines, self._terms.pixels, strict=True
        ):
            lines: dict[tuple[int, int], set[Cell]] = {}
            for cell, first in self._of.items():
                lines.setdefault((cell[a], cell[b]), set()).add(first)
            for pixel, line in lines.items():
                entry = found.setdefault(frozenset(line), [0.0, 0.0])
                entry[0] += float(outline[pixel])
                entry[1] += area
        for cells, (shared, covered) in found.items():
            behind = [self._filled[cell] for cell in sorted(cells)]
            if len(behind) == 1:
                seen = behind[0]
            else:
                seen = self._model.new_bool_var("")
                self._model.add_bool_or([seen.negated(), *behind])
                for variable in behind:
                    self._model.add_implication(variable, seen)
            self._pixels.append((seen, shared, covered))

    def _add_rows(self) -> None:
        """No holes and no notches where the wanted shape has none."""
        found = set()
        for first, between, last in broken_rows(self._terms.volume >= self._terms.cell / 2):
            ends = sorted((self._of[first], self._of[last]))
            found.add((ends[0], self._of[between], ends[1]))
        for first, between, last in sorted(found):
            if between not in (first, last):
                self._model.add_bool_or(
                    self._filled[first].negated(),
                    self._filled[between],
                    self._filled[last].negated(),
                )

    def join(self, cells: Cells) -> None:
        """Demand of an object in several pieces, and of those like it, that they hang together."""
        for piece in pieces(cells):
            around = {c for cell in piece for c in cell.neighbours()}
            border = {c for c in around if c in self._of and c not in piece}
            beyond = self._of.keys() - border - piece
            here, there = self._model.new_bool_var(""), self._model.new_bool_var("")
            for cell in sorted({self._of[c] for c in piece}):
                self._model.add_implication(self._filled[cell], here)
            for cell in sorted({self._of[c] for c in beyond}):
                self._model.add_implication(self._filled[cell], there)
            across = [self._filled[c] for c in sorted({self._of[c] for c in border})]
            self._model.add_bool_or([here.negated(), there.negated(), *across])

    def forbid(self, mechanisms: Iterable[Mechanism], floor_grips: bool) -> None:
        """Exclude every place of mechanisms of collapse."""
        seen = set()
        for mechanism in mechanisms:
            for place in mechanism.places(self.size, floor_grips):
                loose = frozenset(self._of[cell] for cell in place.moving)
                held = frozenset(self._of[cell] for cell in place.missing)
                start = None if place.first is None else self._of[place.first]
                if loose & held or (loose, held, start) in seen:
                    continue
                seen.add((loose, held, start))
                helping = [self._holding(cell, place.moving) for cell in sorted(place.missing)]
                first = [] if start is None else [self._starts[start]]
                if place.loads:
                    self._model.add(
                        sum(load * self._at(cell) for cell, load in place.loads) <= place.limit
                    ).only_enforce_if([*(h.negated() for h in helping), *first])
                else:
                    standing = [self._filled[cell] for cell in sorted(loose)] + first
                    self._model.add_bool_or([*helping, *(v.negated() for v in standing)])

    def _holding(self, cell: Cell, moving: Cells) -> cp_model.IntVar:
        """Whether a cell beside moving ones is there and holds them.

        It must rest on something that stays, or be joined to a part that does, side by side. What
        only hangs on the moving ones is no help.
        """
        if cell.z == 0:
            return self._at(cell)
        props = frozenset(
            first
            for one, below, first in self._props[cell]
            if one not in moving and below not in moving
        )
        key = (self._of[cell], props)
        if key not in self._holds:
            holds = self._model.new_bool_var("")
            self._model.add_implication(holds, self._at(cell))
            self._model.add_bool_or(
                [holds.negated(), *(self._resting(first) for first in sorted(props))]
            )
            self._holds[key] = holds
        return self._holds[key]

    def _resting(self, first: Cell) -> cp_model.IntVar:
        """Whether a cell is there and rests on something."""
        if first.z == 0:
            return self._filled[first]
        if first not in self._rests:
            rests = self._model.new_bool_var("")
            self._model.add_implication(rests, self._filled[first])
            self._model.add_implication(rests, self._at(first.below()))
            self._rests[first] = rests
        return self._rests[first]

    def exclude(self, cells: Cells) -> None:
        """Exclude one object."""
        filled = {self._of[cell] for cell in cells}
        self._model.add_bool_or(
            [v.negated() if c in filled else v for c, v in self._filled.items()]
        )

    def beat(self, score: float, effort: Effort, *, required: bool) -> Answer:
        """The object that beats a score most: shared volume and outlines beyond what it asks for.

        Args:
            score: to be beaten; the answer is the best of all if its own score equals it.
            effort: what may be spent.
            required: whether an object that does not beat it is no answer.
        """
        from ortools.sat.python import cp_model  # noqa: PLC0415 - heavy

        model = self._model.clone()
        ratio = score / self._terms.agreement
        coefficients: dict[int, int] = {}
        variables: dict[int, cp_model.IntVar] = {}

        def count(variable: cp_model.IntVar, shared: float, covered: float) -> None:
            value = round(_SCALE * (shared - ratio * (covered - shared)))
            coefficients[variable.index] = coefficients.get(variable.index, 0) + value
            variables[variable.index] = variable

        for cell, variable in self._filled.items():
            count(variable, self._volume[cell], self._terms.cell * len(self._orbits[cell]))
        for variable, shared, covered in self._pixels:
            count(variable, shared, covered)
        constant = round(_SCALE * -2.0 * ratio)
        objective = sum(coefficients[i] * variables[i] for i in coefficients) + constant
        if required:
            # Far more than rounding can add up to, and as little as makes a difference.
            model.add(objective >= round(_SCALE * SAME))
        model.maximize(objective)
        if self._hint:
            filled = {self._of[cell] for cell in self._hint}
            for cell, variable in self._filled.items():
                model.add_hint(variable, cell in filled)
        solver = cp_model.CpSolver()
        solver.parameters.num_workers = 1  # more are not deterministic
        solver.parameters.random_seed = _SEED
        solver.parameters.max_time_in_seconds = max(effort.seconds, 0.01)
        solver.parameters.max_deterministic_time = effort.steps
        # Outlines are tight as linear constraints, without which proofs take ten times as long; on
        # level 2 the programme is so large that all takes twice as long.
        solver.parameters.linearization_level = 1
        # Models so small are solved in the time that looking for symmetries and probing takes.
        solver.parameters.symmetry_level = 0
        solver.parameters.cp_model_probing_level = 0
        solver.parameters.max_presolve_iterations = 1
        status = solver.solve(model)
        spent = float(solver.response_proto.deterministic_time)
        if status == cp_model.INFEASIBLE:
            return Answer(frozenset(), score if required else 0.0, proven=True, steps=spent)
        # What is shared beyond the ratio, over all that is covered, is ratio beyond it.
        over = solver.best_objective_bound / _SCALE
        over /= _LEAST_COVERED if over > 0.0 else self._most_covered
        bound = self._terms.agreement * (ratio + over) if math.isfinite(over) else 1.0
        if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            return Answer(frozenset(), bound, proven=False, steps=spent)
        cells = frozenset(
            cell
            for first, variable in self._filled.items()
            if solver.boolean_value(variable)
            for cell in self._orbits[first]
        )
        self._hint = cells
        return Answer(cells, bound, proven=status == cp_model.OPTIMAL, steps=spent)
