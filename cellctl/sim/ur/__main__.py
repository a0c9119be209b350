"""``python -m cellctl.sim.ur``: an emulated controller alone, with nothing around the arm.

It prints a line of JSON when its ports are open. Then it reads commands, one a line, and answers
each with a line of JSON:

    truth
    inject FAULT [name=value ...]
    clear FAULT [name=value ...]
    input LINE 0|1
    quit

It ends at ``quit``, at the end of its input, and on SIGTERM or SIGINT.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import signal
import sys
from dataclasses import fields
from typing import get_args, get_type_hints

import numpy as np

from cellctl.errors import CellctlError, ExitStatus, UsageError
from cellctl.sim.plant import Floats
from cellctl.sim.ur.controller import UrController
from cellctl.sim.ur.options import UrOptions

_TICK_S = 0.002
_LONGEST_TICK_S = 0.02
"""After a stall of this process time goes on by no more than this."""


class EmptyPlant:
    """A cell with nothing in it; its input lines are set by hand."""

    def __init__(self) -> None:
        self.levels = 0
        self.outputs = 0
        self.moved_s = 0.0

    def robot_moved(self, flange: Floats, joints_rad: Floats, dt_s: float) -> None:  # noqa: ARG002
        self.moved_s += dt_s

    def commanded(self, speed_m_s: float, acceleration_m_s2: float) -> None:
        pass  # nothing is placed here

    def tcp_force_n(self) -> Floats:
        return np.zeros(3)

    def outputs_changed(self, bits: int) -> None:
        self.outputs = bits

    def inputs(self) -> int:
        return self.levels


def _parse(arguments: list[str]) -> UrOptions:
    parser = argparse.ArgumentParser(
        prog="python -m cellctl.sim.ur",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    hints = get_type_hints(UrOptions)
    for field in fields(UrOptions):
        kind = hints[field.name]
        flag = "--" + field.name.replace("_", "-")
        if kind in (str, float, int):
            parser.add_argument(flag, type=kind, default=field.default)
        elif kind is bool:
            parser.add_argument(flag, action=argparse.BooleanOptionalAction, default=field.default)
        elif choices := [choice for choice in get_args(kind) if isinstance(choice, str)]:
            parser.add_argument(flag, choices=choices, default=field.default)
        elif field.name.endswith(("_rad", "_rad_s")):
            parser.add_argument(flag, type=_six, default=field.default)
    return UrOptions(**vars(parser.parse_args(arguments)))


def _six(text: str) -> tuple[float, ...]:
    return tuple(float(value) for value in text.split(","))


def _obey(controller: UrController, plant: EmptyPlant, line: str) -> dict[str, object]:
    """Carry out one command.

    Raises:
        UsageError: it is not understood.
    """
    command, *words = line.split() or [""]
    if command == "truth":
        return {**controller.truth(), "outputs_at_plant": plant.outputs, "moved_s": plant.moved_s}
    if command in ("inject", "clear") and words:
        pairs = (word.partition("=") for word in words[1:])
        arguments = {name: _value(value) for name, _, value in pairs}
        act = controller.inject if command == "inject" else controller.clear
        act(words[0], **arguments)
        return {"done": line}
    if command == "input" and len(words) == 2 and words[0].isdigit():
        bit = 1 << int(words[0])
        plant.levels = plant.levels | bit if words[1] == "1" else plant.levels & ~bit
        return {"done": line}
    raise UsageError(
        f"{line!r} is not understood.", "Known: truth, inject, clear, input LINE 0|1, quit."
    )


def _value(text: str) -> object:
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


def _say(message: dict[str, object]) -> None:
    sys.stdout.write(json.dumps(message) + "\n")
    sys.stdout.flush()


async def _read_commands(controller: UrController, plant: EmptyPlant) -> None:
    reader = asyncio.StreamReader()
    loop = asyncio.get_running_loop()
    transport, _ = await loop.connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), sys.stdin
    )
    try:
        while line := (await reader.readline()).decode().strip():
            if line == "quit":
                return
            try:
                _say(_obey(controller, plant, line))
            except CellctlError as error:
                _say({"error": str(error)})
    finally:
        transport.close()


class _Drive:
    """Calls the controller every tick of the wall clock, until it is stopped or fails.

    A timer of the loop, not a task that sleeps: at 500 Hz that saves a third of an idle emulator's
    processor time.
    """

    def __init__(self, controller: UrController) -> None:
        self._controller = controller
        self._loop = asyncio.get_running_loop()
        self._last_s = self._due_s = self._loop.time()
        self._timer: asyncio.Handle = self._loop.call_soon(self._tick)
        self.failed: asyncio.Future[None] = self._loop.create_future()

    def stop(self) -> None:
        self._timer.cancel()

    def _tick(self) -> None:
        now_s = self._loop.time()
        elapsed_s = min(now_s - self._last_s, _LONGEST_TICK_S)
        self._last_s = now_s
        try:
            self._controller.advance(elapsed_s * self._controller.options.clock_rate)
        except Exception as error:  # noqa: BLE001 - raised by whoever waits for it
            self.failed.set_exception(error)
            return
        self._due_s = max(self._due_s + _TICK_S, now_s)
        self._timer = self._loop.call_at(self._due_s, self._tick)


async def _run(options: UrOptions) -> None:
    plant = EmptyPlant()
    controller = UrController(options, plant)
    await controller.start()
    drive = _Drive(controller)
    commands = asyncio.create_task(_read_commands(controller, plant))
    loop = asyncio.get_running_loop()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, commands.cancel)
    _say({"ready": options.host})
    try:
        await asyncio.wait([commands, drive.failed], return_when=asyncio.FIRST_COMPLETED)
    finally:
        drive.stop()
        commands.cancel()
        await asyncio.wait([commands])
        await controller.stop()
    for outcome in (commands, drive.failed):
        if outcome.done() and not outcome.cancelled():
            outcome.result()


def main() -> int:
    """Run an emulated controller until it is told to quit; returns the exit status."""
    try:
        asyncio.run(_run(_parse(sys.argv[1:])))
    except CellctlError as error:
        sys.stderr.write(f"{error}\n")
        return error.exit_status
    except OSError as error:
        sys.stderr.write(f"{error.strerror}.\n")
        return ExitStatus.USAGE
    return ExitStatus.DONE


if __name__ == "__main__":
    sys.exit(main())
