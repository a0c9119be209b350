"""Secrets for other people's services: from systemd's credentials, else from the environment.

A secret is never part of a configuration file, a message, a ``repr`` or a log line.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

from cellctl.errors import ConfigError

_FOLDER_VARIABLE = "CREDENTIALS_DIRECTORY"
_MAX_BYTES = 4096


@dataclass(frozen=True)
class Credential:
    """A secret, and where it came from."""

    secret: str = field(repr=False)
    source: str


def variable_of(name: str) -> str:
    """The environment variable of a credential: ``llm-key`` is ``CELLCTL_LLM_KEY``."""
    return f"CELLCTL_{name.upper().replace('-', '_')}"


def find_credential(name: str) -> Credential | None:
    """The credential of that name, or None when nobody gave one.

    Args:
        name: as in systemd's ``LoadCredential=``, such as ``llm-key``.

    Raises:
        ConfigError: there is one, and it cannot be read or is no single line of text.
    """
    if folder := os.environ.get(_FOLDER_VARIABLE):
        path = Path(folder) / name
        if path.is_file():
            return Credential(_checked(_read(path), str(path)), str(path))
    variable = variable_of(name)
    if value := os.environ.get(variable):
        return Credential(_checked(value, f"${variable}"), f"${variable}")
    return None


def _read(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return file.read(_MAX_BYTES + 1).decode("ascii")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: the credential cannot be read: {error}.") from error


def _checked(text: str, source: str) -> str:
    secret = text.strip()
    if not secret or len(secret) > _MAX_BYTES or not secret.isascii() or not secret.isprintable():
        raise ConfigError(
            f"{source}: is no key.", "Give the key as one line, without quotation marks."
        )
    return secret
