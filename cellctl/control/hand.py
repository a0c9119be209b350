"""Movements by an operator's hand: out of a pause, by the same checked routes, one at a time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import structlog

from cellctl.assembling.route import Route, Stance
from cellctl.assembly import Cell
from cellctl.control.acts import ActKind
from cellctl.control.controller import Post
from cellctl.control.dismantling import Dismantler
from cellctl.control.job import Grip
from cellctl.control.journal import Journal
from cellctl.control.moving import ArmAndLatch
from cellctl.control.states import Event
from cellctl.errors import CellctlError, CellFault, RefusedError, UsageError
from cellctl.feeding.inventory import Move
from cellctl.feeding.service import BeltService
from cellctl.messages import HandCommand

log = structlog.get_logger(__name__)


class HandMoves:
    """Carries out one movement at a time.

    Args:
        builder: knows what the latch has and what stands.
        hands: the arm and its latch.
        belt: brings a part for ``index``.
        journal: every movement is an act.
    """

    def __init__(
        self, builder: Dismantler, hands: ArmAndLatch, belt: BeltService, journal: Journal
    ) -> None:
        self._builder = builder
        self._hands = hands
        self._belt = belt
        self._journal = journal
        self._command: HandCommand | None = None
        self._ended: asyncio.Future[str] | None = None

    def why_not(self, command: HandCommand) -> str:
        """Why a movement cannot begin now; empty when it can."""
        if self._builder.doubt is not None:
            return f"{self._builder.doubt.sentence}. Settle that first with `cellctl recover`."
        if command.move == "above_cell" and command.cell is None:
            return "Name the cell."
        gripped = self._builder.grip is Grip.GRIPPED or self._builder.gripping_cut_off
        if gripped and command.move != "open":
            return (
                "The gripper has hold of a part that stands: say resume, or cancel and let it go "
                "with `cellctl hand open`."
            )
        return self._why_no_latch(command)

    def _why_no_latch(self, command: HandCommand) -> str:
        """Why the latch cannot be moved now."""
        grip = self._builder.grip
        cut_off = grip in {Grip.LATCHING, Grip.RELEASING} or self._builder.taking_cut_off
        if command.move == "open" and cut_off:
            return (
                "The latch was cut off in the middle, and only resume knows how far it came: say "
                "resume, or cancel and then `cellctl recover`."
            )
        if command.move == "open" and self._may_fall() and not command.part_held:
            return (
                "The part in the gripper would fall. Hold it, and say `cellctl hand open "
                "--part-held`; it counts as taken to the stock then."
            )
        if command.move in {"close", "check_lines"} and grip is not Grip.NOTHING:
            return "There is a part in the gripper."
        if command.move == "check_lines" and self._may_hold():
            return "There may be a part in the gripper: open it with `cellctl hand open` first."
        return ""

    def begin(self, command: HandCommand) -> asyncio.Future[str]:
        """Take a movement that the machine has accepted.

        Returns:
            A future with what was done, in words for the operator; it fails with the reason why it
            was not done.
        """
        self._command = command
        self._ended = asyncio.get_running_loop().create_future()
        return self._ended

    async def run(self, post: Post) -> None:
        """The stage: carry the movement out.

        Raises:
            CellFault: of a device; what a route checker refuses only ends the movement.
        """
        command, ended = self._command, self._ended
        assert command is not None, "a hand moves by a command"
        assert ended is not None, "whoever gave it waits for its end"
        opens = command.move in {"open", "check_lines"}
        kind = ActKind.HAND_OPEN if opens else ActKind.HAND
        try:
            act = await self._journal.intend(kind, "", None, command.cell)
        except CellFault as fault:
            _end(ended, fault)
            raise
        moves: tuple[Move, ...] = ()
        try:
            message, moves = await self._carry_out(command)
        except asyncio.CancelledError:
            self._journal.settle(act, "interrupted", command.move)
            self._doubt_a_part_let_go(command)
            raise
        except CellctlError as error:
            self._journal.settle(act, "failed", f"{command.move}: {error}")
            self._doubt_a_part_let_go(command)
            _end(ended, error)
            if isinstance(error, CellFault) and error.code != "no_route":
                raise
        else:
            self._journal.settle(act, "done", command.move, moves)
            log.info("moved by hand", move=command.move)
            if not ended.done():
                ended.set_result(message)
        post(Event.HAND_DONE)

    def left(self) -> None:
        """The machine has left the movement, perhaps before it began: nobody waits any longer."""
        if self._ended is not None:
            _end(self._ended, RefusedError("The movement was interrupted."))

    def _doubt_a_part_let_go(self, command: HandCommand) -> None:
        """A latch that was cut off while it opened may have let its part go, or not."""
        if command.move == "open" and self._builder.grip is Grip.PART:
            self._builder.doubt_held(
                "The part in the gripper was about to be taken out", believed="stock"
            )

    async def _carry_out(self, command: HandCommand) -> tuple[str, tuple[Move, ...]]:
        hands, routes = self._hands, self._hands.routes
        # What may be in the gripper is as wide and as low as what is.
        carrying = self._may_hold()
        match command.move:
            case "open":
                return await self._open(command)
            case "close":
                await hands.close()
                return "The latch is closed.", ()
            case "check_lines":
                took_s = await hands.check_wiring()
                return f"Both lines work; the latch confirmed after {took_s:.2f} s.", ()
            case "index":
                return await self._index(), ()
            case "jog":
                await self._travel(
                    command,
                    lambda start, placed: routes.jog(
                        start, placed, command.delta_m, command.turn_rad, carrying=carrying
                    ),
                )
            case "rise":
                await self._travel(
                    command, lambda start, placed: routes.rise(start, placed, carrying=carrying)
                )
            case "retreat":
                await self._travel(
                    command, lambda start, placed: routes.retreat(start, placed, carrying=carrying)
                )
            case "home":
                await self._travel(
                    command, lambda start, placed: routes.to_home(start, placed, carrying=carrying)
                )
            case "above_station":
                await self._travel(
                    command,
                    lambda start, placed: routes.to_above_station(start, placed, carrying=carrying),
                )
            case "above_cell":
                cell = command.cell
                assert cell is not None, "checked before it began"
                await self._travel(
                    command,
                    lambda start, placed: routes.to_above_cell(
                        cell, start, placed, carrying=carrying
                    ),
                )
        x, y, z = (f"{edge * 1000:.0f}" for edge in hands.state().tcp_pose[:3])
        return f"The TCP is at x {x}, y {y}, z {z} mm of the robot's base.", ()

    async def _open(self, command: HandCommand) -> tuple[str, tuple[Move, ...]]:
        if await self._builder.let_stand_by_hand(command.speed_fraction):
            return "The latch is open; the part stands.", ()
        await self._hands.open()
        if self._builder.grip is Grip.PART:
            return "The latch is open; the part counts as taken to the stock.", (Move.TAKE_OUT,)
        return "The latch is open.", ()

    def _may_fall(self) -> bool:
        """Something is in the gripper that would fall if it opened."""
        return self._may_hold() and self._builder.grip is not Grip.GRIPPED

    def _may_hold(self) -> bool:
        """A part is in the gripper, or something that nobody knows of."""
        unknown = self._hands.latched() and not self._builder.ledger.missed
        return self._builder.grip is not Grip.NOTHING or unknown

    async def _index(self) -> str:
        """Bring a part to the pick station."""
        if self._builder.ledger.counts.belt == 0:
            raise UsageError(
                "The inventory counts no part on the belt.",
                "Lay parts on it and tell it with `cellctl refill`.",
            )
        if self._hands.near_station(carrying=self._may_hold()):
            raise RefusedError(
                "The arm is at the pick station, where the part would run into it.",
                "Move it away first, for example with `cellctl hand rise`.",
            )
        self._belt.request_part()
        await self._belt.part_ready()
        return "A part lies at the pick station."

    async def _travel(
        self, command: HandCommand, plan: Callable[[Stance, frozenset[Cell]], Route]
    ) -> None:
        await self._hands.travel(
            plan, self._builder.standing, speed_fraction=command.speed_fraction
        )


def _end(ended: asyncio.Future[str], error: CellctlError) -> None:
    if not ended.done():
        ended.set_exception(error)
        ended.exception()  # whoever asked may have gone
