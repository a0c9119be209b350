"""The mouth's process: ``python -m cellctl.speaking.child FD SETTINGS``.

FD is one end of a socket pair, SETTINGS a ``MouthSettings`` as JSON.
"""

from __future__ import annotations

import time

from cellctl.sound.line import ALIVE_EVERY_S, Alive, ChildLine, arguments
from cellctl.speaking.delivery import Delivery
from cellctl.speaking.events import Condition, MouthEvent, MouthSettings, ToMouth


def main() -> None:
    """Run until the other end closes."""
    descriptor, settings_json = arguments()
    settings = MouthSettings.model_validate_json(settings_json)

    def tell(event: MouthEvent) -> None:
        line.send(event)

    delivery = Delivery(settings, tell)
    line = ChildLine(descriptor, lambda data: delivery.take(ToMouth.validate_json(data)))
    line.send(Condition(state="starting", sentence="The voice is starting."))
    alive_s = 0.0
    while True:
        delivery.step()
        if time.monotonic() - alive_s > ALIVE_EVERY_S:
            alive_s = time.monotonic()
            line.send(Alive())


if __name__ == "__main__":
    main()
