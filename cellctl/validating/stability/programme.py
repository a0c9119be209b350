"""Static equilibrium of rigid parts with magnetic joints, as a linear programme.

The lower-bound theorem of limit analysis: a structure stands if any distribution of joint forces
balances all loads and overloads no joint (Livesley, 1978; Whiting et al., "Procedural modeling of
structurally-sound masonry buildings", 2009). A joint presses with forces ``p >= 0`` at four points
and pulls with at most ``lambda F`` at its centre; friction bounds shear and twist together. The
smallest ``lambda`` says how much of the magnets' force the structure needs.

Units inside: forces in F, the pull of one joint; lengths in half an edge of a cell, so that all
entries are 1 or 2 and the result does not depend on scale.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog
from scipy.sparse import csc_array

from cellctl.errors import PlanError
from cellctl.validating.stability.joints import FLOOR, Ints, Joint, Joints
from cellctl.validating.stability.physics import Physics

Floats = npt.NDArray[np.float64]

_PRESSES = 4
"""Points at which the faces of a joint press on each other."""
_FORCES = 10
"""Unknowns of a joint: the presses, two shears and a twist, each of these as a pair of signs."""
_SIMPLEX_UP_TO = 100
"""Parts up to which the dual simplex is faster than the interior-point method."""
_MOVES = 1e-7
"""A part moves in the collapse if its velocity exceeds this, where the joints open by 1 in all."""


class Solution(NamedTuple):
    """The least pull that a load needs, and what would give way first."""

    pull: float
    """``lambda``: needed share of the magnets' force; infinite if no pull is enough."""
    weakest: Joint | None
    """The joint that opens most as the structure collapses; None if none needs to pull."""
    moving: Ints
    """Numbers of the parts that move as it collapses."""
    wrenches: Floats
    """What the joints bear, (m, 6): force in N, and moment in N m about the centre of the faces,
    by the lower part on the upper one. Empty if no pull is enough."""


class Programme:
    """The equilibrium of one structure; its loads vary.

    Args:
        cells: (n, 3), at least one.
        physics: what holds them.
    """

    def __init__(self, cells: Ints, physics: Physics) -> None:
        self.cells = cells
        self._physics = physics
        self.joints = Joints.among(cells)
        count, joints = len(cells), len(self.joints.axis)
        actions, templates = _templates(physics.contact)
        pull = np.ones(joints)
        if not physics.floor_grips:
            pull[self.joints.lower == FLOOR] = 0.0
        self._actions = actions[self.joints.axis]
        self._actions[:, _FORCES] *= pull[:, None]
        rows, columns, values = [], [], []
        for side, part in enumerate((self.joints.upper, self.joints.lower)):
            # entries of each joint: (m, forces + 1, 6); the last force is the magnets' pull.
            entries = templates[self.joints.axis, :, side, :]
            entries[:, _FORCES, :] *= pull[:, None]
            entries[part == FLOOR] = 0.0
            joint, force, row = np.nonzero(entries)
            rows.append(6 * part[joint] + row)
            columns.append(np.where(force == _FORCES, _FORCES * joints, _FORCES * joint + force))
            values.append(entries[joint, force, row])
        width = _FORCES * joints + 1
        self._balance = csc_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(6 * count, width),
        )
        friction = np.ones((joints, _FORCES))
        friction[:, :_PRESSES] = -physics.friction
        self._friction = csc_array(
            (friction.ravel(), (np.repeat(np.arange(joints), _FORCES), np.arange(width - 1))),
            shape=(joints, width),
        )
        self._opening = np.zeros((joints, 2, 6))
        for side in range(2):
            self._opening[:, side] = templates[self.joints.axis, _FORCES, side, :] * pull[:, None]

    def weights(self) -> Floats:
        """The load of gravity: (n, 6) in newtons and newton metres, force then moment."""
        loads = np.zeros((len(self.cells), 6))
        loads[:, 2] = -self._physics.weight_n
        return loads

    def solve(self, loads: Floats) -> Solution:
        """The least pull under loads (n, 6): force in N and moment about each part's centre in N m.

        Raises:
            PlanError: the solver found neither a solution nor that there is none.
        """
        physics = self._physics
        scaled = loads / physics.magnet_force_n
        scaled[:, 3:] /= physics.pitch_m / 2
        width = self._balance.shape[1]
        cost = np.zeros(width)
        cost[-1] = 1.0
        method = "highs-ds" if len(self.cells) <= _SIMPLEX_UP_TO else "highs-ipm"
        found = linprog(
            cost,
            A_ub=self._friction,
            b_ub=np.zeros(self._friction.shape[0]),
            A_eq=self._balance,
            b_eq=-scaled.ravel(),
            bounds=(0.0, None),
            method=method,
        )
        if found.status == 2:
            moving = self._toppling(-scaled.ravel())
            return Solution(float("inf"), None, moving, np.empty((0, 6)))
        if found.status != 0:
            raise PlanError(
                f"The stability of {len(self.cells)} parts cannot be computed: {found.message}",
                "Ask for a smaller object.",
            )
        pull = max(0.0, float(found.fun))
        velocity = np.asarray(found.eqlin.marginals).reshape(-1, 6)
        moving = np.flatnonzero(np.abs(velocity).max(axis=1) > _MOVES)
        weakest = self._most_open(velocity) if pull > 0.0 and len(moving) else None
        return Solution(pull, weakest, moving, self._wrenches(found.x))

    def _wrenches(self, forces: Floats) -> Floats:
        """What the joints bear, (m, 6), by the solution of the programme."""
        each = np.empty((len(self.joints.axis), _FORCES + 1))
        each[:, :_FORCES] = forces[:-1].reshape(-1, _FORCES)
        each[:, _FORCES] = forces[-1]
        wrenches: Floats = np.einsum("jf,jfk->jk", each, self._actions)
        wrenches *= self._physics.magnet_force_n
        wrenches[:, 3:] *= self._physics.pitch_m / 2
        return wrenches

    def _most_open(self, velocity: Floats) -> Joint:
        """Where the collapse works hardest against the magnets, by the dual solution (n, 6)."""
        opening = np.einsum("jk,jk->j", self._opening[:, 0], velocity[self.joints.upper])
        inner = self.joints.lower != FLOOR
        opening[inner] += np.einsum(
            "jk,jk->j", self._opening[inner, 1], velocity[self.joints.lower[inner]]
        )
        # Equal joints of a symmetric structure differ by rounding only: the first one is named.
        best = int(np.flatnonzero(opening >= opening.max() - 1e-6)[0])
        return self.joints.named(best, self.cells)

    def _toppling(self, loads: Floats) -> Ints:
        """Which parts move although the magnets were as strong as you like: helped least."""
        rows, width = self._balance.shape
        helped = csc_array(
            (
                np.r_[self._balance.tocoo().data, np.ones(rows), -np.ones(rows)],
                (
                    np.r_[self._balance.tocoo().row, np.arange(rows), np.arange(rows)],
                    np.r_[self._balance.tocoo().col, width + np.arange(2 * rows)],
                ),
            ),
            shape=(rows, width + 2 * rows),
        )
        friction = self._friction.tocoo()
        found = linprog(
            np.r_[np.zeros(width), np.ones(2 * rows)],
            A_ub=csc_array(
                (friction.data, (friction.row, friction.col)),
                shape=(friction.shape[0], width + 2 * rows),
            ),
            b_ub=np.zeros(friction.shape[0]),
            A_eq=helped,
            b_eq=loads,
            bounds=(0.0, None),
            method="highs",
        )
        if found.status != 0:
            return np.arange(len(self.cells))
        velocity = np.asarray(found.eqlin.marginals).reshape(-1, 6)
        return np.flatnonzero(np.abs(velocity).max(axis=1) > _MOVES)


@lru_cache(maxsize=2)
def _templates(contact: str) -> tuple[Floats, Floats]:
    """What a unit of each force of a joint does; the last force is the pull of its magnets.

    Returns:
        (3 axes, forces + 1, 6): force on the upper part, and moment about the centre of the faces;
        (3 axes, forces + 1, upper and lower part, 6): force on each part, and moment about its
        own centre.
    """
    unit = np.eye(3)
    actions = np.zeros((3, _FORCES + 1, 6))
    templates = np.zeros((3, _FORCES + 1, 2, 6))
    for axis in range(3):
        along, u, v = unit[axis], unit[(axis + 1) % 3], unit[(axis + 2) % 3]
        points = (u, -u, v, -v) if contact == "diamond" else (u + v, u - v, v - u, -u - v)
        each = [(along, np.cross(point, along)) for point in points]
        each += [(shear, np.zeros(3)) for shear in (u, -u, v, -v)]
        # Friction at the contact points twists with a lever of half an edge.
        each += [(np.zeros(3), twist) for twist in (along, -along)]
        each.append((-along, np.zeros(3)))
        for number, (force, moment) in enumerate(each):
            actions[axis, number] = np.r_[force, moment]
            for side, (sign, centre) in enumerate(((1.0, -along), (-1.0, along))):
                templates[axis, number, side, :3] = sign * force
                templates[axis, number, side, 3:] = sign * (moment + np.cross(centre, force))
    actions.flags.writeable = templates.flags.writeable = False
    return actions, templates
