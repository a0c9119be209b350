from __future__ import annotations

import pytest

from cellctl.listening.commands import spoken_command


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
    ],
)
def test_nothing_else_is_a_command(text: str) -> None:
    assert spoken_command(text) is None
