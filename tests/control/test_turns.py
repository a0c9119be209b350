"""Whose turn it is, and what visitors are called, without a cell."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from cellctl.assembly import Utterance
from cellctl.control.dialogue.names import Names
from cellctl.control.dialogue.reading import Phrasebook
from cellctl.control.dialogue.table import Input
from cellctl.control.dialogue.waiting_list import WaitingList
from cellctl.listening.understanding.talk import talk
from cellctl.wording import load_wording

NOW = datetime(2026, 1, 1, tzinfo=UTC)


def test_a_wish_whose_turn_could_not_begin_is_wanted_as_often_as_before(tmp_path: Path) -> None:
    line = WaitingList(5, 2, 600.0, tmp_path / "waiting.json")
    stools = Utterance(text="three stools", source="text")
    line.add(stools, "a stool", owner="anna", name="", now=NOW, copies=3)
    line.add(Utterance(text="a bench", source="text"), "a bench", owner="ben", name="", now=NOW)
    for _ in range(3):
        turn = line.take_next()
        assert turn is not None
        line.put_back(turn)
    begun = []
    while (turn := line.take_next()) is not None:
        begun.append(turn.entry.wish)
    assert begun.count("a stool") == 3
    assert begun.count("a bench") == 1


def test_a_name_goes_with_the_one_in_front_and_stays_with_a_device() -> None:
    now_s = 0.0
    names = Names(lambda: now_s)
    names.keep("", "Anna")
    names.keep("mark", "Ben")
    now_s += 400.0
    names.heard("", at_work=True)
    assert names.of("") == "Anna"
    now_s += 50.0
    names.heard("", at_work=False)
    assert names.of("") == "Anna"
    now_s += 61.0
    names.heard("mark", at_work=False)
    names.heard("", at_work=False)
    assert names.of("") == ""
    assert names.of("mark") == "Ben"


def test_nobody_is_called_what_offends() -> None:
    book = Phrasebook(load_wording("en"))
    assert book.read("call me Anna").name == "Anna"
    for word in talk().insults:
        assert book.read(f"call me {word}").said is not Input.NAME
