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

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, hstack

from cellctl.validating.stability.joints import FLOOR, Floats, Ints, Joint, Joints
from cellctl.validating.stability.physics import Physics
from cellctl.validating.stability.solver import minimise

_PRESSES = 4
"""Points at which the faces of a joint press on each other."""
_FORCES = 10
"""Unknowns of a joint: the presses, two shears and a twist, each of these as a pair of signs."""
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
        known: the joints of the cells, where they are at hand.
    """

    def __init__(self, cells: Ints, physics: Physics, known: Joints | None = None) -> None:
        self.cells = cells
        self._physics = physics
        self.joints = Joints.among(cells) if known is None else known
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
        # Friction: the shears and twists of a joint are at most mu times its presses, together.
        friction = np.ones((joints, _FORCES))
        friction[:, :_PRESSES] = -physics.friction
        rows.append(6 * count + np.repeat(np.arange(joints), _FORCES))
        columns.append(np.arange(width - 1))
        values.append(friction.ravel())
        self._conditions = csr_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(6 * count + joints, width),
        )
        self._opening = np.zeros((joints, 2, 6))
        for side in range(2):
            self._opening[:, side] = templates[self.joints.axis, _FORCES, side, :] * pull[:, None]

    def weights(self) -> Floats:
        """The load of gravity: (n, 6) in newtons and newton metres, force then moment."""
        loads = np.zeros((len(self.cells), 6))
        loads[:, 2] = -self._physics.weight_n
        return loads

    def solve(self, loads: Floats, enough: float = 0.0, thrift: float = 0.0) -> Solution:
        """The least pull under loads (n, 6): force in N and moment about each part's centre in N m.

        Args:
            loads: on each part, (n, 6).
            enough: a pull that is not to be improved on; the solution has at least this.
            thrift: what a unit of shear or twist costs beside a unit of pull. With any, forces go
                short ways, and the pull is not quite the least.

        Raises:
            PlanError: the solver found neither a solution nor that there is none.
        """
        physics = self._physics
        scaled = -loads / physics.magnet_force_n
        scaled[:, 3:] /= physics.pitch_m / 2
        height, width = self._conditions.shape
        equations = scaled.size
        cost = np.full(width, thrift)
        cost[:-1].reshape(-1, _FORCES)[:, :_PRESSES] = 0.0
        cost[-1] = 1.0
        low = np.zeros(width)
        low[-1] = enough
        sides = np.zeros(height)
        sides[:equations] = scaled.ravel()
        found = minimise(cost, self._conditions, sides, low, equations)
        if math.isinf(found.value):
            return Solution(math.inf, None, self._toppling(sides), np.empty((0, 6)))
        pull = max(0.0, float(found.variables[-1]))
        velocity = found.duals.reshape(-1, 6)
        moving = np.flatnonzero(np.abs(velocity).max(axis=1) > _MOVES)
        weakest = self._most_open(velocity) if pull > 0.0 and len(moving) else None
        return Solution(pull, weakest, moving, self._wrenches(found.variables))

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

    def _toppling(self, sides: Floats) -> Ints:
        """Which parts move although the magnets were as strong as you like.

        Hands from outside could hold the structure; where their least help is, the parts move.
        """
        height, width = self._conditions.shape
        equations = 6 * len(self.cells)
        hands = np.arange(equations)
        help_ = csr_array(
            (
                np.r_[np.ones(equations), -np.ones(equations)],
                (np.r_[hands, hands], np.arange(2 * equations)),
            ),
            shape=(height, 2 * equations),
        )
        found = minimise(
            np.r_[np.zeros(width), np.ones(2 * equations)],
            csr_array(hstack([self._conditions, help_])),
            sides,
            np.zeros(width + 2 * equations),
            equations,
        )
        velocity = found.duals.reshape(-1, 6)
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
