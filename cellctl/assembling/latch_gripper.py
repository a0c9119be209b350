"""The latch gripper on two digital lines of the robot's controller.

The command line is high to unlatch and low to latch, so that a broken wire, a lost link and an
emergency stop keep the voxel. The status line is high only while a completed latch is confirmed,
falls as soon as the command changes, and toggles at 5 Hz to report a fault. So a latch counts only
when the line was seen low first, rose, and then stayed high; and an opening, which no line
confirms, is given the time that it takes, unless the board's serial port tells that it is over.

A board that is reset leaves its latch where it is, with the line low as if it were open, and takes
the level of its command line for granted. Where its serial port is connected, it is asked after
each opening; an opening during which it was reset counts for nothing. And after any reset the next
opening begins with a closing, which is a place that the board confirms.
"""

from __future__ import annotations

import structlog

from cellctl.assembling.arm import Arm, ArmState
from cellctl.assembling.gripper_board import GripperBoard
from cellctl.config import CellConfig
from cellctl.errors import CellctlError, CellFault

_TOGGLE_PERIOD_S = 0.2
"""Of the status line while the gripper reports a fault."""
STEADY_S = 1.1 * _TOGGLE_PERIOD_S
"""A level that holds for this long (cell time) is no toggle."""

_ASK_EVERY_S = 0.02
"""While the latch opens, its board is asked this often (cell time)."""

_log = structlog.get_logger(__name__)


class LatchGripper:
    """The ``Gripper`` of a cell, real or emulated.

    Args:
        arm: whose controller the lines are on; it must be connected.
        config: the cell.
        board: what its serial port tells; None where it is not connected.
    """

    def __init__(self, arm: Arm, config: CellConfig, board: GripperBoard | None = None) -> None:
        self._arm = arm
        self._lines = config.gripper
        self._board = board
        self._resets_settled = 0
        """The board's resets before the last latch that it confirmed."""

    async def latch(self, *, prove: bool = True, begun: bool = False) -> None:
        trouble = ""
        for attempt in range(self._lines.retries + 1):
            if attempt > 0:
                _log.warning("gripper_latch_again", attempt=attempt)
            # A latch that is closed already is opened, or its closing would prove nothing; and a
            # status line that is high before it closes proves nothing either.
            opened = attempt == 0 and self._commanded_open()
            closing = attempt == 0 and begun
            if not closing and not (opened and await self._status(high=False, timeout_s=0.0)):
                await self.unlatch()
            if await self._close():
                if not prove:
                    return
                try:
                    await self.proof()
                except CellFault as fault:
                    if fault.code != "gripper_reset":
                        raise
                else:
                    return
                trouble = " Its board was reset."
        raise CellFault(
            "gripper_silent",
            f"No confirmed latch within {self._lines.travel_timeout_s:.1f} s "
            f"({self._lines.retries + 1} attempts).{trouble}{await self._board_says()}",
        )

    async def proof(self) -> None:
        # However long ago it was confirmed, nobody has watched the line since.
        if not await self._status(high=False, timeout_s=STEADY_S):
            return
        # Asking the board may take a while, in which nothing may be carried.
        await self._arm.stop()
        if await self._reset_since(self._resets_settled):
            raise CellFault("gripper_reset", "It was reset after it had confirmed the latch.")
        raise CellFault("gripper_fault", "The latch was confirmed and then revoked.")

    async def unlatch(self) -> None:
        trouble = CellFault("gripper_silent")
        for attempt in range(self._lines.retries + 1):
            if attempt > 0:
                _log.warning("gripper_unlatch_again", attempt=attempt)
                await self._command(open_=False)
            if self._resets() != self._resets_settled:
                await self._close()
                self._resets_settled = self._resets()
            resets = self._resets()
            await self._command(open_=True)
            if not await self._status(high=False, timeout_s=self._lines.travel_timeout_s):
                says = await self._board_says()
                trouble = CellFault(
                    "gripper_silent",
                    f"The status line stays high although the latch was told to open.{says}",
                )
                continue
            await self._opening()
            if not await self._reset_since(resets):
                return
            trouble = CellFault("gripper_reset", "It was reset while the latch opened.")
        raise trouble

    async def _opening(self) -> None:
        """Give the latch the time that it takes to open; less where its board says that it is.

        Raises:
            CellFault: ``gripper_fault``: the status line rose.
        """
        begun_s = self._state().robot_time_s
        opening_s, wait_s = max(self._lines.release_s, STEADY_S), STEADY_S
        board = self._board
        while wait_s > 0.0:
            if await self._status(high=True, timeout_s=wait_s):
                raise CellFault("gripper_fault", "The status line rose while it opened.")
            if board is not None:
                try:
                    said = await board.state()
                except CellctlError as error:
                    _log.info("gripper_board_asked_in_vain", reason=str(error))
                    board = None
                else:
                    if said.told_open and not said.moving and not said.fault:
                        return
            left_s = opening_s - (self._state().robot_time_s - begun_s)
            wait_s = left_s if board is None else min(left_s, _ASK_EVERY_S)

    async def feels_part(self) -> bool:
        if self._board is None:
            raise CellFault("gripper_silent", "Its board, which feels parts, is not connected.")
        try:
            return (await self._board.state()).part
        except CellctlError as error:
            raise CellFault(
                "gripper_silent", f"Its board does not tell whether it has a part: {error}"
            ) from error

    async def check_wiring(self) -> float:
        await self.unlatch()
        before = self._state()
        await self._command(open_=False)
        rose = await self._status(high=True, timeout_s=self._lines.travel_timeout_s)
        after = self._state()
        revoked = rose and await self._status(high=False, timeout_s=STEADY_S)
        # Whatever was seen, the latch is left open: nobody counts on it to hold anything.
        await self._command(open_=True)
        if not rose:
            raise CellFault("gripper_silent", self._never_rose(before, after))
        if revoked:
            raise CellFault(
                "gripper_fault",
                f"Input {self._lines.status_input} rose and fell again although the latch was told "
                "to stay closed.",
            )
        await self.unlatch()
        return after.robot_time_s - before.robot_time_s

    def _never_rose(self, before: ArmState, after: ArmState) -> str:
        """What the inputs did instead when output and status line should have closed the latch."""
        lines = self._lines
        changed = before.digital_inputs ^ after.digital_inputs
        others = [line for line in range(8) if changed >> line & 1 and line != lines.status_input]
        told = (
            f"Output {lines.command_output} was told to close the latch, and input "
            f"{lines.status_input} did not rise within {lines.travel_timeout_s:.1f} s"
        )
        if others:
            names = " and ".join(str(line) for line in others)
            return f"{told}; input {names} changed instead: is that the status line?"
        return f"{told}; no input changed: look at the command line and at the gripper's power."

    def _resets(self) -> int:
        """How many resets of the board are known."""
        return self._board.resets if self._board is not None else 0

    async def _close(self) -> bool:
        """Tell the latch to close; whether it confirms."""
        resets = self._resets()
        await self._command(open_=False)
        confirmed = await self._status(high=True, timeout_s=self._lines.travel_timeout_s)
        if confirmed:
            self._resets_settled = resets
        return confirmed

    async def _reset_since(self, resets: int) -> bool:
        """Whether the board was reset since it counted so many; False where nobody can tell."""
        if self._board is None:
            return False
        try:
            await self._board.state()
        except CellctlError as error:
            _log.info("gripper_board_asked_in_vain", reason=str(error))
        return self._resets() != resets

    async def _board_says(self) -> str:
        """What the board makes of it, as a sentence for the operator; empty where it tells nothing.

        Tells a broken status line from a latch that does not move, and a broken command line.
        """
        if self._board is None:
            return ""
        try:
            said = await self._board.state()
        except CellctlError as error:
            return f" Its board tells nothing more: {error}"
        told = "open" if said.told_open else "closed"
        confirmed = "confirmed" if said.confirmed else "not confirmed"
        return f" Its board says: the command line asks for {told}, the latch is {confirmed}."

    def _state(self) -> ArmState:
        state = self._arm.state()
        if state is None:
            raise CellFault("robot_lost")
        return state

    def _commanded_open(self) -> bool:
        state = self._arm.state()
        return state is not None and bool(state.digital_outputs >> self._lines.command_output & 1)

    async def _command(self, *, open_: bool) -> None:
        await self._arm.set_output(self._lines.command_output, high=open_)

    async def _status(self, *, high: bool, timeout_s: float) -> bool:
        return await self._arm.wait_input(self._lines.status_input, high, timeout_s)
