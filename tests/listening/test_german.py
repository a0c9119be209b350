"""German: words of command, questions and wishes, as typed or recognised."""

from __future__ import annotations

import pytest

from cellctl.assembly import Intent
from cellctl.config import load_config
from cellctl.control.dialogue.naming import Naming
from cellctl.control.dialogue.reading import Phrasebook
from cellctl.control.dialogue.table import Input
from cellctl.listening.ears.words import overheard_command
from cellctl.listening.translating import TranslatingInterpreter, Translator
from cellctl.listening.understanding.choosing import interpreter_for
from cellctl.listening.understanding.interpreter import DEFAULT_SETTING
from cellctl.wording import load_wording
from tests.cell.harness import CONFIG

GERMAN = load_wording("de")
BOOK = Phrasebook(GERMAN)
READER = TranslatingInterpreter(
    interpreter_for(load_config(CONFIG)), Translator(GERMAN.hearing["words"])
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Ja, bitte!", Input.YES),
        ("ja gerne", Input.YES),
        ("Na klar", Input.YES),
        ("yes", Input.YES),
        ("Nein danke.", Input.NO),
        ("lieber nicht", Input.NO),
        ("Stopp!", Input.STOP),
        ("stopp stopp stopp", Input.STOP),
        ("Halt an", Input.STOP),
        ("stop", Input.STOP),
        ("Warte mal bitte", Input.PAUSE),
        ("Weiter", Input.RESUME),
        ("Vergiss es", Input.CANCEL),
        ("Bau es ab", Input.TAKE_APART),
        ("Danke, das gehört mir", Input.HAND_OVER),
        ("Ich nehme es mit", Input.HAND_OVER),
        ("etwas anderes", Input.ANOTHER),
        ("Wie bitte?", Input.REPEAT),
        ("Hilfe", Input.HELP),
        ("Ich heiße Jörg", Input.NAME),
        ("Was kannst du bauen?", Input.QUESTION),
        ("Ich möchte einen Hocker", Input.SENTENCE),
    ],
)
def test_what_a_german_sentence_is(text: str, said: Input) -> None:
    assert BOOK.read(text).said is said


@pytest.mark.parametrize(
    ("text", "topic"),
    [
        ("Was kannst du alles bauen?", "can_make"),
        ("Wie lange dauert das noch?", "how_long"),
        ("Was machst du da?", "doing"),
        ("Wie viele Teile fehlen noch?", "parts_left"),
        ("Warum ist er so klein?", "why"),
        ("Wer bist du?", "who"),
        ("Vielen Dank!", "thanks"),
        ("how long will it take", "how_long"),
    ],
)
def test_what_a_german_question_is_about(text: str, topic: str) -> None:
    assert BOOK.read(text).topic == topic


def test_stop_is_overheard_in_german_and_english() -> None:
    assert overheard_command("stopp", BOOK.sayings) == "stop"
    assert overheard_command("anhalten bitte", BOOK.sayings) == "stop"
    assert overheard_command("stop the robot", BOOK.sayings) == "stop"
    assert overheard_command("ja", BOOK.sayings) == "yes"
    assert overheard_command("schönes wetter heute", BOOK.sayings) is None


@pytest.mark.parametrize(
    ("text", "noun", "attributes", "named"),
    [
        ("Ich möchte einen einfachen Hocker", "stool", {}, "ein Hocker"),
        ("Bau einen Hocker mit vier Beinen", "stool", {"legs": 4}, "ein Hocker mit vier Beinen"),
        ("ein Regal mit zwei Böden", "shelf", {"tiers": 2}, "ein Regal mit zwei Böden"),
        ("Ich hätte gerne eine Bank", "bench", {}, "eine Bank"),
        ("Kannst du mir bitte einen Tisch bauen?", "table", {}, "ein Tisch"),
        ("eine Treppe mit drei Stufen", "staircase", {"steps": 3}, "eine Treppe mit drei Stufen"),
        ("Ich brauche einen Stuhl mit Lehne", "chair", {"back": True}, "ein Stuhl mit Lehne"),
    ],
)
def test_a_german_wish_is_understood_and_named(
    text: str, noun: str, attributes: dict[str, object], named: str
) -> None:
    request = READER.interpret(text, DEFAULT_SETTING)
    assert request.intent is Intent.DESIGN
    assert request.objects == (noun,)
    assert request.attributes == attributes
    assert Naming(GERMAN).wish(request) == named


@pytest.mark.parametrize(
    ("text", "edit"),
    [
        ("Mach es höher", ("scale", "height", "+")),
        ("Mach es bitte etwas breiter", ("scale", "width", "+")),
        ("mach es kleiner", ("scale", None, "-")),
        ("Mach es niedriger", ("scale", "height", "-")),
    ],
)
def test_a_german_change_is_understood(text: str, edit: tuple[str, str | None, str]) -> None:
    request = READER.interpret(text, DEFAULT_SETTING)
    assert request.intent is Intent.EDIT
    first = request.edits[0]
    assert (first.op, first.axis, first.direction) == edit


@pytest.mark.parametrize(
    ("text", "edit"),
    [
        ("noch ein Boden", ("add", "tiers", 1.0, None)),
        ("zwei Böden mehr", ("add", "tiers", 2.0, None)),
        ("ein Bein weniger", ("remove", "legs", 1.0, None)),
        ("mach ihn rot", ("set", "colour", None, "red")),
        ("mach ihn schöner", ("scale", "looks", None, None)),
    ],
)
def test_a_german_change_of_a_feature_is_understood(
    text: str, edit: tuple[str, str, float | None, str | None]
) -> None:
    request = READER.interpret(text, DEFAULT_SETTING)
    assert request.intent is Intent.EDIT
    first = request.edits[0]
    assert (first.op, first.attribute, first.amount, first.value) == edit


@pytest.mark.parametrize("text", ["noch einen Hocker", "noch eine Bank"])
def test_another_thing_in_german_is_a_wish(text: str) -> None:
    assert READER.interpret(text, DEFAULT_SETTING).intent is Intent.DESIGN


def test_a_size_in_german_is_a_size() -> None:
    request = READER.interpret("einen Tisch, 40 cm hoch", DEFAULT_SETTING)
    assert request.dimensions_m == {"height": 0.4}


@pytest.mark.parametrize("text", ["Das Wetter ist schön", "Ich war gestern im Kino", "Guten Abend"])
def test_what_is_no_wish_in_german_is_none(text: str) -> None:
    assert READER.interpret(text, DEFAULT_SETTING).intent is not Intent.DESIGN


def test_what_the_code_writes_in_english_is_said_in_german() -> None:
    assert GERMAN.translated("Nothing waits for a yes.") == "Auf ein Ja wartet gerade nichts."
    assert GERMAN.translated("One stool, not 2.") == "Nur ein Stück (Hocker), nicht 2."
    assert GERMAN.translated("Unheard of.") == "Unheard of."
    assert load_wording("en").translated("Nothing waits for a yes.") == "Nothing waits for a yes."
