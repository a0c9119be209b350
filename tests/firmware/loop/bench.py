"""Boards of either kind at the ends of their cables, a world, and time that tests hand out."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self

from cellctl.boards.constants import REPLY_LIMIT, Command, ReplyKind
from cellctl.boards.line import (
    BANNER_START,
    REPLY_START,
    Banner,
    CommandLine,
    LineSplitter,
    Reply,
    decode_reply,
    encode_command,
)
from cellctl.config import CellConfig
from cellctl.sim.boards import Board, GripperBoard, make_boards
from cellctl.sim.wiring import CellPlant
from cellctl.sim.world import World
from cellctl.sim.world_values import Imperfections
from tests.leaks import REPOSITORY
from tests.sim.world.hand import Hand, emulated_config

STEP_S = 0.002
"""The emulated cell's own slice at real speed."""
LONG_STEP_S = 0.01
"""Where it does not matter: each slice of a compiled program costs two switches of process."""
ANSWER_S = 0.03
"""A board has answered by then: its longest reply takes 6 ms on the line."""
BOOT_S = 0.1
PITCH = 1000


class Host:
    """The far end of a board's port, which speaks raw lines."""

    def __init__(self, port: str, bench: Bench) -> None:
        self._bench = bench
        self._descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self._splitter = LineSplitter((REPLY_START, BANNER_START), REPLY_LIMIT)

    def close(self) -> None:
        """Let go of the port."""
        os.close(self._descriptor)

    def write(self, data: bytes) -> None:
        """Put bytes on the line."""
        os.write(self._descriptor, data)

    def heard(self) -> list[Reply | Banner]:
        """What the board has said since."""
        try:
            data = os.read(self._descriptor, 4096)
        except BlockingIOError:
            return []
        return [decode_reply(frame) for frame in self._splitter.feed(data)]

    def ask(self, sequence: int, command: str, argument: int | None = None) -> Reply:
        """Send a line and wait for its answer."""
        self.write(encode_command(CommandLine(sequence, command, argument)))
        for _ in range(round(ANSWER_S / LONG_STEP_S)):
            self._bench.advance(LONG_STEP_S)
            for reply in self.heard():
                if isinstance(reply, Reply) and reply.sequence == sequence:
                    return reply
        raise AssertionError(f"no answer to {command} within {ANSWER_S} s")

    def identify(self) -> Reply:
        """Begin a session; the newest number is 0 then."""
        return self.ask(0, Command.IDENTIFY)

    def finish(self, sequence: int, command: str = Command.FORWARD, pitch: int = PITCH) -> Reply:
        """Repeat an index's line until its outcome is known, as a host does."""
        for _ in range(400):
            reply = self.ask(sequence, command, pitch)
            if reply.kind is not ReplyKind.BUSY:
                return reply
            self._bench.advance(0.03)
        raise AssertionError("the index never ends")


class Bench:
    """The boards of one emulated cell without its robot; use it as a context manager.

    Args:
        kind: plain or elf.
        gripper, conveyor: which boards there are.
        imperfections: of the belt and its parts.
    """

    def __init__(
        self,
        kind: str,
        *,
        gripper: bool = False,
        conveyor: bool = False,
        imperfections: Imperfections | None = None,
        seed: int = 1,
    ) -> None:
        self.kind = kind
        self._stack = ExitStack()
        folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory()))
        self.config = _config(kind, folder)
        self.world = World(self.config, seed, imperfections)
        self.latch, talking, self.conveyor = make_boards(self.world, self.config)
        assert talking is not None
        self.gripper: GripperBoard = talking
        self.plant = CellPlant(self.world, self.latch, self.config.gripper)
        self.hand = Hand(self.world, self, travel_s=0.4)
        wanted: list[tuple[bool, Board]] = [(gripper, self.gripper), (conveyor, self.conveyor)]
        self._boards = [board for there, board in wanted if there]
        self._talks_to = self.config.gripper.port if gripper else self.config.feeder.port
        self.time_s = 0.0

    def __enter__(self) -> Self:
        for board in self._boards:
            board.start()
            self._stack.callback(board.stop)
        assert self._talks_to is not None
        self.host = Host(self._talks_to, self)
        self._stack.callback(self.host.close)
        self.advance(BOOT_S)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    def advance(self, duration_s: float) -> None:
        """Let cell time pass, in slices no longer than ``LONG_STEP_S``."""
        end_s = self.time_s + duration_s
        while self.time_s < end_s - 1e-9:
            step_s = min(LONG_STEP_S, end_s - self.time_s)
            self.world.advance(step_s)
            self.plant.advance(step_s)
            self.latch.advance(step_s)
            for board in self._boards:
                board.advance(step_s)
            self.time_s += step_s

    def command(self, high: bool) -> None:
        """The robot's level on the command line."""
        self.plant.outputs_changed(int(high) << self.config.gripper.command_output)

    @property
    def status(self) -> bool:
        """What the robot reads on the status line."""
        return bool(self.plant.inputs())

    def levels(self, duration_s: float) -> list[bool]:
        """Let time pass; the status after each slice."""
        levels = []
        for _ in range(round(duration_s / LONG_STEP_S)):
            self.advance(LONG_STEP_S)
            levels.append(self.status)
        return levels

    def until_status(self, high: bool, within_s: float = 1.0) -> float:
        """Wait for the status to have a level; returns how long it took, to ``STEP_S``."""
        began_s = self.time_s
        while self.status is not high:
            assert self.time_s - began_s < within_s, f"status did not become {high}"
            self.advance(STEP_S)
        return self.time_s - began_s


def compile_programs() -> None:
    """Bring ``firmware/build`` up to date with the sources."""
    subprocess.run(
        ["make", "--no-print-directory", "-s", "-C", REPOSITORY / "firmware"],
        check=True,
        timeout=120,
    )


def _config(kind: str, folder: Path) -> CellConfig:
    config = emulated_config()
    assert config.emulation is not None
    return config.model_copy(
        update={
            "gripper": config.gripper.model_copy(update={"port": str(folder / "gripper")}),
            "feeder": config.feeder.model_copy(update={"port": str(folder / "conveyor")}),
            "emulation": config.emulation.model_copy(update={"firmware": kind}),
        }
    )


@contextmanager
def gripper(kind: str) -> Iterator[Bench]:
    """A gripper's board that has started; nobody has identified it."""
    with Bench(kind, gripper=True) as bench:
        yield bench


@contextmanager
def conveyor(
    kind: str, imperfections: Imperfections | None = None, seed: int = 1
) -> Iterator[Bench]:
    """A conveyor's board in a session; the newest sequence number is 0."""
    with Bench(kind, conveyor=True, imperfections=imperfections, seed=seed) as bench:
        bench.host.identify()
        bench.host.heard()
        yield bench
