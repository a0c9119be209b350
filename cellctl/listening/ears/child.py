"""The ears' process: ``python -m cellctl.listening.ears.child FD SETTINGS``.

FD is one end of a socket pair, SETTINGS the ``[hearing]`` table as JSON. The process ends when the
other end closes, whatever PortAudio is doing.
"""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import socket
import sys
import threading
import time

from cellctl.config import HearingSection
from cellctl.errors import HearingError
from cellctl.listening.ears.detectors import MicroWakeWordDetector, SileroDetector
from cellctl.listening.ears.events import (
    LINE_LIMIT_BYTES,
    Alive,
    Condition,
    EarsEvent,
    Expect,
    Listen,
    Mute,
    Order,
    ToEars,
    encode,
)
from cellctl.listening.ears.pipeline import Pipeline
from cellctl.listening.ears.supervision import Supervisor

ALIVE_EVERY_S = 0.25
"""How often the daemon hears that the loop goes round (wall time)."""
_SEND_TIMEOUT_S = 5.0
"""A daemon that takes nothing for so long is dead or hangs, and this process with it."""
_ORDERS_LIMIT = 100


def make_pipeline(settings: HearingSection) -> Pipeline:
    """The pipeline that the settings ask for.

    Raises:
        HearingError: a detector is not installed.
    """
    waits = settings.activation == "wake_word"
    return Pipeline(
        SileroDetector(),
        MicroWakeWordDetector(settings.wake_word) if waits else None,
        open_to_all=settings.activation == "open",
    )


class _Line:
    """This process's end of the socket pair."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self.orders: queue.Queue[Order] = queue.Queue(_ORDERS_LIMIT)

    def send(self, message: EarsEvent | Alive) -> None:
        try:
            self._connection.sendall(encode(message))
        except OSError:  # the daemon is gone, or hangs
            os._exit(0)

    def read(self) -> None:
        """Thread: take orders; end the process when the daemon has gone."""
        rest = b""
        while True:
            try:
                data = self._connection.recv(65_536)
            except TimeoutError:
                continue
            except OSError:
                data = b""
            if not data or len(rest) > LINE_LIMIT_BYTES:
                # At once, whatever the other threads wait for.
                os._exit(0)
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                with contextlib.suppress(queue.Full):
                    self.orders.put_nowait(ToEars.validate_json(line))


def main() -> None:
    """Run until the other end closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    descriptor, settings_json = sys.argv[1:3]
    connection = socket.socket(fileno=int(descriptor))
    connection.settimeout(_SEND_TIMEOUT_S)
    line = _Line(connection)
    threading.Thread(target=line.read, name="orders", daemon=True).start()
    line.send(Condition(state="starting", sentence="The ears are starting."))
    settings = HearingSection.model_validate_json(settings_json)
    try:
        pipeline = make_pipeline(settings)
    except HearingError as error:
        # Nothing helps but an installation: say so for as long as the daemon runs.
        line.send(Condition(state="lost", sentence=str(error)))
        while True:
            line.send(Alive())
            threading.Event().wait(ALIVE_EVERY_S)
    supervisor = Supervisor(settings.microphone, pipeline, line.send)
    alive_s = 0.0
    while True:
        while not line.orders.empty():
            _obey(line.orders.get_nowait(), supervisor, pipeline)
        supervisor.step()
        if time.monotonic() - alive_s > ALIVE_EVERY_S:
            alive_s = time.monotonic()
            line.send(Alive())


def _obey(order: Order, supervisor: Supervisor, pipeline: Pipeline) -> None:
    match order:
        case Expect():
            pipeline.expecting = order.what
        case Listen():
            pipeline.listen()
        case Mute():
            supervisor.mute(order.muted)


if __name__ == "__main__":
    main()
