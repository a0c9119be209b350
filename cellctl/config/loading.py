"""Where the file is, reading it, and refusals that name file, key and what would be right."""

from __future__ import annotations

import difflib
import os
import tomllib
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from cellctl.config.cell import CellConfig
from cellctl.errors import ConfigError

DEFAULT_PATH = Path("/etc/cellctl/cell.toml")
ENVIRONMENT_VARIABLE = "CELLCTL_CONFIG"


def find_config(explicit: Path | None) -> Path:
    """Where the configuration is: ``--config``, then the environment, then ``/etc``.

    Raises:
        ConfigError: none of them names a file that exists. The emulated cell is never assumed.
    """
    if explicit is not None:
        return explicit
    if from_environment := os.environ.get(ENVIRONMENT_VARIABLE):
        return Path(from_environment)
    if DEFAULT_PATH.exists():
        return DEFAULT_PATH
    raise ConfigError(
        f"No configuration: --config is not given, ${ENVIRONMENT_VARIABLE} is not set, "
        f"and {DEFAULT_PATH} does not exist.",
        "Name one, for example --config config/sim.toml for the emulated cell.",
    )


def load_config(path: Path) -> CellConfig:
    """Read and validate one file.

    Raises:
        ConfigError: with one line for each thing that is wrong.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not UTF-8 text.") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}.") from error
    return parse_config(data, str(path))


def parse_config(data: dict[str, Any], origin: str) -> CellConfig:
    """Validate settings that are already parsed; ``origin`` names them in errors.

    Raises:
        ConfigError: with one line for each thing that is wrong.
    """
    try:
        return CellConfig.model_validate(data)
    except ValidationError as error:
        lines = [f"{origin}: {_explain(item)}" for item in error.errors()]
        raise ConfigError("\n".join(lines)) from error


UNITS = {
    "_m_s2": "metres per second squared",
    "_m_s": "metres per second",
    "_kg": "kilograms",
    "_hz": "hertz",
    "_rad": "radians",
    "_m": "metres",
    "_s": "seconds",
    "_v": "volts",
}
"""What the endings of option names mean; the longer ones first."""


def unit_of(name: str) -> str:
    """The unit that an option's name ends in, in words; empty for none."""
    return next((unit for ending, unit in UNITS.items() if name.endswith(ending)), "")


def _explain(item: Any) -> str:
    location = list(item["loc"])
    key = ".".join(str(part) for part in location if isinstance(part, str)) or "(whole file)"
    key += "".join(f"[{part}]" for part in location if isinstance(part, int))
    kind = item["type"]
    if kind == "extra_forbidden":
        return f"{key}: unknown key; {_suggest([str(part) for part in location])}"
    if kind == "missing":
        return f"{key}: is missing."
    if kind in {"model_type", "model_attributes_type", "dict_type"}:
        return f"{key} = {item['input']!r}: must be a table, [{key}]."
    message = item["msg"].removeprefix("Value error, ").removeprefix("Input ")
    message = message[0].lower() + message[1:].replace("tuple", "array")
    if kind == "value_error":
        return f"{key}: {message}." if location else f"{message}."
    names = [part for part in location if isinstance(part, str)]
    unit = unit_of(names[-1]) if names else ""
    number = f" (in {unit})" if unit else ""
    return f"{key} = {item['input']!r}: {message.replace('should', 'must', 1)}{number}."


def _suggest(location: list[str]) -> str:
    """The valid name that an unknown one most likely stands for."""
    *tables, name = location
    here = _names_in(tables)
    elsewhere = [
        f"{table}.{name}"
        for table in CellConfig.model_fields
        if [table] != tables and name in _names_in([table])
    ]
    if elsewhere:
        return f"did you mean {' or '.join(elsewhere)}?"
    if near := difflib.get_close_matches(name, here, n=1, cutoff=0.4):
        return f"did you mean {'.'.join([*tables, near[0]])}?"
    return f"known here: {', '.join(sorted(here))}."


def _names_in(tables: list[str]) -> list[str]:
    """The keys that a table may hold; those of the whole file for no table."""
    model: type[BaseModel] = CellConfig
    for table in tables:
        annotation = model.model_fields[table].annotation
        options = (annotation, *get_args(annotation))  # [emulation] may be absent: X | None
        model = next(o for o in options if isinstance(o, type) and issubclass(o, BaseModel))
    return list(model.model_fields)
