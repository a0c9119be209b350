"""Death at any point: what was acknowledged is there, and at most one act more."""

from __future__ import annotations

import asyncio
import random
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.control.acts import ActKind
from cellctl.control.journal_reader import JournalReader
from cellctl.control.journal_store import SqliteJournal
from cellctl.feeding.inventory import InventoryError, Move
from tests.control.journals import CELLS, FIRST, belief, files, opened, record

Choice = tuple[str, int]

choices = st.tuples(
    st.sampled_from(["intend", "settle", "settle", "record", "count", "own", "job", "prune"]),
    st.integers(0, 10_000),
)
KINDS = [ActKind.FEED, ActKind.PICK, ActKind.PLACE, ActKind.RELEASE]
BY_HAND = [Move.LAY, Move.TAKE_OUT, Move.FIND, Move.SCRAP, Move.SCRAP_GRIPPED]


async def do(journal: SqliteJournal, choice: Choice) -> None:
    """One thing that happens to a cell; what cannot be is refused and leaves no trace."""
    what, number = choice
    unsettled = journal.unsettled()
    counts = journal.ledger.counts
    with suppress(InventoryError):
        if what == "intend" and len(unsettled) < 2:
            cell = CELLS[number % len(CELLS)]
            await journal.intend(KINDS[number % len(KINDS)], "job", number % 9, cell)
        elif what == "settle" and unsettled:
            act = unsettled[number % len(unsettled)]
            moves = {ActKind.PICK: (Move.PICK,), ActKind.RELEASE: (Move.PLACE,)}
            journal.settle(act.act_id, "done", str(number), moves.get(act.kind, ()))
        elif what == "record":
            await journal.record(ActKind.SETTLE, moves=(BY_HAND[number % len(BY_HAND)],))
        elif what == "count":
            await journal.record(ActKind.COUNT, counts=counts.counted(belt=number % 30))
        elif what == "own":
            await journal.record(ActKind.OWN, counts=counts.owning(counts.total + number % 3))
        elif what == "job":
            journal.keep_job(record(phase=str(number)), files(number, 50))
        elif what == "prune":
            await journal.prune(0.0001, 1)
    await journal.flush()


@settings(max_examples=15, deadline=None)
@given(st.lists(choices, min_size=1, max_size=25), st.data())
def test_a_file_cut_off_at_any_byte_tells_what_was_acknowledged(
    tmp_path_factory: pytest.TempPathFactory, history: list[Choice], data: st.DataObject
) -> None:
    """SQLite only appends to its log between checkpoints: cutting the log off at a byte is what a
    loss of power at that moment leaves. Around a pruning, which is a checkpoint, the files are
    taken as they are."""
    folder = tmp_path_factory.mktemp("crash")
    path = folder / "journal.db"
    log = path.with_name("journal.db-wal")
    moments: list[tuple[bytes, bytes, dict[str, Any]]] = []

    async def live() -> None:
        async with opened(path) as journal:
            moments.append((path.read_bytes(), log.read_bytes(), belief(journal)))
            for choice in history:
                await do(journal, choice)
                moments.append((path.read_bytes(), log.read_bytes(), belief(journal)))

    async def live_again() -> dict[str, Any]:
        async with opened(path) as journal:
            return belief(journal)

    asyncio.run(live())
    index = data.draw(st.integers(0, len(moments) - 1), "moment")
    before_file, before_log, before = moments[index]
    after_file, after_log, after = moments[min(index + 1, len(moments) - 1)]
    if after_file == before_file and after_log.startswith(before_log):
        cut = data.draw(st.integers(len(before_log), len(after_log)), "cut")
        log.write_bytes(after_log[:cut])
        whole = cut == len(after_log)
    else:
        log.write_bytes(before_log)
        whole = False
    path.write_bytes(before_file)
    found = asyncio.run(live_again())
    assert found == after if whole else found in (before, after)


def test_a_writer_that_is_killed_loses_nothing(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"
    chance = random.Random(3)  # noqa: S311 - a test
    acknowledged = 0
    for _ in range(3):
        with subprocess.Popen(
            [sys.executable, "-m", "tests.control.journal_life", str(path)],
            stdout=subprocess.PIPE,
        ) as writer:
            assert writer.stdout is not None
            for _ in range(chance.randint(1, 60)):
                acknowledged = int(writer.stdout.readline())
            writer.kill()
            rest = writer.stdout.read().split(b"\n")[:-1]  # what it said before it died
            acknowledged = max([acknowledged, *map(int, rest)])
        with JournalReader(path) as reader:
            found = reader.check()
        assert found.acts in (acknowledged, acknowledged + 1)
        assert found.ledger.counts.total == FIRST.total
