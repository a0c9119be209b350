"""The dashboard of a UR controller: who it is, and how to leave a stop of its own.

Source of commands and replies: Universal Robots, "Dashboard Server e-Series" and "CB-Series".
"""

from __future__ import annotations

import re
import select
import socket
import time
from collections.abc import Generator
from typing import Literal, TypeVar

from cellctl.assembling.arm import ArmIdentity
from cellctl.assembling.arm_receiver import (
    RUNNING,
    STOPPED,
    VIOLATION,
    Receiver,
    safety_fault,
)
from cellctl.config import RobotSection
from cellctl.errors import CellFault

Answer = TypeVar("Answer")

_REPLY_TIMEOUT_S = 2.0
_POLL_S = 0.001
_REMOTE = "is in remote control"
_IDLE = 5
"""``robot_mode`` of an arm with power on and brakes held."""
_RETRY_S = 0.25
_UNLOCK_TIMEOUT_S = 10.0
_END_PROGRAM_TIMEOUT_S = 3.0
_POWER_S = 20.0
"""For switching the arm on, and for releasing its brakes; a real one takes some seconds each."""


def finished(steps: Generator[None, None, Answer]) -> Answer:
    """Go through steps that have no loop to give rounds to, and return what comes of them."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            answer: Answer = end.value
            return answer
        time.sleep(_POLL_S)


class Dashboard:
    """One connection to the dashboard, line by line.

    ur_rtde's own client wants exact replies and raises on documented ones (``Failed to execute:
    stop`` where nothing runs), so the lines are spoken here.

    Args:
        robot: which controller.

    Raises:
        CellFault: ``robot_lost``.
    """

    def __init__(self, robot: RobotSection) -> None:
        self._where = f"{robot.host}:{robot.dashboard_port}"
        try:
            self._socket = socket.create_connection(
                (robot.host, robot.dashboard_port), timeout=_REPLY_TIMEOUT_S
            )
        except OSError as error:
            raise CellFault("robot_lost", f"{self._where}: {error.strerror or error}.") from error
        self._received = bytearray()
        self._owed = 1
        """Replies that are still to come, the greeting and those that nobody waits for included."""
        self._being_asked = False
        try:
            self._read()
        except CellFault:
            self.close()
            raise

    def ask(self, command: str) -> str:
        """Send a line and return the reply.

        Raises:
            CellFault: ``robot_lost`` when none comes.
        """
        self._send(command)
        return self._read()

    def close(self) -> None:
        """Let go of the connection."""
        self._socket.close()

    def asking(self, command: str) -> Generator[None, None, str]:
        """``ask`` for a loop that has other things to do: each ``yield`` gives it a round.

        Raises:
            CellFault: ``robot_lost`` when no reply comes.
        """
        deadline_s = time.monotonic() + _REPLY_TIMEOUT_S
        while self._being_asked:  # by an order that nobody may wait for any more
            self._check(deadline_s)
            yield
        self._being_asked = True
        try:
            self._send(command)
            while (reply := self._newest()) is None:
                if select.select([self._socket], [], [], 0.0)[0]:
                    self._receive()
                    continue
                self._check(deadline_s)
                yield
            return reply
        finally:
            self._being_asked = False

    def identity(self, expected: Literal["ur10", "ur10e"]) -> ArmIdentity:
        """Who the controller is, if it is the one that is expected; waits for it.

        Raises:
            CellFault: ``robot_mismatch``, ``local_control`` or ``robot_lost``.
        """
        return finished(self.identifying(expected))

    def identifying(self, expected: Literal["ur10", "ur10e"]) -> Generator[None, None, ArmIdentity]:
        """``identity`` for a loop that has other things to do.

        Both arms call themselves UR10; the generation of the controller tells them apart.

        Raises:
            CellFault: ``robot_mismatch``, ``local_control`` or ``robot_lost``.
        """
        version_line = yield from self.asking("PolyscopeVersion")
        found = re.search(r"(\d+)\.(\d+)\.(\d+)", version_line)
        if found is None:
            raise CellFault("robot_mismatch", f"Unknown controller version {version_line!r}.")
        e_series = int(found[1]) >= 5
        model = (yield from self.asking("get robot model")).strip()
        if (e_series, model.upper().removesuffix("E")) != (expected == "ur10e", "UR10"):
            raise CellFault(
                "robot_mismatch",
                f"The configuration says {expected}; the controller says {model} with software "
                f"{found[0]}.",
            )
        serial_number = ""
        if e_series:
            if not _is_remote((yield from self.asking(_REMOTE))):
                raise CellFault("local_control")
            serial_number = (yield from self.asking("get serial number")).strip()
        return ArmIdentity(model=expected, controller_version=found[0], serial_number=serial_number)

    def remote(self) -> bool:
        """Whether the controller takes commands from the network; a CB3 always does."""
        return _is_remote(self.ask(_REMOTE))

    def end_program(self, receiver: Receiver) -> None:
        """End whatever program runs or is paused.

        Raises:
            CellFault: ``program_stopped`` when it does not end, or ``robot_lost``.
        """
        deadline_s = time.monotonic() + _END_PROGRAM_TIMEOUT_S
        while receiver.refresh().runtime_state != STOPPED:
            if time.monotonic() > deadline_s:
                raise CellFault("program_stopped", "The controller does not end its program.")
            self.ask("stop")
            receiver.wait(lambda sample: sample.runtime_state == STOPPED, _RETRY_S)

    def leave_stop(self, receiver: Receiver) -> None:
        """Unlock, power on and release the brakes, as the case may be. Moves nothing.

        Raises:
            CellFault: ``emergency_stop`` or ``safeguard_stop`` while it is pressed or open;
                ``protective_stop`` when it cannot be unlocked; ``robot_lost``.
        """
        deadline_s = time.monotonic() + _UNLOCK_TIMEOUT_S
        while (fault := safety_fault(receiver.refresh())) is not None:
            if fault.code != "protective_stop" or time.monotonic() > deadline_s:
                raise fault
            self.ask("close safety popup")
            # Refused for the first 5 s, so that somebody looks for the cause.
            violation = receiver.sample.safety_bits & VIOLATION
            self.ask("restart safety" if violation else "unlock protective stop")
            receiver.wait(lambda sample: safety_fault(sample) is None, _RETRY_S)
        self.ask("close safety popup")
        if receiver.sample.robot_mode != RUNNING:
            self._power_up(receiver)

    def _power_up(self, receiver: Receiver) -> None:
        self.ask("power on")
        powered = receiver.wait(lambda sample: sample.robot_mode >= _IDLE, _POWER_S)
        self.ask("brake release")
        if not powered or not receiver.wait(lambda sample: sample.robot_mode == RUNNING, _POWER_S):
            raise safety_fault(receiver.sample) or CellFault(
                "robot_lost", "The arm does not switch on or does not release its brakes."
            )

    def _send(self, command: str) -> None:
        try:
            self._socket.sendall(f"{command}\n".encode())
        except OSError as error:
            raise CellFault("robot_lost", f"{self._where}: {error.strerror or error}.") from error
        self._owed += 1

    def _read(self) -> str:
        while (reply := self._newest()) is None:
            self._receive()
        return reply

    def _receive(self) -> None:
        try:
            data = self._socket.recv(4096)
        except OSError as error:
            raise CellFault("robot_lost", f"{self._where} does not answer: {error}.") from error
        if not data:
            raise CellFault("robot_lost", f"{self._where} closed the connection.")
        self._received += data

    def _newest(self) -> str | None:
        """The reply to the newest question, once it is there; older ones are dropped."""
        while self._owed and b"\n" in self._received:
            line, _, self._received = self._received.partition(b"\n")
            self._owed -= 1
            if not self._owed:
                return line.decode("utf-8", "replace").rstrip("\r")
        return None

    def _check(self, deadline_s: float) -> None:
        if time.monotonic() > deadline_s:
            raise CellFault("robot_lost", f"{self._where} does not answer.")


def _is_remote(reply: str) -> bool:
    """A CB3 does not know the question, and always takes commands."""
    reply = reply.strip().lower()
    return reply == "true" or "understand" in reply
