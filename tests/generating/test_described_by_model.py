"""A language model describes simple solids; what it writes is input like any other."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cellctl.assembly import Intent, Request
from cellctl.config import CellConfig, load_config, parse_config
from cellctl.control.design_chain import design_by_chain
from cellctl.description import PartsDescription
from cellctl.errors import ConfigError, DesignError
from cellctl.mesh import GeneratedMesh
from cellctl.validating.plan import plan_build
from tests.listening.model_server import ModelServer, Reply, error, model_server

PATH = Path(__file__).parents[2] / "config" / "sim.toml"
CONFIG = load_config(PATH)
TABLE = {
    "title": "anything",
    "parts": [
        {"shape": "box", "size_m": [0.3, 0.3, 0.1], "at_m": [0, 0, 0.25]},
        {"shape": "box", "size_m": [0.1, 0.1, 0.2], "at_m": [0, 0, 0.1]},
    ],
}


@pytest.fixture
def server() -> Iterator[ModelServer]:
    with model_server() as running:
        yield running


def config(url: str, **generating: Any) -> CellConfig:
    data = CONFIG.model_dump(mode="json", exclude_none=True)
    data["understanding"] |= {"model_url": url, "model_name": "small-model"}
    data["generating"] |= {"chain": ["description", "model"], "answer_timeout_s": 5.0} | generating
    return parse_config(data, "cell.toml")


async def _here(function: Callable[..., GeneratedMesh], *arguments: object) -> GeneratedMesh:
    return function(*arguments)


def designed(settings: CellConfig, phrase: str = "violin", **more: Any) -> GeneratedMesh:
    wish = Request(text=phrase, intent=Intent.DESIGN, phrase=phrase, objects=(phrase,), **more)
    return asyncio.run(design_by_chain(wish, settings, _here, lambda _: None)).mesh


def test_what_no_family_knows_is_described_and_can_be_built(server: ModelServer) -> None:
    server.replies = [Reply(content=json.dumps(TABLE))]
    settings = config(server.url)
    found = designed(settings)
    assert found.title == "violin"
    assert found.provenance.startswith("described by small-model")
    assert isinstance(found.description, PartsDescription)
    assert plan_build(found, settings).parts == 11
    (asked,) = server.requests
    assert asked["messages"][-1] == {"role": "user", "content": "a violin"}
    assert "0.6 x 0.5 x 0.6 m" in asked["messages"][0]["content"]


def test_a_stated_size_is_kept(server: ModelServer) -> None:
    server.replies = [Reply(content=json.dumps(TABLE))]
    found = designed(config(server.url), dimensions_m={"height": 0.6})
    assert not found.metric
    assert np.isclose(np.ptp(found.vertices[:, 2]), 0.3)
    assert found.stated_dimensions_m == {"height": 0.6}


def test_a_family_is_asked_first(server: ModelServer) -> None:
    assert designed(config(server.url), "stool").title.startswith("stool")
    assert server.requests == []


@pytest.mark.parametrize(
    ("reply", "said"),
    [
        (Reply(content="I would love to help!"), "not valid JSON"),
        (Reply(content='{"title": "x", "parts": []}'), "parts"),
        (Reply(content='{"title": "x", "parts": [{"shape": "blob"}]}'), "blob"),
        (Reply(content='{"family": "stool"}'), "described no solids"),
        (error(401, "invalid_api_key"), "the key is refused"),
        (error(429, "insufficient_quota"), "quota is used up"),
        (error(500, "server_error"), "failed (500)"),
        (Reply(drop=True), "no connection"),
        (Reply(silent=True), "no answer within"),
    ],
)
def test_an_answer_that_is_of_no_use_is_told(server: ModelServer, reply: Reply, said: str) -> None:
    server.replies = [reply]
    with pytest.raises(DesignError) as refusal:
        designed(config(server.url, answer_timeout_s=0.5 if reply.silent else 5.0))
    assert said in str(refusal.value)
    assert "I can design a stool" in str(refusal.value)
    assert len(server.requests) == 1


def test_a_model_that_nobody_named_is_refused() -> None:
    with pytest.raises(ConfigError, match="model_url and model_name"):
        config("")
