"""The client of the emulated cell's control socket: injects faults, reads the world's truth."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import zmq

from cellctl.assembly import Value
from cellctl.errors import CellctlError, UsageError
from cellctl.sim.messages import (
    Argument,
    AskTruth,
    CellTruth,
    Clear,
    ClearWorkspace,
    HandOver,
    Inject,
    Moved,
    Ping,
    Pong,
    Refill,
    Reply,
    SetImperfections,
    Shutdown,
)
from cellctl.sim.world_values import Imperfections


class NoEmulatedCellError(CellctlError):
    """Nothing answers on the emulated cell's control socket."""


class SimClient:
    """Talks to one emulated cell. Synchronous; belongs to one thread; close it when done.

    Every method raises ``NoEmulatedCellError`` when nothing answers in time, and ``UsageError``
    when the emulated cell refuses.

    Args:
        endpoint: ``emulation.control`` of the configuration.
        timeout_s: how long to wait for each reply (wall time).
    """

    def __init__(self, endpoint: str, timeout_s: float = 5.0) -> None:
        self.endpoint = endpoint
        self.timeout_s = timeout_s
        self._context = zmq.Context()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the socket."""
        self._context.destroy(linger=0)

    def ping(self) -> Pong:
        """Who answers."""
        return Pong.model_validate(self._ask(Ping(), self.timeout_s))

    def wait_ready(self, timeout_s: float) -> Pong:
        """Wait until the emulated cell has started."""
        return Pong.model_validate(self._ask(Ping(), timeout_s))

    def truth(self) -> CellTruth:
        """All that is the case in the emulated cell."""
        return CellTruth.model_validate(self._ask(AskTruth(), self.timeout_s))

    def inject(self, fault: str, **arguments: Argument) -> None:
        """Make a fault of ``cellctl.sim.faults.FAULTS`` happen."""
        self._ask(Inject(fault=fault, arguments=arguments), self.timeout_s)

    def clear(self, fault: str, **arguments: Argument) -> None:
        """Mend what a fault broke."""
        self._ask(Clear(fault=fault, arguments=arguments), self.timeout_s)

    def refill(self, parts: int | None = None) -> int:
        """Lay parts on the belt, None fills it; returns how many there were."""
        return Moved.model_validate(self._ask(Refill(parts=parts), self.timeout_s)).parts

    def hand_over(self) -> int:
        """Give the visitor what stands in the workspace; returns the number of parts."""
        return Moved.model_validate(self._ask(HandOver(), self.timeout_s)).parts

    def clear_workspace(self) -> int:
        """Take what stands or lies in the workspace to the stock; returns the number of parts."""
        return Moved.model_validate(self._ask(ClearWorkspace(), self.timeout_s)).parts

    def set_imperfections(self, imperfections: Imperfections, *, relay: bool = False) -> None:
        """Make the belt and its parts less perfect; ``relay`` lays the belt's parts anew."""
        self._ask(SetImperfections(imperfections=imperfections, relay=relay), self.timeout_s)

    def shutdown(self) -> None:
        """End the emulated cell; returns when it has agreed."""
        self._ask(Shutdown(), self.timeout_s)

    def _ask(self, request: Value, timeout_s: float) -> dict[str, object]:
        # A socket for each request: a REQ socket whose reply is overdue can ask nothing more.
        with self._context.socket(zmq.REQ) as socket:
            socket.setsockopt(zmq.LINGER, 0)
            socket.connect(self.endpoint)
            socket.send(request.model_dump_json().encode())
            if not socket.poll(int(timeout_s * 1000)):
                raise NoEmulatedCellError(
                    f"No emulated cell answered at {self.endpoint} within {timeout_s:g} s.",
                    "Start one: cellctl sim --config FILE.",
                )
            reply = Reply.model_validate_json(socket.recv())
        if not reply.ok:
            raise UsageError(reply.error, reply.hint)
        return reply.result
