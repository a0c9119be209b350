"""The table of how the cell talks with people."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cellctl.config.section import NotNegative, Positive, Section


class DialogueSection(Section):
    """How the cell talks with people."""

    language: Annotated[str, Field(pattern=r"^[a-z]{2,3}(_[A-Z]{2})?$")] = "en"
    """The language of what the cell says and shows; there must be a file of messages for it."""
    messages_folder: str | None = None
    """Where message files of your own are, in folders named `LANGUAGE` or as `LANGUAGE.toml`; they
    come before the packaged ones."""
    queue_limit: Annotated[int, Field(ge=0, le=100)] = 6
    """How many wishes may wait while the cell is busy; 0 lets nobody wait."""
    queue_per_visitor: Annotated[int, Field(ge=1, le=100)] = 2
    """How many of them one visitor may have."""
    queue_expires_s: Positive = 1800.0
    """A wish that has waited for so long is forgotten."""
    take_along_s: NotNegative = 60.0
    """How long a finished object is left to its owner before the next wish in line begins."""
    copies_limit: Annotated[int, Field(ge=1, le=20)] = 3
    """How many of one thing a visitor gets, one after another."""
    transcripts: Literal["none", "text"] = "none"
    """``text`` keeps what is said to the cell and what it answers, in the folder ``transcripts``
    beside the journal; sound is never kept."""
