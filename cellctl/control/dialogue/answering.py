"""What a yes and a no do to what was asked: the machine's question, and that of the hand-over."""

from __future__ import annotations

from cellctl.assembly import Role
from cellctl.control.cell import Cell
from cellctl.control.commands import Commands
from cellctl.control.dialogue.board import DialogueBoard
from cellctl.control.dialogue.naming import Naming
from cellctl.control.dialogue.said import Said, Who
from cellctl.control.dialogue.turns import Turns
from cellctl.errors import RefusedError
from cellctl.wording import Line


class Answering:
    """Does what a question was about, if the answer was meant for it.

    Args:
        cell: what asks.
        board: knows which question is open.
        commands: carries the answer to the machine.
        turns: the wishes that wait.
    """

    def __init__(
        self, cell: Cell, board: DialogueBoard, *, commands: Commands, turns: Turns
    ) -> None:
        self._cell = cell
        self._board = board
        self._commands = commands
        self._turns = turns
        self._wording = cell.sentences.wording
        self._naming = Naming(self._wording)

    async def confirm(self, said: Said) -> Line:
        """Build it, change what stands into it, or take it apart.

        Raises:
            RefusedError: the answer was meant for another question, or comes too late.
        """
        job = self._cell.active_job
        # Asked again by the consumer: a change may be before the yes in its inbox.
        text = await self._commands.answer(yes=True, unless=lambda: self._why_not_meant(said))
        line = Line(key="reply.yes", text=text, language=self._wording.language)
        copies = self._cell.sentences.copies_left(job) if job is not None else 0
        if job is None or not copies or job.request is None or job.utterance is None:
            return line
        if self._turns.is_full_for(job.owner):
            return line
        self._turns.add(
            job.utterance,
            self._naming.wish(job.request.model_copy(update={"count": 1})),
            owner=job.owner,
            name=job.owner_name,
            copies=copies,
        )
        more = self._wording.text("queue.copies", count=copies)
        return line.model_copy(update={"text": f"{text} {more}"})

    async def decline(self, _said: Said) -> Line:
        """Leave it; whichever question a no was meant for, nothing moves by it."""
        text = await self._commands.answer(yes=False)
        return Line(key="reply.no", text=text, language=self._wording.language)

    async def ask_hand_over(self, said: Said) -> Line:
        """Ask whether what stands is taken along.

        Raises:
            RefusedError: nothing stands, or it is somebody else's.
        """
        self._refuse_anothers_object(said.who)
        count = len(self._cell.builder.standing)
        if not count:
            raise RefusedError(self._wording.text("explain.nothing_stands"))
        amount = self._wording.text("count.parts", count=count)
        return self._wording.line("ask.hand_over", amount=amount)

    async def hand_over(self, said: Said) -> Line:
        """Write off what stands.

        Raises:
            RefusedError: it is somebody else's, or the answer was meant for another question.
        """
        self._refuse_anothers_object(said.who)
        if why := self._why_not_meant(said):
            raise RefusedError(why)
        count = len(self._cell.builder.standing)
        await self._commands.take("hand_over", said.who.role)
        amount = self._wording.text("count.parts", count=count)
        return self._wording.line("reply.handed_over", amount=amount)

    async def leave(self, _said: Said) -> Line:
        """What stands stays."""
        return self._wording.line("reply.stays")

    def _why_not_meant(self, said: Said) -> str:
        """Why an answer does not count for what is asked now; empty when it does."""
        if said.answers is None or self._board.questions.is_open(said.answers):
            return ""
        return self._wording.text("explain.asked_anew", question=self._board.asked)

    def _refuse_anothers_object(self, who: Who) -> None:
        """What stands is taken along from where it stands, or by the one for whom it was built.

        Raises:
            RefusedError: somebody elsewhere says so.
        """
        job = self._cell.job
        if who.role is Role.VISITOR and who.owner and (job is None or job.owner != who.owner):
            raise RefusedError(self._wording.text("explain.anothers_object"))
