"""How deep the stack gets, measured in the simulated chip, beside what the image allows at most."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cellctl.boards.constants import BoardRole, Register
from cellctl.boards.line import CommandLine, Reply, decode_reply, encode_command
from cellctl.sim.avr.programs import program
from cellctl.sim.avr.simulator import Simulator
from tests.firmware.image import Image
from tests.firmware.noise import LETTERS, fuzz

PINS = {
    BoardRole.GRIPPER: {"PA1": "L", "PA7": "H"},
    BoardRole.CONVEYOR: {"PA4": "H", "PA5": "L"},
}
MEMORY_LIMITS = {BoardRole.GRIPPER: 200, BoardRole.CONVEYOR: 1_024 - 128}
LINE_S = 0.01


@pytest.fixture(params=list(PINS))
def board(request: pytest.FixtureRequest) -> Iterator[tuple[BoardRole, Simulator]]:
    """A board that has done everything that it can do, and was shouted at."""
    role = BoardRole(request.param)
    simulator = Simulator(role)
    simulator.start()
    try:
        exercise(role, simulator)
        yield role, simulator
    finally:
        simulator.stop()


def exercise(role: BoardRole, simulator: Simulator) -> None:
    """Every command while something moves and while nothing does, and noise at line rate."""
    pins = PINS[role]
    simulator.advance(0.1, pins)
    simulator.advance(LINE_S, pins, encode_command(CommandLine(0, "I")))
    sequence = 0
    for level in ("H", "L"):
        pins = {**pins, "PA1": level} if role is BoardRole.GRIPPER else pins
        for argument in (None, 0, 7, 1000):
            for letter in LETTERS.replace("I", "") + "K":
                sequence = (sequence + 1) % 256
                line = encode_command(CommandLine(sequence, letter, argument))
                simulator.advance(LINE_S, pins, line)
    noise = fuzz(7, 5_000)
    simulator.advance(len(noise) * 10 / 115_200 + 0.1, pins, noise)


def test_the_stack_never_gets_deeper_than_the_image_says(
    board: tuple[BoardRole, Simulator],
) -> None:
    role, simulator = board
    image = Image(program(role))
    memory = simulator.memory()
    assert memory.static == image.static_memory
    assert memory.stack <= image.deepest_stack()
    assert memory.stack >= image.deepest_stack() / 2, "hardly anything was tried"
    assert memory.static + memory.stack <= MEMORY_LIMITS[role]
    if role is BoardRole.GRIPPER:
        assert told_by(simulator) == memory.size - memory.static - memory.stack


def told_by(simulator: Simulator) -> int:
    """The memory that the stack has never used, by the program itself."""
    simulator.advance(LINE_S, {}, encode_command(CommandLine(0, "I")))
    asked = encode_command(CommandLine(1, "R", Register.STACK_LEFT))
    heard = simulator.advance(2 * LINE_S, {}, asked).serial
    reply = decode_reply(heard[heard.index(b"<01") :])
    assert isinstance(reply, Reply)
    assert reply.status is not None
    return reply.status.value
