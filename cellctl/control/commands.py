"""Words of command: what may be asked of a cell without arguments, and by whom."""

from __future__ import annotations

from collections.abc import Callable

from cellctl.assembly import Role
from cellctl.control.books import Books
from cellctl.control.cell import Cell
from cellctl.control.job import Job
from cellctl.control.states import Event
from cellctl.errors import RefusedError
from cellctl.messages import OPERATOR_COMMANDS

_EVENTS = {
    "pause": Event.PAUSE,
    "stop": Event.STOP,
    "cancel": Event.CANCEL,
    "reset": Event.RESET,
}


def refuse_visitors(command: str, role: Role) -> None:
    """Raises RefusedError for what only an operator may do."""
    if role is not Role.OPERATOR and command in OPERATOR_COMMANDS:
        raise RefusedError(f"{command} needs the operator.")


class Commands:
    """Carries words of command out.

    Args:
        cell: the cell.
        books: writes down what people say of parts.
    """

    def __init__(self, cell: Cell, books: Books) -> None:
        self._cell = cell
        self._books = books
        self._wording = cell.sentences.wording

    async def take(self, word: str, role: Role, owner: str = "") -> str:
        """Carry out a command without arguments.

        Args:
            word: such as ``pause``.
            role: of the one who gives it.
            owner: mark of that visitor.

        Returns:
            What happens now, for people.

        Raises:
            CellctlError: why it is not done.
        """
        controller = self._cell.controller
        refuse_visitors(word, role)
        if word == "cancel":
            self._refuse_to_cancel_anothers(role, owner)
        if word == "take_apart":
            await controller.command(
                Event.TAKE_APART,
                lambda: self._cell.begin(Job.taking_apart(role, owner)),
                unless=self._why_nothing_to_take_apart,
            )
            return self._wording.text("reply.take_apart")
        if word in {"clear", "hand_over"}:
            return await self._books.empty_workspace(handed_over=word == "hand_over")
        if word == "pause" and role is Role.VISITOR and controller.state == "idle":
            # Only an operator could lead out of it again.
            raise RefusedError("There is nothing to pause.")
        if word == "resume":
            await self._resume()
        else:
            idle = controller.state == "idle"
            await controller.command(_EVENTS[word])
            if word == "stop" and idle:
                return self._wording.text("reply.nothing_moves")
            if word == "stop" and not self._cell.builder.ledger.holding:
                return self._wording.text("reply.stop_empty")
        return self._wording.text(f"reply.{word}")

    async def answer(self, yes: bool, unless: Callable[[], str] | None = None) -> str:
        """A yes or a no to what the machine asks.

        Args:
            yes: which of them.
            unless: asked at the moment of the decision; a reason refuses it.

        Raises:
            RefusedError: it asks nothing.
        """
        job = self._cell.active_job
        agreed = job.confirm_event() if job is not None else Event.CONFIRM
        await self._cell.controller.command(agreed if yes else Event.DECLINE, unless=unless)
        return self._wording.text("reply.yes" if yes else "reply.no")

    async def _resume(self) -> None:
        """Go on; what is believed of a part in doubt is taken for granted then."""
        cell = self._cell
        if cell.controller.state == "paused_resting":
            await cell.resume_doubt()
        job = cell.active_job
        why_not = job.why_not_resume if job is not None else None
        await cell.controller.command(cell.resume_event(), unless=why_not)

    def _why_nothing_to_take_apart(self) -> str:
        idle = self._cell.controller.state == "idle"
        return (
            "Nothing stands in the workspace." if idle and not self._cell.builder.standing else ""
        )

    def _refuse_to_cancel_anothers(self, role: Role, owner: str) -> None:
        """A visitor may end what is the visitor's own; an operator everything."""
        job = self._cell.job
        if job is None or job.outcome or role is Role.OPERATOR:
            return
        if job.role is not role:
            raise RefusedError(
                "The operator began this job; cancel needs the operator.",
                "Say stop if the cell has to stop now.",
            )
        if job.owner != owner:
            raise RefusedError(
                "Another visitor began this job, and may end it.",
                "Say stop if the cell has to stop now.",
            )
