"""What a language model answered, checked like any other input, and what it means."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cellctl.assembly import Attribute, Axis, Edit, EditOp, Intent, Request
from cellctl.listening.attributes import read_attributes
from cellctl.listening.dimensions import read_sizes
from cellctl.listening.lexicon import singular
from cellctl.listening.phrases import read_phrase
from cellctl.listening.request import tokens
from cellctl.listening.snapping import unvoiced_sound_of
from cellctl.listening.understanding.hints import hints_of, question_of
from cellctl.listening.understanding.interpreter import Setting
from cellctl.listening.understanding.judging import kind_of
from cellctl.listening.understanding.policy import refusal_of

Noun = Annotated[str, Field(pattern=r"^[a-z][a-z '\-]{0,38}$")]
Size = Annotated[float, Field(gt=0.0, le=100.0)]
Count = Annotated[int, Field(ge=0, le=200)]
_ARTICLE = re.compile(r"^(?:a|an|the|some) ")
_PHRASE = re.compile(r"[a-z0-9][a-z0-9 ',.\-]{0,118}")
_MOST_CHARACTERS = 8000


class UselessAnswerError(Exception):
    """A model answered, and the answer cannot be taken."""


class _Checked(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class _Attributes(_Checked):
    legs: Count | None = None
    tiers: Count | None = None
    steps: Count | None = None
    drawers: Count | None = None
    back: bool | None = None
    arms: bool | None = None
    lid: bool | None = None
    glyph: Annotated[str, Field(pattern=r"^[A-Za-z0-9]$")] | None = None
    colour: Noun | None = None


class _Edit(_Checked):
    op: EditOp
    part: Annotated[str, Field(pattern=r"^[a-z ]{0,40}$")] = ""
    attribute: Literal[
        "", "legs", "tiers", "steps", "drawers", "arches", "back", "arms", "lid", "glyph",
        "colour", "count", "strength",
    ] = ""  # fmt: skip
    axis: Literal["width", "depth", "height", "length"] | None = None
    direction: Literal["+", "-"] | None = None
    amount: Annotated[float, Field(gt=0.0, le=360.0)] | None = None
    unit: Literal["parts", "voxels", "metres", "times", "degrees"] | None = None
    value: Count | bool | Noun | None = None


class _Answer(_Checked):
    intent: Literal["design", "edit", "query", "none"]
    phrase: Annotated[str, Field(max_length=200)]
    objects: Annotated[list[Noun], Field(max_length=6)] = []
    count: Count = 0
    attributes: _Attributes = _Attributes()
    width_m: Size | None = None
    depth_m: Size | None = None
    height_m: Size | None = None
    edits: Annotated[list[_Edit], Field(max_length=8)] = []
    question: Annotated[str, Field(max_length=200)] = ""


def read_structured(content: str, text: str, setting: Setting) -> Request:
    """The request that an answer by the schema stands for.

    Raises:
        UselessAnswerError: it does not follow the schema, contradicts itself, or names an object of
            which the sentence says nothing.
    """
    if len(content) > _MOST_CHARACTERS:
        raise UselessAnswerError("the answer is too long")
    try:
        answer = _Answer.model_validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the answer"
        raise UselessAnswerError(f"{where}: {first['msg']}") from error
    phrase = _phrase(answer.phrase)
    edits = tuple(Edit.model_validate(edit.model_dump()) for edit in answer.edits)
    replaces = any(edit.op == "replace" for edit in edits)
    if answer.intent == "edit" and not edits:
        raise UselessAnswerError("it is an edit that changes nothing")
    named = answer.intent == "design" or (answer.intent == "edit" and replaces)
    if not named:
        return _plain(answer, text, edits)
    if phrase == "false" or not answer.objects:
        raise UselessAnswerError("it names no object, and wants one")
    _mentioned(answer.objects, text)
    objects = tuple(singular(noun.split()[-1]) for noun in answer.objects)
    attributes: dict[str, Attribute] = answer.attributes.model_dump(exclude_none=True)
    if isinstance(glyph := attributes.get("glyph"), str):
        attributes["glyph"] = glyph.upper()
    said: dict[Axis, float | None] = {
        "width": answer.width_m,
        "depth": answer.depth_m,
        "height": answer.height_m,
    }
    sizes = {axis: size_m for axis, size_m in said.items() if size_m is not None}
    count = max(1, answer.count)
    return Request(
        text=text,
        intent=Intent(answer.intent),
        phrase=phrase,
        objects=objects,
        kind=kind_of(objects[0]),
        count=count,
        attributes=attributes,
        dimensions_m=sizes,
        dimension_sources=dict.fromkeys(sizes, "stated"),
        edits=edits if answer.intent == "edit" else (),
        hints=hints_of(objects[0], count, sizes, attributes, setting),
        ask=_question(answer.question) or question_of(objects, count, either=False),
        refusal=refusal_of(phrase.split(), objects[0]),
    )


def read_phrase_answer(content: str, text: str, setting: Setting) -> Request:
    """The request that an answer to the paper's prompt stands for: a phrase, or "false".

    Its attributes and sizes are read from the sentence by rules, for the prompt asks for none.

    Raises:
        UselessAnswerError: it is neither.
    """
    answer = content.strip().strip("\"'.`").strip().lower()
    phrase = _ARTICLE.sub("", answer)
    if phrase == "false":
        return Request(text=text, intent=Intent.NONE, phrase="false", reason=_NO_OBJECT)
    named = read_phrase(tokens(phrase), []) if _PHRASE.fullmatch(phrase) else None
    if named is None or len(phrase.split()) > 16:
        raise UselessAnswerError("the answer is neither a phrase nor false")
    _mentioned(named.objects, text)
    words = tokens(text)
    sizes = read_sizes(words, setting.pitch_m)
    attributes = read_attributes(words, named.objects[0])
    return Request(
        text=text,
        intent=Intent.DESIGN,
        phrase=phrase,
        objects=named.objects,
        count=named.count,
        attributes=attributes,
        dimensions_m=sizes.metres,
        dimension_sources=sizes.sources,
        hints=hints_of(named.objects[0], named.count, sizes.metres, attributes, setting),
        ask=question_of(named.objects, named.count, either=named.either),
        refusal=refusal_of(words, named.objects[0]),
    )


_NO_OBJECT = (
    'I heard no wish for an object in that. Try "a simple stool" or "a shelf with two tiers".'
)


def _plain(answer: _Answer, text: str, edits: tuple[Edit, ...]) -> Request:
    """An edit without a new object, a question, or nothing."""
    intent = Intent(answer.intent)
    ask = _question(answer.question)
    return Request(
        text=text,
        intent=intent,
        phrase="false",
        edits=edits if intent is Intent.EDIT else (),
        ask=ask,
        reason="" if intent is Intent.EDIT else f"{_NO_OBJECT} {ask}".strip(),
    )


def _phrase(said: str) -> str:
    phrase = _ARTICLE.sub("", said.strip().lower())
    if not _PHRASE.fullmatch(phrase):
        raise UselessAnswerError("phrase: is none")
    return phrase


def _question(said: str) -> str:
    """A question for the visitor; what is none, or holds what no question does, is dropped."""
    plain = " ".join(said.split())
    return plain if re.fullmatch(r"[A-Za-z][\w ,;:'\-]{2,150}\?", plain) else ""


def _mentioned(objects: list[str] | tuple[str, ...], text: str) -> None:
    """What the sentence says nothing of was made up, or spoken into the model's mouth."""
    said = {singular(word) for word in tokens(text)}
    joined = "".join(tokens(text))
    for noun in objects:
        words = [singular(word) for word in noun.replace("-", " ").split()]
        if (
            not set(words) & said
            and noun.replace(" ", "") not in joined
            and not _sounds(words, said)
        ):
            raise UselessAnswerError(f"nobody said {noun!r}")


def _sounds(words: list[str], said: set[str]) -> bool:
    return bool({unvoiced_sound_of(word) for word in words} & {unvoiced_sound_of(w) for w in said})
