"""The ears' process: ``python -m cellctl.listening.ears.child FD SETTINGS``.

FD is one end of a socket pair, SETTINGS the ``[hearing]`` table as JSON. The process ends when the
other end closes, whatever PortAudio is doing.
"""

from __future__ import annotations

import contextlib
import queue
import time

from cellctl.config import HearingSection
from cellctl.errors import HearingError
from cellctl.listening.ears.detectors import MicroWakeWordDetector, SileroDetector
from cellctl.listening.ears.events import (
    Condition,
    Expect,
    Listen,
    Mute,
    Order,
    OwnVoiceBegan,
    OwnVoiceEnded,
    ToEars,
)
from cellctl.listening.ears.pipeline import Pipeline
from cellctl.listening.ears.supervision import Supervisor
from cellctl.sound.line import ALIVE_EVERY_S, Alive, ChildLine, arguments

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


def main() -> None:
    """Run until the other end closes."""
    descriptor, settings_json = arguments()
    orders: queue.Queue[Order] = queue.Queue(_ORDERS_LIMIT)

    def take(line: bytes) -> None:
        with contextlib.suppress(queue.Full):
            orders.put_nowait(ToEars.validate_json(line))

    line = ChildLine(descriptor, take)
    line.send(Condition(state="starting", sentence="The ears are starting."))
    settings = HearingSection.model_validate_json(settings_json)
    try:
        pipeline = make_pipeline(settings)
    except HearingError as error:
        line.send(Condition(state="lost", sentence=str(error)))
        line.stay_lost()
    supervisor = Supervisor(settings.microphone, pipeline, line.send)
    alive_s = 0.0
    while True:
        while not orders.empty():
            _obey(orders.get_nowait(), supervisor, pipeline)
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
        case OwnVoiceBegan():
            supervisor.own_voice_began(order)
        case OwnVoiceEnded():
            supervisor.own_voice_ended(order.at_s)


if __name__ == "__main__":
    main()
