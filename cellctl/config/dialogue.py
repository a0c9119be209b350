"""The table of how the cell talks with people."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cellctl.config.section import Section


class DialogueSection(Section):
    """How the cell talks with people."""

    language: Annotated[str, Field(pattern=r"^[a-z]{2,3}(_[A-Z]{2})?$")] = "en"
    """The language of what the cell says and shows; there must be a file of messages for it."""
    messages_folder: str | None = None
    """Folder of message files of your own, named `LANGUAGE.toml`; they come before the packaged
    ones."""
