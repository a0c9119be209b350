"""What a search is given and what it returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cellctl.validating.repairing.collapse import Collapses, Mechanism, Stands
from cellctl.validating.repairing.model import SAME
from cellctl.validating.repairing.score import Size
from cellctl.validating.rules import Cells

Judge = Callable[[Cells, float], Stands | Collapses | None]
"""Whether connected cells that are accessible from above stand at every step of some order; None
where a time of the monotonic clock came before that was known."""


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
