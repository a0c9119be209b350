"""What the daemon says of itself: warnings and errors, and who commanded what."""

from __future__ import annotations

from cellctl.kiosk.components import Button, Text, box, shown
from cellctl.kiosk.operator.desk import Desk
from cellctl.kiosk.operator.history import when
from cellctl.messages import AskCommand, AuditData, LogsData


class Records:
    """Two lists, the newest first."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        say = desk.words.say
        with box("div", "grid"):
            with box("section", "panel", aria_labelledby="logs"):
                with box("div", "panel__head"):
                    Text("h2", say("records.logs"), "panel__title").props["id"] = "logs"
                    Button(say("history.refresh"), self.open, kind="quiet", picture="another")
                Text("p", say("records.logs_what"), "small")
                self._none = Text("p", say("records.none"), "small")
                self._logs = box("ol", "lines", tabindex="0")
            with box("section", "panel", aria_labelledby="audit"):
                Text("h2", say("records.audit"), "panel__title").props["id"] = "audit"
                Text("p", say("records.audit_what"), "small")
                self._audit = box("ol", "lines", tabindex="0")

    async def open(self) -> None:
        """Ask for both, and show them."""
        logs = await self._desk.ask(AskCommand(command="log"), LogsData)
        audit = await self._desk.ask(AskCommand(command="audit"), AuditData)
        words = self._desk.words
        shown(self._none, not logs.entries)
        self._logs.clear()
        with self._logs:
            for entry in reversed(logs.entries):
                with box("li", f"line line--{entry.entry.level}"):
                    Text("span", when(entry.time), "line__time")
                    Text("span", words.say(f"records.{entry.entry.level}"), "tag")
                    Text("span", entry.entry.message, "line__text")
        self._audit.clear()
        with self._audit:
            for command in reversed(audit.entries):
                with box("li", "line"):
                    Text("span", when(command.time), "line__time")
                    Text("span", words.say(f"records.{command.role}"), "tag")
                    said = f"{command.command} {command.detail}".strip()
                    Text("span", said, "line__text")
                    answer = command.message or words.say("records.done")
                    Text("span", answer, "line__answer" if command.ok else "line__answer--no")
