"""Where the parts are, as a fold over what was done with them.

``Counts`` is a value and ``Counts.after`` a pure function; ``Inventory`` keeps the newest counts.
The law: no act makes a part or loses one, the sum over all places is constant.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum, StrEnum
from functools import reduce
from typing import Annotated, Self

from pydantic import Field

from cellctl.assembly import Value
from cellctl.errors import CellctlError


class Place(StrEnum):
    """Where a part can be; the names of the counts."""

    STOCK = "stock"
    """Beside the cell, out of its reach."""
    BELT = "belt"
    """On the belt, the one at the pick station included."""
    GRIPPER = "gripper"
    STRUCTURE = "structure"
    SCRAP = "scrap"
    """Written off."""
    UNKNOWN = "unknown"
    """Somewhere; an operator has to look."""


class Act(Enum):
    """What moves one part from one place to another."""

    LAY = (Place.STOCK, Place.BELT)
    """A person lays a part on the belt."""
    PICK = (Place.BELT, Place.GRIPPER)
    MISS = (Place.GRIPPER, Place.BELT)
    """The part that counted as picked is still at the pick station, or was put back there."""
    PLACE = (Place.GRIPPER, Place.STRUCTURE)
    TAKE_APART = (Place.STRUCTURE, Place.BELT)
    """A person takes a part off the structure and lays it on the belt."""
    LOSE = (Place.GRIPPER, Place.UNKNOWN)
    """The gripper should hold a part and does not."""
    FIND = (Place.UNKNOWN, Place.BELT)
    """A person finds a part and lays it on the belt."""
    SCRAP = (Place.UNKNOWN, Place.SCRAP)

    @property
    def source(self) -> Place:
        """Where the part is before."""
        return self.value[0]

    @property
    def target(self) -> Place:
        """Where the part is after."""
        return self.value[1]


class InventoryError(CellctlError):
    """An act that the counts rule out: what was believed of the parts is wrong."""


Count = Annotated[int, Field(ge=0)]


class Counts(Value):
    """How many parts are in each place."""

    stock: Count = 0
    belt: Count = 0
    gripper: Annotated[int, Field(ge=0, le=1)] = 0
    structure: Count = 0
    scrap: Count = 0
    unknown: Count = 0

    @property
    def total(self) -> int:
        """The sum over all places, which no act changes."""
        return sum(getattr(self, place) for place in Place)

    def after(self, act: Act) -> Counts:
        """The counts after an act.

        Raises:
            InventoryError: there is no part where it begins, or no room where it ends.
        """
        if getattr(self, act.source) == 0:
            raise InventoryError(
                f"{act.name.lower()}: the inventory counts no part in {act.source}.",
                "Count the parts by hand and start anew.",
            )
        if act.target is Place.GRIPPER and self.gripper == 1:
            raise InventoryError(
                f"{act.name.lower()}: the inventory counts a part in the gripper already.",
                "Count the parts by hand and start anew.",
            )
        counts = self.model_copy(
            update={
                act.source: getattr(self, act.source) - 1,
                act.target: getattr(self, act.target) + 1,
            }
        )
        assert counts.total == self.total, f"{act} changed the number of parts"
        return counts

    def after_all(self, acts: Iterable[Act]) -> Counts:
        """The counts after a history of acts.

        Raises:
            InventoryError: as for ``after``.
        """
        return reduce(Counts.after, acts, self)


class Inventory:
    """The newest counts of a running cell.

    Args:
        counts: what the fold begins with.
    """

    def __init__(self, counts: Counts) -> None:
        self.counts = counts

    @classmethod
    def full(cls, parts: int) -> Self:
        """All parts on the belt, as after an operator has filled it."""
        return cls(Counts(belt=parts))

    @property
    def available(self) -> int:
        """Parts that can be placed without a person's help: on the belt and in the gripper."""
        return self.counts.belt + self.counts.gripper

    def apply(self, act: Act) -> None:
        """Take note of an act.

        Raises:
            InventoryError: as for ``Counts.after``; the counts stay.
        """
        self.counts = self.counts.after(act)
