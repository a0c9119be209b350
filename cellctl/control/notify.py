"""What the service manager is told: ready, what the cell does, still alive, about to end.

The protocol is systemd's (sd_notify(3)): datagrams of ``NAME=VALUE`` lines to the socket that
``$NOTIFY_SOCKET`` names. The send never blocks: a service manager that does not listen must not
hold the robot's daemon up.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass

import structlog

log = structlog.get_logger(__name__)

_TICK_S = 0.25
"""Longest time between looks at the cell's state (wall time)."""
_START_EXTENSION_S = 30.0
_STOP_EXTENSION_S = 60.0
"""More than all devices together may take to close (wall time)."""


class NotifySocket:
    """The sending end of the service manager's socket; without one, nothing is sent.

    Args:
        address: a path, or a name that begins with ``@`` (abstract); empty for none.
    """

    def __init__(self, address: str) -> None:
        self._address = f"\0{address[1:]}" if address.startswith("@") else address

    def send(self, *lines: str) -> bool:
        """Send ``NAME=VALUE`` lines in one datagram; False when they cannot be taken now."""
        if not self._address:
            return True
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sender:
            sender.setblocking(False)
            try:
                sender.sendto("\n".join(lines).encode(), self._address)
            except OSError as error:
                log.debug("service manager not told", reason=str(error))
                return False
        return True


@dataclass(frozen=True)
class ServiceManager:
    """Where the service manager listens, and how often it wants to hear of us."""

    socket: NotifySocket
    watchdog_s: float | None = None
    """It restarts the service after this long without a ping (wall time); None: it does not."""

    @classmethod
    def from_environment(cls, variables: MutableMapping[str, str] | None = None) -> ServiceManager:
        """Take its variables out of the environment, so that no child process speaks for us."""
        variables = os.environ if variables is None else variables
        address = variables.pop("NOTIFY_SOCKET", "")
        watchdog_us = variables.pop("WATCHDOG_USEC", "")
        meant = variables.pop("WATCHDOG_PID", str(os.getpid())) == str(os.getpid())
        watched = address and meant and watchdog_us.isdigit() and int(watchdog_us) > 0
        return cls(NotifySocket(address), int(watchdog_us) / 1e6 if watched else None)


@dataclass(frozen=True)
class Condition:
    """What the service manager is told about the cell."""

    up: bool
    """Started, or in a fault that it can tell of."""
    sentence: str


class ServiceReport:
    """Tells the service manager how the cell is, for as long as the cell answers.

    Every message waits for ``probe`` first: the service manager hears of us only as long as the
    controller's consumer takes events from its inbox. There is no timer thread that could go on
    telling when nothing else does.

    Args:
        manager: who is told.
        probe: returns when an event has gone through the controller's inbox.
        condition: how the cell is now.
    """

    def __init__(
        self,
        manager: ServiceManager,
        probe: Callable[[], Awaitable[None]],
        condition: Callable[[], Condition],
    ) -> None:
        self._manager = manager
        self._probe = probe
        self._condition = condition
        self._ready = False
        self._sentence = ""

    async def run(self) -> None:
        """Tell until cancelled; three pings or more in each period that the watchdog allows."""
        loop = asyncio.get_running_loop()
        watchdog_s = self._manager.watchdog_s
        tick_s = min(_TICK_S, watchdog_s / 8) if watchdog_s is not None else _TICK_S
        pinged_s = -float("inf")
        while True:
            await self._answered()
            now, lines = self._condition(), []
            if now.sentence != self._sentence:
                lines.append(f"STATUS={' '.join(now.sentence.split())}")
            if not self._ready:
                # Whatever the start waits for has a time-out of its own.
                extension = f"EXTEND_TIMEOUT_USEC={_START_EXTENSION_S * 1e6:.0f}"
                lines.append("READY=1" if now.up else extension)
            if watchdog_s is not None and loop.time() - pinged_s >= watchdog_s / 4:
                lines.append("WATCHDOG=1")
            if lines and self._manager.socket.send(*lines):
                self._ready, self._sentence = self._ready or now.up, now.sentence
                if lines[-1] == "WATCHDOG=1":
                    pinged_s = loop.time()
            await asyncio.sleep(tick_s)

    def stopping(self) -> None:
        """Tell that the daemon ends, and that letting go of the devices may take its time."""
        self._manager.socket.send(
            "STOPPING=1",
            "STATUS=The daemon ends.",
            f"EXTEND_TIMEOUT_USEC={_STOP_EXTENSION_S * 1e6:.0f}",
            # The consumer ends first, and with it the pings.
            f"WATCHDOG_USEC={_STOP_EXTENSION_S * 1e6:.0f}",
        )

    async def _answered(self) -> None:
        """Wait for the probe; the watchdog is the limit, so here a long wait is told only."""
        probe = asyncio.ensure_future(self._probe())
        try:
            while not probe.done():
                await asyncio.wait({probe}, timeout=self._manager.watchdog_s or _START_EXTENSION_S)
                if not probe.done():
                    log.error("the controller does not answer", last_told=self._sentence)
            probe.result()
        finally:
            probe.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await probe
