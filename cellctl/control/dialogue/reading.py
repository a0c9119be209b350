"""What a sentence is for the conversation, as far as rules can tell without understanding it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from cellctl.control.dialogue.table import Input
from cellctl.listening.commands import Sayings, plain, spoken_command
from cellctl.listening.understanding.policy import refusal_of
from cellctl.wording import REFERENCE_LANGUAGE, Wording, load_wording

Topic = Literal["can_make", "how_long", "doing", "parts_left", "why", "queue", "who", "thanks"]
"""What can be asked, and what else is said that wants no more than an answer."""
_TOPICS: tuple[Topic, ...] = (
    *("can_make", "how_long", "parts_left", "queue"),
    *("doing", "why", "who", "thanks"),
)
_NAME_MOST = 30
_INPUTS = {
    "yes": Input.YES,
    "no": Input.NO,
    "stop": Input.STOP,
    "pause": Input.PAUSE,
    "resume": Input.RESUME,
    "cancel": Input.CANCEL,
    "take_apart": Input.TAKE_APART,
    "hand_over": Input.HAND_OVER,
    "another": Input.ANOTHER,
    "again": Input.AGAIN,
    "repeat": Input.REPEAT,
    "help": Input.HELP,
}
"""Commands, by their names in the message files."""


@dataclass(frozen=True)
class Reading:
    """What a sentence is."""

    said: Input
    topic: Topic | None = None
    """Of a question."""
    name: str = ""
    """Of ``call me Anna``."""


class Phrasebook:
    """Reads sentences in the cell's language, and in English.

    Args:
        wording: the cell's language.
    """

    def __init__(self, wording: Wording) -> None:
        english = load_wording(REFERENCE_LANGUAGE).hearing
        own = wording.hearing
        commands: dict[str, object] = {}
        for table in (english, own):
            for name, sentences in table.get("commands", {}).items():
                commands[name] = [*_listed(commands.get(name)), *_listed(sentences)]
        self.sayings = Sayings.of(commands)
        """Words of command."""
        self._questions = [
            (topic, pattern)
            for topic in _TOPICS
            for table in (own, english)
            for pattern in _patterns(table.get("questions", {}).get(topic))
        ]
        self._names = [
            pattern
            for table in (own, english)
            for pattern in _patterns(table.get("names", {}).get("call_me"))
        ]

    def read(self, text: str) -> Reading:
        """What a sentence is: a word of command, a question, a name, or still to be understood."""
        if (command := spoken_command(text, self.sayings)) is not None:
            return Reading(_INPUTS[command])
        sentence = plain(text)
        for pattern in self._names:
            match = pattern.fullmatch(sentence)
            if match and len(match[1]) <= _NAME_MOST and not _offends(match[1]):
                return Reading(Input.NAME, name=match[1].title())
        for topic, pattern in self._questions:
            if pattern.fullmatch(sentence):
                return Reading(Input.QUESTION, topic=topic)
        return Reading(Input.SENTENCE)


def _offends(name: str) -> bool:
    """Whether it is no name to be called aloud by, or shown to everybody."""
    words = name.split()
    return bool(refusal_of(words, words[-1]))


def _listed(value: object) -> list[object]:
    return value if isinstance(value, list) else []


def _patterns(sentences: object) -> list[re.Pattern[str]]:
    """Sentences in which an asterisk stands for some words."""
    return [re.compile(" ".join(map(_word, str(one).split()))) for one in _listed(sentences)]


def _word(word: str) -> str:
    return "(.+)" if word == "*" else re.escape(plain(word))
