"""What the page believes of the cell, message by message."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime

from cellctl.assembly import Cell, PartOutcome, StepKind, Value
from cellctl.kiosk.mirror import Mirror, Sequence
from cellctl.messages import (
    TOPIC_OF,
    ArmData,
    ConveyorData,
    FaultData,
    GripperData,
    HealthData,
    LogData,
    PartData,
    Snapshot,
    StateData,
    StatusMessage,
    VoiceData,
)
from cellctl.notices import NOTICES

PATIENCE_S = 30.0


def snapshot(seq: int = 1, **changes: object) -> Snapshot:
    """A cell that is idle."""
    whole = Snapshot(
        seq=seq,
        version="1",
        cell="cell",
        kind="emulated",
        grid=(6, 5, 6),
        state=StateData(state="idle", previous="starting", event="started"),
        job=None,
        plan=None,
        parts=(),
        standing=(),
        inventory={},
        arm=ArmData(connected=False),
        conveyor=ConveyorData(connected=True),
        gripper=GripperData(holding="nothing"),
        fault=FaultData(),
        health=HealthData(uptime_s=1.0, loop_blocked_p99_s=0.0, loop_blocked_max_s=0.0, inbox=0),
        recogniser="none",
    )
    return whole.model_copy(update=changes)


def message(data: Value, seq: int = 2) -> StatusMessage:
    """One message of the bus."""
    return StatusMessage(
        seq=seq,
        time=datetime(2026, 1, 1, tzinfo=UTC),
        cell_time_s=1.0,
        state="idle",
        topic=TOPIC_OF[type(data)],
        data=data.model_dump(mode="json"),
    )


def in_loop(mirror: Mirror, work: Callable[[], None]) -> None:
    """Run something that changes the mirror, and wait until all who watch it were told."""

    async def run() -> None:
        told = asyncio.Event()
        unwatch = mirror.watch(told.set)
        work()
        await asyncio.wait_for(told.wait(), PATIENCE_S)
        unwatch()

    asyncio.run(run())


def test_messages_in_their_order_are_taken_and_lost_ones_are_noticed() -> None:
    sequence = Sequence()
    sequence.snapshot(10)
    # What was sent before the snapshot was made arrives after it.
    assert [sequence.place(seq) for seq in (9, 10, 11, 12)] == ["known", "known", "next", "next"]
    assert sequence.place(14) == "gap"
    sequence.snapshot(15)
    assert [sequence.place(seq) for seq in (15, 16)] == ["known", "next"]


def test_a_daemon_that_begins_to_count_anew_is_noticed() -> None:
    sequence = Sequence()
    sequence.snapshot(500)
    assert sequence.place(501) == "next"
    assert sequence.place(1) == "gap"
    sequence.snapshot(3)
    assert [sequence.place(seq) for seq in (2, 3, 4)] == ["known", "known", "next"]


def test_a_lost_loudspeaker_is_known_at_once() -> None:
    mirror = Mirror(2.0)

    def hear() -> None:
        mirror.take_snapshot(snapshot())
        mirror.take(message(VoiceData(state="lost", notice=NOTICES["loudspeaker_lost"])))

    in_loop(mirror, hear)
    assert mirror.snapshot is not None
    assert mirror.snapshot.voice.notice == NOTICES["loudspeaker_lost"]


def test_parts_come_and_go() -> None:
    mirror = Mirror(2.0)

    def part(kind: StepKind) -> StatusMessage:
        outcome = PartOutcome(step=0, kind=kind, cell=Cell(1, 2, 0), seconds=7.0, waited_s=0.0)
        return message(PartData(job_id="1", outcome=outcome, placed=1, total=2))

    def stands() -> set[Cell]:
        return set(mirror.snapshot.standing) if mirror.snapshot is not None else set()

    def work() -> None:
        mirror.take_snapshot(snapshot())
        mirror.take(part(StepKind.PLACE))
        assert stands() == {Cell(1, 2, 0)}
        mirror.take(part(StepKind.REMOVE))
        assert stands() == set()

    in_loop(mirror, work)


def test_what_is_shown_is_stale_after_a_silence() -> None:
    now = [100.0]
    mirror = Mirror(2.0, now=lambda: now[0])
    seen: list[tuple[bool, float]] = [(mirror.stale, mirror.age_s)]

    def work() -> None:
        mirror.take_snapshot(snapshot())
        seen.append((mirror.stale, mirror.age_s))
        now[0] += 5.0
        seen.append((mirror.stale, mirror.age_s))

    in_loop(mirror, work)
    assert seen == [(True, float("inf")), (False, 0.0), (True, 5.0)]


def test_many_changes_are_told_once_and_one_page_cannot_keep_them_from_another() -> None:
    mirror = Mirror(2.0)
    told: list[str] = []

    def broken() -> None:
        raise ValueError("this page is broken")

    mirror.watch(broken)
    unwatch = mirror.watch(lambda: told.append("told"))

    def work() -> None:
        mirror.take_snapshot(snapshot())
        for text in "abc":
            mirror.take(message(LogData(level="warning", message=text)))

    in_loop(mirror, work)
    assert told == ["told"]
    assert [data.message for _, data in mirror.logs] == ["a", "b", "c"]
    unwatch()
    in_loop(mirror, work)
    assert told == ["told"]
