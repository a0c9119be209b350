"""What bars the way to a part that stands: the gripper's way down, and the arm above it."""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import Cell, TakeOff
from cellctl.errors import PlanError
from cellctl.validating.access import Gripper


class ArmAccess:
    """As ``Gripper``, and the links of an arm that stands where it stands in this cell: a wrist
    beside the gripper must not meet a higher part some cells away.

    Args:
        gripper: what comes straight down.
        planner: the arm's routes.
    """

    def __init__(self, gripper: Gripper, planner: RoutePlanner) -> None:
        self._gripper = gripper
        self._planner = planner
        self._hindering: dict[Cell, frozenset[Cell]] = {}

    def blockers(self, cell: Cell, standing: AbstractSet[Cell]) -> tuple[Cell, ...]:
        """The parts that bar the way to a cell, sorted."""
        if found := self._gripper.blockers(cell, standing):
            return found
        if cell not in self._hindering:
            self._hindering[cell] = self._hindering_of(cell)
        return tuple(sorted(self._hindering[cell] & standing))

    def frees(self, cell: Cell, way: TakeOff, standing: AbstractSet[Cell]) -> bool:
        """Whether the arm can take a part off that way; ``standing`` includes it."""
        try:
            self._planner.take_off(cell, way, standing)
        except PlanError:
            return False
        return True

    def _hindering_of(self, cell: Cell) -> frozenset[Cell]:
        try:
            return self._planner.hindering(cell)
        except PlanError:
            # Out of reach, whatever stands: the routes say so.
            return frozenset()
