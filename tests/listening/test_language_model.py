"""The language model's back end against a service that misbehaves in every documented way."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from cellctl.assembly import Intent, Request
from cellctl.config import UnderstandingSection
from cellctl.credentials import Credential
from cellctl.errors import ConfigError
from cellctl.listening.understanding.embedded import EmbeddedInterpreter
from cellctl.listening.understanding.interpreter import DEFAULT_SETTING
from cellctl.listening.understanding.language_model.interpreter import LanguageModelInterpreter
from cellctl.listening.understanding.language_model.prompts import (
    ANSWER_SCHEMA,
    PAPER_EXAMPLES,
    PAPER_PROMPT,
    PRESETS,
)
from tests.listening.model_server import KEY, ModelServer, Reply, error, model_server

DESIGN: dict[str, Any] = {
    "intent": "design",
    "phrase": "stool with three legs",
    "objects": ["stool"],
    "count": 1,
    "attributes": {"legs": 3, "tiers": None, "steps": None, "drawers": None, "back": None,
                   "arms": None, "lid": None, "glyph": None, "colour": None},
    "width_m": None,
    "depth_m": None,
    "height_m": 0.5,
    "edits": [],
    "question": "",
}  # fmt: skip
SENTENCE = "a three legged stool half a metre high"


@pytest.fixture
def server() -> Iterator[ModelServer]:
    with model_server() as running:
        yield running


def section(server: ModelServer, **changes: Any) -> UnderstandingSection:
    values: dict[str, Any] = {
        "back_end": "model",
        "model_url": server.url,
        "model_name": "tiny",
        "timeout_s": 1.0,
        "budget_s": 3.0,
        "attempts": 2,
    }
    return UnderstandingSection(**{**values, **changes})


def interpreter(server: ModelServer, **changes: Any) -> LanguageModelInterpreter:
    key = Credential(KEY, "here")
    return LanguageModelInterpreter(section(server, **changes), EmbeddedInterpreter(), key)


def ask(server: ModelServer, text: str = SENTENCE, **changes: Any) -> Request:
    return interpreter(server, **changes).interpret(text, DEFAULT_SETTING)


def answering(**changes: Any) -> Reply:
    return Reply(content=json.dumps({**DESIGN, **changes}))


def test_the_answer_becomes_a_request(server: ModelServer) -> None:
    server.replies = [answering()]
    request = ask(server)
    assert request.intent is Intent.DESIGN
    assert (request.phrase, request.objects) == ("stool with three legs", ("stool",))
    assert request.attributes == {"legs": 3}
    assert request.dimensions_m == {"height": 0.5}
    assert request.back_end == "tiny at 127.0.0.1"
    assert request.cloud == "", "the words stayed on this computer"
    body = server.requests[0]
    assert body["model"] == "tiny"
    assert body["messages"][-1] == {"role": "user", "content": SENTENCE}
    assert body["response_format"]["json_schema"]["schema"] == ANSWER_SCHEMA
    assert server.keys == [f"Bearer {KEY}"]


def test_edits_and_refusals_hold_for_a_models_answer_too(server: ModelServer) -> None:
    edit = {"op": "scale", "part": "", "attribute": "", "axis": "height", "direction": "+",
            "amount": 2, "unit": "voxels", "value": None}  # fmt: skip
    server.replies = [answering(intent="edit", phrase="false", objects=[], edits=[edit])]
    request = ask(server, "could it be two blocks taller than that")
    assert request.intent is Intent.EDIT
    assert (request.edits[0].axis, request.edits[0].amount) == ("height", 2)
    server.replies = [answering(phrase="gun", objects=["gun"])]
    assert ask(server, "i want a gun").refusal, "policy is the cell's, not the model's"


@pytest.mark.parametrize(
    "answer",
    [
        Reply(content="I would love to help you with a stool!"),
        Reply(content="[]"),
        Reply(content='{"intent": "design"}'),
        Reply(content=json.dumps({**DESIGN, "extra": 1})),
        Reply(content=json.dumps(DESIGN)[:60]),
        answering(intent="control"),
        answering(count=-1),
        answering(height_m=1e9),
        answering(height_m=0),
        answering(attributes={**DESIGN["attributes"], "legs": 10**6}),
        answering(objects=[]),
        answering(phrase="false"),
        answering(phrase="<script>alert(1)</script>"),
        answering(objects=["elephant"], phrase="elephant"),
        answering(objects=["x" * 100]),
        answering(intent="edit", edits=[]),
        Reply(content=json.dumps(DESIGN).replace("0.5", "NaN")),
        Reply(content="[" * 5000),
        Reply(content=" "),
        Reply(content=json.dumps(DESIGN), finish_reason="length"),
        Reply(content=json.dumps(DESIGN), finish_reason="content_filter"),
        Reply(body=b"<html>gateway</html>"),
        Reply(body=b"{}"),
        Reply(body=b'{"choices": []}'),
        Reply(body=b'{"choices": [{"message": null}]}'),
        Reply(body=b"x" * 1_000_000),
        Reply(status=302, headers={"location": "http://127.0.0.1:1/"}),
        Reply(drop=True),
        error(400, "invalid_request_error"),
        error(500, "server_error"),
        error(503, "overloaded", retry_after="0"),
        error(503, "overloaded", retry_after="Wed, 21 Oct 2026 07:28:00 GMT"),
    ],
)
def test_what_cannot_be_taken_leaves_the_decision_to_the_embedded_back_end(
    server: ModelServer, answer: Reply
) -> None:
    server.replies = [answer]
    request = ask(server)
    assert request.back_end == "rules"
    assert (request.phrase, request.attributes) == ("three legged stool", {"legs": 3})
    assert "was of no use" in request.why
    assert KEY not in request.model_dump_json()


@pytest.mark.parametrize("answer", [Reply(silent=True), Reply(trickle=True)])
def test_a_service_that_never_ends_is_left_within_the_budget(
    server: ModelServer, answer: Reply
) -> None:
    server.replies = [answer]
    begin_s = time.monotonic()
    request = ask(server, timeout_s=0.2, budget_s=0.5, attempts=6)
    assert request.back_end == "rules"
    assert time.monotonic() - begin_s < 30.0
    assert len(server.requests) <= 4


def test_a_failure_that_passes_is_tried_again(server: ModelServer) -> None:
    server.replies = [error(503, "overloaded", retry_after="0"), answering()]
    assert ask(server).back_end == "tiny at 127.0.0.1"
    assert len(server.requests) == 2
    server.replies = [error(429, "rate_limit_exceeded", retry_after="0"), answering()]
    assert ask(server).back_end == "tiny at 127.0.0.1"


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (error(401, "invalid_api_key"), "key is refused"),
        (error(429, "insufficient_quota"), "quota"),
        (error(404, "model_not_found", "no model tiny"), "no such model"),
        (error(429, "rate_limit_exceeded", retry_after="3600"), "too many"),
    ],
)
def test_what_no_second_attempt_cures_keeps_nobody_waiting_again(
    server: ModelServer, answer: Reply, said: str
) -> None:
    server.replies = [answer]
    asking = interpreter(server)
    assert said in asking.interpret(SENTENCE, DEFAULT_SETTING).why
    second = asking.interpret(SENTENCE, DEFAULT_SETTING)
    assert second.phrase == "three legged stool"
    assert "not asked again yet" in second.why
    assert len(server.requests) == 1


def test_it_costs_no_more_than_it_may(server: ModelServer) -> None:
    server.replies = [answering()]
    asking = interpreter(server, requests_per_hour=2)
    for expected in ("tiny at 127.0.0.1", "tiny at 127.0.0.1", "rules"):
        assert asking.interpret(SENTENCE, DEFAULT_SETTING).back_end == expected
    assert len(server.requests) == 2


@pytest.mark.parametrize("text", ["stop", "Stop!", "pause please", "yes", "", "   ", "a " * 80])
def test_words_of_command_and_no_words_pass_no_model(server: ModelServer, text: str) -> None:
    server.replies = [answering()]
    request = ask(server, text)
    assert request.intent in (Intent.CONTROL, Intent.NONE)
    assert server.requests == []


def test_nobody_there_is_no_error(server: ModelServer) -> None:
    request = ask(server, model_url="http://127.0.0.1:1/v1", attempts=1)
    assert request.phrase == "three legged stool"
    assert "no connection" in request.why


def test_words_that_leave_the_computer_are_told() -> None:
    settings = UnderstandingSection(
        back_end="model", model_url="https://model.invalid/v1", model_name="big", attempts=1,
        timeout_s=2.0, budget_s=2.0,
    )  # fmt: skip
    asking = LanguageModelInterpreter(settings, EmbeddedInterpreter(), Credential(KEY, "here"))
    assert asking.interpret(SENTENCE, DEFAULT_SETTING).cloud == "model.invalid"
    with pytest.raises(ConfigError, match="unencrypted"):
        LanguageModelInterpreter(
            settings.model_copy(update={"model_url": "http://model.invalid/v1"}),
            EmbeddedInterpreter(),
            Credential(KEY, "here"),
        )


class TestThePapersPrompt:
    """The prompt and its examples as the paper prints them, and what is made of the answers."""

    def test_it_is_sent_word_for_word(self, server: ModelServer) -> None:
        server.replies = [Reply(content="simple stool")]
        request = ask(server, "I want a simple stool", prompt="paper")
        assert request.phrase == "simple stool"
        contents = [message["content"] for message in server.requests[0]["messages"]]
        assert contents == [
            PAPER_PROMPT, "I need a shelf", "shelf", "Knowledge", "false", "I want a simple stool",
        ]  # fmt: skip
        assert "response_format" not in server.requests[0]

    def test_it_is_the_papers(self, test_data: Path) -> None:
        paper = test_data.parent / "paper.tex"
        if not paper.is_file():
            pytest.skip("the paper is not at hand")
        source = paper.read_text(encoding="utf-8")
        assert f'The prompt we used is: "{PAPER_PROMPT}" To ensure' in source
        printed = re.findall(r'Request: "([^"]+?) ?" → Response: "([^"]+)"', source)
        assert tuple(printed) == PAPER_EXAMPLES
        assert PRESETS["paper"].examples == PAPER_EXAMPLES

    @pytest.mark.parametrize(
        ("text", "answer", "phrase", "attributes"),
        [
            ("create beauty", "false", "false", {}),
            ("create beauty", "'False'.", "false", {}),
            ("make me a coffee table", '"coffee table"', "coffee table", {}),
            ("a shelf with two tiers", "A shelf with two tiers", "shelf with two tiers",
             {"tiers": 2}),
            ("I need a box to hold memories", "box", "box", {}),
        ],
    )  # fmt: skip
    def test_its_answers(
        self, server: ModelServer, text: str, answer: str, phrase: str, attributes: dict[str, int]
    ) -> None:
        server.replies = [Reply(content=answer)]
        request = ask(server, text, prompt="paper")
        assert (request.phrase, request.attributes) == (phrase, attributes)
        assert request.back_end == "tiny at 127.0.0.1"

    @pytest.mark.parametrize(
        "answer", ["Sure! Here is the phrase you asked for: stool " * 3, "an elephant", "\x00"]
    )
    def test_what_is_neither_phrase_nor_false_is_not_taken(
        self, server: ModelServer, answer: str
    ) -> None:
        server.replies = [Reply(content=answer)]
        request = ask(server, "a stool", prompt="paper")
        assert (request.phrase, request.back_end) == ("stool", "rules")


@pytest.mark.parametrize(
    "values",
    [
        {"model_name": ""},
        {"model_url": ""},
        {"model_url": "ftp://host/v1"},
        {"model_url": "https://user:secret@host/v1"},
        {"budget_s": 1.0, "timeout_s": 2.0},
    ],
)
def test_a_back_end_that_cannot_work_is_refused_at_the_start(values: dict[str, Any]) -> None:
    good: dict[str, Any] = {
        "back_end": "model", "model_url": "https://host/v1", "model_name": "big"
    }  # fmt: skip
    UnderstandingSection(**good)
    with pytest.raises(ValidationError):
        UnderstandingSection(**{**good, **values})
