"""What is told to those who ask for more than a command: one model a kind of answer."""

from __future__ import annotations

from typing import Literal

from cellctl.assembly import Value
from cellctl.messages.commands import FileKind


class FileData(Value):
    """About the file that is the reply's second frame."""

    about: Literal["file"] = "file"
    job_id: str
    kind: FileKind
    name: str
    """To save it under."""
    media_type: str
    size_bytes: int
    sha256: str
