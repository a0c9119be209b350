"""What people say of parts: laid on the belt, taken along, missing, counted. Nothing moves."""

from __future__ import annotations

import structlog

from cellctl.control.acts import ActKind
from cellctl.control.cell import Cell
from cellctl.control.job import Grip
from cellctl.control.states import Event
from cellctl.errors import RefusedError, UsageError
from cellctl.feeding.inventory import Move
from cellctl.messages import (
    CalibratedCommand,
    CountCommand,
    MissingCommand,
    OwnCommand,
    RecoverCommand,
    RefillCommand,
)

log = structlog.get_logger(__name__)


class Books:
    """Writes down what people say.

    Args:
        cell: the cell whose parts they are.
    """

    def __init__(self, cell: Cell) -> None:
        self._cell = cell

    async def take(
        self,
        said: RefillCommand
        | RecoverCommand
        | MissingCommand
        | CountCommand
        | OwnCommand
        | CalibratedCommand,
    ) -> str:
        """Take note of what an operator says.

        Returns:
            What is believed now, for people.

        Raises:
            RefusedError: not in this state.
            UsageError, InventoryError: it cannot be so.
            CellFault: ``journal_failed``.
        """
        match said:
            case RefillCommand():
                return await self._refill(said.parts)
            case RecoverCommand():
                return await self._recover(said)
            case MissingCommand():
                return await self._missing(said)
            case CountCommand():
                return await self._count(said)
            case OwnCommand():
                return await self._own(said)
            case CalibratedCommand():
                await self._cell.controller.command(Event.BOOK)
                await self._cell.record(ActKind.CALIBRATED, detail=f"{said.what}: {said.note}")
                return "Written down."

    async def empty_workspace(self, *, handed_over: bool) -> str:
        """What stood was taken along by somebody, or taken apart into the stock.

        Raises:
            RefusedError: a job is under way, or nothing stands.
            CellFault: ``journal_failed``.
        """
        cell = self._cell
        await cell.controller.command(Event.BOOK, unless=self._why_not_empty)
        count = len(cell.builder.standing)
        if handed_over and not count:
            raise RefusedError("Nothing stands in the workspace.")
        kind = ActKind.HAND_OVER if handed_over else ActKind.CLEAR
        move = Move.HAND_OVER if handed_over else Move.TAKE_APART
        await cell.record(kind, moves=(move,) * count)
        if handed_over:
            return f"{_parts(count)} handed over. Enjoy it, and bring them back one day."
        return f"The workspace counts as empty; {_parts(count)} back in the stock. {self._belt()}"

    def _why_not_empty(self) -> str:
        if self._cell.active_job is not None:
            return "A job is under way: cancel it first."
        return ""

    def _why_not_missing(self) -> str:
        if self._cell.builder.grip is Grip.RELEASING:
            return "A part is just being let go: say resume, or cancel, before another is missing."
        return ""

    async def _refill(self, parts: int | None) -> str:
        config, counts = self._cell.config, self._cell.builder.ledger.counts
        room = max(0, config.feeder.capacity_parts - counts.belt)
        count = min(room, counts.stock) if parts is None else parts
        if count > counts.stock:
            raise UsageError(
                f"The stock has {_parts(counts.stock)}.",
                "If parts came back or were found, count them: `cellctl inventory set stock=N`.",
            )
        if count > room:
            raise UsageError(f"The belt has room for {_parts(room)}.")
        if count == 0:
            raise UsageError(
                "No part can be laid on the belt: "
                + ("the stock is empty." if room else "the belt is full.")
            )
        await self._cell.record(ActKind.REFILL, moves=(Move.LAY,) * count)
        await self._cell.controller.command(Event.REFILL)
        return f"{_parts(count)} laid on the belt. {self._belt()}"

    async def _recover(self, said: RecoverCommand) -> str:
        state = self._cell.controller.state
        if state != "paused_resting":
            raise RefusedError(
                "Only a paused cell can be told where the part is.", "Pause it, or reset its fault."
            )
        try:
            await self._cell.recover_part(said.part)
        except KeyError:
            raise RefusedError("That was settled already.") from None
        return self._cell.last_state.sentence

    async def _missing(self, said: MissingCommand) -> str:
        cell = self._cell
        standing = cell.builder.standing
        for place in said.cells:
            if place not in standing:
                raise UsageError(f"No part is known to stand at {_at(place)}.")
        gone = set(said.cells)
        for place in standing - gone:
            below = place._replace(z=place.z - 1)
            if below in gone and not _beside(place, standing - gone):
                raise UsageError(
                    f"The part at {_at(place)} cannot stand without the one at {_at(below)}.",
                    "Take it out too, and name both.",
                )
        await cell.controller.command(Event.BOOK, unless=self._why_not_missing)
        for place in said.cells:
            cell.builder.part_is_missing(place)
            await cell.record(ActKind.MISSING, at=place, moves=(Move.LOSE_PLACED,))
        return f"{_parts(len(gone))} missing, and unknown now; a build that goes on fills the gap."

    async def _count(self, said: CountCommand) -> str:
        counted = said.model_dump(exclude={"command", "note"}, exclude_none=True)
        if not counted:
            raise UsageError("Say what was counted, for example belt=12 stock=28.")
        counts = self._cell.builder.ledger.counts.counted(**counted)
        await self._cell.controller.command(Event.BOOK)
        await self._cell.record(ActKind.COUNT, counts=counts, detail=said.note)
        return self._places()

    async def _own(self, said: OwnCommand) -> str:
        counts = self._cell.builder.ledger.counts.owning(said.parts)
        await self._cell.controller.command(Event.BOOK)
        await self._cell.record(ActKind.OWN, counts=counts, detail=said.note)
        return self._places()

    def _belt(self) -> str:
        counts = self._cell.builder.ledger.counts
        return f"On the belt: {counts.belt}, in the stock: {counts.stock}."

    def _places(self) -> str:
        counts = self._cell.builder.ledger.counts
        filled = {k: v for k, v in counts.model_dump().items() if v}
        return ", ".join(f"{place.replace('_', ' ')} {count}" for place, count in filled.items())


def _beside(cell: tuple[int, int, int], standing: frozenset[tuple[int, int, int]]) -> bool:
    x, y, z = cell
    return any(
        near in standing for near in ((x + 1, y, z), (x - 1, y, z), (x, y + 1, z), (x, y - 1, z))
    )


def _at(cell: tuple[int, int, int]) -> str:
    return f"[{cell[0]}, {cell[1]}, {cell[2]}]"


def _parts(count: int) -> str:
    return "1 part" if count == 1 else f"{count} parts"
