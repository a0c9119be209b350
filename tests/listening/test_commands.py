from __future__ import annotations

import pytest

from cellctl.listening.commands import is_praise, spoken_command


@pytest.mark.parametrize(
    ("text", "command"),
    [
        ("stop", "stop"),
        ("Stop.", "stop"),
        ("STOP!", "stop"),
        ("please stop", "stop"),
        ("ok, stop now", "stop"),
        ("stop stop stop", "stop"),
        ("Stop the robot!", "stop"),
        ("emergency stop", "stop"),
        ("Pause.", "pause"),
        ("wait", "pause"),
        ("resume", "resume"),
        ("Continue, please.", "resume"),
        ("cancel", "cancel"),
        ("never mind", "cancel"),
        ("Yes.", "yes"),
        ("yes please", "yes"),
        ("okay", "yes"),
        ("No, thanks.", "no"),
        ("no", "no"),
        ("Don’t.", "no"),  # noqa: RUF001 - recognisers print this apostrophe
        ("take it apart", "take_apart"),
        ("help", "help"),
        ("yes", "yes"),
        ("Yes, please go ahead.", "yes"),
        ("yes okay", "yes"),
        ("okay build it", "yes"),
        ("can you stop please", "stop"),
        ("Could you please pause for a moment?", "pause"),
        ("hold on a second", "pause"),
        ("cancel please, I changed my mind", "cancel"),
        ("Yes, that's perfect, thank you!", "yes"),
        ("No thanks, that's not what I meant.", "no"),
        ("sounds lovely, go on then", "yes"),
        ("okay you can start", "yes"),
        ("hmm, no, I don't think so", "no"),
        ("sorry could you repeat that", "repeat"),
        ("show us another version please", "another"),
        ("yes, do it, no, stop", "stop"),
        ("go ahead, wait", "pause"),
        ("hang on just a minute", "pause"),
        ("no wait", "pause"),
        ("no stop", "stop"),
        ("yes stop it", "stop"),
        ("you can continue now", "resume"),
        ("i said cancel", "cancel"),
        ("no cancel that", "cancel"),
        ("let's start over", "cancel"),
        ("no that's wrong", "no"),
        ("please don't", "no"),
        ("say it again please", "repeat"),
        ("one more please", "again"),
        ("No, show me another one please.", "another"),
        ("something different", "another"),
        ("not like that", "another"),
    ],
)
def test_control_words_are_commands(text: str, command: str) -> None:
    assert spoken_command(text) == command


@pytest.mark.parametrize(
    "text",
    [
        "",
        "please",
        "a door stop",
        "I want a stop sign",
        "stop and smell the roses",
        "no lid on the box",
        "yes I want a stool",
        "a simple stool",
        "know",
        "oh okay that one",
        "oh",
        "so then",
        "can you",
        "will you stop by later",
        "stop the music",
        "go home",
        "wait for the bus",
        "sure is hot today",
        "i want you to make it taller",
    ],
)
def test_nothing_else_is_a_command(text: str) -> None:
    assert spoken_command(text) is None


@pytest.mark.parametrize(
    ("text", "praise"),
    [
        *(("lovely", True), ("Exactly!", True), ("thank you, lovely", True), ("I like it", True)),
        *(("yes, lovely", False), ("sounds lovely, go on then", False), ("okay", False)),
        *(("build it", False), ("a simple stool", False), ("no", False)),
    ],
)
def test_what_pleases_people_is_told_from_what_they_agree_to(text: str, praise: bool) -> None:
    assert is_praise(text) is praise
