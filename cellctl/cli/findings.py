"""What ``cellctl doctor`` finds out: one finding a line, with what to do about it."""

from __future__ import annotations

from datetime import datetime
from enum import StrEnum

from cellctl.assembly import Value


class Level(StrEnum):
    """How a finding is to be taken."""

    OK = "ok"
    """As it should be."""
    WARNING = "warning"
    """The cell runs; something is worth a look."""
    PROBLEM = "problem"
    """The cell does not run, or not safely, until this is put right."""


class Finding(Value):
    """One thing that was looked at."""

    topic: str
    level: Level
    found: str
    """What was found, in a sentence."""
    advice: str = ""
    """What to do; empty where nothing is."""


class DoctorReport(Value):
    """All findings of one run."""

    time: datetime
    version: str
    config: str
    """The configuration file that was used; empty where there is none."""
    findings: tuple[Finding, ...]

    @property
    def healthy(self) -> bool:
        """Whether nothing is a problem."""
        return all(finding.level is not Level.PROBLEM for finding in self.findings)


def ok(topic: str, found: str) -> Finding:
    """Something is as it should be."""
    return Finding(topic=topic, level=Level.OK, found=found)


def warning(topic: str, found: str, advice: str = "") -> Finding:
    """Something is worth a look."""
    return Finding(topic=topic, level=Level.WARNING, found=found, advice=advice)


def problem(topic: str, found: str, advice: str = "") -> Finding:
    """Something must be put right."""
    return Finding(topic=topic, level=Level.PROBLEM, found=found, advice=advice)
