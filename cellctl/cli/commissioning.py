"""The record of a cell's commissioning: who did it, when, with what, and what came of each step."""

from __future__ import annotations

import hashlib
from datetime import datetime
from pathlib import Path
from typing import Literal

from pydantic import ValidationError

from cellctl.assembling.arm import ArmIdentity
from cellctl.assembly import Value
from cellctl.cli.findings import Finding, ok, warning
from cellctl.config import CellConfig
from cellctl.errors import UsageError

_FILE = "commissioning.json"
_UNLIKE = frozenset({"cell", "hearing", "planning", "bus", "policy", "journal", "emulation"})
"""Tables that have nothing to do with where things are and how they move."""


class StepRecord(Value):
    """What came of one step."""

    name: str
    outcome: Literal["passed", "failed", "skipped"]
    note: str = ""


class CommissionRecord(Value):
    """One walk through a cell."""

    cell: str
    kind: Literal["real", "emulated"]
    time: datetime
    who: str
    version: str
    config_sha256: str
    """Of what the configuration says of geometry, tool and devices."""
    robot: ArmIdentity | None = None
    steps: tuple[StepRecord, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every step was done and passed."""
        return bool(self.steps) and all(step.outcome == "passed" for step in self.steps)


def record_path(config: CellConfig) -> Path:
    """Where a cell's record is: beside its journal."""
    return Path(config.journal.path).parent / _FILE


def fingerprint(config: CellConfig) -> str:
    """SHA-256 of what a commissioning has proved: where things are and how they move."""
    data = config.model_copy(
        update={"feeder": config.feeder.model_copy(update={"capacity_parts": 1})}
    ).model_dump_json(exclude=set(_UNLIKE))
    return hashlib.sha256(data.encode()).hexdigest()


def read_record(config: CellConfig) -> CommissionRecord | None:
    """The last record; None where there is none.

    Raises:
        UsageError: it cannot be read.
    """
    path = record_path(config)
    try:
        return CommissionRecord.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}.") from error
    except ValidationError as error:
        raise UsageError(
            f"{path}: is no record of a commissioning.", "Commission the cell anew."
        ) from error


def write_record(config: CellConfig, record: CommissionRecord) -> Path:
    """Write the record, whole or not at all.

    Raises:
        UsageError: it cannot be written.
    """
    path = record_path(config)
    draft = path.with_name(path.name + ".new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft.write_text(record.model_dump_json(indent=2) + "\n", encoding="utf-8")
        draft.replace(path)
    except OSError as error:
        raise UsageError(
            f"{path}: cannot be written: {error.strerror}.",
            "Ask as the daemon's user, for example with `sudo -u cellctl cellctl commission`.",
        ) from error
    return path


def commissioning(config: CellConfig) -> tuple[list[Finding], CommissionRecord | None]:
    """What the record says, for the doctor."""
    topic, anew = "commissioning", "Commission the cell: `cellctl commission`."
    try:
        record = read_record(config)
    except UsageError as error:
        return [warning(topic, error.message, error.hint or anew)], None
    if record is None:
        return [warning(topic, "this cell was never commissioned", anew)], None
    text = f"{record.time:%Y-%m-%d} by {record.who} with cellctl {record.version}"
    if not record.steps:
        return [warning(topic, f"{text}; no step was done", anew)], record
    open_steps = [step for step in record.steps if step.outcome != "passed"]
    if open_steps:
        names = "; ".join(f"{step.name} {step.outcome}: {step.note}" for step in open_steps)
        return [warning(topic, f"{text}; {names}", anew)], record
    if record.config_sha256 != fingerprint(config):
        changed = f"{text}; the configuration of geometry or devices has changed since"
        return [warning(topic, changed, anew)], record
    return [ok(topic, f"{text}: {len(record.steps)} steps passed")], record
