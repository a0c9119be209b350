"""The control socket of the emulated cell: one JSON request, one JSON reply."""

from __future__ import annotations

import os
from collections.abc import Callable

import zmq
import zmq.asyncio
from pydantic import ValidationError

from cellctl.assembly import Value
from cellctl.endpoints import listened_on
from cellctl.errors import CellctlError, UsageError
from cellctl.sim.cell import EmulatedCell
from cellctl.sim.messages import (
    REQUEST,
    AskTruth,
    Clear,
    ClearWorkspace,
    HandOver,
    Inject,
    Moved,
    Ping,
    Pong,
    Refill,
    Reply,
    Request,
    SetImperfections,
    Shutdown,
)
from cellctl.sim.pace import SimClock


class InjectionServer:
    """Answers requests about one emulated cell until it is cancelled.

    Args:
        shut_down: called when a client asks to end the emulated cell.
    """

    def __init__(self, cell: EmulatedCell, clock: SimClock, shut_down: Callable[[], None]) -> None:
        self._cell = cell
        self._clock = clock
        self._shut_down = shut_down
        self._context = zmq.asyncio.Context()
        self._socket = self._context.socket(zmq.REP)

    def bind(self, endpoint: str) -> None:
        """Open the control socket.

        Raises:
            UsageError: the end point is taken or malformed.
        """
        hint = "Is another emulated cell running? Stop it, or choose another end point."
        if listened_on(endpoint):
            raise UsageError(f"emulation.control = {endpoint!r}: is in use.", hint)
        try:
            self._socket.bind(endpoint)
        except zmq.ZMQError as error:
            raise UsageError(
                f"emulation.control = {endpoint!r}: {error.strerror}.", hint
            ) from error

    async def serve(self) -> None:
        """Answer requests, one after the other."""
        while True:
            raw = await self._socket.recv()
            await self._socket.send(self.answer(raw).model_dump_json().encode())

    def close(self) -> None:
        """Close the socket; a last reply still goes out."""
        self._context.destroy(linger=200)

    def answer(self, raw: bytes) -> Reply:
        """The reply to one request; whatever is wrong with it becomes an error reply."""
        try:
            result = self._do(REQUEST.validate_json(raw))
        except ValidationError as error:
            problems = (
                f"{'.'.join(str(part) for part in item['loc']) or 'request'}: {item['msg']}"
                for item in error.errors(include_url=False)
            )
            return Reply(ok=False, error=f"No valid request: {'; '.join(problems)}.")
        except CellctlError as error:
            return Reply(ok=False, error=error.message, hint=error.hint)
        except (TypeError, ValueError) as error:
            # An emulator that refuses the value of an argument.
            return Reply(ok=False, error=f"Refused: {error}.")
        return Reply(ok=True, result=result.model_dump(mode="json") if result else {})

    def _do(self, request: Request) -> Value | None:
        cell, world = self._cell, self._cell.world
        match request:
            case Ping():
                config = cell.config.cell
                return Pong(pid=os.getpid(), cell=config.name, speed=self._clock.rate)
            case AskTruth():
                return cell.truth(self._clock.lost_s)
            case Inject(fault=fault, arguments=arguments):
                cell.inject(fault, arguments)
            case Clear(fault=fault, arguments=arguments):
                cell.clear(fault, arguments)
            case Refill(parts=parts):
                return Moved(parts=world.refill_belt(parts))
            case HandOver():
                return Moved(parts=world.hand_over())
            case ClearWorkspace():
                return Moved(parts=world.clear_workspace())
            case SetImperfections(imperfections=imperfections, relay=relay):
                world.imperfections = imperfections
                if relay:
                    world.empty_belt()
                    world.refill_belt()
            case Shutdown():
                self._shut_down()
        return None
