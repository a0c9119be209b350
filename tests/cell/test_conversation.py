"""Visits at a running cell: what is said, what is asked, whose turn it is, and who may say yes."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from cellctl.errors import RefusedError
from cellctl.messages import ControlReply, DialogueData, DropWishCommand, visitor_mark
from tests.cell.harness import RunningCell, bar, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    talk = {"take_along_s": 2.0, "queue_limit": 2}
    policy = {"confirmation": "ask", "confirmation_timeout_s": 60.0}
    with running_cell(speed=20.0, policy=policy, dialogue=talk) as running:
        yield running


@pytest.fixture
def idle(cell: RunningCell) -> Iterator[RunningCell]:
    cell.begin_test()
    yield cell
    assert cell.client.snapshot().dialogue.queue == ()
    cell.bring_back()


def said(cell: RunningCell, text: str, visitor: str = "") -> str:
    cell.visitor.visitor = visitor
    try:
        return cell.visitor.say(text).message
    finally:
        cell.visitor.visitor = ""


def refused(cell: RunningCell, text: str, visitor: str = "") -> str:
    with pytest.raises(RefusedError) as error:
        said(cell, text, visitor)
    return str(error.value)


def dialogue(cell: RunningCell) -> DialogueData:
    return cell.client.snapshot().dialogue


def lines(cell: RunningCell) -> list[str]:
    """Everything said since the test began, in its order."""
    while waiting := list(cell.client.messages(0.0)):
        cell.seen.extend(waiting)
    numbered: dict[int, str] = {}
    for message in cell.seen:
        if message.topic == "dialogue":
            data = message.payload()
            assert isinstance(data, DialogueData)
            if data.line is not None:
                numbered[data.line.number] = data.line.text
    return [numbered[number] for number in sorted(numbered)]


def test_a_wish_is_understood_read_back_changed_and_only_built_after_a_yes(
    idle: RunningCell,
) -> None:
    assert dialogue(idle).phase == "ready"
    assert dialogue(idle).offers == ()
    said(idle, "a table with four legs")
    idle.wait_state("validating_confirming")
    asking = dialogue(idle)
    assert (asking.phase, asking.question) == ("asking", "build")
    assert asking.offers == ("yes", "no", "another", "change")
    assert asking.understood == "A table with four legs."
    assert asking.deadline is not None
    assert asking.line is not None
    assert asking.line.key == "ask.build"
    assert "parts, about" in asking.line.text
    assert "It takes about" in said(idle, "how long will it take?")
    assert "parts" in said(idle, "How many parts are left?")
    assert refused(idle, "good weather today").endswith("make it taller.")
    assert idle.client.snapshot().state.state == "validating_confirming"
    said(idle, "make it red")
    idle.wait("what stays", lambda now: "So it stays" in now.state.sentence)
    assert said(idle, "why?").startswith("I cannot change the colour of a table.")
    said(idle, "the letter T")
    idle.wait(
        "the other question",
        lambda now: now.dialogue.question == "build" and now.dialogue.understood == "A letter T.",
    )
    assert said(idle, "thank you").endswith("Say yes if I shall build it.")
    assert said(idle, "no thanks") == "Then I leave it."
    assert idle.finish().outcome == "declined"
    assert idle.truth().built == ()
    # The last thing to be heard is what the cell waits for.
    declined = "All right, I shall not build it. What shall I build?"
    idle.wait(
        "that", lambda now: now.dialogue.line is not None and now.dialogue.line.text == declined
    )
    assert "A table with four legs." in lines(idle)
    assert said(idle, "what are you doing?") == "I wait for a wish. What shall I build?"


def test_a_yes_counts_for_the_question_that_was_shown_and_for_no_later_one(
    idle: RunningCell,
) -> None:
    said(idle, "the letter T")
    idle.wait_state("validating_confirming")
    before = dialogue(idle).asked
    said(idle, "the letter L")
    idle.wait("the other question", lambda now: now.dialogue.asked not in {"", before})
    late: tuple[Callable[[], ControlReply], ...] = (
        lambda: idle.visitor.confirm(True, asked=before),
        lambda: idle.client.confirm(True, asked=before),
        lambda: idle.visitor.say("yes", asked=before),
        lambda: idle.visitor.say("yes", asked=""),
    )
    for answer in late:
        with pytest.raises(RefusedError, match=r"Now I ask: Letter L, .* Shall I build it"):
            answer()
    assert idle.client.snapshot().state.state == "validating_confirming"
    idle.visitor.say("yes please", asked=dialogue(idle).asked)
    assert idle.finish().outcome == "built"
    assert dialogue(idle).asked == ""
    said(idle, "thank you, it is mine")
    assert {"confirm", "cancel"} <= set(idle.client.snapshot().state.commands)
    with pytest.raises(RefusedError, match="Now I ask: You take along"):
        idle.visitor.confirm(True, asked=before)
    idle.visitor.confirm(False)
    assert "confirm" not in idle.client.snapshot().state.commands


def test_what_is_not_understood_is_helped_differently_each_time(idle: RunningCell) -> None:
    help_given = []
    for nonsense in ("the weather is nice", "my dog ate it", "we went home", "it rained"):
        said(idle, nonsense)
        help_given.append(idle.finish().message)
    assert len(set(help_given[:3])) == 3
    assert help_given[2] == help_given[3]
    assert "speak" not in help_given[2]
    said(idle, "make it taller")
    assert idle.finish().message.startswith("I change a thing only before you say yes to it.")
    assert said(idle, "help").startswith("Tell me what to build")
    said(idle, "it rained again")
    assert idle.finish().message == help_given[0]


def test_somebody_else_waits_in_line_and_cannot_say_yes(idle: RunningCell) -> None:
    said(idle, "the letter T")
    idle.wait_state("validating_confirming")
    assert "Another visitor" in refused(idle, "yes", "anna")
    assert "Another visitor" in refused(idle, "make it taller", "anna")
    assert said(idle, "call me Anna", "anna") == "Hello Anna."
    waits = said(idle, "the letter L", "anna")
    assert "you are number 1" in waits
    entry = dialogue(idle).queue[0]
    assert (entry.name, entry.owner, entry.wish) == ("Anna", visitor_mark("anna"), "a letter L")
    assert said(idle, "the letter I", "ben").endswith("number 2 in the line.")
    assert "no more wishes can wait" in refused(idle, "the letter V", "ben")
    assert "2 wishes wait" in said(idle, "who is next?")
    ticket = dialogue(idle).queue[1].ticket
    with pytest.raises(RefusedError, match="needs the operator"):
        idle.visitor.request(DropWishCommand(ticket=ticket))
    assert "Dropped: a letter" in idle.client.request(DropWishCommand(ticket=ticket)).message
    with pytest.raises(RefusedError, match="No wish"):
        idle.client.request(DropWishCommand(ticket=ticket))
    assert said(idle, "the letter I", "ben").endswith("number 2 in the line.")
    assert "dropped your wish" in said(idle, "cancel", "ben")
    assert idle.client.snapshot().state.state == "validating_confirming"
    said(idle, "no")
    turn = idle.wait(
        "Anna's turn", lambda now: now.dialogue.owner_name == "Anna" and bool(now.dialogue.question)
    )
    assert turn.dialogue.queue == ()
    assert any("Anna, it is your turn" in line for line in lines(idle))
    assert "Another visitor" in refused(idle, "yes")
    said(idle, "no", "anna")
    assert idle.finish().outcome == "declined"
    assert idle.truth().built == ()


def test_a_finished_object_is_handed_over_after_a_yes_and_silence_is_a_no(
    idle: RunningCell,
) -> None:
    assert refused(idle, "it's mine") == "Nothing stands in the workspace."
    idle.client.build("bar.json", bar(1, 1, 1))
    idle.wait_state("validating_confirming")
    assert "Another visitor" in refused(idle, "yes", "anna")
    said(idle, "yes")
    working = idle.wait("work", lambda now: now.dialogue.phase == "building").dialogue
    assert working.offers == ("stop", "cancel")
    assert "I am building" in said(idle, "what are you doing?")
    assert said(idle, "two stools", "anna").endswith("number 1 in the line.")
    assert "dropped" in said(idle, "cancel", "anna")
    idle.finish()
    assert set(dialogue(idle).offers) == {"take_apart", "hand_over"}
    assert "somebody else" in refused(idle, "thank you, it is mine", "anna")
    assert said(idle, "thank you").endswith("say: it is mine.")
    assert "1 part" in said(idle, "thank you, it is mine")
    assert said(idle, "why?") == "I have asked whether you take along what stands."
    assert "somebody else" in refused(idle, "yes", "anna")
    asking = dialogue(idle)
    assert (asking.phase, asking.question) == ("asking", "hand_over")
    idle.wait("silence", lambda now: now.dialogue.question == "")
    assert idle.client.snapshot().standing != ()
    said(idle, "I'll take it")
    idle.world.hand_over()
    assert "1 part handed over" in said(idle, "yes")
    assert idle.client.snapshot().standing == ()
    assert said(idle, "thanks") == "You are welcome."
    idle.assert_inventory_true()


def test_after_a_stop_an_operator_resumes_and_the_question_is_what_is_said_last(
    idle: RunningCell,
) -> None:
    said(idle, "the letter T")
    idle.wait_state("validating_confirming")
    assert said(idle, "stop") == "Stopping now."
    idle.wait_state("paused_resting")
    assert refused(idle, "go on") == "Only an operator lets me go on."
    assert "I stand still" in said(idle, "what are you doing?")
    assert idle.client.command("resume").message == "Going on."
    idle.wait_state("validating_confirming")
    asking = dialogue(idle).line
    assert asking is not None
    assert asking.key == "ask.build"
    said(idle, "no")


def test_counts_are_told_what_is_possible(idle: RunningCell) -> None:
    said(idle, "a hundred chairs")
    snapshot = idle.wait_state("validating_confirming")
    assert "more than I can make for one visitor" in snapshot.state.sentence or (
        "not enough parts for more than one" in snapshot.state.sentence
    )
    said(idle, "no")
    said(idle, "two pillars 30 cm high")
    assert "begin with the first" in idle.wait_state("validating_confirming").state.sentence
    said(idle, "no")
    assert dialogue(idle).queue == ()
