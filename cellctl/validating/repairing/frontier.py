"""Which sizes there are, the most promising first, with bounds that are found when they matter."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cellctl.validating.repairing.bound import quick_bounds, relaxed_bound
from cellctl.validating.repairing.model import Model
from cellctl.validating.repairing.score import Size, Wanted
from cellctl.validating.rules import Cells


@dataclass
class Candidate:
    """A size, and what is known of its objects."""

    size: Size
    bound: float
    """No object of this size has a higher score."""
    cells: Cells = frozenset()
    """The best of this size, as far as it is known."""
    model: Model | None = None
    learnt: int = 0
    """How many of the mechanisms the model knows."""
    rounds: int = 0
    exhausted: bool = False
    """Whether the solver could not settle it with the effort that is due; it keeps its bound."""


class Frontier:
    """All sizes, of which only those are opened that could hold the best object.

    Args:
        wanted: the shape.
        most: the largest size.
        square: whether only sizes that are as wide as they are deep count.
        parts: the most cells.
        most_cells: larger boxes are never opened; they keep their quick bound.
    """

    def __init__(
        self, wanted: Wanted, most: Size, square: bool, parts: int, most_cells: float
    ) -> None:
        self._wanted = wanted
        self._parts = parts
        bounds = quick_bounds(wanted, most, parts)
        if square:
            bounds = np.where(np.eye(most[0], most[1], dtype=bool)[:, :, None], bounds, 0.0)
        order = np.argsort(-bounds, axis=None, kind="stable")
        order = order[bounds.flat[order] > 0.0]
        self._all = np.stack(np.unravel_index(order, bounds.shape), axis=1) + 1
        solvable = self._all.prod(axis=1) <= most_cells
        self._sizes = self._all[solvable]
        self._quick = bounds.flat[order[solvable]]
        self.beyond = float(bounds.flat[order[~solvable]].max(initial=0.0))
        """No object of a larger box has a higher score."""
        self.opened: list[Candidate] = []

    def top(self, above: float, until_s: float) -> Candidate | None:
        """The size with the highest bound of those that are not exhausted.

        Args:
            above: sizes whose bound does not exceed this are of no use.
            until_s: no more sizes are opened after this time of the monotonic clock; the best
                opened one is taken then.
        """
        top = max(
            (candidate for candidate in self.opened if not candidate.exhausted),
            key=lambda candidate: candidate.bound,
            default=None,
        )
        while self._next > max(above, 0.0 if top is None else top.bound):
            if time.monotonic() > until_s:
                break
            opened = self._open()
            if top is None or opened.bound > top.bound:
                top = opened
        return top

    @property
    def bound(self) -> float:
        """No object of any size has a higher score."""
        return max([self.beyond, self._next, *(candidate.bound for candidate in self.opened)])

    @property
    def _next(self) -> float:
        """The highest bound of a size that was not opened."""
        count = len(self.opened)
        return float(self._quick[count]) if count < len(self._quick) else 0.0

    def _open(self) -> Candidate:
        quick = self._next
        size = _size(self._sizes[len(self.opened)])
        bound = min(quick, relaxed_bound(self._wanted.terms(size), self._parts))
        self.opened.append(Candidate(size, bound))
        return self.opened[-1]

    def all(self) -> Iterator[Size]:
        """Every size, the one with the highest quick bound first."""
        return map(_size, self._all)


def _size(row: npt.NDArray[np.int64]) -> Size:
    nx, ny, nz = row.tolist()
    return (nx, ny, nz)
