"""Where every part of the emulated cell is, and what people do with parts."""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from collections import Counter

from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.sim.plant import Floats
from cellctl.sim.world_belt import BeltRow
from cellctl.sim.world_values import Imperfections, PartTruth, Where


class Parts(ABC):
    """Keeps each part in exactly one place.

    Args:
        config: the cell.
        seed: where all chance comes from.
        imperfections: how far the belt and its parts are from perfect.
    """

    def __init__(self, config: CellConfig, seed: int, imperfections: Imperfections) -> None:
        self.config = config
        self.imperfections = imperfections
        self._pitch_m = config.voxel.pitch_m
        self._stock = list(range(config.limits.inventory_parts))
        self._row = BeltRow(self._pitch_m, random.Random(seed))  # noqa: S311 - repeatable chance
        self._held: int | None = None
        self._placed: dict[Cell, int] = {}
        self._fallen: list[int] = []
        self._handed_over: list[int] = []
        self._everything = frozenset(self._stock)
        self._bond: tuple[int, Floats] | None = None
        """The part that sticks to the held one, and the TCP where that was picked."""
        self._gripped: tuple[Cell, Floats] | None = None
        """The placed part in the closed latch that has not come off yet, and the TCP then, on its
        seat."""
        self.parts_stick = False
        """Parts that are let go at a cell stick to the gripper."""
        self.raised_m: dict[Cell, float] = {}
        """How much higher than its cell a placed part stands, as over a crumb: the arm feels it."""

    # ---- hands: what a person does in the cell ----

    def refill_belt(self, parts: int | None = None) -> int:
        """Lay parts on the belt: from the stock, then those that visitors bring back.

        Args:
            parts: how many; None fills the belt.

        Returns:
            How many places were filled.
        """
        room = self.config.feeder.capacity_parts - len(self._row)
        count = room if parts is None else min(parts, room)
        source = self._stock + self._handed_over
        laid, kept = source[:count], source[count:]
        left_out = self._row.lay(laid, self.imperfections)
        self._stock = [part for part in kept if part not in self._handed_over] + left_out
        self._handed_over = [part for part in self._handed_over if part in kept]
        self._settle()
        return len(laid) - len(left_out)

    def empty_belt(self) -> None:
        """Take every part off the belt, into the stock."""
        self._stock += self._row.empty()
        self._bond = None
        self._settle()

    def hand_over(self) -> int:
        """Give what stands in the workspace to the visitor; returns the number of parts."""
        parts = list(self._placed.values())
        self._gripped = None
        self._handed_over += parts
        self._placed.clear()
        self._settle()
        return len(parts)

    def clear_workspace(self) -> int:
        """Take what stands or lies in the workspace to the stock; returns the number of parts."""
        parts = [*self._placed.values(), *self._fallen]
        self._stock += parts
        self._gripped = None
        self._placed.clear()
        self._fallen.clear()
        self.raised_m.clear()
        self._settle()
        return len(parts)

    # ---- mishaps on demand ----

    def turn_next_part(self, yaw_rad: float) -> None:
        """Turn the first part on the belt about the vertical."""
        if self._row.parts:
            self._row.parts[0].yaw_rad = yaw_rad

    def straighten_parts(self) -> None:
        """Turn every part on the belt square to it, and part those that stick together."""
        for item in self._row.parts:
            item.yaw_rad = 0.0
            item.sticky = False
        self._bond = None

    def stick_next_part(self) -> None:
        """Make the first part on the belt stick to the one behind it."""
        if self._row.parts:
            self._row.parts[0].sticky = True

    def free_parts(self) -> None:
        """Parts no longer stick to the gripper, and none that sticks is held any more."""
        self.parts_stick = False
        self._gripped = None

    def remove_next_part(self) -> None:
        """Take the first part off the belt, into the stock; its place stays empty."""
        if self._row.parts:
            part = self._row.parts[0].part
            self._row.take(part)
            self._stock.append(part)
            self._settle()

    def drop_held_part(self) -> None:
        """Let the part slip out of the closed gripper."""
        if self._held is not None:
            self._fallen.append(self._held)
            self._held = self._bond = None
            self._settle()

    def take_placed_part(self, cell: Cell) -> None:
        """A visitor takes a part off the structure along; what cannot hold without it falls.

        Raises:
            ValueError: there is no part at that cell.
        """
        if cell not in self._placed:
            raise ValueError(f"no part stands at {tuple(cell)}")
        if self._gripped is not None and self._gripped[0] == cell:
            self._gripped = None
        self._handed_over.append(self._placed.pop(cell))
        self._drop_what_cannot_hold(None)
        self._settle()

    def put_part(self, cell: Cell) -> None:
        """Somebody puts a part from the stock at a cell.

        Raises:
            ValueError: there is one already, or none in the stock.
        """
        if cell in self._placed or not self._stock:
            raise ValueError(f"no part can be put at {tuple(cell)}")
        self._placed[cell] = self._stock.pop()
        self._settle()

    def raise_part(self, cell: Cell, height_m: float) -> None:
        """A placed part comes to stand higher than its cell; 0 puts it right.

        Raises:
            ValueError: there is no part at that cell.
        """
        if cell not in self._placed:
            raise ValueError(f"no part stands at {tuple(cell)}")
        self.raised_m[cell] = height_m

    # ---- truth ----

    @property
    def built(self) -> frozenset[Cell]:
        """The cells that hold a part."""
        return frozenset(self._placed)

    def parts(self) -> tuple[PartTruth, ...]:
        """Every part and where it is, by part number."""
        at_stop = self._row.at_stop()
        truths = [PartTruth(part=part, where=Where.STOCK) for part in self._stock]
        for item in self._row.parts:
            where = Where.PICK_STATION if item is at_stop else Where.BELT
            belt_m = round(-item.position_m, 6)
            truths.append(PartTruth(part=item.part, where=where, belt_m=belt_m))
        if self._held is not None:
            truths.append(PartTruth(part=self._held, where=Where.GRIPPER))
        for cell, part in self._placed.items():
            truths.append(PartTruth(part=part, where=Where.PLACED, cell=cell))
        truths += [PartTruth(part=part, where=Where.FALLEN) for part in self._fallen]
        truths += [PartTruth(part=part, where=Where.HANDED_OVER) for part in self._handed_over]
        return tuple(sorted(truths, key=lambda truth: truth.part))

    def counts(self) -> dict[Where, int]:
        """How many parts are at each kind of place; the sum never changes."""
        found = Counter(truth.where for truth in self.parts())
        return {where: found[where] for where in Where}

    # ---- inside ----

    @abstractmethod
    def _drop_what_cannot_hold(self, newest: Cell | None) -> None:
        """Let fall what does not stay."""

    def _settle(self) -> None:
        """The law of conservation: every part is in exactly one place, none comes or goes."""
        places = [
            *self._stock,
            *(item.part for item in self._row.parts),
            *([] if self._held is None else [self._held]),
            *self._placed.values(),
            *self._fallen,
            *self._handed_over,
        ]
        assert len(places) == len(self._everything), "a part came, went or is in two places"
        assert set(places) == self._everything, "a part was swapped for another"
