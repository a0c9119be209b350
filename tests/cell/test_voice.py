"""A cell that speaks into its own microphone: it does not answer itself, and can be interrupted."""

from __future__ import annotations

import time

import pytest

from cellctl.messages import SpeechData, VoiceData
from tests.cell.harness import RunningCell, running_cell
from tests.cell.spoken import ECHO_DB, People, hearing, people, said, wait_for_ears

pytestmark = pytest.mark.wire

SPEED = 10.0
_STOPS = 3
_HEARD_S = 5.0
"""After which a word was not heard, on a busy machine."""


def heard(cell: RunningCell) -> list[str]:
    """What was published of all that was said, each sentence once."""
    payloads = [message.payload() for message in cell.seen if message.topic == "speech"]
    texts = [data.utterance.text for data in payloads if isinstance(data, SpeechData)]
    plain = [text.strip(" .!").lower() for text in texts]
    return [text for text, before in zip(plain, ["", *plain], strict=False) if text != before]


def stop_aloud(there: People, cell: RunningCell) -> None:
    """Say "stop" until it stops, as people do: it speaks itself meanwhile and may miss one."""
    for _ in range(_STOPS):
        there.say("stop")
        until_s = time.monotonic() + _HEARD_S
        while time.monotonic() < until_s:
            if cell.client.snapshot().state.state == "paused_resting":
                return
            cell.listen()
    pytest.fail(f"stop was not heard {_STOPS} times: {heard(cell)}")


def wait_saying(cell: RunningCell, text: str) -> VoiceData:
    """Wait until the cell says something with these words."""
    return cell.wait(f"the words {text!r}", lambda now: text in now.voice.saying).voice


@pytest.mark.soak
def test_it_does_not_answer_itself_and_is_interrupted_while_it_speaks() -> None:
    # Every sentence that it hears would count.
    sections = hearing("open", SPEED, loudspeaker="spk")
    with people(echo_db=ECHO_DB) as there, running_cell(speed=SPEED, **sections) as cell:
        there.prepare("the letter T", "a simple stool", "yes", "stop")
        wait_for_ears(cell)
        cell.wait("a voice", lambda now: now.voice.state == "quiet")
        cell.begin_test()
        there.say("the letter T")
        wait_saying(cell, "Shall I build it?")
        began_s = time.monotonic()
        cell.wait("silence", lambda now: not now.voice.saying)
        whole_s = time.monotonic() - began_s
        assert cell.wait_state("validating_confirming").job is not None

        # Another wish instead, and an answer in the middle of the question.
        there.say("a simple stool")
        wait_saying(cell, "Shall I build it?")
        began_s = time.monotonic()
        there.say("yes")
        cell.wait("silence", lambda now: "Shall I build it?" not in now.voice.saying)
        # This question is the longer one, so it was not said to its end.
        assert time.monotonic() - began_s < whole_s
        cell.wait_state("assembling_placing")
        stop_aloud(there, cell)
        assert "Shall I build it?" in " ".join(said(cell))
        # Nothing that it said came back to it as somebody's words.
        cell.wait("the last word", lambda _: heard(cell)[-1:] == ["stop"])
        assert heard(cell) == ["the letter t", "a simple stool", "yes", "stop"]
        assert cell.truth().violations == ()
