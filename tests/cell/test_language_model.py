"""A daemon that asks a language model: its answers count, and its failures stop nothing."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from tests.cell.harness import RunningCell, running_cell
from tests.listening.model_server import ModelServer, Reply, error, model_server
from tests.listening.test_language_model import DESIGN

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


@pytest.fixture(scope="module")
def server() -> Iterator[ModelServer]:
    with model_server() as running:
        yield running


@pytest.fixture(scope="module")
def cell(server: ModelServer) -> Iterator[RunningCell]:
    understanding = {
        "back_end": "model",
        "model_url": server.url,
        "model_name": "tiny",
        "timeout_s": 0.5,
        "budget_s": 1.0,
    }
    policy = {"confirmation": "ask"}
    with running_cell(speed=10.0, policy=policy, understanding=understanding) as running:
        yield running


def asked_about(cell: RunningCell, sentence: str) -> tuple[str, str]:
    """The question that the sentence leads to, and who understood it."""
    cell.begin_test()
    cell.visitor.say(sentence)
    snapshot = cell.wait_state("validating_confirming")
    assert snapshot.job is not None
    assert snapshot.job.request is not None
    cell.visitor.confirm(False)
    cell.finish()
    return snapshot.state.sentence, snapshot.job.request.back_end


def test_the_models_answer_is_designed(cell: RunningCell, server: ModelServer) -> None:
    server.replies = [Reply(content=json.dumps({**DESIGN, "height_m": 0.4}))]
    question, back_end = asked_about(cell, "something like a stool but on three legs")
    assert question.startswith("Stool with three legs")
    assert " x 40 cm" in question
    assert back_end == "tiny at 127.0.0.1"


@pytest.mark.parametrize("reply", [Reply(silent=True), error(500, "server_error")])
def test_the_cell_goes_on_without_it(cell: RunningCell, server: ModelServer, reply: Reply) -> None:
    server.replies = [reply]
    question, back_end = asked_about(cell, "a simple stool")
    assert question.startswith("Stool")
    assert back_end == "rules"


def test_stop_asks_no_model(cell: RunningCell, server: ModelServer) -> None:
    server.replies = [Reply(silent=True)]
    before = len(server.requests)
    assert "nothing moves" in cell.visitor.say("stop").message
    assert len(server.requests) == before
