"""What the code writes in English is said in every language: no sentence escapes its message."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from cellctl.assembly import Request
from cellctl.config import load_config
from cellctl.control.plainly import BY_FAULT, BY_RULE, INSTEAD, plainly
from cellctl.control.sentences import Sentences
from cellctl.errors import CATALOGUE, CellFault, DesignError, PlanError
from cellctl.generating.design import design
from cellctl.generating.families import FAMILIES
from cellctl.listening.request import read_request
from cellctl.validating.fit import size_questions
from cellctl.wording import languages, load_wording
from tests.leaks import REPOSITORY

ENGLISH, GERMAN = load_wording("en"), load_wording("de")
ROOMS = ("generating", "validating", "control", "feeding", "assembling")
"""Whose errors, faults and changes people are told."""
SPEAKING = {
    *("RefusedError", "DesignError", "UnknownObjectError", "PlanError", "NoObjectError"),
    *("CellFault", "Change", "ServiceError", "LateError", "BusyError"),
}
SAID = {"what", "why", "message", "hint", "detail"}
FOR_LOGS = ("journal_", "backup", "files.py")
"""Modules whose errors name files and their damage: for those who mend them."""
COMPOSED = {
    "I can design 7.": "ends with a list of things",
    "7; 7 instead of 7.": "begins with what stays",
    "It is 7.": "how it was turned",
    "This shape cannot be built here. 7": "ends with the reasons",
    "The arm cannot place every part of this object anywhere in the workspace. 7": "the same",
    "The belt is full; 7 to come off and no room on it.": "a number with its verb",
    "7 There should be 7 on the belt.": "begins with what was seen",
    "7: 7.": "a place, and what the system says of it",
    "At 7 7.": "a place, and what is felt there",
    "7: 7": "a defect, named by its class",
    "The arm 7 7.": "what it cannot do, and where",
    "7 7.": "what a service says, or two sentences that are written elsewhere",
    "7 It may have begun all the same, so I do not ask twice.": "begins with what went wrong",
}
"""Sentences whose literal part is no message: what they are made of is."""


def samples(node: ast.expr) -> Iterator[str]:
    """What an expression may say, with a number for everything that is computed."""
    match node:
        case ast.Constant(value=str(text)):
            yield text
        case ast.JoinedStr(values=values):
            found = [""]
            for value in values:
                inner = value.value if isinstance(value, ast.FormattedValue) else value
                ways = list(samples(inner)) or ["7"]
                found = [start + way for start in found for way in ways]
            yield from found
        case ast.IfExp(body=body, orelse=other):
            yield from samples(body)
            yield from samples(other)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            yield from (one + two for one in samples(left) for two in samples(right))


def written(file: Path) -> Iterator[tuple[int, str]]:
    """Sentences of the errors and changes of a module, by line."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        match node:
            case ast.Call(func=ast.Name(id=name), args=args, keywords=keywords):
                if name in SPEAKING:
                    said = [*args, *(word.value for word in keywords if word.arg in SAID)]
                    for value in said[name == "CellFault" :][:2]:
                        # What a service says itself may follow.
                        found = (re.sub(r"(?<=\.)7$", "", text) for text in samples(value))
                        yield from ((node.lineno, text) for text in found if text)


@pytest.mark.parametrize("room", ROOMS)
def test_every_sentence_has_its_message(room: str) -> None:
    unknown = [
        f"{file.relative_to(REPOSITORY)}:{line}: {text}"
        for file in sorted((REPOSITORY / "cellctl" / room).rglob("*.py"))
        if not file.name.startswith(FOR_LOGS) and file.name not in FOR_LOGS
        for line, text in written(file)
        if text not in COMPOSED and not ENGLISH.knows(text)
    ]
    assert not unknown, "add to cellctl/wording/*/: " + "\n".join(unknown)


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("code", CATALOGUE)
def test_every_fault_has_its_messages(language: str, code: str) -> None:
    entry, wording = CATALOGUE[code], load_wording(language)
    for part, text in (("title", entry.title), ("remedy", entry.remedy)):
        said = wording.text(f"fault.{code}.{part}")
        assert ENGLISH.text(f"fault.{code}.{part}") == text
        assert wording.translated(text) == said
        assert (said == text) == (language == "en")


FOR_OPERATORS = re.compile(
    r"`|cellctl|[a-z]\.[a-z]|reset|resume|cancel|lösche|störung|port|board|platine", re.IGNORECASE
)
"""Commands, options, and what only those know who mend the cell."""


@pytest.mark.parametrize("code", CATALOGUE)
def test_every_fault_is_told_visitors_without_what_only_operators_can_do(code: str) -> None:
    fault, told = CellFault(code, "Output 3 could not be written."), set()
    for wording in (ENGLISH, GERMAN):
        sentences = Sentences(wording, 0.05, 1, lambda: 0)
        line = sentences.for_visitors(CATALOGUE[code].leads_to, fault)
        assert line is not None
        assert line.language == wording.language
        assert not FOR_OPERATORS.search(line.text)
        told.add(line.text)
    assert len(told) == 2


def test_every_reason_to_wait_is_told_and_no_other() -> None:
    told = {f"waits.{key}" for key in ENGLISH.under("waits")}
    assert told == {*BY_FAULT.values(), "waits.look"}
    assert BY_FAULT.keys() == CATALOGUE.keys()


@pytest.mark.parametrize(
    ("english", "german"),
    [
        (
            "This shape cannot be built here. It breaks the rule of count: It would take 60 parts, "
            "and there are 40. Cells: [0, 0, 0] and 58 more. What could be built: something of 30 "
            "parts, 3 x 4 x 5 (wide, deep, high), that keeps 80% of the shape. Ask for another "
            "shape, or a simpler one.",
            "Diese Form lässt sich hier nicht bauen. Es verletzt die Regel „Anzahl“: Es würde 60 "
            "Teile brauchen, und es gibt 40. Zellen: [0, 0, 0] und 58 weitere. Bauen ließe sich: "
            "etwas (30 Teile; 3 x 4 x 5 breit, tief, hoch), das 80% der Form bewahrt. Wünsche dir "
            "eine andere Form, oder eine einfachere.",
        ),
        (
            "It is one part narrower and two parts lower: 3 x 3 x 3 parts (wide, deep, high) "
            "instead of 4 x 3 x 5.",
            "Es ist ein Teil schmaler und zwei Teile niedriger: 3 x 3 x 3 Teile (breit, tief, "
            "hoch) statt 4 x 3 x 5.",
        ),
        ("One leg moved in.", "Ein Bein: nach innen gerückt."),
        ("I cannot change the colour of a table. I can change: its sizes, legs.",
         "Das kann ich nicht ändern: Farbe (ein Tisch). Ändern kann ich: seine Größe, Beine."),
        ("I cannot design a table with no legs; at least one leg here.",
         "Das kann ich nicht entwerfen: Tisch, keine Beine; hier mindestens ein Bein."),
        ("All legs became thinner.", "Alle Beine: dünner geworden."),
        ("Two parts of the legs are left out.", "Zwei Teile fehlen (Beine)."),
        ("7 parts laid on the belt. On the belt: 12, in the stock: 28.",
         "7 Teile auf das Band gelegt. Auf dem Band: 12, im Vorrat: 28."),
        ("1 part laid on the belt.", "1 Teil auf das Band gelegt."),
        ("Part 3 may be in the gripper, or stand at its cell",
         "Teil 3 ist vielleicht im Greifer, oder steht an seinem Platz"),
        ("Unheard of. Try again.", "Unheard of. Versuche es noch einmal."),
    ],
)  # fmt: skip
def test_fields_are_said_in_the_language_as_well(english: str, german: str) -> None:
    assert GERMAN.translated(english) == german
    assert ENGLISH.translated(english) == english
    assert GERMAN.translated(german) == german


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        (
            "a shelf with nine tiers",
            "kann ich nicht entwerfen: Regal, neun Böden; hier höchstens 6.",
        ),
        ("the sign %", "Ich habe nicht gehört, welchen Buchstaben oder welche Ziffer. Sage, welch"),
        ("a zeppelin", "Das kann ich noch nicht entwerfen: "),
        ("a penguin", "ein Hund, eine Katze, eine Giraffe, ein Elefant oder eine Ente."),
    ],
)
def test_refusals_of_real_wishes_have_no_english_in_them(wish: str, said: str) -> None:
    config = load_config(REPOSITORY / "config" / "sim.toml")
    request: Request = read_request(wish)
    with pytest.raises(DesignError) as refused:
        design(request, config)
    assert ENGLISH.knows(refused.value.message)
    assert said in GERMAN.translated(str(refused.value))


TRAITS = {"colour", "looks", "weight", "roundness", "strength", "simplicity"}
"""Of things, that people would like to have otherwise, and nothing here can change."""


@pytest.mark.parametrize("name", sorted(TRAITS.union(*(family.takes for family in FAMILIES))))
def test_what_people_would_change_of_a_thing_is_named_in_the_language(name: str) -> None:
    assert ENGLISH.knows(name)
    assert GERMAN.translated(name) != name


def test_every_rule_is_said_plainly_in_every_language() -> None:
    broken = {
        word.value.value
        for file in (REPOSITORY / "cellctl" / "validating").rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        for word in node.keywords
        if word.arg == "rule" and isinstance(word.value, ast.Constant)
    }
    assert broken
    assert broken <= BY_RULE.keys()
    for text in (*BY_RULE.values(), INSTEAD):
        assert ENGLISH.knows(text)
        assert GERMAN.translated(text) != text


def test_a_visitor_is_told_neither_cells_nor_settings() -> None:
    refusal = PlanError(
        "It would take 60 parts, and there are 40. Cells: [0, 3, 0] and 59 more.",
        "Get more parts and tell of them (`limits.inventory_parts`).",
        rule="count",
    )
    assert plainly(refusal) == (
        "It takes more parts than I have. "
        "Ask for something smaller or simpler, or for something else."
    )
    assert plainly(DesignError("I cannot.", "Ask.")) == "I cannot. Ask."


@pytest.mark.parametrize(
    "text",
    [
        *size_questions({"width": 1.0}, (6, 6, 6), 0.1),
        "I am asking Meshy for a giraffe.",
        "Meshy has begun (task 7f3a).",
        "Meshy works on it: 40 %.",
        "generated by Meshy",
        "The quota at Meshy is used up. It says: No credit.",
        "from the catalogue, by Ann Example, CC-BY 4.0",
        "I cannot make out spoken words at the moment. Please type them.",
    ],
)
def test_what_is_told_besides_has_its_message(text: str) -> None:
    assert ENGLISH.knows(text)
    said = GERMAN.translated(text)
    assert not {"the", "is", "of", "for", "please"} & set(re.findall(r"[a-z]+", said.lower()))


def test_a_fault_with_its_detail_is_told_in_the_language() -> None:
    fault = CellFault("belt_jam", "After 10 s the belt is still moving.")
    assert ENGLISH.knows(str(fault))
    assert "Nach 10 s: das Band läuft noch." in GERMAN.translated(str(fault))
