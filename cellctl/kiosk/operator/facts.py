"""Devices, versions and limits."""

from __future__ import annotations

from typing import Final

from nicegui.element import Element

from cellctl.config import unit_of
from cellctl.kiosk.components import Action, Button, Text, box
from cellctl.kiosk.operator.desk import Desk, lasting
from cellctl.messages import AboutData, AskCommand, LimitData, LimitsData

_UNITS: Final = {
    "metres": "m",
    "seconds": "s",
    "kilograms": "kg",
    "hertz": "Hz",
    "newtons": "N",
    "volts": "V",
    "metres per second": "m/s",
    "metres per second squared": "m/s²",
}


class Devices:
    """What the cell consists of."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._body = _section(desk, "devices", self.open)

    async def open(self) -> None:
        """Ask, and show."""
        about = await self._desk.ask(AskCommand(command="about"), AboutData)
        words = self._desk.words
        self._body.clear()
        with self._body:
            _table(
                tuple(words.say(f"devices.{name}") for name in _DEVICE_HEAD),
                tuple(
                    (
                        words.say(f"device.{device.name}"),
                        words.say("devices.yes" if device.connected else "devices.no"),
                        device.model,
                        device.version,
                        device.serial_number,
                        device.detail,
                    )
                    for device in about.devices
                ),
            )
            Text("h3", words.say("devices.shapes"), "label")
            _table(
                tuple(words.say(f"devices.{name}") for name in ("source", "where", "ready")),
                tuple(
                    (
                        source.name,
                        source.where or words.say("devices.here"),
                        words.say("devices.yes" if source.ready else "devices.no_key"),
                    )
                    for source in about.generators
                ),
            )
            Text("h3", words.say("devices.software"), "label")
            facts = {
                "cellctl": about.version,
                "Python": about.python,
                words.say("devices.recogniser"): f"{about.recogniser} ({about.language})",
                words.say("devices.understanding"): about.understanding
                or words.say("devices.rules"),
                words.say("devices.settings"): about.config_sha256[:12],
                words.say("devices.journal"): about.journal,
                words.say("devices.uptime"): lasting(words, about.uptime_s),
            }
            with box("dl", "facts"):
                for name, value in (facts | about.packages).items():
                    Text("dt", name)
                    Text("dd", value)


_DEVICE_HEAD: Final = ("device", "connected", "model", "version", "serial", "at")


class Limits:
    """What is configured, and what is in force."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._body = _section(desk, "limits", self.open)

    async def open(self) -> None:
        """Ask, and show."""
        limits = await self._desk.ask(AskCommand(command="limits"), LimitsData)
        words = self._desk.words
        self._body.clear()
        with self._body:
            _table(
                tuple(words.say(f"limits.{name}") for name in ("limit", "configured", "in_force")),
                tuple(
                    (
                        words.say(f"limit.{limit.option.replace('.', '_')}"),
                        shown_value(limit, limit.configured),
                        shown_value(limit, limit.in_force),
                    )
                    for limit in limits.limits
                ),
            )


def shown_value(limit: LimitData, value: float | str | None) -> str:
    """A value with its unit; empty for none."""
    if value is None:
        return ""
    text = value if isinstance(value, str) else f"{value:g}"
    if isinstance(value, str) and not value.replace(" x ", "").replace(".", "").isdigit():
        return text
    unit = unit_of(limit.option)
    return f"{text} {_UNITS.get(unit, unit)}".strip()


def _section(desk: Desk, name: str, again: Action) -> Element:
    say = desk.words.say
    with box("section", "panel", aria_labelledby=name):
        with box("div", "panel__head"):
            Text("h2", say(f"{name}.title"), "panel__title").props["id"] = name
            Button(say("history.refresh"), again, kind="quiet", picture="another")
        Text("p", say(f"{name}.what"), "small")
        return box("div", "panel__body")


def _table(head: tuple[str, ...], rows: tuple[tuple[str, ...], ...]) -> None:
    with box("div", "table", tabindex="0", role="region", aria_label=head[0]), box("table"):
        with box("thead"), box("tr"):
            for name in head:
                Text("th", name).props["scope"] = "col"
        with box("tbody"):
            for first, *rest in rows:
                with box("tr"):
                    Text("th", first).props["scope"] = "row"
                    for cell in rest:
                        Text("td", cell or "-")
