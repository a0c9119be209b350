"""A serial port in the event loop: frames in and out, through pyserial, without blocking.

Reads and writes never wait. Opening may (a USB adapter answers control transfers), so it happens in
a thread and is bounded.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
import select
import termios
from collections import deque
from collections.abc import Callable
from typing import Final

import serial
import structlog

from cellctl.boards.constants import REPLY_LIMIT
from cellctl.boards.line import (
    BANNER_START,
    REPLY_START,
    Banner,
    LineError,
    LineSplitter,
    Reply,
    decode_reply,
)
from cellctl.errors import CellctlError

log = structlog.get_logger(__name__)

OPEN_TIMEOUT_S: Final = 5.0
"""For the operating system to open a port (wall time)."""
_READ_BYTES: Final = 4096
_QUEUE_LIMIT: Final = 100
"""Frames kept for a reader; more are old news, and the oldest are dropped."""


class LinkLostError(CellctlError):
    """The port cannot be opened, or has gone."""


class SerialLink:
    """One open port. Made by ``open``; belongs to the event loop that opened it.

    Args:
        device: an open port with ``timeout=0`` and ``write_timeout=0``.
        on_banner: called when a board tells that it has started, before the banner is received.
    """

    def __init__(self, device: serial.Serial, on_banner: Callable[[Banner], None]) -> None:
        self._device = device
        self._on_banner = on_banner
        self._loop = asyncio.get_running_loop()
        self._splitter = LineSplitter((REPLY_START, BANNER_START), REPLY_LIMIT)
        self._received: deque[Reply | Banner] = deque(maxlen=_QUEUE_LIMIT)
        self._arrived = asyncio.Event()
        self._lost: LinkLostError | None = None
        self._writable = select.poll()
        self._writable.register(device.fileno(), select.POLLOUT)
        self._loop.add_reader(device.fileno(), self._read)

    @classmethod
    async def open(
        cls, port: str, baud: int, on_banner: Callable[[Banner], None] = lambda _: None
    ) -> SerialLink:
        """Open a port for this process alone.

        Raises:
            LinkLostError: it does not exist, is no serial port, is in use, or does not open in
                ``OPEN_TIMEOUT_S``.
        """
        opening = asyncio.get_running_loop().run_in_executor(None, _open_device, port, baud)
        try:
            async with asyncio.timeout(OPEN_TIMEOUT_S):
                return cls(await asyncio.shield(opening), on_banner)
        except TimeoutError:
            opening.add_done_callback(_close_late)
            raise LinkLostError(f"{port} does not open within {OPEN_TIMEOUT_S:g} s.") from None
        except asyncio.CancelledError:
            opening.add_done_callback(_close_late)
            raise
        except OSError as error:
            # pyserial's own words repeat the port and the number of the error.
            plain = error.errno in {errno.ENOENT, errno.EACCES}
            reason = os.strerror(error.errno) if plain and error.errno else str(error)
            raise LinkLostError(f"{port} cannot be opened: {reason}.") from error
        except termios.error as error:
            raise LinkLostError(f"{port} cannot be opened: {error}.") from error

    def send(self, frame: bytes) -> None:
        """Write a frame. One that does not fit the output buffer is lost, as on a real wire.

        Raises:
            LinkLostError: the port has gone.
        """
        if self._lost is not None:
            raise self._lost
        # pyserial's own non-blocking write spins for ever on a full buffer: look first.
        if not any(event & select.POLLOUT for _, event in self._writable.poll(0)):
            return
        try:
            self._device.write(frame)
        except OSError as error:
            raise self._lose(error) from error

    async def receive(self) -> Reply | Banner:
        """The next valid frame; damaged ones are dropped. Waits until there is one.

        Raises:
            LinkLostError: the port has gone.
        """
        while not self._received:
            if self._lost is not None:
                raise self._lost
            self._arrived.clear()
            await self._arrived.wait()
        return self._received.popleft()

    def close(self) -> None:
        """Let go of the port; safe to repeat."""
        if not self._device.is_open:
            return
        self._loop.remove_reader(self._device.fileno())
        # With output pending, closing a port waits for it to drain.
        with contextlib.suppress(OSError, termios.error):
            self._device.reset_output_buffer()
        self._device.close()
        self._lose(None)

    def _read(self) -> None:
        try:
            data = self._device.read(_READ_BYTES)
        except OSError as error:
            self._loop.remove_reader(self._device.fileno())
            self._lose(error)
            return
        for frame in self._splitter.feed(data):
            try:
                message = decode_reply(frame)
            except LineError as error:
                log.debug("damaged line dropped", port=self._device.port, reason=str(error))
                continue
            if isinstance(message, Banner):
                self._on_banner(message)
            self._received.append(message)
        if self._received:
            self._arrived.set()

    def _lose(self, error: OSError | None) -> LinkLostError:
        if self._lost is None:
            reason = f"has gone: {error}" if error is not None else "is closed"
            self._lost = LinkLostError(f"{self._device.port} {reason}.")
            self._arrived.set()
        return self._lost


def _open_device(port: str, baud: int) -> serial.Serial:
    return serial.Serial(port, baud, timeout=0, write_timeout=0, exclusive=True)


def _close_late(opening: asyncio.Future[serial.Serial]) -> None:
    """Nobody waits for this port any more."""
    if not opening.cancelled() and opening.exception() is None:
        opening.result().close()
