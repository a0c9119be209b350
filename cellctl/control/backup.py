"""One archive of all that a cell cannot be made again from: configuration, journal, keys.

The journal is copied with SQLite's online backup, so that the copy is consistent while the daemon
writes. A manifest names every file with its size, mode and sha256; nothing of an archive is used
before all of it has been checked.
"""

from __future__ import annotations

import hashlib
import io
import os
import shutil
import sqlite3
import tarfile
import tempfile
from contextlib import ExitStack, closing
from datetime import datetime
from pathlib import Path, PurePosixPath
from typing import Final, Literal

from pydantic import ValidationError

from cellctl import __version__
from cellctl.assembly import Value
from cellctl.config import CellConfig, load_config
from cellctl.control.journal_lock import JournalLock, give_to_owner_of_folder
from cellctl.errors import CellctlError, ConfigError, UsageError

CONFIGURATION: Final = "cell.toml"
JOURNAL: Final = "journal.db"
KEYS: Final = "keys"
_MANIFEST: Final = "manifest.json"
_MANIFEST_LIMIT_BYTES: Final = 1 << 20
_MEMBERS_LIMIT: Final = 1000
_BACKUP_BUSY_S: Final = 30.0
ASIDE: Final = ".before-restore"
"""What is replaced is kept beside it under its name with this ending."""


class ArchivedFile(Value):
    """One file of an archive."""

    name: str
    size_bytes: int
    mode: int
    sha256: str


class Manifest(Value):
    """What an archive holds."""

    format: Literal[1] = 1
    version: str
    """Of the cellctl that made it."""
    cell: str
    made_at: datetime
    journal_schema: int | None
    """SQLite's user_version of the journal; None when there was no journal."""
    files: tuple[ArchivedFile, ...]


def write_backup(configuration: Path, archive: Path, now: datetime) -> Manifest:
    """Write an archive, readable for its owner only; blocks.

    Args:
        configuration: the cell's ``cell.toml``; it names journal and keys.
        archive: must not exist yet.
        now: the calendar time.

    Raises:
        UsageError: the archive exists, or something cannot be read or written.
    """
    config = load_config(configuration)
    if archive.exists():
        raise UsageError(f"{archive}: exists already.", "Name another file.")
    partial = archive.with_name(archive.name + ".partial")
    try:
        with tempfile.TemporaryDirectory(prefix="cellctl-backup-") as name:
            copies = {CONFIGURATION: configuration}
            schema = None
            if Path(config.journal.path).exists():
                copies[JOURNAL] = Path(name) / JOURNAL
                schema = _copy_journal(Path(config.journal.path), copies[JOURNAL])
            keys = Path(config.bus.keys)
            for key in sorted(keys.rglob("*")) if keys.is_dir() else ():
                if key.is_file() and not key.is_symlink():
                    copies[f"{KEYS}/{key.relative_to(keys).as_posix()}"] = key
            files = tuple(_described(member, path) for member, path in copies.items())
            manifest = Manifest(
                version=__version__,
                cell=config.cell.name,
                made_at=now,
                journal_schema=schema,
                files=files,
            )
            _pack(partial, manifest, copies)
        partial.rename(archive)
    except (OSError, sqlite3.Error) as error:
        partial.unlink(missing_ok=True)
        where = getattr(error, "filename", None) or archive
        reason = getattr(error, "strerror", None) or error
        raise UsageError(
            f"{where}: the backup failed: {reason}.",
            "Run it as root, or as the user of the daemon, and look that the disk has room.",
        ) from error
    return manifest


def _copy_journal(journal: Path, copy: Path) -> int:
    with (
        closing(
            sqlite3.connect(f"file:{journal}?mode=ro", uri=True, timeout=_BACKUP_BUSY_S)
        ) as old,
        closing(sqlite3.connect(copy)) as new,
    ):
        old.backup(new)
        new.execute("PRAGMA journal_mode=DELETE")  # one file, without a log beside it
        return int(new.execute("PRAGMA user_version").fetchone()[0])


def _described(member: str, path: Path) -> ArchivedFile:
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    status = path.stat()
    mode = 0o640 if member == JOURNAL else status.st_mode & 0o777
    return ArchivedFile(name=member, size_bytes=status.st_size, mode=mode, sha256=digest)


def _pack(archive: Path, manifest: Manifest, copies: dict[str, Path]) -> None:
    descriptor = os.open(archive, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
    with (
        os.fdopen(descriptor, "wb") as sink,
        tarfile.open(fileobj=sink, mode="w:gz", format=tarfile.PAX_FORMAT) as tar,
    ):
        text = manifest.model_dump_json(indent=2).encode()
        entry = tarfile.TarInfo(_MANIFEST)
        entry.size, entry.mtime = len(text), int(manifest.made_at.timestamp())
        tar.addfile(entry, io.BytesIO(text))
        for file in manifest.files:
            entry = tarfile.TarInfo(file.name)
            entry.size, entry.mode = file.size_bytes, file.mode
            entry.mtime = int(manifest.made_at.timestamp())
            with copies[file.name].open("rb") as source:
                tar.addfile(entry, source)


def restore_backup(archive: Path, configuration: Path) -> tuple[Manifest, tuple[Path, ...]]:
    """Check an archive and put its files in place; blocks.

    What stood there is kept beside it with ``.before-restore`` at its name's end; what an earlier
    restore kept so is given up.

    Args:
        archive: as ``write_backup`` made it.
        configuration: where ``cell.toml`` goes; it says where journal and keys go.

    Returns:
        The manifest, and what was kept aside.

    Raises:
        UsageError: the archive is damaged, or something cannot be written.
        ConfigError: a daemon runs on the journal, or the archive's configuration is wrong.
    """
    with tempfile.TemporaryDirectory(prefix="cellctl-restore-") as name:
        folder = Path(name)
        try:
            manifest = _unpack(archive, folder)
        except (OSError, tarfile.TarError, EOFError, ValidationError) as error:
            raise UsageError(
                f"{archive}: is no backup that can be used: {error}.", "Nothing was changed."
            ) from error
        config = load_config(folder / CONFIGURATION)
        try:
            with ExitStack() as locks:
                for journal in sorted(
                    {Path(config.journal.path), *_present_journal(configuration)}
                ):
                    locks.enter_context(JournalLock(journal))
                return manifest, _put_in_place(folder, manifest, config, configuration)
        except OSError as error:
            raise CellctlError(
                f"{error.filename}: cannot be restored: {error.strerror}.",
                f"Run it as root; what was replaced stands beside it as *{ASIDE}.",
            ) from error


def _present_journal(configuration: Path) -> tuple[Path, ...]:
    """The journal that a daemon may be running on, which need not be the archive's.

    A configuration that is missing or damaged, which may be why one restores, names none.
    """
    try:
        return (Path(load_config(configuration).journal.path),)
    except ConfigError:
        return ()


def _unpack(archive: Path, folder: Path) -> Manifest:
    with tarfile.open(archive, mode="r:gz") as tar:
        first = tar.next()
        if first is None or first.name != _MANIFEST or first.size > _MANIFEST_LIMIT_BYTES:
            raise tarfile.TarError("it does not begin with a manifest")
        text = tar.extractfile(first)
        assert text is not None
        manifest = Manifest.model_validate_json(text.read())
        expected = {file.name: file for file in manifest.files}
        for name in expected:
            if not _harmless(name):
                raise tarfile.TarError(f"it holds a file of another kind: {name!r}")
        if CONFIGURATION not in expected or len(expected) > _MEMBERS_LIMIT:
            raise tarfile.TarError("its manifest names no configuration, or too much")
        while (entry := tar.next()) is not None:
            file = expected.pop(entry.name, None)
            content = tar.extractfile(entry) if entry.isfile() else None
            if file is None or content is None or entry.size != file.size_bytes:
                raise tarfile.TarError(f"{entry.name!r} is not as its manifest says")
            target = folder / entry.name
            target.parent.mkdir(parents=True, exist_ok=True)
            with target.open("wb") as sink:
                shutil.copyfileobj(content, sink)
            with target.open("rb") as check:
                if hashlib.file_digest(check, "sha256").hexdigest() != file.sha256:
                    raise tarfile.TarError(f"{entry.name!r}: its sha256 is another one")
    if expected:
        raise tarfile.TarError(f"{', '.join(expected)} missing")
    return manifest


def _harmless(name: str) -> bool:
    parts = PurePosixPath(name).parts
    if name in {CONFIGURATION, JOURNAL}:
        return True
    return len(parts) in {2, 3} and parts[0] == KEYS and ".." not in parts


def _put_in_place(
    folder: Path, manifest: Manifest, config: CellConfig, configuration: Path
) -> tuple[Path, ...]:
    journal, keys = Path(config.journal.path), Path(config.bus.keys)
    kept: list[Path] = []
    names = {file.name: file for file in manifest.files}
    _place(folder / CONFIGURATION, configuration, names[CONFIGURATION].mode, kept)
    for ending in ("-wal", "-shm"):  # they belong to the journal that goes
        _set_aside(journal.with_name(journal.name + ending), kept)
    if JOURNAL in names:
        _place(folder / JOURNAL, journal, names[JOURNAL].mode, kept)
    else:
        _set_aside(journal, kept)
    key_files = [file for file in manifest.files if file.name.startswith(f"{KEYS}/")]
    if key_files:
        owner = keys.stat() if keys.is_dir() else None
        _set_aside(keys, kept)
        keys.mkdir(parents=True, mode=0o700)
        for file in key_files:
            target = keys / PurePosixPath(file.name).relative_to(KEYS)
            _place(folder / file.name, target, file.mode, kept)
        if owner is not None and os.geteuid() == 0:
            for path in (keys, *keys.rglob("*")):
                os.chown(path, owner.st_uid, owner.st_gid)
    return tuple(kept)


def _place(source: Path, target: Path, mode: int, kept: list[Path]) -> None:
    """Put a file in place in one step; the old one is kept aside."""
    target.parent.mkdir(parents=True, exist_ok=True)
    fresh = target.with_name(target.name + ".restoring")
    shutil.copyfile(source, fresh)
    fresh.chmod(mode)
    give_to_owner_of_folder(fresh)
    _set_aside(target, kept)
    fresh.rename(target)


def _set_aside(path: Path, kept: list[Path]) -> None:
    if not path.exists():
        return
    aside = path.with_name(path.name + ASIDE)
    if aside.is_dir():
        shutil.rmtree(aside)
    path.replace(aside)
    kept.append(aside)
