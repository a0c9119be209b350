"""New values in the text of a configuration, with its comments and its order kept."""

from __future__ import annotations

import difflib
import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

from cellctl.config.cell import CellConfig
from cellctl.config.loading import parse_config
from cellctl.errors import ConfigError

NewValues = Mapping[tuple[str, str], float | str | Sequence[float]]
"""By table and key."""

_TABLE = re.compile(r"\s*\[([A-Za-z0-9_.]+)\]")


def rewritten(text: str, values: NewValues, origin: str) -> tuple[str, CellConfig]:
    """The text with these values, each in its own line, and what it says then.

    Args:
        text: of a configuration file.
        values: what is to be in it; a key that is not there is put at the top of its table.
        origin: names the text in errors.

    Raises:
        ConfigError: a value is written over several lines or its table is missing, or the result is
            no configuration.
    """
    lines = text.splitlines()
    for (table, key), value in values.items():
        _set(lines, table, key, _written(value), origin)
    new = "\n".join(lines) + "\n"
    return new, parse_config(tomllib.loads(new), origin)


def difference(old: str, new: str, path: Path) -> str:
    """What changes, line by line."""
    return "\n".join(
        difflib.unified_diff(
            old.splitlines(), new.splitlines(), f"{path} (now)", f"{path} (new)", lineterm="", n=1
        )
    )


def replace_file(path: Path, old: str, new: str, suffix: str) -> Path:
    """Put a new text in a file's place; the old one is kept beside it.

    Args:
        path: the file.
        old: what it held when ``new`` was made.
        new: what it is to hold.
        suffix: of the file that keeps the old text.

    Returns:
        The file that keeps the old text.

    Raises:
        ConfigError: somebody has changed the file meanwhile, or it cannot be written.
    """
    kept, draft = path.with_name(path.name + suffix), path.with_name(path.name + ".new")
    try:
        if path.read_text(encoding="utf-8") != old:
            raise ConfigError(f"{path}: somebody has changed it meanwhile.", "Begin anew.")
        kept.write_text(old, encoding="utf-8")
        draft.write_text(new, encoding="utf-8")
        draft.replace(path)
    except OSError as error:
        raise ConfigError(
            f"{path}: cannot be written: {error.strerror}.",
            "Put the lines that were shown into it by hand, as a user who may.",
        ) from error
    return kept


def _written(value: float | str | Sequence[float]) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float | int):
        return repr(round(float(value), 6))
    return "[" + ", ".join(repr(round(float(one), 6) + 0.0) for one in value) + "]"


def _set(lines: list[str], table: str, key: str, written: str, origin: str) -> None:
    inside, begins = False, -1
    for i, line in enumerate(lines):
        found = _TABLE.match(line)
        if found:
            inside = found[1] == table
            begins = i if inside else begins
        elif inside and (
            match := re.match(rf"(\s*{re.escape(key)}\s*=\s*)([^#]*?)(\s*#.*)?$", line)
        ):
            try:
                tomllib.loads(f"x = {match[2]}")
            except tomllib.TOMLDecodeError as error:
                raise ConfigError(
                    f"{origin}: {table}.{key} is written over several lines.",
                    f"Write it in one line, or put {key} = {written} there by hand.",
                ) from error
            lines[i] = f"{match[1]}{written}{match[3] or ''}"
            return
    if begins < 0:
        raise ConfigError(f"{origin}: there is no table [{table}].")
    lines.insert(begins + 1, f"{key} = {written}")
