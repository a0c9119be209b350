"""Small forms: labelled fields and a button that sends what is in them."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from nicegui import ui
from nicegui.element import Element

from cellctl.errors import UsageError
from cellctl.kiosk.components import Kind, Text, attempt, box
from cellctl.kiosk.words import Words

Values = dict[str, str]
"""What is in the fields, by their names."""


@dataclass(frozen=True)
class Field:
    """One field of a form."""

    name: str
    label: str
    kind: str = "number"
    """``number`` or ``text``."""
    value: str = ""
    least: float | None = None
    most: float | None = None
    step: str = "1"
    hint: str = ""
    """Shown in an empty field."""


class Form(Element):
    """Fields in a row, and what is done with them.

    Args:
        words: in the page's language.
        fields: from left to right.
        button: words of the button.
        send: gets what is in the fields.
        kind: of the button.
        clears: whether the fields are empty again afterwards.
    """

    def __init__(
        self,
        words: Words,
        fields: tuple[Field, ...],
        button: str,
        send: Callable[[Values], Awaitable[None]],
        *,
        kind: Kind = "plain",
        clears: bool = True,
    ) -> None:
        super().__init__("form")
        self.classes("form")
        self._send = send
        self._words = words
        self._sending = asyncio.Lock()
        with self:
            for field in fields:
                self._add(field)
            with box("button", f"button button--{kind}", type="submit") as self._button:
                Text("span", button)
        emptying = " event.target.reset();" if clears else ""
        self.on(
            "submit.prevent",
            self._submitted,
            js_handler="(event) => { emit(Object.fromEntries(new FormData(event.target)));"
            f"{emptying} }}",
        )

    def _add(self, field: Field) -> None:
        name = f"field-{self.id}-{field.name}"
        with box("div", "form__field"):
            Text("label", field.label, "label").props["for"] = name
            line = ui.element("input").classes("field")
            limits = {"min": field.least, "max": field.most, "step": field.step}
            line.props.update(
                {"id": name, "name": field.name, "type": field.kind, "autocomplete": "off"}
                | ({"value": field.value} if field.value else {})
                | ({"placeholder": field.hint} if field.hint else {})
                | (
                    {key: value for key, value in limits.items() if value is not None}
                    if field.kind == "number"
                    else {"maxlength": 200}
                )
            )

    def enable(self, possible: bool) -> None:
        """Let it be sent, or not."""
        if bool(self._button.props.get("disabled")) is possible:
            self._button.props["disabled"] = not possible
            self._button.update()

    async def _submitted(self, event: Any) -> None:
        values = {str(name): str(value).strip() for name, value in dict(event.args).items()}
        async with self._sending:
            await attempt(self, lambda: self._send(values))


def whole(values: Values, name: str, words: Words) -> int | None:
    """A whole number of a form; None where the field is empty.

    Raises:
        UsageError: it is none.
    """
    text = values.get(name, "")
    if not text:
        return None
    try:
        return int(text)
    except ValueError:
        raise UsageError(words.say("form.no_number", text=text)) from None


def number(values: Values, name: str, words: Words) -> float:
    """A number of a form; 0 where the field is empty.

    Raises:
        UsageError: it is none.
    """
    text = values.get(name, "")
    try:
        return float(text) if text else 0.0
    except ValueError:
        raise UsageError(words.say("form.no_number", text=text)) from None


def cells(text: str, words: Words) -> tuple[tuple[int, int, int], ...]:
    """Cells as people type them: ``2,3,0`` or ``[2, 3, 0] [2, 3, 1]``.

    Raises:
        UsageError: they are none.
    """
    numbers = text.replace("[", " ").replace("]", " ").replace(",", " ").split()
    try:
        found = [int(part) for part in numbers]
    except ValueError:
        found = []
    if not found or len(found) % 3:
        raise UsageError(words.say("form.no_cell", text=text))
    return tuple((found[i], found[i + 1], found[i + 2]) for i in range(0, len(found), 3))
