from __future__ import annotations

import string
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks import requests as benchmark
from cellctl.assembly import Intent
from cellctl.listening.request import read_request
from cellctl.listening.understanding.interpreter import Setting


@pytest.mark.parametrize(
    ("text", "phrase"),
    [
        ("I want a simple stool", "simple stool"),
        ("a shelf with two tiers", "shelf with two tiers"),
        ("the letter T", "letter t"),
        ("assemble me a table with one leg", "table with one leg"),
        ("I need a shelf", "shelf"),
        ("make me a coffee table", "coffee table"),
        ("a stool with four legs", "stool with four legs"),
        ("I need a box to hold memories", "box"),
        ("a dog", "dog"),
        ("Could you please build me a small bench?", "small bench"),
        ("hey robot, can I have a tower", "tower"),
        ("I'd like you to make us a chair with arms, please.", "chair with arms"),
        ("would you mind building me a wardrobe", "wardrobe"),
        ("how about a bookcase instead", "bookcase"),
        ("um a uh stool", "stool"),
        ("desk", "desk"),
        ("stool, please", "stool"),
        ("a birdcage", "birdcage"),
        ("give me a zither", "zither"),
        ("a model of a lighthouse", "model of a lighthouse"),
        ("a stool 50 cm high", "stool"),
        ("a bed for my dog", "bed"),
        ("a shelf no a bench", "bench"),
        ("a table with four legs no wait three legs", "table with three legs"),
        ("build me a stool, no, make it a chair", "chair"),
        ("a house I can live in", "house"),
        ("make me a t", "letter t"),
        ("number seven", "number seven"),
    ],
)
def test_wishes_for_objects(text: str, phrase: str) -> None:
    request = read_request(text)
    assert request.intent is Intent.DESIGN
    assert request.phrase == phrase
    assert request.text == text
    assert request.objects
    assert request.command is None


@pytest.mark.parametrize(
    ("text", "objects", "count"),
    [
        ("a stool", ("stool",), 1),
        ("two stools", ("stool",), 2),
        ("a couple of shelves", ("shelf",), 2),
        ("a hundred chairs", ("chair",), 100),
        ("a shelf and a stool", ("shelf", "stool"), 2),
        ("a three tier shelf", ("shelf",), 1),
        ("a model of a tower", ("tower",), 1),
        ("a chest of drawers", ("chest",), 1),
        ("the letter T", ("letter",), 1),
    ],
)
def test_what_and_how_many(text: str, objects: tuple[str, ...], count: int) -> None:
    request = read_request(text)
    assert (request.objects, request.count) == (objects, count)


@pytest.mark.parametrize(
    ("text", "attributes"),
    [
        ("a simple stool", {}),
        ("a table with one leg", {"legs": 1}),
        ("a table with a leg", {"legs": 1}),
        ("a one-legged table", {"legs": 1}),
        ("a stool with 3 legs", {"legs": 3}),
        ("a stool with four sturdy legs", {"legs": 4}),
        ("a shelf with two tiers", {"tiers": 2}),
        ("a three-tier shelf", {"tiers": 3}),
        ("a bookcase with four shelves", {"tiers": 4}),
        ("a ladder with five rungs", {"steps": 5}),
        ("a desk with two drawers", {"drawers": 2}),
        ("a chair without a back", {"back": False}),
        ("a backless chair", {"back": False}),
        ("a chair with arms and a back", {"arms": True, "back": True}),
        ("a bench with a back rest", {"back": True}),
        ("a box with no lid", {"lid": False}),
        ("a box with a lid", {"lid": True}),
        ("the letter T", {"glyph": "T"}),
        ("capital r", {"glyph": "R"}),
        ("two letters T", {"glyph": "T"}),
        ("the number seven", {"glyph": "7"}),
        ("a red stool", {"colour": "red"}),
        ("a chair. It should have three legs", {"legs": 3}),
        ("a shelf for the back of the room", {}),
    ],
)
def test_attributes(text: str, attributes: dict[str, int | str | bool]) -> None:
    request = read_request(text)
    assert request.intent is Intent.DESIGN
    assert request.attributes == attributes


def test_sizes_are_read_with_the_cells_pitch() -> None:
    request = read_request("make a table. It should be 0.8 m tall and 60cm wide")
    assert request.phrase == "table"
    assert request.dimensions_m == {"height": 0.8, "width": 0.6}
    assert read_request("a tower ten blocks high", Setting(pitch_m=0.05)).dimensions_m == {
        "height": 0.5
    }


@pytest.mark.parametrize(
    "text",
    [
        "create beauty",
        "Knowledge",
        "I need something to hold memories",
        "build trust",
        "give me an idea",
        "I want to be happy",
        "make some music",
        "the colour blue",
        "Create ennui",
        "a zestfulness",
        "I want my mommy",
        "I don't need a chair",
        "chairs are great",
        "open the door",
        "remind me to buy a chair",
        "set an alarm for seven",
        "Thanks for watching!",
        "you",
        "the",
        "42",
        "hello robot",
        "make it happen",
    ],
)
def test_what_is_no_object_gets_a_polite_reason(text: str) -> None:
    request = read_request(text)
    assert request.intent is Intent.NONE
    assert request.phrase == "false"
    assert request.objects == ()
    assert request.count == 0
    assert '"a simple stool"' in request.reason, "it says what to say instead"


@pytest.mark.parametrize("text", ["", "   ", "\n"])
def test_silence_is_nothing(text: str) -> None:
    request = read_request(text)
    assert (request.intent, request.reason) == (Intent.NONE, "I heard nothing.")


@pytest.mark.parametrize("text", ["what can you build", "how tall is the table", "where is it"])
def test_questions_are_queries(text: str) -> None:
    assert read_request(text).intent is Intent.QUERY


@pytest.mark.parametrize(
    "text",
    [
        "make it taller",
        "can you make it wider",
        "make the legs longer",
        "add another shelf",
        "remove the legs",
        "a bit smaller please",
        "the table is too small",
        "make it red",
    ],
)
def test_changes_are_edits(text: str) -> None:
    request = read_request(text)
    assert (request.intent, request.phrase) == (Intent.EDIT, "false")


def test_an_edit_may_name_another_object() -> None:
    request = read_request("actually make it a bench")
    assert (request.intent, request.phrase, request.objects) == (Intent.EDIT, "bench", ("bench",))


@pytest.mark.parametrize(("text", "command"), [("Stop!", "stop"), ("pause", "pause")])
def test_control_words_come_first(text: str, command: str) -> None:
    request = read_request(text)
    assert (request.intent, request.command) == (Intent.CONTROL, command)


@pytest.mark.parametrize(
    ("heard", "phrase"),
    [
        ("a shelf with two tears", "shelf with two tiers"),
        ("a shelf with to tears", "shelf with two tiers"),
        ("a simple stole", "simple stool"),
        ("I want a stoole", "stool"),
        ("a stool with four lakes", "stool with four legs"),
        ("a stool with for legs", "stool with four legs"),
        ("a self with two tiers", "shelf with two tiers"),
        ("a letter with five steps", "ladder with five steps"),
        ("the letter tea", "letter t"),
        ("i kneed a shelf", "shelf"),
        ("A sample me a table with one leg.", "table with one leg"),
        ("Take me a coffee table.", "coffee table"),
        ("I want to throne", "throne"),
        ("Make it cross.", "cross"),
        ("I want it thrown.", "throne"),
        ("I bet for my dog.", "bed"),
    ],
)
def test_slips_are_put_right_by_sound_and_said(heard: str, phrase: str) -> None:
    request = read_request(heard)
    assert request.phrase == phrase
    assert request.text == heard
    assert request.reason.startswith("I understood ")


@pytest.mark.parametrize(
    "text",
    [
        "a letter t",
        "a cabinet with two doors",
        "a bunch of roses",
        "a style",
        "a giraffe with long legs",
        "a table with four wheels",
    ],
)
def test_what_makes_sense_is_left_alone(text: str) -> None:
    assert "I understood" not in read_request(text).reason


@given(st.text(alphabet=string.ascii_letters + string.digits + " '-.,é椅\x00", max_size=200))
def test_any_text_gives_some_request(text: str) -> None:
    request = read_request(text)
    assert (request.phrase == "false") == (
        request.intent is not Intent.DESIGN and not request.objects
    )


WORDS = (
    *("a", "an", "the", "make", "it", "two", "with", "and", "no", "of", "legs", "stool", "letter"),
    *("t", "cm", "by", "for", "half", "5", "wait", "tall"),
)


@given(st.lists(st.sampled_from(WORDS), max_size=12).map(" ".join))
def test_any_order_of_known_words_gives_some_request(text: str) -> None:
    request = read_request(text)
    if request.intent is Intent.DESIGN:
        assert request.phrase
        assert request.objects
        assert request.count >= 1


def test_the_evaluation_sentences(test_data: Path) -> None:
    verdicts = [
        (gold["split"], benchmark.judge(gold, read_request(gold["text"])))
        for gold in benchmark.load(test_data)
    ]
    paper = [verdict for split, verdict in verdicts if split == "paper"]
    assert len(paper) == 12
    assert all(all(verdict.values()) for verdict in paper)
    decided = [verdict["decision"] for _, verdict in verdicts]
    named = [verdict["phrase"] for _, verdict in verdicts]
    assert sum(decided) / len(decided) >= 0.95
    assert sum(named) / len(named) >= 0.93
