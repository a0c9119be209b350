"""What both views are made of: plain HTML elements with the classes of ``look/kiosk.css``."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any, Literal

from nicegui import ui
from nicegui.element import Element
from nicegui.elements.mixins.text_element import TextElement
from pydantic import ValidationError

from cellctl.errors import CellctlError

Kind = Literal["plain", "strong", "quiet", "danger"]
"""``strong``: what is most likely wanted, one of a page; ``danger``: stop."""
Action = Callable[[], Awaitable[None]]
_WAITING_MOST = 4
"""Sentences of one page that wait for each other; what a browser sends beyond is no person's."""


def box(tag: str = "div", classes: str = "", **attributes: str) -> Element:
    """An element without words; a ``with`` block fills it."""
    element = ui.element(tag).classes(classes)
    for name, value in attributes.items():
        element.props[name.replace("_", "-")] = value
    return element


class Text(TextElement):
    """Words.

    Args:
        tag: such as ``p``, ``h2``, ``span``.
        text: what it says at first.
        classes: of the style sheet.
    """

    def __init__(self, tag: str, text: str = "", classes: str = "") -> None:
        super().__init__(tag=tag, text=text)
        self.classes(classes)

    def say(self, text: str) -> None:
        """Say this; nothing goes to the browser when it does so already."""
        if text != self.text:
            self.text = text

    def show(self, text: str) -> None:
        """Say this, or be hidden when there is nothing to say."""
        self.say(text)
        shown(self, bool(text))


def shown(element: Element, visible: bool) -> None:
    """Show or hide an element; nothing goes to the browser when it is so already."""
    if element.visible is not visible:
        element.set_visibility(visible)


def attribute(element: Element, name: str, value: str) -> None:
    """Set an attribute; nothing goes to the browser when it has that value already."""
    if element.props.get(name) != value:
        element.props[name] = value
        element.update()


def asked_of(element: Element, name: str) -> None:
    """Let whatever is pressed or typed inside of an element carry the name of the question that its
    browser showed then, which may be older than what is known here."""
    attribute(element, "data-asked", name)


_ASKED = "event.currentTarget.closest('[data-asked]')?.dataset.asked ?? ''"


def icon(name: str) -> Element:
    """A picture of ``look/icons.svg``; words beside it say what it means."""
    with box("svg", "icon", aria_hidden="true", viewBox="0 0 24 24") as drawing:
        box("use", href=f"/look/icons.svg#{name}")
    return drawing


class Button(Element):
    """A button that does one thing, once at a time, and tells what speaks against it.

    Args:
        label: its words.
        action: what it does; a ``CellctlError`` is shown to the one who pressed.
        kind: how much it stands out.
        picture: of ``icon``; none for words alone.
        classes: further ones.
    """

    def __init__(
        self,
        label: str,
        action: Action,
        *,
        kind: Kind = "plain",
        picture: str = "",
        classes: str = "",
    ) -> None:
        super().__init__("button")
        self.classes(f"button button--{kind} {classes}")
        self.props["type"] = "button"
        self._action = action
        self._enabled = True
        self._busy = False
        self.asked = ""
        """Name of the question that stood around it when it was pressed: see ``asked_of``."""
        with self:
            if picture:
                icon(picture)
            self.label = Text("span", label)
        self.on("click", self._pressed, js_handler=f"(event) => emit({_ASKED})")

    def enable(self, possible: bool) -> None:
        """Let it be pressed, or not."""
        if possible is not self._enabled:
            self._enabled = possible
            self.props["disabled"] = not possible
            self.update()

    async def _pressed(self, event: Any) -> None:
        if self._busy or not self._enabled:
            return
        self._busy, self.asked = True, str(event.args)
        try:
            await attempt(self, self._action)
        finally:
            self._busy = False


async def attempt(element: Element, action: Action) -> bool:
    """Do something for the one who looks at the page; tell why it is not done.

    Returns:
        Whether it was done.
    """
    try:
        await action()
    except CellctlError as error:
        why = str(error)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        why = f"{' '.join(map(str, first['loc']))}: {first['msg']}"
    else:
        return True
    if not element.is_deleted:
        with element:
            notice(why)
    return False


def notice(text: str) -> None:
    """Words that come up over the page, are read out, and go again."""
    ui.run_javascript(f"cellctl.notice({_quoted(text)})")


def _quoted(text: str) -> str:
    """A JavaScript string that ends no script element."""
    import json  # noqa: PLC0415

    return json.dumps(text).replace("</", "<\\/")


class Entry(Element):
    """A line to type into, with its button.

    Args:
        label: what is to be typed, for people and screen readers.
        button: words of the button.
        send: gets what was typed, and the name of the question that stood around it then; what it
            refuses stays in the line.
        longest: most characters.
        urgent: what does not wait for what was typed before it.
    """

    def __init__(
        self,
        label: str,
        button: str,
        send: Callable[[str, str], Awaitable[None]],
        longest: int,
        *,
        urgent: Callable[[str], bool] = lambda _text: False,
    ) -> None:
        super().__init__("form")
        self.classes("entry")
        self._send = send
        self._longest = longest
        self._urgent = urgent
        self._waiting: list[str] = []
        self._sending = asyncio.Lock()
        name = f"entry-{self.id}"
        with self:
            Text("label", label, "sr-only").props["for"] = name
            field: dict[str, Any] = {
                "type": "text",
                "name": "text",
                "placeholder": label,
                "maxlength": longest,
                "autocomplete": "off",
                "id": name,
            }
            self._input = ui.element("input").classes("entry__line")
            self._input.props.update(field)
            with box("button", "button button--plain entry__send", type="submit"):
                icon("send")
                Text("span", button, "sr-only")
        # The words stay until they were taken: they may have to be sent again.
        self.on(
            "submit.prevent",
            self._submitted,
            js_handler=f"(event) => emit([event.target.elements.text.value, {_ASKED}])",
        )
        self._input.on("input", js_handler="(event) => cellctl.typed(event.target)")
        ui.run_javascript(f"cellctl.typedBefore({_quoted(name)})")
        self._name = name

    def invite(self, label: str) -> None:
        """Say what may be typed."""
        attribute(self._input, "placeholder", label)

    async def _submitted(self, event: Any) -> None:
        typed, asked = map(str, event.args)
        text = typed.strip()[: self._longest]
        if not text:
            return
        if self._urgent(text):
            taken = await attempt(self, lambda: self._send(text, asked))
        elif text in self._waiting or len(self._waiting) >= _WAITING_MOST:
            return
        else:
            self._waiting.append(text)
            try:
                async with self._sending:
                    taken = await attempt(self, lambda: self._send(text, asked))
            finally:
                self._waiting.remove(text)
        if taken and not self.is_deleted:
            with self:
                ui.run_javascript(f"cellctl.taken({_quoted(self._name)}, {_quoted(text)})")
