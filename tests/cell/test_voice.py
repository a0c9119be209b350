"""A cell that speaks into its own microphone: it does not answer itself, and can be interrupted."""

from __future__ import annotations

import time

import pytest

from cellctl.messages import SpeechData, VoiceData
from tests.cell.harness import RunningCell, running_cell
from tests.cell.spoken import ECHO_DB, hearing, people, said, wait_for_ears

pytestmark = pytest.mark.wire

SPEED = 10.0
INTERRUPTED_S = 2.0
"""From the end of a word to silence: what ends the word, and recognising it, on a busy machine."""


def heard(cell: RunningCell) -> list[str]:
    """What was published of all that was said, each sentence once."""
    payloads = [message.payload() for message in cell.seen if message.topic == "speech"]
    texts = [data.utterance.text for data in payloads if isinstance(data, SpeechData)]
    plain = [text.strip(" .!").lower() for text in texts]
    return [text for text, before in zip(plain, ["", *plain], strict=False) if text != before]


def wait_saying(cell: RunningCell, text: str) -> VoiceData:
    """Wait until the cell says something with these words."""
    return cell.wait(f"the words {text!r}", lambda now: text in now.voice.saying).voice


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
        cell.wait("silence", lambda now: not now.voice.saying)
        assert cell.wait_state("validating_confirming").job is not None

        # Another wish instead, and an answer in the middle of the question.
        there.say("a simple stool")
        wait_saying(cell, "Shall I build it?")
        ended_s = there.say("yes")
        cell.wait("silence", lambda now: "Shall I build it?" not in now.voice.saying)
        assert time.monotonic() - ended_s < INTERRUPTED_S
        cell.wait_state("assembling_placing")
        there.say("stop")
        cell.wait_state("paused_resting")
        assert "Shall I build it?" in " ".join(said(cell))
        # Nothing that it said came back to it as somebody's words.
        cell.wait("the last word", lambda _: heard(cell)[-1:] == ["stop"])
        assert heard(cell) == ["the letter t", "a simple stool", "yes", "stop"]
        assert cell.truth().violations == ()
