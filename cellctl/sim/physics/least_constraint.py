"""How a structure begins to move, by Gauss's principle of least constraint.

Of all motions that its contacts permit, a structure of rigid parts begins with the one nearest to
how its parts would move without them, in the measure of their inertia [Gauss 1829; Moreau 1966
for contacts]::

    minimise  1/2 a'Ma - c'a   such that   G'a >= 0

``a`` are the accelerations of parts, ``c`` the forces on them (weight, magnets, pushes), and each
column of ``G`` is an extreme wrench of a contact, which can push and not pull. The minimum is
unique. It is nought if and only if the contacts can hold all parts in place, and else it names
the parts that do not stay.

It is found by a primal-dual interior-point method with predictor and corrector [Mehrotra 1992],
for several loads at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cellctl.sim.physics.block_tridiagonal import Factors
from cellctl.sim.physics.joints import Floats
from cellctl.sim.physics.structure import Structure

ITERATIONS = 60
"""At most; structures of 3 to 60 parts take 5 to 18."""
GAP = 1e-8
"""Twice how far the minimum may be missed; accelerations are off by its root (in g), at most."""
LEFT = 1e-7
"""What may be left of the imbalance and mismatch at the start, as a share of them. It is reckoned
from the steps taken: measured, it would be what rounding makes of stiff joints."""
_BACK_OFF = 0.995
"""Steps end this near to where something would leave the interior."""


def accelerations(structure: Structure, loads: Floats, still: float = 0.0) -> Floats:
    """How the parts begin to move under each of several loads.

    Args:
        structure: at least one part.
        loads: cases x parts x 6: forces and moments on the parts, magnets included.
        still: what is proven to be slower than this (in g) is given as 0.

    Returns:
        Cases x parts x 6: linear and angular accelerations.
    """
    newton = _Newton(structure)
    iterate = newton.start(loads)
    found = np.zeros_like(loads)
    unfinished = np.arange(len(loads))
    for _ in range(ITERATIONS):
        stands = newton.least_bound(iterate) < still
        done = iterate.finished() | stands
        found[unfinished[done]] = np.where(stands[done, None, None], 0.0, iterate.motion[done])
        unfinished, iterate = unfinished[~done], iterate.only(~done)
        if not len(unfinished):
            return found
        iterate = newton.improved(iterate)
    found[unfinished] = iterate.motion
    return found


class _Iterate(NamedTuple):
    """A point in the interior, for each case."""

    load: Floats
    """Cases x parts x 6."""
    motion: Floats
    slack: Floats
    """Cases x joints x corners, positive: what ``G'a`` is to be."""
    force: Floats
    """The same for the multipliers: how hard each corner pushes."""
    left: Floats
    """By case; see ``LEFT``."""

    def gap(self) -> Floats:
        return np.asarray(np.einsum("cjk,cjk->c", self.slack, self.force))

    def finished(self) -> npt.NDArray[np.bool_]:
        return np.asarray((self.gap() <= GAP) & (self.left <= LEFT))

    def only(self, cases: npt.NDArray[np.bool_]) -> _Iterate:
        return _Iterate(*(array[cases] for array in self))


class _Step(NamedTuple):
    motion: Floats
    slack: Floats
    force: Floats


class _Newton:
    """Improves iterates of one structure."""

    def __init__(self, structure: Structure) -> None:
        self._structure = structure
        self._corners = structure.material.corners()

    def start(self, load: Floats) -> _Iterate:
        shape = (len(load), len(self._structure.joints), self._corners.shape[1])
        motion = np.zeros_like(load)
        return _Iterate(load, motion, np.ones(shape), np.ones(shape), np.ones(len(load)))

    def least_bound(self, at: _Iterate) -> Floats:
        """How fast any part can begin to move at most, by case.

        Whatever the corners push with, the forces that remain are a bound: the least that can
        remain, over all pushes, is what accelerates the parts [the dual of the minimum].
        """
        remains = at.load + self._structure.forces(at.force @ self._corners.T)
        inertia = self._structure.inertia
        return np.asarray(np.sqrt((remains**2 / inertia).sum(axis=(1, 2)) / inertia.min()))

    def improved(self, at: _Iterate) -> _Iterate:
        """One step of predictor and corrector."""
        ratio = at.force / at.slack
        of_joints = (ratio[:, :, None, :] * self._corners) @ self._corners.T
        factors = Factors.of(*self._structure.stiffness(of_joints))
        complement = at.slack * at.force
        ahead = self._step(at, factors, complement)
        mean = complement.mean(axis=(1, 2), keepdims=True)
        reach = _reach(at, ahead)
        after = (at.slack + reach * ahead.slack) * (at.force + reach * ahead.force)
        centring = (after.mean(axis=(1, 2), keepdims=True) / mean) ** 3
        step = self._step(at, factors, complement + ahead.slack * ahead.force - centring * mean)
        reach = _BACK_OFF * _reach(at, step)
        return _Iterate(
            at.load,
            at.motion + reach * step.motion,
            at.slack + reach * step.slack,
            at.force + reach * step.force,
            at.left * (1.0 - reach[:, 0, 0]),
        )

    def _step(self, at: _Iterate, factors: Factors, complement: Floats) -> _Step:
        """Newton's step towards balance, with ``complement`` taken off slack times force."""
        structure, corners = self._structure, self._corners
        mismatch = structure.relative(at.motion) @ corners - at.slack
        target = at.force - (complement + at.force * mismatch) / at.slack
        right = at.load + structure.forces(target @ corners.T) - structure.inertia * at.motion
        motion = structure.joined(factors.solve(structure.sliced(right)))
        slack = structure.relative(motion) @ corners + mismatch
        force = -(complement + at.force * slack) / at.slack
        return _Step(motion, slack, force)


def _reach(at: _Iterate, step: _Step) -> Floats:
    """How much of a step can be taken with everything positive, at most 1; cases x 1 x 1."""
    fastest = np.maximum(-step.slack / at.slack, -step.force / at.force)
    return np.asarray(1.0 / np.maximum(fastest.max(axis=(1, 2), keepdims=True), 1.0))
