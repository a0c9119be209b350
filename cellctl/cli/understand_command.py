"""``cellctl understand``: what sentences ask for, one line of JSON for each."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cellctl.assembly import Edit, Request
from cellctl.cli.options import ConfigOption
from cellctl.config import DEFAULT_PATH, ENVIRONMENT_VARIABLE, find_config, load_config
from cellctl.errors import UsageError

if TYPE_CHECKING:
    from cellctl.listening.understanding.interpreter import Interpreter, Setting

_STDIN = Path("-")


def told(request: Request) -> dict[str, Any]:
    """A request as a line tells it: plain values, its edits in short."""
    edits = [_short(edit) for edit in request.edits]
    line = request.model_dump(mode="json", exclude={"edits", "text"})
    return {"text": request.text, **line, "edit": edits[0] if edits else None, "edits": edits}


def _short(edit: Edit) -> dict[str, Any]:
    values = edit.model_dump(mode="json")
    values["dir"] = values.pop("direction")
    return {name: value for name, value in values.items() if value not in (None, "")}


def sentences(files: list[Path]) -> Iterator[str]:
    """The lines of files, or of standard input; bytes that are no UTF-8 are replaced.

    Raises:
        UsageError: a file cannot be read.
    """
    for path in files or [_STDIN]:
        if path == _STDIN:
            for raw in sys.stdin.buffer:
                yield _line(raw)
            continue
        try:
            with path.open("rb") as file:
                for raw in file:
                    yield _line(raw)
        except OSError as error:
            raise UsageError(f"{path}: cannot be read: {error.strerror}.") from error


def _line(raw: bytes) -> str:
    return raw.decode("utf-8", errors="replace").rstrip("\r\n")


def _interpreter(path: Path | None) -> tuple[Interpreter, Setting]:
    """Those of the configured cell; without any configuration the embedded one, in the paper's."""
    from cellctl.listening.understanding.choosing import interpreter_for  # noqa: PLC0415
    from cellctl.listening.understanding.embedded import EmbeddedInterpreter  # noqa: PLC0415
    from cellctl.listening.understanding.interpreter import (  # noqa: PLC0415
        DEFAULT_SETTING,
        Setting,
    )

    if path is None and ENVIRONMENT_VARIABLE not in os.environ and not DEFAULT_PATH.is_file():
        return EmbeddedInterpreter(), DEFAULT_SETTING
    config = load_config(find_config(path))
    return interpreter_for(config), Setting.of(config)


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def understand(
        files: Annotated[
            list[Path] | None,
            typer.Argument(help="Files of sentences, one a line; none or - is standard input."),
        ] = None,
        config: ConfigOption = None,
    ) -> None:
        """Say what sentences ask for: one line of JSON for each line, empty ones included.

        Nothing is designed or built, and no daemon is needed.
        """
        interpreter, setting = _interpreter(config)
        try:
            for text in sentences(files or []):
                request = interpreter.interpret(text, setting)
                sys.stdout.write(json.dumps(told(request), ensure_ascii=False) + "\n")
                sys.stdout.flush()
        except BrokenPipeError:
            # Whoever read has had enough; what is left in the buffer must not fail at exit either.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
