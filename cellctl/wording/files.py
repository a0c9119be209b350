"""Reading message files, and refusing those that would leave somebody without words."""

from __future__ import annotations

import gettext
import tomllib
from dataclasses import replace
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from cellctl.errors import ConfigError
from cellctl.wording.wording import REFERENCE_LANGUAGE, Forms, Wording, fields_of

_ABOUT = ("language", "name", "plural")
_HEARING = "hearing"
_SUFFIX = ".toml"
_MOST_BYTES = 1_000_000
_COUNTS = range(200)
"""Counts that a plural rule is tried with."""


def languages(folder: str | None = None) -> list[str]:
    """Codes of the languages that there are files for.

    Args:
        folder: the cell's own files, beside the packaged ones.
    """
    places: list[Traversable] = [resources.files(__package__)]
    if folder is not None:
        places.append(Path(folder))
    entries = [entry for place in places if place.is_dir() for entry in place.iterdir()]
    return sorted(
        {entry.name.removesuffix(_SUFFIX) for entry in entries if entry.name.endswith(_SUFFIX)}
        | {entry.name for entry in entries if _files_in(entry)}
    )


def load_wording(language: str, folder: str | None = None) -> Wording:
    """The messages of a language.

    Args:
        language: its code.
        folder: the cell's own files; they come before the packaged ones.

    Raises:
        ConfigError: there is no file, or it lacks messages; with one line for each thing wrong.
    """
    own = Path(folder) if folder is not None else None
    if own is not None and (files := _files_of(own, language)):
        return _checked(own / language, files, language)
    if _files_of(resources.files(__package__), language):
        return _packaged(language)
    where = f" {own / language} and {language}{_SUFFIX} do not exist." if own is not None else ""
    raise ConfigError(
        f"dialogue.language = {language!r}: there are no messages in that language.{where}",
        f"There are: {', '.join(languages(folder))}. Others: see docs/how-to/languages.md.",
    )


def _files_of(place: Traversable, language: str) -> list[Traversable]:
    """The files of a language in a place: those in its folder, or the one that bears its name."""
    file = place / f"{language}{_SUFFIX}"
    return _files_in(place / language) or ([file] if file.is_file() else [])


def _files_in(folder: Traversable) -> list[Traversable]:
    if not folder.is_dir():
        return []
    return sorted(
        (file for file in folder.iterdir() if file.name.endswith(_SUFFIX)), key=lambda f: f.name
    )


@cache
def _packaged(language: str) -> Wording:
    place = resources.files(__package__)
    return _checked(place / language, _files_of(place, language), language)


def _checked(where: Traversable, files: list[Traversable], language: str) -> Wording:
    wording = _read(where, files)
    if wording.language != language:
        raise ConfigError(f"{where}: says language = {wording.language!r}, not {language!r}.")
    if language == REFERENCE_LANGUAGE:
        return wording
    if wrong := differences(wording):
        raise ConfigError("\n".join(f"{where}: {line}" for line in wrong))
    return replace(wording, reference=_packaged(REFERENCE_LANGUAGE))


def differences(wording: Wording) -> list[str]:
    """What messages lack, or have too much, against those of the reference language."""
    reference = _packaged(REFERENCE_LANGUAGE).messages
    wrong = [f"{key}: is missing." for key in reference if key not in wording.messages]
    for key, forms in wording.messages.items():
        if key not in reference:
            wrong.append(f"{key}: is no message of this version.")
            continue
        here, there = fields_of(forms), fields_of(reference[key])
        if here != there:
            wrong.append(f"{key}: has the fields {_listed(here)}; it needs {_listed(there)}.")
    return wrong


def _listed(names: frozenset[str]) -> str:
    return ", ".join(f"{{{name}}}" for name in sorted(names)) or "none"


def _read(where: Traversable, files: list[Traversable]) -> Wording:
    """The files of one language as one.

    Args:
        where: what all of them are called together.
        files: the files; which of their tables stand in which is of no importance.

    Raises:
        ConfigError: one cannot be read, or two say the same.
    """
    document: dict[str, Any] = {}
    for file in files:
        _merge(file, "", _document(file), document)
    language, name, plural = (_about(where, document, key) for key in _ABOUT)
    forms = _number_of_forms(where, plural)
    hearing = document.pop(_HEARING, {})
    if not isinstance(hearing, dict) or not all(isinstance(v, dict) for v in hearing.values()):
        raise ConfigError(f"{where}: [{_HEARING}] must hold tables.")
    messages: dict[str, Forms] = {}
    _flatten(where, "", document, messages, forms)
    return Wording(language, name, plural, messages, hearing)


def _document(file: Traversable) -> dict[str, Any]:
    try:
        content = file.read_bytes()
        if len(content) > _MOST_BYTES:
            raise ConfigError(f"{file}: is larger than {_MOST_BYTES} bytes.")
        return tomllib.loads(content.decode("utf-8"))
    except OSError as error:
        raise ConfigError(f"{file}: cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{file}: is not UTF-8 text.") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{file}: is not valid TOML: {error}.") from error


def _merge(file: Traversable, start: str, table: dict[str, Any], into: dict[str, Any]) -> None:
    for name, value in table.items():
        both = into.setdefault(name, {}) if isinstance(value, dict) else None
        if isinstance(both, dict):
            _merge(file, f"{start}{name}.", value, both)
        elif name in into:
            raise ConfigError(f"{file}: {start}{name} stands in another file, too.")
        else:
            into[name] = value


def _about(file: Traversable, document: dict[str, Any], key: str) -> str:
    value = document.pop(key, None)
    if not isinstance(value, str) or not value:
        raise ConfigError(f"{file}: {key} must be a text at the top of the file.")
    return value


def _number_of_forms(file: Traversable, plural: str) -> int:
    try:
        rule = gettext.c2py(plural)
        return 1 + max(rule(count) for count in _COUNTS)
    except (ValueError, ZeroDivisionError) as error:
        raise ConfigError(
            f"{file}: plural = {plural!r} is no rule: {error}.",
            'Write it as gettext does: "n != 1" where one thing and several differ.',
        ) from error


def _flatten(
    file: Traversable, start: str, table: dict[str, Any], into: dict[str, Forms], forms: int
) -> None:
    for name, value in table.items():
        key = f"{start}{name}"
        match value:
            case dict():
                _flatten(file, f"{key}.", value, into, forms)
                continue
            case str():
                into[key] = (value,)
            case list() if len(value) == forms and all(isinstance(form, str) for form in value):
                into[key] = tuple(value)
            case _:
                raise ConfigError(f"{file}: {key} must be a text, or a list of {forms} texts.")
        try:
            names = fields_of(into[key])
        except ValueError as error:
            raise ConfigError(f"{file}: {key}: {error}.") from error
        if not all(name.isidentifier() for name in names):
            raise ConfigError(f"{file}: {key}: fields must have names, such as {{count}}.")
