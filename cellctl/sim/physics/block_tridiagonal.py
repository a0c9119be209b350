"""Symmetric systems whose unknowns stand in slices, each tied to the next one only."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from cellctl.sim.physics.joints import Floats


class Factors(NamedTuple):
    """A factored system, of several cases at once: solves for right-hand sides."""

    inverse: tuple[Floats, ...]
    """One a slice: cases x size x size, the inverse of what elimination left of its block."""
    back: tuple[Floats, ...]
    """One for each slice but the last: cases x size x next size."""

    @classmethod
    def of(cls, diagonal: list[Floats], upper: list[Floats]) -> Self:
        """Factor a positive definite system.

        Args:
            diagonal: one block a slice, cases x size x size.
            upper: the blocks that tie each slice to the next, cases x size x next size.

        Raises:
            numpy.linalg.LinAlgError: it is singular to working precision.
        """
        inverse: list[Floats] = [np.asarray(np.linalg.inv(diagonal[0]))]
        back: list[Floats] = []
        for block, tie in zip(diagonal[1:], upper, strict=True):
            back.append(inverse[-1] @ tie)
            inverse.append(np.asarray(np.linalg.inv(block - tie.swapaxes(-1, -2) @ back[-1])))
        return cls(tuple(inverse), tuple(back))

    def solve(self, right: list[Floats]) -> list[Floats]:
        """One vector a slice, cases x size, to the solution in the same form."""
        ahead = [right[0]]
        for vector, tie in zip(right[1:], self.back, strict=True):
            ahead.append(vector - np.einsum("cij,ci->cj", tie, ahead[-1]))
        found = [np.einsum("cij,cj->ci", self.inverse[-1], ahead[-1])]
        for vector, inverse, tie in zip(
            ahead[-2::-1], self.inverse[-2::-1], self.back[::-1], strict=True
        ):
            level = np.einsum("cij,cj->ci", inverse, vector)
            found.append(level - np.einsum("cij,cj->ci", tie, found[-1]))
        return found[::-1]
