"""The operator's end of one page: orders and questions in a session, and what is asked twice."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Final, TypeVar

from nicegui import ui
from nicegui.element import Element

from cellctl.assembly import Role
from cellctl.errors import CellctlError
from cellctl.kiosk.components import Button, Text, box, notice
from cellctl.kiosk.operator.access import Session
from cellctl.kiosk.shell import Page, duration
from cellctl.kiosk.words import Words
from cellctl.messages import Command, Inquiry, Snapshot

T = TypeVar("T")

_ORDER_S: Final = 15.0
MOVING_S: Final = 130.0
"""Longest wait for a movement by hand; the cell itself gives up before."""


class Desk:
    """What panels use to act.

    Args:
        page: where they are.
        session: of the operator.
    """

    def __init__(self, page: Page, session: Session) -> None:
        self.page = page
        self.session = session
        self._question = _Question(page.words)
        self.go: Callable[[str], None] = lambda _: None
        """Opens a part of the view by its name."""

    @property
    def words(self) -> Words:
        """The labels in the page's language."""
        return self.page.words

    @property
    def snapshot(self) -> Snapshot | None:
        """The cell as it is known."""
        return self.page.site.mirror.snapshot

    def takes(self, command: str) -> bool:
        """Whether the cell would take a command now, as far as is known."""
        snapshot, mirror = self.snapshot, self.page.site.mirror
        return snapshot is not None and not mirror.stale and command in snapshot.state.commands

    async def order(self, body: Command, timeout_s: float = _ORDER_S) -> None:
        """Give a command, and tell what was answered.

        Raises:
            CellctlError: what the cell says against it.
        """
        self.session.use()
        reply = await self.page.site.link.ask(body, role=Role.OPERATOR, timeout_s=timeout_s)
        if reply.message:
            notice(reply.message)

    async def ask(self, body: Inquiry, kind: type[T]) -> T:
        """Ask something.

        Raises:
            CellctlError: there is no answer.
        """
        self.session.use()
        reply = await self.page.site.link.ask(body, role=Role.OPERATOR)
        if not isinstance(reply.data, kind):
            raise CellctlError("The cell answered something else.")
        return reply.data

    def ordering(self, body: Command) -> Callable[[], Awaitable[None]]:
        """An action that gives a command at once."""

        async def act() -> None:
            await self.order(body)

        return act

    def asking_first(
        self, key: str, act: Callable[[], Awaitable[None]], told: Callable[[], str] | None = None
    ) -> Callable[[], Awaitable[None]]:
        """An action that asks once more, and says what will happen.

        Args:
            key: of the sentence ``sure.KEY`` that says what will happen.
            act: what is done after a yes.
            told: says it instead, where it depends on the moment.
        """

        async def ask() -> None:
            sentence = told() if told is not None else self.words.say(f"sure.{key}")
            self._question.ask(sentence, act)

        return ask


def lasting(words: Words, seconds: float) -> str:
    """A length of time that may be days."""
    hours = seconds / 3600.0
    if hours < 2.0:
        return duration(words, seconds)
    return (
        words.say("time.hours", n=round(hours))
        if hours < 48.0
        else words.say("time.days", n=round(hours / 24.0))
    )


class _Question:
    """The one question of a page that comes up over it; the browser keeps the focus in it."""

    def __init__(self, words: Words) -> None:
        self._act: Callable[[], Awaitable[None]] | None = None
        with box("dialog", "sure", aria_labelledby="sure-what") as self._dialog:
            Text("h2", words.say("sure.title"), "sure__title")
            self._what = Text("p", "", "sure__what")
            self._what.props["id"] = "sure-what"
            with box("div", "sure__answers"):
                Button(words.say("sure.no"), self._leave, classes="sure__no")
                Button(words.say("sure.yes"), self._go, kind="danger", classes="sure__yes")

    def ask(self, sentence: str, act: Callable[[], Awaitable[None]]) -> None:
        """Ask, and act after a yes."""
        self._act = act
        self._what.say(sentence)
        _run(self._dialog, "showModal")

    async def _leave(self) -> None:
        self._act = None
        _run(self._dialog, "close")

    async def _go(self) -> None:
        act, self._act = self._act, None
        _run(self._dialog, "close")
        if act is not None:
            await act()


def _run(dialog: Element, method: str) -> None:
    ui.run_javascript(f"document.getElementById('{dialog.html_id}').{method}()")
