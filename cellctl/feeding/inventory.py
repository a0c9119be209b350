"""Where the parts are, as a fold over what was done with them.

``Counts`` is a value and ``Counts.after`` a pure function. The law: no move makes a part or loses
one, the sum over all places is constant; only ``Counts.owning`` changes it, for parts that are
bought or sold.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
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
    HANDED_OVER = "handed_over"
    """In an object that somebody took along."""
    SCRAP = "scrap"
    """Written off."""
    UNKNOWN = "unknown"
    """Somewhere; an operator has to look."""


class Move(StrEnum):
    """What brings one part from one place to another."""

    LAY = "lay"
    """A person lays a part on the belt."""
    PICK = "pick"
    MISS = "miss"
    """The part that counted as picked is still at the pick station."""
    PLACE = "place"
    TAKE_OFF = "take_off"
    """The arm takes a part off the structure."""
    PUT_BACK = "put_back"
    """The arm lays a part back on the belt."""
    TAKE_APART = "take_apart"
    """A person takes a part off the structure."""
    TAKE_OUT = "take_out"
    """A person takes the part out of the gripper."""
    HAND_OVER = "hand_over"
    """A part leaves in an object that somebody takes along."""
    RETURN = "return"
    """A part of an object that was taken along comes back."""
    LOSE_GRIPPED = "lose_gripped"
    """The gripper should hold a part and does not."""
    LOSE_PLACED = "lose_placed"
    """A part that should stand does not."""
    FIND = "find"
    """A person finds a part that was unknown."""
    SCRAP = "scrap"
    """A person writes off a part that was unknown."""
    SCRAP_GRIPPED = "scrap_gripped"
    """The part in the gripper is written off."""

    @property
    def source(self) -> Place:
        """Where the part is before."""
        return _WAYS[self][0]

    @property
    def target(self) -> Place:
        """Where the part is after."""
        return _WAYS[self][1]


_WAYS: dict[Move, tuple[Place, Place]] = {
    Move.LAY: (Place.STOCK, Place.BELT),
    Move.PICK: (Place.BELT, Place.GRIPPER),
    Move.MISS: (Place.GRIPPER, Place.BELT),
    Move.PLACE: (Place.GRIPPER, Place.STRUCTURE),
    Move.TAKE_OFF: (Place.STRUCTURE, Place.GRIPPER),
    Move.PUT_BACK: (Place.GRIPPER, Place.BELT),
    Move.TAKE_APART: (Place.STRUCTURE, Place.STOCK),
    Move.TAKE_OUT: (Place.GRIPPER, Place.STOCK),
    Move.HAND_OVER: (Place.STRUCTURE, Place.HANDED_OVER),
    Move.RETURN: (Place.HANDED_OVER, Place.STOCK),
    Move.LOSE_GRIPPED: (Place.GRIPPER, Place.UNKNOWN),
    Move.LOSE_PLACED: (Place.STRUCTURE, Place.UNKNOWN),
    Move.FIND: (Place.UNKNOWN, Place.STOCK),
    Move.SCRAP: (Place.UNKNOWN, Place.SCRAP),
    Move.SCRAP_GRIPPED: (Place.GRIPPER, Place.SCRAP),
}


class InventoryError(CellctlError):
    """A move that the counts rule out: what was believed of the parts is wrong."""


Count = Annotated[int, Field(ge=0)]


class Counts(Value):
    """How many parts are in each place."""

    stock: Count = 0
    belt: Count = 0
    gripper: Annotated[int, Field(ge=0, le=1)] = 0
    structure: Count = 0
    handed_over: Count = 0
    scrap: Count = 0
    unknown: Count = 0

    @property
    def total(self) -> int:
        """The sum over all places, which no move changes."""
        return sum(getattr(self, place) for place in Place)

    def after(self, move: Move) -> Counts:
        """The counts after a move.

        Raises:
            InventoryError: there is no part where it begins, or no room where it ends.
        """
        if getattr(self, move.source) == 0:
            raise InventoryError(
                f"{move.value}: the inventory counts no part in {move.source}.",
                "Count the parts and tell it with `cellctl inventory set`.",
            )
        if move.target is Place.GRIPPER and self.gripper == 1:
            raise InventoryError(
                f"{move.value}: the inventory counts a part in the gripper already.",
                "Count the parts and tell it with `cellctl inventory set`.",
            )
        counts = self.model_copy(
            update={
                move.source: getattr(self, move.source) - 1,
                move.target: getattr(self, move.target) + 1,
            }
        )
        assert counts.total == self.total, f"{move} changed the number of parts"
        return counts

    def after_all(self, moves: Iterable[Move]) -> Counts:
        """The counts after a history of moves.

        Raises:
            InventoryError: as for ``after``.
        """
        return reduce(Counts.after, moves, self)

    @property
    def available(self) -> int:
        """Parts that an object may have: on the belt, in the gripper, and in the stock, from where
        a person lays them on the belt."""
        return self.stock + self.belt + self.gripper

    def counted(self, **parts: int) -> Counts:
        """The counts after a person has counted some places; what is missing then is unknown.

        Args:
            parts: how many parts there are, by place; places that are not named stay.

        Raises:
            InventoryError: there would be more parts than before.
        """
        known = {place: parts.get(place, getattr(self, place)) for place in Place}
        known[Place.UNKNOWN] = 0
        unknown = self.total - sum(known.values())
        if unknown < 0:
            raise InventoryError(
                f"That is {-unknown} more than the {self.total} parts that there are in all.",
                "Count again; if parts were added, tell how many there are in all: "
                "`cellctl inventory own NUMBER`.",
            )
        return Counts.model_validate({**known, Place.UNKNOWN: unknown})

    def owning(self, total: int) -> Counts:
        """The counts after parts were bought or sold, which come to the stock or go from it.

        Raises:
            InventoryError: the stock has too few to sell.
        """
        stock = self.stock + total - self.total
        if stock < 0:
            raise InventoryError(
                f"{self.total - total} parts cannot go: the stock has {self.stock}.",
                "Take parts off the belt and count them first.",
            )
        return self.model_copy(update={"stock": stock})

    @classmethod
    def at_first(cls, parts: int, capacity: int) -> Self:
        """What a new cell begins with: the belt full, the rest in the stock."""
        on_belt = min(parts, capacity)
        return cls(belt=on_belt, stock=parts - on_belt)
