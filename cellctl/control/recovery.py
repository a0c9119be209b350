"""What became of an act that was cut off, as far as the devices can tell.

A death of the daemon, a pause or a fault can cut an act off at any instant. The robot's controller
keeps its output lines and the latch finishes what it was told, so the gripper's status line, the
arm's place, the station's sensor and the board's counter say how far it came in nearly every case.
What they cannot say is a ``Doubt``, which an operator settles by looking.

``settle`` is a pure function, so that every case can be listed and tested.
"""

from __future__ import annotations

import math

from cellctl.assembling.arm import ArmState
from cellctl.assembling.poses import distance
from cellctl.assembly import Value
from cellctl.config import CellConfig, Pose
from cellctl.control.acts import Act, ActKind, Outcome
from cellctl.control.ledger import Ledger
from cellctl.feeding.belt import BeltState
from cellctl.feeding.inventory import Move
from cellctl.messages import PartPlace

STAYED_M = 0.005
STAYED_RAD = 0.02
"""The arm counts as where it was left within this distance and this turn: a part that is twisted or
tilted by more has come off, though the TCP may not have moved."""
LIFT_SHARE = 0.7
"""Once the TCP has risen by this share of a voxel, the station's sensor does not see its part..."""
LEAVE_SHARE = 1.0
"""...nor once it is this share of a voxel away in any direction."""


def left_station(tcp: Pose, pick: Pose, pitch_m: float) -> bool:
    """Whether the station's sensor cannot see a part in a gripper there.

    Args:
        tcp: where the gripper is, in the base frame.
        pick: where it is with the part at the station.
        pitch_m: edge of a part.
    """
    return (
        tcp[2] - pick[2] > LIFT_SHARE * pitch_m
        or math.dist(tcp[:3], pick[:3]) > LEAVE_SHARE * pitch_m
    )


def stayed(tcp: Pose, left_at: Pose) -> bool:
    """Whether the gripper is where it was left, upright and turned as it was.

    Args:
        tcp: where it is.
        left_at: where it was left, in the same frame.
    """
    apart_m, apart_rad = distance(tcp, left_at)
    return apart_m < STAYED_M and apart_rad < STAYED_RAD


_NOT_CLOSED = "cut off before the latch closed"
_NOT_OPENED = "cut off before the latch opened"
_NOT_PARTED = "cut off before the part was parted from its neighbours"


class Evidence(Value):
    """What the devices say while everything is at rest."""

    latched: bool
    """The status line confirms a closed latch."""
    told_open: bool
    """The command line tells the latch to be open."""
    at_station: bool
    """The TCP is where parts are picked."""
    at_cell: bool
    """The TCP is where the part of the act in question belongs."""
    risen: bool
    """The TCP is higher above the pick station than the sensor sees."""
    part_at_station: bool
    belt_indexes: int

    @classmethod
    def of(
        cls, config: CellConfig, arm: ArmState, belt: BeltState, pick: Pose, place: Pose | None
    ) -> Evidence:
        """From the devices' states; ``place`` is the TCP pose at the cell, None without one."""
        lines = config.gripper
        return cls(
            latched=bool(arm.digital_inputs >> lines.status_input & 1),
            told_open=bool(arm.digital_outputs >> lines.command_output & 1),
            at_station=stayed(arm.tcp_pose, pick),
            at_cell=place is not None and stayed(arm.tcp_pose, place),
            risen=left_station(arm.tcp_pose, pick, config.voxel.pitch_m),
            part_at_station=belt.part_present,
            belt_indexes=belt.indexes,
        )


class Doubt(Value):
    """What nobody can know without looking."""

    act_id: int | None
    """The act that is left without an outcome until it is settled."""
    kind: ActKind
    sentence: str
    """What is believed, and what to look for."""
    believed: PartPlace
    """What ``resume`` takes for granted."""


class Settled(Value):
    """What became of one act."""

    act_id: int
    outcome: Outcome
    detail: str = ""
    moves: tuple[Move, ...] = ()
    belt_indexes: int | None = None


class Settlement(Value):
    """What became of everything that was cut off."""

    acts: tuple[Settled, ...] = ()
    missed: bool = False
    """The part that counts as held was never lifted: it is at the station."""
    lifted: bool = False
    """The part in the gripper has left the station for certain."""
    doubt: Doubt | None = None


def settle(ledger: Ledger, unsettled: tuple[Act, ...], evidence: Evidence, part: str) -> Settlement:
    """Decide what can be decided.

    Args:
        ledger: what the settled acts say.
        unsettled: acts without an outcome, oldest first.
        evidence: what the devices say.
        part: what to call the part that was on its way, for people: "Part 15".
    """
    settled: list[Settled] = []
    doubt: Doubt | None = None
    held_after = ledger.holding
    for act in unsettled:
        result = _settle_act(ledger, act, evidence, part, holding=held_after)
        if isinstance(result, Doubt):
            doubt = result
            continue
        settled.append(result)
        held_after = _holds_after(held_after, result.moves)
    if doubt is not None or not held_after:
        return Settlement(acts=tuple(settled), doubt=doubt)
    if not evidence.latched:
        return Settlement(acts=tuple(settled), doubt=unconfirmed(part, evidence.told_open))
    if not ledger.lift_unchecked or not evidence.risen:
        return Settlement(acts=tuple(settled))
    if any(act.kind is ActKind.FEED for act in unsettled):
        # The next part was called in only after this one was seen to leave.
        return Settlement(acts=tuple(settled), lifted=True)
    if not evidence.part_at_station:
        return Settlement(acts=tuple(settled), lifted=True)
    return _lift(ledger, evidence, tuple(settled), part)


def _holds_after(holding: bool, moves: tuple[Move, ...]) -> bool:
    taken = not {Move.PICK, Move.TAKE_OFF}.isdisjoint(moves)
    return (holding or taken) and {Move.PLACE, Move.PUT_BACK, Move.MISS}.isdisjoint(moves)


def unconfirmed(part: str, told_open: bool) -> Doubt:
    """A part counts as held, and the latch does not confirm it.

    Args:
        part: what to call it, for people.
        told_open: the latch was told to open, which only a person can have done.
    """
    if told_open:
        sentence = f"{part} was in the gripper, and somebody has opened it"
    else:
        sentence = f"{part} should be in the gripper, and the latch does not confirm it"
    return Doubt(
        act_id=None,
        kind=ActKind.PLACE,
        sentence=sentence,
        believed="stock" if told_open else "gripper",
    )


def _lift(
    ledger: Ledger, evidence: Evidence, settled: tuple[Settled, ...], part: str
) -> Settlement:
    """A part lies at the station: the one that should be in the gripper, or the next one."""
    before, now = ledger.belt_indexes, evidence.belt_indexes
    if before is not None and now == before:
        return Settlement(acts=settled, missed=True)
    if before is not None and now > before:
        return Settlement(acts=settled, lifted=True)
    # The board was switched off in between: its counter says nothing.
    return Settlement(
        acts=settled,
        doubt=Doubt(
            act_id=None,
            kind=ActKind.PLACE,
            sentence=f"{part} may be in the gripper, or still at the pick station",
            believed="gripper",
        ),
    )


def _settle_act(
    ledger: Ledger, act: Act, evidence: Evidence, part: str, *, holding: bool
) -> Settled | Doubt:
    if act.kind is ActKind.PICK and not holding:
        return _settle_pick(ledger, act, evidence, part)
    if act.kind is ActKind.RELEASE and holding:
        return _settle_release(act, evidence, part)
    if act.kind is ActKind.GRIP and not holding:
        return _settle_grip(act, evidence)
    if act.kind is ActKind.TAKE_OFF and not holding:
        return _settle_take_off(act, evidence)
    if act.kind is ActKind.PUT_BACK and holding:
        return _settle_put_back(act, evidence)
    # Feeding and moving the arm bring no part from one place to another.
    return Settled(act_id=act.act_id, outcome="interrupted", detail="cut off")


def _settle_pick(ledger: Ledger, act: Act, evidence: Evidence, part: str) -> Settled | Doubt:
    if evidence.latched and evidence.at_station and not evidence.part_at_station:
        return Settled(
            act_id=act.act_id,
            outcome="failed",
            detail="cut off; the latch closed where no part lay",
            moves=(Move.PICK, Move.MISS),
        )
    if evidence.latched and evidence.at_station:
        return Settled(
            act_id=act.act_id,
            outcome="done",
            detail="cut off; the latch was confirmed at the station",
            moves=(Move.PICK,),
            belt_indexes=evidence.belt_indexes,
        )
    if ledger.missed or evidence.told_open or (not evidence.latched and evidence.part_at_station):
        return Settled(act_id=act.act_id, outcome="failed", detail=_NOT_CLOSED)
    if not evidence.latched and not evidence.at_station and not evidence.part_at_station:
        sentence = f"{part} may be in the gripper, whose latch reports nothing"
    elif evidence.latched:
        sentence = f"{part} is in the gripper, it seems, but the arm was moved"
    else:
        return Settled(act_id=act.act_id, outcome="failed", detail=_NOT_CLOSED)
    return Doubt(act_id=act.act_id, kind=act.kind, sentence=sentence, believed="gripper")


def _settle_release(act: Act, evidence: Evidence, part: str) -> Settled | Doubt:
    if evidence.latched:
        return Settled(act_id=act.act_id, outcome="failed", detail=_NOT_OPENED)
    if evidence.told_open and evidence.at_cell:
        # It stands; whether the gripper is free of it was not felt, so the outcome is not "done".
        return Settled(
            act_id=act.act_id,
            outcome="interrupted",
            detail="cut off; the latch was told to open at the cell",
            moves=(Move.PLACE,),
        )
    if evidence.told_open:
        return Doubt(
            act_id=act.act_id,
            kind=act.kind,
            sentence=f"{part} was let go, but the arm was moved",
            believed="cell",
        )
    return Doubt(
        act_id=act.act_id,
        kind=act.kind,
        sentence=f"{part} may be in the gripper, or stand at its cell",
        believed="gripper",
    )


def _settle_grip(act: Act, evidence: Evidence) -> Settled:
    """The part stands whatever the latch did: only a taking that has begun moves it. A latch that
    was told to close there may have, whatever its status line says."""
    if evidence.at_cell and (evidence.latched or not evidence.told_open):
        confirmed = "was" if evidence.latched else "was not"
        detail = f"cut off; the latch {confirmed} confirmed at the cell"
        return Settled(act_id=act.act_id, outcome="done", detail=detail)
    return Settled(act_id=act.act_id, outcome="failed", detail=_NOT_CLOSED)


def _settle_take_off(act: Act, evidence: Evidence) -> Settled | Doubt:
    """The latch had closed on the part; where the arm is now says whether it came along."""
    if evidence.at_cell:
        # Still gripped, or let go where it stands: another grip finds out.
        outcome: Outcome = "interrupted" if evidence.latched else "failed"
        return Settled(act_id=act.act_id, outcome=outcome, detail=_NOT_PARTED)
    if evidence.latched:
        return Settled(
            act_id=act.act_id,
            outcome="done",
            detail="cut off; the latch was confirmed, and the arm off the cell",
            moves=(Move.TAKE_OFF,),
        )
    part = _called(act)
    if evidence.told_open:
        sentence = f"{part} was being taken off, and somebody has opened the gripper"
        return Doubt(act_id=act.act_id, kind=act.kind, sentence=sentence, believed="cell")
    sentence = f"{part} may be in the gripper, or stand at its cell"
    return Doubt(act_id=act.act_id, kind=act.kind, sentence=sentence, believed="gripper")


def _settle_put_back(act: Act, evidence: Evidence) -> Settled | Doubt:
    if evidence.latched:
        return Settled(act_id=act.act_id, outcome="failed", detail=_NOT_OPENED)
    if evidence.told_open and evidence.at_station:
        return Settled(
            act_id=act.act_id,
            outcome="done",
            detail="cut off; the latch was told to open at the station",
            moves=(Move.PUT_BACK,),
        )
    part = _called(act)
    if evidence.told_open:
        sentence = f"{part} was let go, but the arm was moved"
        return Doubt(act_id=act.act_id, kind=act.kind, sentence=sentence, believed="station")
    sentence = f"{part} may be in the gripper, or lie at the pick station"
    return Doubt(act_id=act.act_id, kind=act.kind, sentence=sentence, believed="gripper")


def _called(act: Act) -> str:
    """What people call the part of an act."""
    return f"Part {act.step + 1}" if act.step is not None else "The part"


def moves_to(doubt: Doubt, part: PartPlace) -> tuple[Outcome, tuple[Move, ...]]:
    """What an operator's answer means for the inventory.

    Args:
        doubt: what is in doubt; a part that only counts as held has the kind ``place``.
        part: where the part is, by the operator.

    Returns:
        The outcome of the act in doubt, and what became of the part.

    Raises:
        KeyError: never; every pair has an answer.
    """
    if doubt.kind is ActKind.PICK:  # the part counts as on the belt
        after_pick = {
            "gripper": (),
            "cell": (Move.PLACE,),
            "stock": (Move.TAKE_OUT,),
            "scrap": (Move.SCRAP_GRIPPED,),
            "unknown": (Move.LOSE_GRIPPED,),
        }
        if part == "station":
            return "failed", ()
        return "done", (Move.PICK, *after_pick[part])
    if doubt.kind in {ActKind.GRIP, ActKind.TAKE_OFF}:  # it counts as standing at its cell
        after_taking = {
            "gripper": (),
            "station": (Move.PUT_BACK,),
            "stock": (Move.TAKE_OUT,),
            "scrap": (Move.SCRAP_GRIPPED,),
            "unknown": (Move.LOSE_GRIPPED,),
        }
        # A latch that was only closing on it has taken nothing off: it grips anew.
        if part == "cell" or (part == "gripper" and doubt.kind is ActKind.GRIP):
            return "failed", ()
        return "done", (Move.TAKE_OFF, *after_taking[part])
    # The part counts as in the gripper.
    laid_back = doubt.kind is ActKind.PUT_BACK
    held: dict[PartPlace, tuple[Outcome, tuple[Move, ...]]] = {
        "gripper": ("failed", ()),
        "cell": ("done", (Move.PLACE,)),
        "station": ("done", (Move.PUT_BACK,)) if laid_back else ("failed", (Move.MISS,)),
        "stock": ("failed", (Move.TAKE_OUT,)),
        "scrap": ("failed", (Move.SCRAP_GRIPPED,)),
        "unknown": ("failed", (Move.LOSE_GRIPPED,)),
    }
    return held[part]
