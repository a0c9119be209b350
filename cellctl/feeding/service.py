"""The belt as a service: it brings parts on request, also while the arm is busy elsewhere, and
makes room for those that come back.

A request outlives the state that made it: whoever wants the part waits for it, and may stop waiting
without stopping the belt. Retries happen here and are no fault; which of jam and empty a fault is,
the inventory decides, for the board can only tell that nothing came.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from enum import StrEnum
from typing import Final

import structlog

from cellctl.errors import CellFault
from cellctl.feeding.belt import Belt, BeltIdentity, BeltState
from cellctl.messages import BoardData, ConveyorData

log = structlog.get_logger(__name__)

_LOOK_EVERY_S: Final = 2.0
"""How often an idle board is asked (wall time)."""
_RECONNECT_EVERY_S: Final = 0.1
"""How often a lost one is looked for while a part is waited for (wall time)."""
_RECONNECTIONS: Final = 3
"""How often it may get lost while it brings one part."""


class BeltActivity(StrEnum):
    """What the service is doing."""

    IDLE = "idle"
    INDEXING = "indexing"
    """The belt brings a part."""
    PRESENTING = "presenting"
    """The belt has stopped; the sensor is asked whether the part lies there."""
    MAKING_ROOM = "making_room"
    """The belt goes backward, so that a part can be laid at the pick station."""
    READY = "ready"
    """A part lay at the pick station when last looked at."""
    FAULT = "fault"
    """The last request ended in a fault; the next one, or ``recover``, tries anew."""


class BeltService:
    """Brings parts to the pick station. Belongs to one event loop; ``close`` ends it.

    Args:
        belt: the conveyor.
        retries: how often bringing one part is tried again before it is a fault.
        parts_on_belt: how many parts the inventory counts there: tells an empty belt from a jammed
            one.
        on_change: called in the event loop with the new view whenever it changes.
        reconnect_timeout_s: how long a board that is lost while it should bring a part is looked
            for (wall time).
    """

    def __init__(
        self,
        belt: Belt,
        retries: int,
        parts_on_belt: Callable[[], int],
        on_change: Callable[[ConveyorData], None],
        *,
        reconnect_timeout_s: float = 0.0,
    ) -> None:
        self._belt = belt
        self._retries = retries
        self._parts_on_belt = parts_on_belt
        self._on_change = on_change
        self._reconnect_timeout_s = reconnect_timeout_s
        self._bringing: asyncio.Task[None] | None = None
        """The newest request; done when the part lies there or could not be brought."""
        self._for_room = False
        """The newest request is for room, not for a part."""
        self._near = asyncio.Event()
        """The newest request has gone past indexing."""
        self._has_room = False
        """A part can be laid at the pick station: room was made, and none has come since."""
        self._board: BoardData | None = None
        self._view = ConveyorData(connected=False, activity=BeltActivity.IDLE)

    @property
    def ready(self) -> bool:
        """Whether the part that was requested lies at the pick station."""
        return self._view.activity == BeltActivity.READY

    def view(self) -> ConveyorData:
        """As the bus shows it; never asks the board."""
        return self._view

    async def connect(self) -> BeltIdentity:
        """Connect to the board and look at the pick station.

        Raises:
            CellFault: ``belt_lost`` or ``belt_mismatch``.
        """
        try:
            identity = await self._belt.connect()
        except CellFault as fault:
            self._show_fault(fault)
            raise
        self._board = BoardData(
            port=identity.port,
            serial_number=identity.serial_number,
            protocol_version=identity.protocol_version,
            firmware_version=identity.firmware_version,
        )
        self._show(BeltActivity.IDLE)
        await self.state()
        return identity

    async def state(self) -> BeltState:
        """Ask the board.

        Raises:
            CellFault: ``belt_lost`` or ``belt_mismatch``.
        """
        try:
            state = await self._belt.state()
        except CellFault as fault:
            self._show_fault(fault)
            raise
        taken = self.ready and not state.part_present
        activity = BeltActivity.IDLE if taken else self._view.activity
        self._show(activity, part_present=state.part_present)
        return state

    def request_part(self) -> None:
        """Begin to bring the next part; returns at once.

        Does nothing while an earlier request is under way. A part that lies at the pick station
        fulfils a request, so ask for the next one only when the last has left it.
        """
        under_way = self._bringing is not None and not self._bringing.done()
        if not under_way or self._for_room:
            before = self._bringing if under_way else None
            self._has_room = self._for_room = False
            self._near.clear()
            self._show(BeltActivity.INDEXING)
            self._bringing = asyncio.create_task(self._bring(before), name="belt: bring a part")
            self._bringing.add_done_callback(_retrieve)

    async def part_ready(self, near: Callable[[], None] = lambda: None) -> None:
        """Wait until the part that was requested lies at the pick station.

        Cancelling this wait does not stop the belt.

        Args:
            near: called once, when the part has arrived and is being checked.

        Raises:
            CellFault: the belt could not bring it.
            CancelledError: also when ``halt`` ended the request.
        """
        assert self._bringing is not None, "wait for a part only after requesting one"
        bringing = self._bringing
        nearing = asyncio.create_task(self._near.wait(), name="belt: part near")
        try:
            await asyncio.wait({bringing, nearing}, return_when=asyncio.FIRST_COMPLETED)
            if self._near.is_set():
                near()
        finally:
            nearing.cancel()
            with suppress(asyncio.CancelledError):
                await nearing
        await asyncio.shield(bringing)

    def request_room(self) -> None:
        """Begin to make room for a part at the pick station; returns at once.

        Does nothing while that is under way. A part that was requested is no longer brought.
        """
        under_way = self._bringing is not None and not self._bringing.done()
        if not under_way or not self._for_room:
            before = self._bringing if under_way else None
            self._for_room = True
            self._bringing = asyncio.create_task(self._make_room(before), name="belt: make room")
            self._bringing.add_done_callback(_retrieve)

    async def room_ready(self) -> None:
        """Wait until there is the room that was requested.

        Cancelling this wait does not stop the belt.

        Raises:
            CellFault: ``belt_jam``, ``belt_lost`` or ``belt_mismatch``.
            CancelledError: also when ``halt`` ended the request.
        """
        assert self._bringing is not None, "wait for room only after requesting it"
        assert self._for_room, "wait for room only after requesting it"
        await asyncio.shield(self._bringing)

    async def _make_room(self, before: asyncio.Task[None] | None) -> None:
        await _ended(before)
        if self._has_room and not (await self.state()).part_present:
            return
        self._has_room = False
        self._show(BeltActivity.MAKING_ROOM)
        await self._insist(self._belt.make_room)
        self._has_room = True
        self._show(BeltActivity.IDLE, part_present=False)

    def room_was_used(self) -> None:
        """A part was laid at the pick station: the next one needs room of its own."""
        self._has_room = False
        self._show(BeltActivity.READY, part_present=True)

    async def halt(self) -> None:
        """Drop the request under way and stop the belt.

        Never raises for a board that does not answer: one that hears nothing stops by itself.
        """
        await self._drop_request()
        try:
            await self._belt.halt()
        except CellFault as fault:
            log.warning("the belt cannot be told to halt", reason=str(fault))
            self._show_fault(fault)

    async def recover(self) -> None:
        """Leave a fault: connect anew, drop what was requested, look at the pick station.

        Raises:
            CellFault: ``belt_lost`` or ``belt_mismatch``: its cause is still there.
        """
        await self._drop_request()
        await self.connect()

    async def watch(self, begun: Callable[[], bool]) -> None:
        """Look after the board while nothing is asked of it, until cancelled: a board that is lost
        is shown, and found again by itself. It is no fault before somebody needs it.

        Args:
            begun: whether the board was connected in earnest.
        """
        while True:
            await asyncio.sleep(_LOOK_EVERY_S)
            if not begun() or (self._bringing is not None and not self._bringing.done()):
                continue
            lost = not self._view.connected
            with suppress(CellFault):
                await (self.connect() if lost else self.state())
                if lost:
                    log.info("the conveyor's board is back")

    async def close(self) -> None:
        """End the request under way and let go of the port; safe to repeat."""
        await self._drop_request()
        await self._belt.close()
        self._show(BeltActivity.IDLE, connected=False)

    async def _bring(self, before: asyncio.Task[None] | None) -> None:
        await _ended(before)
        await self._insist(self._bring_once)
        self._show(BeltActivity.READY, part_present=True)

    async def _insist(self, work: Callable[[], Awaitable[None]]) -> None:
        """Have the belt do something, trying again where that may help.

        Raises:
            CellFault: it did not.
        """
        retries, reconnections = self._retries, _RECONNECTIONS
        while True:
            try:
                await work()
            except CellFault as raised:
                fault = self._judged(raised)
            except asyncio.CancelledError:
                self._show(BeltActivity.IDLE)
                raise
            else:
                return
            if fault.code in {"belt_empty", "belt_mismatch"}:
                break
            if fault.code == "belt_lost" and reconnections > 0 and await self._found_again():
                reconnections -= 1
            elif retries > 0 and fault.code != "belt_lost":
                retries -= 1
            else:
                break
            log.warning("the belt failed, trying again", reason=str(fault))
        self._show_fault(fault)
        raise fault

    async def _found_again(self) -> bool:
        """Whether a board that was lost answers again within the time for it."""
        deadline_s = time.monotonic() + self._reconnect_timeout_s
        while True:
            try:
                await self._belt.connect()
            except CellFault as fault:
                if fault.code != "belt_lost" or time.monotonic() >= deadline_s:
                    return False
                await asyncio.sleep(_RECONNECT_EVERY_S)
            else:
                return True

    async def _bring_once(self) -> None:
        await self._belt.present()
        self._show(BeltActivity.PRESENTING)
        self._near.set()
        state = await self._belt.state()
        if not state.part_present:
            raise CellFault("belt_empty", "The part that came is gone again.")

    def _judged(self, fault: CellFault) -> CellFault:
        """Nothing came: with parts on the belt, by the inventory, that is a jam."""
        on_belt = self._parts_on_belt()
        if fault.code != "belt_empty" or on_belt == 0:
            return fault
        return CellFault("belt_jam", f"{fault.detail} There should be {on_belt} on the belt.")

    async def _drop_request(self) -> None:
        if self._bringing is not None and not self._bringing.done():
            self._bringing.cancel()
            await asyncio.wait({self._bringing})

    def _show_fault(self, fault: CellFault) -> None:
        connected = fault.code not in {"belt_lost", "belt_mismatch"}
        self._show(BeltActivity.FAULT, connected=connected, part_present=False)

    def _show(
        self, activity: str, *, connected: bool = True, part_present: bool | None = None
    ) -> None:
        view = ConveyorData(
            connected=connected,
            activity=activity,
            part_present=self._view.part_present if part_present is None else part_present,
            board=self._board,
        )
        if view != self._view:
            self._view = view
            self._on_change(view)


async def _ended(request: asyncio.Task[None] | None) -> None:
    """Drop a request that another has replaced."""
    if request is not None:
        request.cancel()
        await asyncio.wait({request})


def _retrieve(bringing: asyncio.Task[None]) -> None:
    """A fault that nobody waits for is shown, and no defect."""
    if not bringing.cancelled():
        bringing.exception()
