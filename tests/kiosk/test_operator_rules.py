"""What the operator's view decides without a browser: access, remedies, replays, its words."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import re
import tomllib
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from cellctl.assembly import Cell, PartOutcome, Role, StepKind
from cellctl.control.about import SHOWN_LIMITS
from cellctl.control.possible import possible
from cellctl.errors import CATALOGUE, ConfigError, RefusedError, UsageError
from cellctl.kiosk import words as words_package
from cellctl.kiosk.operator import remedies
from cellctl.kiosk.operator.access import Access, TooSoonError
from cellctl.kiosk.operator.form import cells
from cellctl.kiosk.operator.replay import moments
from cellctl.kiosk.words import Words
from cellctl.messages import JobRecordData, JobSummary
from cellctl.passphrase import PassphraseHash
from tests.control.journals import tower

RIGHT = "a few words in a row"


class Clock:
    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@cache
def quick_hash() -> PassphraseHash:
    """A hash that is as cheap to try as one may be."""
    cost, salt = 2**10, b"sixteen of salt."
    digest = hashlib.scrypt(RIGHT.encode(), salt=salt, n=cost, r=8, p=1, dklen=32)
    kept = (base64.b64encode(part).decode() for part in (salt, digest))
    return PassphraseHash.read("$".join(("scrypt", str(cost), *kept)))


def access(clock: Clock) -> Access:
    return Access(quick_hash(), idle_s=600.0, now=clock)


def test_a_hash_tells_right_from_wrong_and_not_the_passphrase() -> None:
    line = PassphraseHash.of(RIGHT).line
    assert RIGHT not in line
    assert PassphraseHash.of(RIGHT).line != line
    assert PassphraseHash.read(line).fits(RIGHT)
    assert not PassphraseHash.read(line).fits(f"{RIGHT}s")
    with pytest.raises(UsageError, match="characters"):
        PassphraseHash.of("short")


@pytest.mark.parametrize("line", ["", RIGHT, "scrypt$32768$AAAA$BBBB", "md5$1$a$b"])
def test_what_is_no_hash_is_no_passphrase(line: str) -> None:
    with pytest.raises(ConfigError, match="keys passphrase"):
        PassphraseHash.read(line)


def test_guessing_gets_slower_and_one_address_does_not_lock_out_another() -> None:
    async def exercise() -> None:
        clock = Clock()
        door = access(clock)
        for _ in range(3):
            with pytest.raises(RefusedError, match="not the passphrase"):
                await door.log_in("wrong", "here")
        with pytest.raises(TooSoonError):
            await door.log_in(RIGHT, "here")
        assert await door.log_in(RIGHT, "elsewhere")
        clock.now_s += 2.1
        assert await door.log_in(RIGHT, "here")

    asyncio.run(exercise())


def test_a_session_ends_when_nothing_is_done_and_at_log_out() -> None:
    async def exercise() -> None:
        clock = Clock()
        door = access(clock)
        token = await door.log_in(RIGHT, "here")
        session = door.session(token)
        assert session is not None
        assert door.session(f"{token}x") is None
        clock.now_s = 599.0
        session.use()
        clock.now_s = 1198.0
        assert door.session(token) is session
        clock.now_s = 1200.0
        assert door.session(token) is None
        with pytest.raises(RefusedError, match="logged out"):
            session.use()
        other = await door.log_in(RIGHT, "here")
        door.log_out(other)
        assert door.session(other) is None

    asyncio.run(exercise())


@pytest.mark.parametrize("code", CATALOGUE)
def test_every_fault_has_buttons_that_do_its_remedy(code: str) -> None:
    entry, actions = CATALOGUE[code], remedies.REMEDIES[code]
    words = Words("en")
    assert all(words.say(f"act.{action}") for action in actions)
    # Where the fault leads, the first button works; where a reset leads, all others do.
    assert remedies.COMMANDS.get(actions[0], actions[0]) in possible(entry.leads_to)
    for action in actions:
        if action not in {"reset", "refill"}:
            assert remedies.COMMANDS.get(action, action) in possible("paused_resting")
    # What the remedy names is among the buttons.
    for plain in ("reset", "resume", "cancel"):
        assert not re.search(rf"\b{plain}\b", entry.remedy, re.IGNORECASE) or plain in actions
    known = {"hand": {"hand", "rise", "open_held"}, "inventory": {"count"}}
    for command in re.findall(r"`cellctl (\w+)", entry.remedy):
        if command not in remedies.IN_A_SHELL:
            assert known.get(command, {command}) & set(actions), command


def test_a_replay_has_what_stood_after_each_step() -> None:
    plan = tower(3)
    parts = (
        PartOutcome(step=0, cell=Cell(0, 0, 0), seconds=5.0, waited_s=0.0),
        PartOutcome(step=1, cell=Cell(0, 0, 1), seconds=6.0, waited_s=0.0, retries=1),
        PartOutcome(step=1, kind=StepKind.REMOVE, cell=Cell(0, 0, 1), seconds=4.0, waited_s=0.0),
    )
    told = moments(JobRecordData(job=summary(), plan=plan, parts=parts))
    assert [len(moment.standing) for moment in told] == [0, 1, 2, 1]
    assert [moment.seconds for moment in told] == [0.0, 5.0, 11.0, 15.0]
    assert told[2].retries == 1
    assert told[-1].planned == (Cell(0, 0, 1), Cell(0, 0, 2))
    assert moments(JobRecordData(job=summary())) == ()


def summary() -> JobSummary:
    return JobSummary(
        number=1,
        job_id="job",
        role=Role.VISITOR,
        began_at=datetime(2026, 5, 1, tzinfo=UTC),
        what="a tower",
        phase="building",
        outcome="cancelled",
        parts_done=2,
        steps=3,
        seconds=11.0,
        cellctl_version="1",
        config_sha256="0",
    )


def test_cells_are_read_as_people_type_them() -> None:
    words = Words("en")
    assert cells("2,3,0", words) == ((2, 3, 0),)
    assert cells("[2, 3, 0] [2 3 1]", words) == ((2, 3, 0), (2, 3, 1))
    for wrong in ("", "2,3", "here"):
        with pytest.raises(UsageError, match="names no cell"):
            cells(wrong, words)


def test_the_view_has_the_same_words_in_every_language() -> None:
    folder = Path(str(words_package.__file__)).parent / "operator"
    tables: dict[str, dict[str, dict[str, Any]]] = {
        file.stem: tomllib.loads(file.read_text(encoding="utf-8")) for file in folder.glob("*.toml")
    }
    fields = {
        language: {
            (table, name): sorted(re.findall(r"\{(\w+)\}", text))
            for table, lines in found.items()
            for name, text in lines.items()
        }
        for language, found in tables.items()
    }
    assert len(fields) >= 2
    assert all(found == fields["en"] for found in fields.values())


def test_every_limit_that_is_shown_has_its_name() -> None:
    words = Words("en")
    assert all(words.say(f"limit.{option.replace('.', '_')}") for option in SHOWN_LIMITS)
