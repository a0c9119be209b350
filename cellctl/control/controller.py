"""One inbox, one consumer: every input is an event, and nothing else touches the machine.

A word, a sensor, a timer, a stage's result, a person's command: each becomes an ``Item`` in the
inbox. The consumer feeds its event to the machine and then starts or cancels the stage that
belongs to the state it landed in. A stage is one task; results of a stage that was cancelled carry
an old number and are dropped.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

import structlog

from cellctl.control.states import FAULTS, CellMachine, Decision, Event, top_of
from cellctl.errors import CellctlError, CellFault, RefusedError, Severity
from cellctl.messages import FaultData, StatusData

log = structlog.get_logger(__name__)

INBOX_LIMIT = 1_000
"""Events that may wait; faults and stops are taken all the same."""
_STAGE_END_PATIENCE_S = 5.0
_LATER_LIMIT = 20
_AT_ONCE = frozenset({"brake", "hold"})
"""Stages that do not wait for the cancelled one to end, for they are what ends it; what they have
to report waits for it instead."""

STAGES: dict[str, str] = {
    "starting": "start",
    "listening_waiting": "hear",
    "listening_hearing": "hear",
    "listening_interpreting": "interpret",
    "generating": "generate",
    "validating_discretising": "plan",
    "validating_checking": "plan",
    "validating_sequencing": "plan",
    "validating_confirming": "confirm",
    "feeding_indexing": "feed",
    "feeding_presenting": "feed",
    "feeding_refilling": "refill",
    "assembling_picking": "pick",
    "assembling_placing": "place",
    "assembling_verifying": "verify",
    "assembling_retreating": "retreat",
    "disassembling_gripping": "grip",
    "disassembling_parting": "part",
    "disassembling_returning": "return",
    "disassembling_verifying": "put_back",
    "paused_braking": "brake",
    "paused_moving": "hand",
    "fault_held": "hold",
    "fault_stopped": "hold",
    "fault_emergency": "hold",
    "fault_recovering": "recover",
}
"""Which stage runs in which state; none in ``idle`` and ``paused_resting``."""

_FAULT_EVENTS = {
    Severity.HELD: Event.FAULT_HELD,
    Severity.STOPPED: Event.FAULT_STOPPED,
    Severity.EMERGENCY: Event.FAULT_EMERGENCY,
}


class Post(Protocol):
    """How a stage reports; ``then`` runs in the consumer, only if the event is accepted."""

    def __call__(self, event: Event, then: Callable[[], None] | None = None) -> None: ...


class Stages(Protocol):
    """What the cell does in its states, behind the machine."""

    async def run_stage(self, name: str, post: Post) -> None:
        """The work of one stage; cancelled when the machine leaves its states.

        Raises:
            CellFault: the cell must stop.
            CellctlError: the request cannot be carried out; the cell is idle again.
        """
        ...

    def request_ended(self, error: CellctlError) -> None:
        """The request that was under way ended with this error."""
        ...

    def changed(self, event: Event, before: str, after: str) -> None:
        """An event was accepted."""
        ...


@dataclass
class Item:
    """One event in the inbox."""

    event: Event
    stage: int | None = None
    """Number of the stage that sent it; None for people and monitors."""
    then: Callable[[], None] | None = None
    unless: Callable[[], str] | None = None
    fault: CellFault | None = None
    reply: asyncio.Future[Decision] | None = None


@dataclass
class Latched:
    """The first cause of the present fault."""

    fault: CellFault
    during: str
    later: list[str] = field(default_factory=list)

    def view(self) -> FaultData:
        """As the bus shows it."""
        return FaultData(
            entry=self.fault.entry,
            detail=self.fault.detail,
            during=self.during,
            later=tuple(self.later),
        )


class Controller:
    """Feeds the machine and runs the stages.

    Args:
        stages: the work of each state.
        publish: sends a status message; gets the data and the state.
    """

    def __init__(self, stages: Stages, publish: Callable[[StatusData, str], None]) -> None:
        self._stages = stages
        self._publish = publish
        self._machine = CellMachine()
        self._inbox: asyncio.Queue[Item | asyncio.Future[None]] = asyncio.Queue()
        self._stage_number = 0
        self._stage_name: str | None = None
        self._stage_task: asyncio.Task[None] | None = None
        self._stage_before: asyncio.Task[None] | None = None
        self.latched: Latched | None = None

    @property
    def state(self) -> str:
        """Leaf of the machine."""
        return self._machine.state

    @property
    def inbox_size(self) -> int:
        """Events that wait."""
        return self._inbox.qsize()

    async def stage_before_ended(self) -> None:
        """Wait until the stage that was cancelled for this one has ended, for a limited time."""
        if self._stage_before is not None:
            await asyncio.wait({self._stage_before}, timeout=_STAGE_END_PATIENCE_S)

    def post(self, event: Event, then: Callable[[], None] | None = None) -> None:
        """Put an event into the inbox, from a monitor or a service."""
        self._put(Item(event, then=then))

    def post_fault(self, fault: CellFault) -> None:
        """Report a fault that was noticed outside a stage."""
        self._put(Item(_FAULT_EVENTS[fault.entry.severity], fault=fault))

    async def command(
        self,
        event: Event,
        then: Callable[[], None] | None = None,
        *,
        unless: Callable[[], str] | None = None,
        timeout_s: float = 5.0,
    ) -> Decision:
        """Put a person's command into the inbox and wait for what the machine decides.

        Args:
            then: runs in the consumer when the event is accepted.
            unless: asked by the consumer at the moment of the decision; a reason refuses it.
            timeout_s: wall time.

        Raises:
            RefusedError: the present state does not allow it, or the cell is too busy to answer.
        """
        reply: asyncio.Future[Decision] = asyncio.get_running_loop().create_future()
        self._put(Item(event, then=then, unless=unless, reply=reply))
        try:
            async with asyncio.timeout(timeout_s):
                decision = await reply
        except TimeoutError:
            if reply.cancelled():
                raise RefusedError("The cell is too busy to answer.", "Try again.") from None
            decision = reply.result()  # it came at the last moment
        if decision.verdict == "refused":
            raise RefusedError(decision.reason)
        return decision

    async def probe(self) -> None:
        """Return when the consumer has taken everything that waits in the inbox now."""
        taken: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._inbox.put_nowait(taken)
        await taken

    async def run(self) -> None:
        """Consume the inbox until cancelled."""
        self._enter(self.state)
        try:
            while True:
                item = await self._inbox.get()
                if isinstance(item, Item):
                    self._consume(item)
                elif not item.done():
                    item.set_result(None)
        finally:
            await self._end_stage()

    def _put(self, item: Item) -> None:
        urgent = item.event in FAULTS or item.event is Event.STOP
        if self._inbox.qsize() < INBOX_LIMIT or urgent:
            self._inbox.put_nowait(item)
            return
        log.error("inbox full, event dropped", event_name=item.event)
        if item.reply is not None:
            item.reply.set_result(Decision("refused", self.state, "The cell is too busy."))

    def _consume(self, item: Item) -> None:
        if item.stage is not None and item.stage != self._stage_number:
            return
        given_up = item.reply is not None and item.reply.cancelled()
        if given_up and item.event not in {Event.STOP, Event.PAUSE}:
            # Whoever gave it was told that it is not done: a yes must not act after that.
            log.warning("late event dropped", event_name=item.event)
            return
        before = self.state
        reason = item.unless() if item.unless is not None else ""
        decision = Decision("refused", before, reason) if reason else self._machine.feed(item.event)
        if item.reply is not None and not item.reply.done():
            item.reply.set_result(decision)
        if item.fault is not None:
            self._latch(item.fault, before)
        if decision.verdict != "accepted":
            log.debug("event not accepted", event_name=item.event, state=before)
            return
        if item.event is Event.RECOVERED:
            self.latched = None
            self._publish(FaultData(), self.state)
        try:
            if item.then is not None:
                item.then()
            self._enter(decision.state)
            if item.event in FAULTS and self.latched is not None:
                self._publish(self.latched.view(), self.state)
            self._stages.changed(item.event, before, decision.state)
        except Exception as error:
            # The consumer must outlive every defect: without it nothing could be stopped.
            log.exception("event failed", event_name=item.event, before=before)
            if item.event not in FAULTS:
                self.post_fault(CellFault("internal", f"{type(error).__name__}: {error}"))

    def _latch(self, fault: CellFault, during: str) -> None:
        if self.latched is None:
            self.latched = Latched(fault, during)
            log.error("fault", code=fault.code, detail=fault.detail, during=during)
        elif fault.code != self.latched.fault.code:
            self.latched.later = [*self.latched.later, str(fault)][-_LATER_LIMIT:]
            log.warning("further fault", code=fault.code, detail=fault.detail, during=during)

    def _enter(self, state: str) -> None:
        name = STAGES.get(state)
        if name == self._stage_name:
            return
        self._stage_name = name
        self._stage_number += 1
        previous = self._stage_before = self._stage_task
        if previous is not None:
            previous.cancel()
        if name is not None:
            self._stage_task = asyncio.create_task(
                self._run_stage(name, self._stage_number, previous), name=f"stage {name}"
            )

    async def _run_stage(self, name: str, number: int, previous: asyncio.Task[None] | None) -> None:
        posted: list[Item] = []
        at_once = name in _AT_ONCE

        def post(event: Event, then: Callable[[], None] | None = None) -> None:
            item = Item(event, stage=number, then=then)
            posted.append(item) if at_once else self._put(item)

        fault: CellFault | None = None
        try:
            if previous is not None and not at_once:
                await asyncio.wait({previous}, timeout=_STAGE_END_PATIENCE_S)
            await self._stages.run_stage(name, post)
            if previous is not None and at_once:
                await asyncio.wait({previous}, timeout=_STAGE_END_PATIENCE_S)
            for item in posted:
                self._put(item)
        except CellFault as error:
            fault = error
        except CellctlError as error:
            if top_of(self.state) in {"listening", "generating", "validating"}:
                log.info("request ended", reason=str(error))
                post(Event.REJECTED, partial(self._stages.request_ended, error))
                return
            log.exception("stage failed", stage=name)
            fault = CellFault("internal", str(error))
        except Exception as error:
            log.exception("stage failed", stage=name)
            fault = CellFault("internal", f"{type(error).__name__}: {error}")
        if fault is not None:
            self._put(Item(_FAULT_EVENTS[fault.entry.severity], stage=number, fault=fault))

    async def _end_stage(self) -> None:
        task, self._stage_task = self._stage_task, None
        if task is not None:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task
