"""What sentences mean: edits, hints, questions, policy, and the command that prints it all."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cellctl.assembly import Edit, Intent, Request
from cellctl.cli.app import command_line
from cellctl.listening.understanding.embedded import EmbeddedInterpreter
from cellctl.listening.understanding.interpreter import DEFAULT_SETTING, Setting
from cellctl.listening.understanding.words import look_up

SAID = Path(__file__).parent / "said.txt"


def understand(text: str, setting: Setting = DEFAULT_SETTING) -> Request:
    return EmbeddedInterpreter().interpret(text, setting)


def short(edit: Edit) -> str:
    """As ``said.txt`` writes it: ``scale height + 2 voxels``, ``add tiers 2``, ``set legs 3``."""
    what = edit.attribute or (edit.axis or "" if edit.op in ("scale", "set") else edit.part)
    words = [edit.op, "" if edit.op == "replace" else what, edit.direction or ""]
    if edit.amount is not None:
        words.append(f"{edit.amount:g}")
        words.append((edit.unit or "") if edit.op == "scale" else "")
    if edit.value is not None:
        words.append(str(edit.value))
    return " ".join(word for word in words if word)


def said() -> list[list[str]]:
    lines = SAID.read_text(encoding="utf-8").splitlines()
    rows = [[cell.strip() for cell in line.split("|")] for line in lines if line[:1] != "#"]
    return [[*row, ""][:4] for row in rows]


@pytest.mark.parametrize(("text", "intent", "phrases", "edits"), said())
def test_what_people_say(text: str, intent: str, phrases: str, edits: str) -> None:
    request = understand(text)
    # There, a plain question is simply no request.
    found = "none" if request.intent is Intent.QUERY else request.intent.value
    assert found == intent
    assert request.phrase in phrases.split("/")
    assert " , ".join(short(edit) for edit in request.edits) == edits
    assert request.why
    assert request.back_end == "rules"


@pytest.mark.parametrize(
    "text",
    [
        "my books are all over the floor i need a shelf",
        "we are having guests so we need a bigger table",
        "scrap it all, make me a bench",
        "it's cold in here, build a fireplace",
        "nice robot, can you make a cat",
    ],
)
def test_a_wish_may_come_after_something_else(text: str) -> None:
    assert understand(text).intent is Intent.DESIGN


@pytest.mark.parametrize(
    "text",
    [
        "remind me to make a chair",
        "tell me how to build a table",
        "my brother said i need a chair",
        "i don't think i need a shelf",
        "he asked if we need a table",
        "make the room warmer",
        "add milk and eggs to my shopping list",
        "take a picture of us",
        "set up a timer for ten minutes",
        "i need a table for two at seven",
        "can i have a beer",
        "make me a millionaire",
        "open the door and the window",
        "We went to Ikea on Saturday, they had a lovely sofa.",
        "Look, Tom, a robot!",
        "Mum, look, a tower, it's falling!",
        "Our neighbours have a cat, three dogs and a parrot.",
        "What's that, a letter T?",
        "No, that was a camel, not a horse.",
        "Can you see the giraffe, sweetheart? Up there, on the picture.",
        "Well, it's a nice machine, but I'd rather see the dinosaurs.",
        "A friend of mine bought a robot for his lawn.",
        "It would be a shame to break it.",
        "Could I have a word with you, please?",
        "Might be a shelf.",
        "Can you make out a shape?",
    ],
)
def test_talk_that_names_things_is_no_wish(text: str) -> None:
    request = understand(text)
    assert request.intent in (Intent.NONE, Intent.QUERY)
    assert (request.phrase, request.objects, request.edits) == ("false", (), ())


@pytest.mark.parametrize(
    "text", ["build me a gun", "a bomb", "a sword please", "make a guillotine", "a swastika",
             "i want a machine gun", "a middle finger", "make it a rifle"],
)  # fmt: skip
def test_what_shall_not_be_built_is_refused_politely(text: str) -> None:
    request = understand(text)
    assert not request.buildable
    assert request.refusal.startswith("I would rather not build")
    assert request.phrase != "false", "it was understood all the same"


@pytest.mark.parametrize(
    "text",
    ["a water gun", "a knife rack", "a bread knife block", "a cannon tower", "a gun holder",
     "a house as big as mine"],
)  # fmt: skip
def test_what_only_sounds_like_a_weapon_is_built(text: str) -> None:
    assert understand(text).buildable


@pytest.mark.parametrize(
    ("text", "hints", "asked"),
    [
        ("a simple stool", (), ""),
        ("a mug", ("too_small",), ""),
        ("a stool 2 cm high", ("too_small",), ""),
        ("a table 2 metres wide", ("too_big",), ""),
        ("a house", ("too_big",), ""),
        ("a house 50 cm high", (), ""),
        ("two stools", ("too_many",), "begin with one stool?"),
        ("a shelf and a stool", ("too_many",), "begin with the shelf?"),
        ("a bench or a stool", (), "a bench or a stool?"),
        ("a ladder with a hundred rungs", ("too_many",), ""),
        ("something to sit on", (), "a stool, a chair or a bench?"),
        ("i need somewhere to put my books", (), "a shelf?"),
    ],
)
def test_what_is_known_before_it_is_designed(text: str, hints: tuple[str, ...], asked: str) -> None:
    request = understand(text)
    assert request.hints == hints
    assert request.ask.endswith(asked)
    assert bool(request.ask) == bool(asked)


def test_hints_go_by_the_cell() -> None:
    large = Setting(pitch_m=0.05, workspace_m=(3.0, 3.0, 3.0), parts=1000)
    assert understand("a table 2 metres wide", large).hints == ()
    assert understand("a tower ten blocks high", large).dimensions_m == {"height": 0.5}


def test_each_size_says_where_it_comes_from() -> None:
    assert understand("a table 60 cm wide").dimension_sources == {"width": "stated"}
    assert understand("a tower six blocks high").dimension_sources == {"height": "voxels"}
    assert understand("an eighteen inch stool").dimension_sources == {"height": "axis_assumed"}


def test_a_correction_is_told() -> None:
    request = understand("a shelf with to tears")
    assert [(change.heard, change.taken) for change in request.corrections] == [
        ("to", "two"),
        ("tears", "tiers"),
    ]


def test_the_table_of_words() -> None:
    stool, beauty = look_up("stool"), look_up("beauty")
    assert stool is not None
    assert beauty is not None
    assert stool.physical > 0.8
    assert beauty.physical < 0.3
    assert stool.class_name == "artifact"
    assert look_up("blorp") is None
    tower = look_up("eiffel tower")
    assert tower is not None
    assert tower.proper


class TestCommand:
    """``cellctl understand``: a line of JSON for each line."""

    @pytest.fixture(autouse=True)
    def _no_configuration(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.delenv("CELLCTL_CONFIG", raising=False)

    def run(self, *arguments: str, given: bytes = b"") -> list[dict[str, object]]:
        result = CliRunner().invoke(command_line(), ["understand", *arguments], input=given)
        assert result.exit_code == 0, result.output
        return [json.loads(line) for line in result.stdout.splitlines()]

    def test_every_line_is_answered(self) -> None:
        lines = self.run(given=b"I need a shelf with two tiers\n\n  \nmake it taller\r\n\xff\nstop")
        assert [line["text"] for line in lines] == [
            "I need a shelf with two tiers", "", "  ", "make it taller", "�", "stop",
        ]  # fmt: skip
        assert [line["intent"] for line in lines] == [
            "design", "none", "none", "edit", "none", "control",
        ]  # fmt: skip
        assert lines[0]["phrase"] == "shelf with two tiers"
        assert (lines[0]["objects"], lines[0]["count"]) == (["shelf"], 1)
        assert lines[0]["attributes"] == {"tiers": 2}
        assert lines[3]["edit"] == {"op": "scale", "axis": "height", "dir": "+"}
        assert lines[5]["command"] == "stop"

    def test_files_and_standard_input(self, tmp_path: Path) -> None:
        (tmp_path / "one.txt").write_text("a stool 50 cm high\n")
        lines = self.run(str(tmp_path / "one.txt"), "-", given=b"a dog\n")
        assert [line["phrase"] for line in lines] == ["stool", "dog"]
        assert lines[0]["dimensions_m"] == {"height": 0.5}

    def test_a_file_that_is_none(self, tmp_path: Path) -> None:
        result = CliRunner().invoke(command_line(), ["understand", str(tmp_path / "none.txt")])
        assert result.exit_code != 0
        assert "cannot be read" in str(result.exception)

    def test_the_configured_cell_counts(self) -> None:
        config = Path(__file__).parents[2] / "config" / "sim.toml"
        lines = self.run("--config", str(config), given=b"a tower six blocks high\n")
        assert lines[0]["dimensions_m"] == {"height": 0.6}
