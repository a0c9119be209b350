"""Fetch one pinned model archive: all of it, or nothing.

Size and sha256 are known beforehand and checked before a byte is unpacked. Everything happens in a
temporary folder beside the destination, which then takes its name in one step, so that a crash or
a pulled plug never leaves half a model behind.
"""

from __future__ import annotations

import hashlib
import tempfile
import time
import urllib.error
import urllib.request
import zipfile
from dataclasses import dataclass
from pathlib import Path

from cellctl.errors import HearingError

_BLOCK_BYTES = 1 << 18
_STALL_TIMEOUT_S = 20.0
TOTAL_TIMEOUT_S = 300.0


@dataclass(frozen=True)
class PinnedArchive:
    """A zip archive that holds one folder, and what must be true of it."""

    url: str
    size_bytes: int
    sha256: str
    folder: str
    """Name of the one folder in the archive."""


VOSK_SMALL_ENGLISH = PinnedArchive(
    url="https://alphacephei.com/vosk/models/vosk-model-small-en-us-0.15.zip",
    size_bytes=41_205_931,
    sha256="30f26242c4eb449f948e42cb302dd7a686cb29a3423a8367f99ff41780942498",
    folder="vosk-model-small-en-us-0.15",
)
"""Apache-2.0."""


def fetch(archive: PinnedArchive, parent: Path, total_timeout_s: float = TOTAL_TIMEOUT_S) -> Path:
    """Download, check and unpack into ``parent``; returns the model's folder.

    Blocks for up to ``total_timeout_s`` (wall time); meant for a worker process.

    Raises:
        HearingError: the network, the archive or the disk failed; nothing is left behind.
    """
    destination = parent / archive.folder
    try:
        parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".download-", dir=parent) as scratch:
            packed = Path(scratch) / "archive.zip"
            _download(archive, packed, total_timeout_s)
            _unpack(archive, packed, Path(scratch)).rename(destination)
    except OSError as error:
        raise HearingError(
            f"{archive.url}: the model cannot be stored in {parent}: {error.strerror or error}.",
            "Make hearing.model_folder writable, or put the model there by hand.",
        ) from error
    return destination


def _download(archive: PinnedArchive, packed: Path, total_timeout_s: float) -> None:
    deadline_s = time.monotonic() + total_timeout_s
    digest, received = hashlib.sha256(), 0
    try:
        with (
            # The address is a constant of this module; its content is checked below.
            urllib.request.urlopen(archive.url, timeout=_STALL_TIMEOUT_S) as answer,  # noqa: S310
            packed.open("wb") as file,
        ):
            # read1 returns what has arrived, so that a trickle cannot outlast the deadline.
            while block := answer.read1(_BLOCK_BYTES):
                received += len(block)
                if received > archive.size_bytes:
                    break
                _check_deadline(deadline_s, total_timeout_s)
                digest.update(block)
                file.write(block)
    except (urllib.error.URLError, TimeoutError, ConnectionError) as error:
        raise HearingError(
            f"{archive.url}: the download failed: {getattr(error, 'reason', error)}.",
            "Check the network, or unpack the model into hearing.model_folder by hand.",
        ) from error
    if received != archive.size_bytes or digest.hexdigest() != archive.sha256:
        raise HearingError(
            f"{archive.url}: is not the archive that is expected (size or sha256 differ).",
            "It was not used; unpack a model that you trust into hearing.model_folder.",
        )


def _check_deadline(deadline_s: float, total_timeout_s: float) -> None:
    if time.monotonic() > deadline_s:
        raise TimeoutError(f"not done after {total_timeout_s:g} s")


def _unpack(archive: PinnedArchive, packed: Path, scratch: Path) -> Path:
    try:
        with zipfile.ZipFile(packed) as opened:
            # The sha256 vouches for every name in it.
            opened.extractall(scratch)
    except zipfile.BadZipFile as error:
        raise HearingError(f"{archive.url}: is not a zip archive: {error}.") from error
    return scratch / archive.folder
