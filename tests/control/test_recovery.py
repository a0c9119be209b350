"""What becomes of acts that were cut off: every combination of evidence, belief and act."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import NamedTuple, get_args

import pytest

from cellctl.assembling.poses import to_matrix, to_pose
from cellctl.assembly import Cell
from cellctl.control.acts import Act, ActKind
from cellctl.control.ledger import Ledger
from cellctl.control.recovery import Doubt, Evidence, Settlement, moves_to, settle, stayed
from cellctl.feeding.inventory import Counts, Move
from cellctl.messages import PartPlace

NOW = datetime(2026, 5, 1, tzinfo=UTC)
HERE, BELOW = Cell(1, 0, 1), Cell(1, 0, 0)
PICKED_AT = 7
"""The board's counter when the part in the gripper was picked."""
PLACES: tuple[PartPlace, ...] = get_args(PartPlace)

EMPTY = Ledger(counts=Counts(stock=3, belt=4, structure=1), standing=frozenset({BELOW}))
MISSED = EMPTY.model_copy(update={"missed": True})
HELD = Ledger(
    counts=Counts(stock=3, belt=3, gripper=1, structure=1),
    standing=frozenset({BELOW}),
    belt_indexes=PICKED_AT,
)
UNCHECKED = HELD.model_copy(update={"lift_unchecked": True})
UNCOUNTED = UNCHECKED.model_copy(update={"belt_indexes": None})
STANDING = Ledger(counts=Counts(stock=3, belt=3, structure=2), standing=frozenset({BELOW, HERE}))
GRIPPED = STANDING.model_copy(update={"gripped": HERE})
LEDGERS = (EMPTY, MISSED, HELD, UNCHECKED, UNCOUNTED, STANDING, GRIPPED)
PARTS_IN_PLAY = 5
"""On the belt, in the gripper and in the structure, in every one of them."""


def act(kind: ActKind, act_id: int = 5) -> Act:
    """An act that was cut off on the way of a part to ``HERE``."""
    return Act(act_id=act_id, kind=kind, job_id="job", step=1, cell=HERE, intended_at=NOW)


def evidence(**said: bool | int) -> Evidence:
    """What the devices say: nothing latched, the arm nowhere in particular, no part in sight."""
    nothing = dict.fromkeys(
        ("latched", "told_open", "at_station", "at_cell", "risen", "part_at_station"), False
    )
    return Evidence.model_validate({**nothing, "belt_indexes": PICKED_AT, **said})


def all_evidence() -> Iterator[Evidence]:
    """Everything that devices can say; the arm is in one place at a time."""
    arm: tuple[dict[str, bool], ...] = (
        {"at_station": True},
        {"at_cell": True},
        {"risen": True},
        {},
    )
    for latched, told_open, part, indexes, where in itertools.product(
        (False, True), (False, True), (False, True), (0, PICKED_AT, PICKED_AT + 1), arm
    ):
        yield evidence(
            latched=latched,
            told_open=told_open,
            part_at_station=part,
            belt_indexes=indexes,
            **where,
        )


def all_cut_off(ledger: Ledger) -> Iterator[tuple[Act, ...]]:
    """What can be cut off by what is believed: an arm that holds a part picks no other, and one
    that holds none lets none go. A movement by hand may come on top."""
    kinds = [ActKind.FEED, ActKind.PLACE, ActKind.RETREAT, ActKind.HAND]
    if ledger.gripped is not None:
        kinds.append(ActKind.TAKE_OFF)
    elif HERE in ledger.standing:
        kinds.append(ActKind.GRIP)
    else:
        kinds.append(ActKind.RELEASE if ledger.holding else ActKind.PICK)
    yield ()
    yield from ((act(kind),) for kind in kinds)
    if ledger.holding and not ledger.lift_unchecked:
        yield act(ActKind.RETURN), act(ActKind.PUT_BACK, 6)
    yield act(kinds[-1]), act(ActKind.HAND, 6)


def believed_after(ledger: Ledger, cut_off: tuple[Act, ...], settled: Settlement) -> Ledger:
    """The ledger after everything that was decided, as the journal folds it."""
    acts = {entry.act_id: entry for entry in cut_off}
    for one in settled.acts:
        ledger = ledger.after(
            acts[one.act_id].model_copy(
                update={
                    "outcome": one.outcome,
                    "moves": one.moves,
                    "belt_indexes": one.belt_indexes,
                }
            )
        )
    if settled.missed:
        ledger = ledger.after(_settle_act(Move.MISS))
    return ledger


def answered(ledger: Ledger, cut_off: tuple[Act, ...], doubt: Doubt, part: PartPlace) -> Ledger:
    """The ledger after an operator has said where the part is."""
    outcome, moves = moves_to(doubt, part)
    if doubt.act_id is None:
        return ledger.after(_settle_act(*moves)) if moves else ledger
    (open_act,) = (entry for entry in cut_off if entry.act_id == doubt.act_id)
    return ledger.after(open_act.model_copy(update={"outcome": outcome, "moves": moves}))


def _settle_act(*moves: Move) -> Act:
    return Act(
        act_id=9, kind=ActKind.SETTLE, cell=HERE, intended_at=NOW, outcome="done", moves=moves
    )


class Case(NamedTuple):
    """One combination, what was decided, and what is believed then."""

    ledger: Ledger
    cut_off: tuple[Act, ...]
    seen: Evidence
    settled: Settlement
    after: Ledger


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    """All combinations."""
    found = []
    for ledger in LEDGERS:
        for cut_off, seen in itertools.product(all_cut_off(ledger), all_evidence()):
            settled = settle(ledger, cut_off, seen, part="Part 2")
            after = believed_after(ledger, cut_off, settled)
            found.append(Case(ledger, cut_off, seen, settled, after))
    assert len(found) > 3000
    return found


def test_every_act_is_settled_once_or_is_the_one_in_doubt(cases: list[Case]) -> None:
    for case in cases:
        doubt = case.settled.doubt
        done = [one.act_id for one in case.settled.acts]
        if doubt is not None and doubt.act_id is not None:
            done.append(doubt.act_id)
        assert sorted(done) == [entry.act_id for entry in case.cut_off], case


def test_whatever_is_decided_no_part_is_lost_doubled_or_in_two_places(cases: list[Case]) -> None:
    for case in cases:
        counts = case.after.counts
        assert counts.total == case.ledger.counts.total, case
        assert len(case.after.standing) == counts.structure, case
        assert counts.belt + counts.gripper + counts.structure == PARTS_IN_PLAY, case
        if case.settled.lifted:
            assert case.after.holding, case
            assert not case.settled.missed, case


def test_a_part_counts_as_held_only_while_the_latch_confirms_it_or_is_doubted(
    cases: list[Case],
) -> None:
    for case in cases:
        if case.after.holding and not case.seen.latched:
            assert case.settled.doubt is not None, case


def test_a_part_that_the_latch_confirms_never_counts_as_placed(cases: list[Case]) -> None:
    for case in cases:
        if case.seen.latched:
            moves = [move for one in case.settled.acts for move in one.moves]
            assert Move.PLACE not in moves, case


def test_a_doubt_says_what_is_believed_and_every_answer_obeys_the_law(cases: list[Case]) -> None:
    doubted = [case for case in cases if case.settled.doubt is not None]
    assert len(doubted) > 100
    for case, part in itertools.product(doubted, PLACES):
        doubt, before = case.settled.doubt, case.after.counts
        assert doubt is not None
        assert "art 2" in doubt.sentence
        assert doubt.believed in PLACES
        after = answered(case.after, case.cut_off, doubt, part)
        assert after.counts.total == case.ledger.counts.total, (case, part)
        assert after.holding == (part == "gripper"), (case, part)
        assert (HERE in after.standing) == (part == "cell"), (case, part)
        stood = HERE in case.after.standing
        # Wherever it counts now, it is one of these.
        in_doubt = before.belt + before.gripper + stood
        rest = after.counts
        assert rest.belt + rest.gripper == in_doubt - (part not in {"gripper", "station"})
        assert rest.stock - before.stock == (part == "stock"), (case, part)
        assert (rest.scrap, rest.unknown) == (part == "scrap", part == "unknown"), (case, part)


PICK, PLACE, RELEASE = act(ActKind.PICK), act(ActKind.PLACE), act(ActKind.RELEASE)
GRIP, TAKE_OFF, PUT_BACK = act(ActKind.GRIP), act(ActKind.TAKE_OFF), act(ActKind.PUT_BACK)


@pytest.mark.parametrize(
    ("ledger", "cut_off", "seen", "moves", "because"),
    [
        # The belt or the arm was under way: nothing changed hands.
        (EMPTY, act(ActKind.FEED), evidence(part_at_station=True), (), "cut off"),
        (EMPTY, act(ActKind.FEED), evidence(), (), "cut off"),
        (HELD, PLACE, evidence(latched=True, risen=True), (), "cut off"),
        (EMPTY, act(ActKind.RETREAT), evidence(told_open=True, risen=True), (), "cut off"),
        # The latch was closing at the station.
        (EMPTY, PICK, evidence(latched=True, at_station=True), (Move.PICK, Move.MISS),
         "where no part lay"),
        (EMPTY, PICK, evidence(latched=True, at_station=True, part_at_station=True), (Move.PICK,),
         "confirmed"),
        (EMPTY, PICK, evidence(told_open=True, at_station=True, part_at_station=True), (),
         "before the latch closed"),
        (EMPTY, PICK, evidence(at_station=True, part_at_station=True), (),
         "before the latch closed"),
        (EMPTY, PICK, evidence(told_open=True), (), "before the latch closed"),
        # The latch was closing on a part that stands, or the arm was parting it.
        (STANDING, GRIP, evidence(latched=True, at_cell=True), (), "confirmed at the cell"),
        (STANDING, GRIP, evidence(told_open=True, at_cell=True), (), "before the latch closed"),
        (STANDING, GRIP, evidence(latched=True, risen=True), (), "before the latch closed"),
        (GRIPPED, TAKE_OFF, evidence(latched=True, at_cell=True), (), "before the part was parted"),
        (GRIPPED, TAKE_OFF, evidence(told_open=True, at_cell=True), (), "before the part"),
        (GRIPPED, TAKE_OFF, evidence(latched=True), (Move.TAKE_OFF,), "off the cell"),
        # The latch was opening where the part goes back to the belt.
        (HELD, PUT_BACK, evidence(latched=True, at_station=True), (), "before the latch opened"),
        (HELD, PUT_BACK, evidence(told_open=True, at_station=True), (Move.PUT_BACK,), "at the"),
        # The latch was opening at the cell.
        (HELD, RELEASE, evidence(latched=True, at_cell=True), (), "before the latch opened"),
        (HELD, RELEASE, evidence(told_open=True, at_cell=True), (Move.PLACE,), "told to open"),
    ],
)  # fmt: skip
def test_what_the_devices_can_tell_is_decided(
    ledger: Ledger, cut_off: Act, seen: Evidence, moves: tuple[Move, ...], because: str
) -> None:
    settled = settle(ledger, (cut_off,), seen, part="Part 15")
    assert settled.doubt is None
    assert not settled.missed
    (one,) = settled.acts
    assert one.moves == moves
    assert because in one.detail


def test_a_part_whose_letting_go_was_cut_off_is_not_known_to_be_free() -> None:
    seen = evidence(told_open=True, at_cell=True)
    after = believed_after(HELD, (RELEASE,), settle(HELD, (RELEASE,), seen, part="Part 15"))
    assert (after.gripped, after.holding, HERE in after.standing) == (HERE, False, True)


def test_a_latch_that_closed_unconfirmed_on_what_stands_may_have_hold_of_it() -> None:
    settled = settle(STANDING, (GRIP,), evidence(at_cell=True), part="Part 15")
    assert believed_after(STANDING, (GRIP,), settled).gripped == HERE


@pytest.mark.parametrize(("turn_rad", "there"), [(0.0, True), (0.01, True), (0.05, False)])
def test_a_twist_about_the_tool_is_off_the_cell_though_the_tcp_has_not_moved(
    turn_rad: float, there: bool
) -> None:
    at = (0.5, 0.2, 0.3, math.pi, 0.0, 0.0)
    twisted = to_pose(to_matrix(at) @ to_matrix((0.0, 0.0, 0.0, 0.0, 0.0, turn_rad)))
    assert stayed(twisted, at) is there


@pytest.mark.parametrize(
    ("ledger", "cut_off", "seen", "believed", "says"),
    [
        # A latch that reports nothing: it may have closed before its line broke.
        (EMPTY, PICK, evidence(), "gripper", "may be in the gripper, whose latch reports nothing"),
        # It has closed, and somebody moved the arm since.
        (EMPTY, PICK, evidence(latched=True), "gripper", "it seems, but the arm was moved"),
        (HELD, RELEASE, evidence(told_open=True, risen=True), "cell", "let go, but the arm was"),
        (GRIPPED, TAKE_OFF, evidence(), "gripper", "may be in the gripper, or stand at its cell"),
        (GRIPPED, TAKE_OFF, evidence(told_open=True), "cell", "somebody has opened the gripper"),
        (HELD, PUT_BACK, evidence(told_open=True), "station", "let go, but the arm was moved"),
        (HELD, PUT_BACK, evidence(at_station=True), "gripper", "or lie at the pick station"),
        # Told to stay closed, and not confirmed: the line is broken, or the latch lost power.
        (HELD, RELEASE, evidence(at_cell=True), "gripper", "in the gripper, or stand at its cell"),
        (HELD, PLACE, evidence(risen=True), "gripper", "the latch does not confirm it"),
        # Only a person opens a latch that holds a part between two acts.
        (HELD, None, evidence(told_open=True), "stock", "somebody has opened it"),
        # Nobody saw it lift, a part is at the station, and the board was switched off meanwhile.
        (UNCHECKED, PLACE, evidence(latched=True, risen=True, part_at_station=True, belt_indexes=0),
         "gripper", "may be in the gripper, or still at the pick station"),
        (UNCOUNTED, PLACE, evidence(latched=True, risen=True, part_at_station=True),
         "gripper", "may be in the gripper, or still at the pick station"),
    ],
)  # fmt: skip
def test_what_they_cannot_tell_is_asked(
    ledger: Ledger, cut_off: Act | None, seen: Evidence, believed: str, says: str
) -> None:
    doubt = settle(ledger, (cut_off,) if cut_off is not None else (), seen, part="Part 2").doubt
    assert doubt is not None
    assert doubt.believed == believed
    assert "Part 2" in doubt.sentence
    assert says in doubt.sentence


@pytest.mark.parametrize(
    ("seen", "lifted", "missed"),
    [
        (evidence(latched=True, risen=True), True, False),
        # The next part came since, by the board's counter; or none did, and it is still this one.
        (evidence(latched=True, risen=True, part_at_station=True, belt_indexes=PICKED_AT + 1),
         True, False),
        (evidence(latched=True, risen=True, part_at_station=True), False, True),
        # Not high enough to tell: the next movement looks.
        (evidence(latched=True, at_station=True, part_at_station=True), False, False),
    ],
)  # fmt: skip
def test_whether_a_part_was_lifted_is_told_by_the_sensor_and_the_boards_counter(
    seen: Evidence, lifted: bool, missed: bool
) -> None:
    settled = settle(UNCHECKED, (PLACE,), seen, part="Part 15")
    assert (settled.lifted, settled.missed, settled.doubt) == (lifted, missed, None)


def test_a_part_that_was_seen_to_lift_is_not_asked_about_again() -> None:
    seen = evidence(latched=True, risen=True, part_at_station=True, belt_indexes=0)
    settled = settle(HELD, (PLACE,), seen, part="Part 15")
    assert (settled.missed, settled.doubt) == (False, None)


def test_a_latch_closed_on_nothing_after_a_missed_pick_is_no_part() -> None:
    seen = evidence(latched=True, risen=True, part_at_station=True)
    settled = settle(MISSED, (PICK,), seen, part="Part 15")
    assert settled.doubt is None
    assert [one.moves for one in settled.acts] == [()]
