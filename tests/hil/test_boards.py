"""Both boards by their serial ports. Nothing moves."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager

import pytest

from cellctl.assembling.gripper_board import RANGES, GripperBoard
from cellctl.boards.constants import (
    COMMAND_LIMIT,
    FIRMWARE_VERSION,
    PITCH_MAX,
    PULSE_MAX_US,
    SEQUENCE_COUNT,
    BoardRole,
    Command,
    ErrorCode,
    Register,
)
from cellctl.boards.line import Banner, CommandLine, Reply, encode_command
from cellctl.boards.link import LinkLostError, SerialLink
from cellctl.clock import SystemClock
from cellctl.config import CellConfig
from cellctl.feeding.conveyor import Conveyor

REPLY_S = 1.0
"""For one line's answer; ample for any board that lives."""


@pytest.fixture(params=list(BoardRole))
def role(request: pytest.FixtureRequest, config: CellConfig) -> BoardRole:
    """Each board that the cell has on a port."""
    role: BoardRole = request.param
    if role is BoardRole.GRIPPER and config.gripper.port is None:
        pytest.skip("gripper.port is not set")
    return role


def place(config: CellConfig, role: BoardRole) -> tuple[str, int]:
    section = config.feeder if role is BoardRole.CONVEYOR else config.gripper
    assert section.port is not None
    return section.port, section.baud


class Raw:
    """A board by single lines, without a driver's help."""

    def __init__(self, link: SerialLink) -> None:
        self.link = link
        self._sequence = 0x40

    async def ask(self, command: str, argument: int | None = None, *, behind: int = 0) -> Reply:
        """Send one line and wait for its answer; ``behind`` gives it an older number."""
        if not behind:
            self._sequence = (self._sequence + 1) % SEQUENCE_COUNT
        sequence = (self._sequence - behind) % SEQUENCE_COUNT
        self.link.send(encode_command(CommandLine(sequence, command, argument)))
        async with asyncio.timeout(REPLY_S):
            while True:
                said = await self.link.receive()
                if not isinstance(said, Banner) and said.sequence == sequence:
                    return said


@asynccontextmanager
async def raw(config: CellConfig, role: BoardRole) -> AsyncIterator[Raw]:
    """A board that has just been identified."""
    link = await SerialLink.open(*place(config, role))
    try:
        board = Raw(link)
        assert (await board.ask(Command.IDENTIFY)).identity is not None
        yield board
    finally:
        link.close()


def run(config: CellConfig, role: BoardRole, act: Callable[[Raw], Awaitable[None]]) -> None:
    async def scenario() -> None:
        async with raw(config, role) as board:
            await act(board)

    asyncio.run(scenario())


def test_the_board_is_the_one_of_this_version(config: CellConfig, role: BoardRole) -> None:
    async def act(board: Raw) -> None:
        identity = (await board.ask(Command.IDENTIFY)).identity
        assert identity is not None
        print(f"\n{role}: {identity}")  # noqa: T201 - for the operator
        assert identity.role == role
        assert identity.firmware_version == FIRMWARE_VERSION[role]

    run(config, role, act)


@pytest.mark.parametrize(
    "noise", [b"\x00\xff" * 40, b">41 S", b">" * 100, b"A" * 500 + b"\n", b">42 S*00\n"]
)
def test_a_line_is_found_after_any_garbage(
    config: CellConfig, role: BoardRole, noise: bytes
) -> None:
    async def act(board: Raw) -> None:
        board.link.send(noise)
        assert (await board.ask(Command.STATUS)).status is not None

    run(config, role, act)


def test_old_numbers_unknown_commands_and_wrong_arguments_are_refused(
    config: CellConfig, role: BoardRole
) -> None:
    wrong = (
        (Command.FORWARD, PITCH_MAX + 1)
        if role is BoardRole.CONVEYOR
        else (Command.LATCH_PULSE, PULSE_MAX_US + 1)
    )

    async def act(board: Raw) -> None:
        assert (await board.ask(Command.STATUS)).error is None
        assert (await board.ask(Command.STATUS, behind=1)).error is ErrorCode.STALE
        assert (await board.ask("Z")).error is ErrorCode.COMMAND
        assert (await board.ask(Command.STATUS, 1)).error is ErrorCode.ARGUMENT
        assert (await board.ask(*wrong)).error is ErrorCode.ARGUMENT

    run(config, role, act)


def test_a_repeated_line_is_answered_again_alike(config: CellConfig, role: BoardRole) -> None:
    async def act(board: Raw) -> None:
        first = await board.ask(Command.STATUS)
        link, line = board.link, encode_command(CommandLine(first.sequence, Command.STATUS))
        assert len(line) <= COMMAND_LIMIT
        for _ in range(20):
            link.send(line)
            async with asyncio.timeout(REPLY_S):
                assert await link.receive() == first

    run(config, role, act)


def test_the_port_belongs_to_one_host(config: CellConfig, role: BoardRole) -> None:
    async def act(_: Raw) -> None:
        with pytest.raises(LinkLostError):
            await SerialLink.open(*place(config, role))

    run(config, role, act)


def test_the_conveyor_rests_and_says_so(config: CellConfig) -> None:
    async def scenario() -> None:
        conveyor = Conveyor(config.feeder, config.voxel.pitch_m, SystemClock())
        try:
            assert not (await conveyor.state()).moving
        finally:
            await conveyor.close()

    asyncio.run(scenario())


def test_the_gripper_tells_all_its_registers_and_tests_itself(config: CellConfig) -> None:
    if config.gripper.port is None:
        pytest.skip("gripper.port is not set")

    async def scenario() -> None:
        board = GripperBoard(config.gripper, lambda _: None)
        try:
            told = await board.registers()
            found = await board.self_test()
            state = await board.state()
        finally:
            await board.close()
        print(f"\n{told}\nself-test: {found!r}")  # noqa: T201 - for the operator
        assert set(told) == set(Register)
        for setting, (least, most, _) in RANGES.items():
            assert least <= told[Register[setting.name]] <= most
        assert told[Register.STACK_LEFT] > 0
        assert not state.moving

    asyncio.run(scenario())
