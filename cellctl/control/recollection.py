"""What the daemon remembers of its own life: its newest warnings, and who told it what."""

from __future__ import annotations

from collections import deque
from itertools import chain
from typing import Final

import structlog

from cellctl.assembly import Role
from cellctl.clock import Clock
from cellctl.messages import AuditData, AuditEntry, Command, LogData, LogEntry, LogsData

log = structlog.get_logger(__name__)

_ENTRIES: Final = 200
"""So many of each are kept; older ones are in the log."""
_LONGEST: Final = 300
"""Characters of one detail or message."""
_ASKS: Final = frozenset({"snapshot", "file", "history", "job", "about", "limits", "log", "audit"})
"""Commands that change nothing."""
_PRIVATE: Final = frozenset({"command", "text", "name"})
"""What somebody said or called a file is not kept."""


class Recollection:
    """The newest warnings, errors and commands.

    Args:
        clock: stamps them.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._logs: deque[LogEntry] = deque(maxlen=_ENTRIES)
        # Apart, so that however much visitors do, what operators did stays known.
        self._audit: dict[Role, deque[AuditEntry]] = {role: deque(maxlen=_ENTRIES) for role in Role}

    def logged(self, data: LogData) -> None:
        """A warning or an error was logged."""
        self._logs.append(LogEntry(time=self._clock.wall_time(), entry=data))

    def commanded(self, body: Command, role: Role, *, ok: bool, message: str) -> None:
        """A command was answered; an operator's goes to the log as well."""
        if body.command in _ASKS:
            return
        arguments = body.model_dump(mode="json", exclude=set(_PRIVATE), exclude_defaults=True)
        detail = ", ".join(f"{name}={value}" for name, value in arguments.items())[:_LONGEST]
        self._audit[role].append(
            AuditEntry(
                time=self._clock.wall_time(),
                role=role,
                command=body.command,
                detail=detail,
                ok=ok,
                message=message[:_LONGEST],
            )
        )
        if role is Role.OPERATOR:
            log.info("commanded", command=body.command, detail=detail, ok=ok)

    def logs(self) -> LogsData:
        """Warnings and errors."""
        return LogsData(entries=tuple(self._logs))

    def audit(self) -> AuditData:
        """Commands, in their order."""
        entries = sorted(chain(*self._audit.values()), key=lambda entry: entry.time)
        return AuditData(entries=tuple(entries))
