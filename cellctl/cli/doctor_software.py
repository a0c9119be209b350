"""The doctor's look at the software: packages, recogniser and models."""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from cellctl import __version__
from cellctl.cli.findings import Finding, ok, problem, warning
from cellctl.config import CellConfig
from cellctl.errors import HearingError
from cellctl.listening.models import FoundModel, find_model
from cellctl.messages import Snapshot

_REQUIREMENT = re.compile(
    r"(?P<name>[A-Za-z0-9._-]+)(\[[^\]]*\])?\s*(?P<spec>[^;]*?)\s*(;\s*(?P<marker>.*))?$"
)
_EXTRA = re.compile(r"""extra == ["'](?P<extra>[^"']+)["']""")
_EXTRAS = {
    "speech": "Without them no spoken wish is understood; typed ones are.",
    "service": "Without them systemd hears nothing of the daemon's state.",
    "voice": "Without them English is spoken by espeak-ng, where it is installed.",
    "picture": "Without them no pictures are drawn.",
}
"""Parts of cellctl that a cell may do without, and what it lacks then."""
_MODEL_FILES = {"vosk": "am/final.mdl", "whisper": "model.bin"}
"""The file that tells one model from another."""
_ENGINES = {"vosk": "vosk", "whisper": "faster-whisper"}


class _Requirement(NamedTuple):
    name: str
    least: str
    exact: bool
    extra: str


def packages() -> list[Finding]:
    """Every Python package that cellctl needs, with its version."""
    requirements = [_parsed(text) for text in metadata.requires("cellctl") or []]
    found = [ok("cellctl", f"{__version__}, Python {sys.version.split()[0]}")]
    core = _compared(one for one in requirements if not one.extra)
    if core.wrong:
        found.append(
            problem(
                "packages",
                f"{'; '.join(core.wrong)}.",
                "Install cellctl anew: pip install --upgrade cellctl, in its own environment.",
            )
        )
    else:
        found.append(ok("packages", ", ".join(core.good)))
    for extra, without in _EXTRAS.items():
        part = _compared(one for one in requirements if one.extra == extra)
        if part.wrong:
            advice = f"{without} To have them: pip install 'cellctl[{extra}]'."
            found.append(warning(f"packages for {extra}", f"{'; '.join(part.wrong)}.", advice))
        else:
            found.append(ok(f"packages for {extra}", ", ".join(part.good)))
    return found


def recogniser(config: CellConfig, daemon: Snapshot | None) -> list[Finding]:
    """Which model this cell hears with: the daemon's own word, and what would be found now."""
    hearing = config.hearing.model_copy(update={"allow_download": False})
    found = []
    if daemon is not None:
        found.append(ok("recogniser", f"the daemon hears with {daemon.recogniser or 'nothing'}"))
    try:
        model = find_model(hearing)
    except HearingError as error:
        if config.hearing.allow_download and config.hearing.model_path is None:
            found.append(
                warning(
                    "model", error.message, "The daemon will try to download one when it starts."
                )
            )
        else:
            found.append(problem("model", error.message, error.hint))
        return found
    found.append(ok("model", _described(model)))
    return found


def _described(model: FoundModel) -> str:
    engine = _ENGINES[model.engine]
    file = model.folder / _MODEL_FILES[model.engine]
    return (
        f"{model.name} in {model.folder}, {engine} {_version(engine) or 'not installed'}, "
        f"sha256 of {file.name} {_sha256(file)}"
    )


def _sha256(file: Path) -> str:
    try:
        with file.open("rb") as content:
            return hashlib.file_digest(content, "sha256").hexdigest()
    except OSError as error:
        return f"unknown ({error.strerror})"


class _Compared(NamedTuple):
    good: list[str]
    wrong: list[str]


def _compared(requirements: Iterable[_Requirement]) -> _Compared:
    compared = _Compared([], [])
    for one in requirements:
        version = _version(one.name)
        sign = "==" if one.exact else ">="
        if version is None:
            compared.wrong.append(f"{one.name} is not installed")
        elif (one.exact and version != one.least) or _numbers(version) < _numbers(one.least):
            compared.wrong.append(f"{one.name} is {version}, needed is {sign}{one.least}")
        else:
            compared.good.append(f"{one.name} {version}")
    return compared


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _parsed(text: str) -> _Requirement:
    match = _REQUIREMENT.match(text)
    assert match is not None, f"unreadable requirement {text!r}"
    extra = _EXTRA.search(match["marker"] or "")
    spec = match["spec"].strip("() ")
    return _Requirement(
        match["name"], spec.lstrip("=><~! "), spec.startswith("=="), extra["extra"] if extra else ""
    )


def _numbers(version: str) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", version)]
