"""The conversation's table: places and inputs, and nothing else. No I/O, no clocks.

``decide`` answers every place and input: which act follows, and where the conversation is then. Of
the machine it drives the question of ``validating.confirming`` alone: a yes, a no, a change. All
that moves the arm follows from the one act ``confirm``; the diagram in the docs is drawn from
``TABLE``.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Place(StrEnum):
    """Where a conversation can be."""

    STARTING = "starting"
    READY = "ready"
    """For a wish."""
    THINKING = "thinking"
    ASKING_BUILD = "asking_build"
    ASKING_APART = "asking_apart"
    ASKING_HAND_OVER = "asking_hand_over"
    """Whether somebody takes along what stands; the machine is idle meanwhile."""
    WORKING = "working"
    WAITING = "waiting"
    """Paused, or for parts: somebody has to do something."""
    FAULT = "fault"


class Input(StrEnum):
    """What can happen to a conversation."""

    # What somebody says, types or presses.
    SENTENCE = "sentence"
    """Neither a word of command nor a question that is answered by rule; not understood yet."""
    WISH = "wish"
    CHANGE = "change"
    """``make it taller``."""
    ANOTHER = "another"
    """``show me another``, ``something else``."""
    AGAIN = "again"
    """``another one``, ``build it again``."""
    UNCLEAR = "unclear"
    """What was understood is nothing to do."""
    YES = "yes"
    NO = "no"
    QUESTION = "question"
    REPEAT = "repeat"
    HELP = "help"
    NAME = "name"
    """``call me Anna``."""
    TAKE_APART = "take_apart"
    HAND_OVER = "hand_over"
    """``thank you, it is mine``."""
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    CANCEL = "cancel"
    # What time brings.
    SILENCE = "silence"
    """Nobody answered a question in time."""
    # Where the machine has gone.
    CELL_STARTS = "cell_starts"
    CELL_RESTS = "cell_rests"
    CELL_THINKS = "cell_thinks"
    CELL_ASKS_BUILD = "cell_asks_build"
    CELL_ASKS_APART = "cell_asks_apart"
    CELL_WORKS = "cell_works"
    CELL_WAITS = "cell_waits"
    CELL_FAILS = "cell_fails"


class Act(StrEnum):
    """What the cell does about it."""

    NOTHING = "nothing"
    UNDERSTAND = "understand"
    """Find out what a sentence means, and decide anew with that."""
    BEGIN = "begin"
    """Begin a job: it is thought about, planned, and asked about."""
    BEGIN_AGAIN = "begin_again"
    """Begin a job with the wish before."""
    QUEUE = "queue"
    """Keep the wish until its turn comes."""
    QUEUE_AGAIN = "queue_again"
    """Keep the wish that is worked on for another turn."""
    CHANGE = "change"
    """Design anew what is asked about, and ask again."""
    ANOTHER = "another"
    """Show another design for the same wish, or ask what else it shall be."""
    CONFIRM = "confirm"
    """Do what was asked about: the only act that lets the arm move."""
    DECLINE = "decline"
    ASK_HAND_OVER = "ask_hand_over"
    HAND_OVER = "hand_over"
    """Write off what stands: somebody takes it along."""
    LEAVE = "leave"
    """Forget the question of the hand-over."""
    TAKE_APART = "take_apart"
    """Plan how what stands comes apart, and ask."""
    ANSWER = "answer"
    REPEAT = "repeat"
    HELP = "help"
    KEEP_NAME = "keep_name"
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    """Words of command go on to the machine, which knows when they count and from whom."""
    CANCEL = "cancel"
    """End the own job, or forget the own wish that waits."""
    # What is said instead of doing something.
    EXPLAIN = "explain"
    """Say that it was not understood, and what would help."""
    EXPLAIN_CHANGE = "explain_change"
    """Nothing is asked about that could be changed."""
    EXPLAIN_ANSWER = "explain_answer"
    """Say what can be answered now."""
    EXPLAIN_STATE = "explain_state"
    """Say why that cannot be done now."""
    NOTHING_ASKED = "nothing_asked"
    NOT_YOURS = "not_yours"
    """Somebody else's job is asked about."""


@dataclass(frozen=True)
class Row:
    """One row of the table; ``target`` None: the conversation stays where it is."""

    said: Input
    places: tuple[Place, ...]
    act: Act
    target: Place | None = None


@dataclass(frozen=True)
class Decision:
    """What follows from an input."""

    act: Act
    place: Place


_EVERYWHERE = tuple(Place)
_ASKING = (Place.ASKING_BUILD, Place.ASKING_APART)
_AT_REST = (Place.READY, Place.ASKING_HAND_OVER)
_BUSY = (Place.THINKING, Place.WORKING)
_OUT = (Place.STARTING, Place.WAITING, Place.FAULT)
_NOT_AT_REST = tuple(place for place in Place if place not in _AT_REST)
_NOT_ASKING = tuple(p for p in Place if p not in (*_ASKING, Place.ASKING_HAND_OVER))
_HAND_OVER = (Place.ASKING_HAND_OVER,)

TABLE: tuple[Row, ...] = (
    # Sentences: at rest the machine's own stage understands them, for that takes its time.
    Row(Input.SENTENCE, _AT_REST, Act.BEGIN, Place.READY),
    Row(Input.SENTENCE, (*_ASKING, *_BUSY), Act.UNDERSTAND),
    Row(Input.SENTENCE, _OUT, Act.EXPLAIN_STATE),
    Row(Input.WISH, _AT_REST, Act.BEGIN, Place.READY),
    Row(Input.WISH, (Place.ASKING_BUILD,), Act.CHANGE),
    Row(Input.WISH, (Place.ASKING_APART,), Act.EXPLAIN_ANSWER),
    Row(Input.WISH, _BUSY, Act.QUEUE),
    Row(Input.WISH, _OUT, Act.EXPLAIN_STATE),
    Row(Input.CHANGE, (Place.ASKING_BUILD,), Act.CHANGE),
    Row(Input.CHANGE, (Place.ASKING_APART,), Act.EXPLAIN_ANSWER),
    Row(Input.CHANGE, (*_AT_REST, *_BUSY, *_OUT), Act.EXPLAIN_CHANGE),
    Row(Input.ANOTHER, (Place.ASKING_BUILD,), Act.ANOTHER),
    Row(Input.ANOTHER, (Place.ASKING_APART,), Act.EXPLAIN_ANSWER),
    Row(Input.ANOTHER, (*_AT_REST, *_BUSY, *_OUT), Act.NOTHING_ASKED),
    # Before anything is built, "another one" is another shape for the same wish.
    Row(Input.AGAIN, _AT_REST, Act.BEGIN_AGAIN, Place.READY),
    Row(Input.AGAIN, (Place.ASKING_BUILD,), Act.ANOTHER),
    Row(Input.AGAIN, (Place.ASKING_APART,), Act.EXPLAIN_ANSWER),
    Row(Input.AGAIN, _BUSY, Act.QUEUE_AGAIN),
    Row(Input.AGAIN, _OUT, Act.EXPLAIN_STATE),
    Row(Input.UNCLEAR, (*_AT_REST, *_BUSY, *_OUT), Act.EXPLAIN),
    Row(Input.UNCLEAR, _ASKING, Act.EXPLAIN_ANSWER),
    # Answers. Silence means no.
    Row(Input.YES, _ASKING, Act.CONFIRM),
    Row(Input.YES, _HAND_OVER, Act.HAND_OVER, Place.READY),
    Row(Input.YES, _NOT_ASKING, Act.NOTHING_ASKED),
    Row(Input.NO, _ASKING, Act.DECLINE),
    Row(Input.NO, _HAND_OVER, Act.LEAVE, Place.READY),
    Row(Input.NO, _NOT_ASKING, Act.NOTHING_ASKED),
    Row(Input.SILENCE, _ASKING, Act.DECLINE),
    Row(Input.SILENCE, _HAND_OVER, Act.LEAVE, Place.READY),
    Row(Input.SILENCE, _NOT_ASKING, Act.NOTHING),
    # What can be said at any time, and moves nothing.
    Row(Input.QUESTION, _EVERYWHERE, Act.ANSWER),
    Row(Input.REPEAT, _EVERYWHERE, Act.REPEAT),
    Row(Input.HELP, _EVERYWHERE, Act.HELP),
    Row(Input.NAME, _EVERYWHERE, Act.KEEP_NAME),
    # What stands.
    Row(Input.TAKE_APART, _AT_REST, Act.TAKE_APART, Place.READY),
    Row(Input.TAKE_APART, _NOT_AT_REST, Act.EXPLAIN_STATE),
    Row(Input.HAND_OVER, _AT_REST, Act.ASK_HAND_OVER, Place.ASKING_HAND_OVER),
    Row(Input.HAND_OVER, _NOT_AT_REST, Act.EXPLAIN_STATE),
    # Words of command. Each also ends the question of the hand-over.
    *(
        row
        for said, act in (
            (Input.STOP, Act.STOP),
            (Input.PAUSE, Act.PAUSE),
            (Input.RESUME, Act.RESUME),
        )
        for row in (
            Row(said, tuple(p for p in Place if p is not Place.ASKING_HAND_OVER), act),
            Row(said, _HAND_OVER, act, Place.READY),
        )
    ),
    Row(Input.CANCEL, tuple(p for p in Place if p is not Place.ASKING_HAND_OVER), Act.CANCEL),
    Row(Input.CANCEL, _HAND_OVER, Act.LEAVE, Place.READY),
    # The machine goes, the conversation follows.
    Row(Input.CELL_STARTS, _EVERYWHERE, Act.NOTHING, Place.STARTING),
    Row(Input.CELL_RESTS, _NOT_AT_REST, Act.NOTHING, Place.READY),
    Row(Input.CELL_RESTS, _AT_REST, Act.NOTHING),
    Row(Input.CELL_THINKS, _EVERYWHERE, Act.NOTHING, Place.THINKING),
    Row(Input.CELL_ASKS_BUILD, _EVERYWHERE, Act.NOTHING, Place.ASKING_BUILD),
    Row(Input.CELL_ASKS_APART, _EVERYWHERE, Act.NOTHING, Place.ASKING_APART),
    Row(Input.CELL_WORKS, _EVERYWHERE, Act.NOTHING, Place.WORKING),
    Row(Input.CELL_WAITS, _EVERYWHERE, Act.NOTHING, Place.WAITING),
    Row(Input.CELL_FAILS, _EVERYWHERE, Act.NOTHING, Place.FAULT),
)
"""What follows when the owner of what is asked about says it, or anybody while nothing is asked."""

STRANGERS: tuple[Row, ...] = (
    Row(Input.YES, _ASKING, Act.NOT_YOURS),
    Row(Input.NO, _ASKING, Act.NOT_YOURS),
    Row(Input.CHANGE, _ASKING, Act.NOT_YOURS),
    Row(Input.UNCLEAR, _ASKING, Act.EXPLAIN),
    Row(Input.WISH, _ASKING, Act.QUEUE),
    Row(Input.ANOTHER, _ASKING, Act.NOT_YOURS),
    Row(Input.AGAIN, _ASKING, Act.NOT_YOURS),
)
"""What follows instead when somebody else says it while a job's owner is asked."""

_DECISIONS = {(place, row.said): row for row in TABLE for place in row.places}
_STRANGERS = {(place, row.said): row for row in STRANGERS for place in row.places}


def decide(place: Place, said: Input, *, stranger: bool = False) -> Decision:
    """What follows from an input.

    Args:
        place: where the conversation is.
        said: what happened.
        stranger: another than the owner of the job says it.
    """
    row = _STRANGERS.get((place, said)) if stranger else None
    row = row or _DECISIONS[place, said]
    return Decision(row.act, row.target or place)
