"""Where the parts are, and what people say of them: refilled, counted, missing, handed over."""

from __future__ import annotations

from typing import Final

from cellctl.assembly import Cell
from cellctl.kiosk.components import Button, Text, attribute, box, shown
from cellctl.kiosk.operator.desk import Desk
from cellctl.kiosk.operator.form import Field, Form, Values, cells, whole
from cellctl.kiosk.operator.now import order
from cellctl.messages import (
    CountCommand,
    MissingCommand,
    OwnCommand,
    RefillCommand,
)

PLACES: Final = ("belt", "gripper", "structure", "stock", "handed_over", "scrap", "unknown")
"""In the order of a part's life."""
COUNTED: Final = ("belt", "stock", "handed_over", "scrap")
"""What people can count; the rest the cell knows by itself."""


class Parts:
    """The inventory, and its corrections."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        say = desk.words.say
        with box("div", "grid grid--two"):
            with box("section", "panel panel--wide", aria_labelledby="inventory"):
                Text("h2", say("parts.inventory"), "panel__title").props["id"] = "inventory"
                with box("div", "shares", aria_hidden="true"):
                    self._shares = {place: box("span", f"share share--{place}") for place in PLACES}
                with box("dl", "counts"):
                    self._counts = {place: self._count(place) for place in PLACES}
            self._belt_panel()
            self._workspace_panel()
            self._counting_panel()

    def _count(self, place: str) -> Text:
        with box("div", f"count count--{place}"):
            Text("dt", self._desk.words.say(f"at.{place}"))
            return Text("dd", "", "count__number")

    def _belt_panel(self) -> None:
        desk, say = self._desk, self._desk.words.say
        with box("section", "panel", aria_labelledby="refill"):
            Text("h2", say("parts.refill"), "panel__title").props["id"] = "refill"
            Text("p", say("parts.refill_what"), "small")
            self._refill = Form(
                desk.words,
                (Field("parts", say("parts.how_many"), least=1, most=1000, hint=say("parts.all")),),
                say("act.refill"),
                self._refilled,
            )

    def _workspace_panel(self) -> None:
        desk, say = self._desk, self._desk.words.say
        with box("section", "panel", aria_labelledby="workspace"):
            Text("h2", say("parts.workspace"), "panel__title").props["id"] = "workspace"
            self._standing = Text("p", "", "small")
            with box("div", "row"):
                self._workspace = {
                    name: Button(
                        say(f"act.{name}"), desk.asking_first(name, desk.ordering(order(name)))
                    )
                    for name in ("take_apart", "clear", "hand_over")
                }
            self._missing = Form(
                desk.words,
                (Field("cells", say("parts.missing"), "text", hint="2,3,0"),),
                say("act.missing"),
                self._is_missing,
            )

    def _counting_panel(self) -> None:
        desk, say = self._desk, self._desk.words.say
        with box("section", "panel panel--wide", aria_labelledby="counting"):
            Text("h2", say("parts.counting"), "panel__title").props["id"] = "counting"
            Text("p", say("parts.counting_what"), "small")
            note = Field("note", say("parts.note"), "text")
            fields = (*(Field(name, say(f"at.{name}"), least=0) for name in COUNTED), note)
            self._counting = Form(desk.words, fields, say("act.count"), self._counted)
            self._owning = Form(
                desk.words,
                (Field("parts", say("parts.own"), least=1, most=1000),),
                say("act.own"),
                self._owned,
            )

    async def _refilled(self, values: Values) -> None:
        await self._desk.order(RefillCommand(parts=whole(values, "parts", self._desk.words)))

    async def _is_missing(self, values: Values) -> None:
        found = cells(values.get("cells", ""), self._desk.words)
        await self._desk.order(MissingCommand(cells=tuple(Cell(*cell) for cell in found)))

    async def _counted(self, values: Values) -> None:
        counted = {name: whole(values, name, self._desk.words) for name in COUNTED}
        body = CountCommand.model_validate({**counted, "note": values.get("note", "")})
        await self._desk.order(body)

    async def _owned(self, values: Values) -> None:
        words = self._desk.words
        parts = whole(values, "parts", words)
        if parts is None:
            return

        async def tell() -> None:
            await self._desk.order(OwnCommand(parts=parts))

        sentence = words.say("sure.own", parts=parts)
        await self._desk.asking_first("own", tell, lambda: sentence)()

    def show(self) -> None:
        """Show the parts as they are known now."""
        desk, snapshot = self._desk, self._desk.snapshot
        counts = snapshot.inventory if snapshot is not None else {}
        total = max(1, sum(counts.values()))
        for place in PLACES:
            count = counts.get(place, 0)
            self._counts[place].say(str(count) if snapshot is not None else "-")
            attribute(self._shares[place], "style", f"flex-grow: {count / total:.3f}")
            shown(self._shares[place], count > 0)
        standing = len(snapshot.standing) if snapshot is not None else 0
        self._standing.say(desk.words.say("parts.standing", count=standing))
        for name, button in self._workspace.items():
            button.enable(desk.takes(name) and standing > 0)
        self._refill.enable(desk.takes("refill"))
        self._missing.enable(desk.takes("missing") and standing > 0)
        self._counting.enable(desk.takes("count"))
        self._owning.enable(desk.takes("own"))
