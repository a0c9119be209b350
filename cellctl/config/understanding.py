"""The table of how words are understood."""

from __future__ import annotations

from typing import Annotated, Literal, Self
from urllib.parse import urlsplit

from pydantic import Field, model_validator

from cellctl.config.section import Section


class UnderstandingSection(Section):
    """How words are understood: by this computer alone, or by a language model first."""

    back_end: Literal["embedded", "model"] = "embedded"
    """``embedded`` needs no network; ``model`` asks a language model, and falls back to the former
    whenever that fails."""
    model_url: str = ""
    """Of any service that speaks OpenAI's chat completions, in the cloud or beside the cell, such
    as ``http://127.0.0.1:8080/v1``."""
    model_name: str = ""
    """Which of its models to ask."""
    prompt: Literal["cellctl", "paper"] = "cellctl"
    """``cellctl`` asks for attributes, sizes and edits, and has the answer follow a schema;
    ``paper`` is the paper's prompt with its two examples, word for word."""
    timeout_s: Annotated[float, Field(gt=0.0, le=60.0)] = 4.0
    """Of one attempt, from connecting to the last byte (wall time)."""
    budget_s: Annotated[float, Field(gt=0.0, le=120.0)] = 8.0
    """Of all attempts for one sentence, with the pauses between them (wall time)."""
    attempts: Annotated[int, Field(ge=1, le=6)] = 2
    """How often one sentence is asked about at most, where another attempt may go better."""
    requests_per_hour: Annotated[int, Field(ge=1, le=100_000)] = 240
    """What it may cost: beyond it the embedded back end decides alone."""

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        if self.back_end == "embedded":
            return self
        if not self.model_name:
            raise ValueError('model_name must be given for back_end = "model"')
        parts = urlsplit(self.model_url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(
                f'model_url must be an http(s) address for back_end = "model", not '
                f"{self.model_url!r}"
            )
        if parts.username or parts.password or parts.query:
            raise ValueError(
                "model_url must hold no secret: the key is the credential llm-key, "
                "or $CELLCTL_LLM_KEY"
            )
        if self.budget_s < self.timeout_s:
            raise ValueError(
                f"budget_s must be at least timeout_s ({self.budget_s:g} and {self.timeout_s:g})"
            )
        return self
