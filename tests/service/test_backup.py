"""A cell's backup: made while the journal is written, checked before it is used."""

from __future__ import annotations

import hashlib
import io
import os
import sqlite3
import stat
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from cellctl.cli.boards_command import udev_rule
from cellctl.config import load_config
from cellctl.control.journal_lock import JournalLock
from cellctl.errors import UsageError
from cellctl.sim.isolation import write_config
from tests.cell.harness import CONFIG


class BackedUpCell:
    """A cell's files in a folder, and the command line that works on them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.config = folder / "etc" / "cell.toml"
        self.journal = folder / "state" / "journal.db"
        self.keys = folder / "etc" / "keys"
        self.archive = folder / "backup.tar.gz"
        self.config.parent.mkdir()
        base = load_config(CONFIG)
        changes = {
            "journal": base.journal.model_copy(update={"path": str(self.journal)}),
            "bus": base.bus.model_copy(update={"keys": str(self.keys)}),
        }
        write_config(base.model_copy(update=changes), self.config)
        (self.keys / "operators.d").mkdir(parents=True)
        (self.keys / "server.key").write_text("secret")
        (self.keys / "server.key").chmod(0o600)
        (self.keys / "operators.d" / "ann.pub").write_text("public")
        self.journal.parent.mkdir()
        self.writer = sqlite3.connect(self.journal)
        self.writer.execute("PRAGMA journal_mode=WAL")
        self.writer.execute("PRAGMA user_version=7")
        self.writer.execute("CREATE TABLE acts (n INTEGER)")
        self.write(1)

    def write(self, number: int) -> None:
        """Write one more act."""
        with self.writer:
            self.writer.execute("INSERT INTO acts VALUES (?)", (number,))

    def acts(self) -> list[int]:
        """The acts in the journal's file."""
        with closing(sqlite3.connect(self.journal)) as journal:
            return [row[0] for row in journal.execute("SELECT n FROM acts")]

    def run(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run cellctl with the cell's configuration."""
        return subprocess.run(
            [sys.executable, "-m", "cellctl", *arguments, "--config", str(self.config)],
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )


@pytest.fixture
def cell(tmp_path: Path) -> Iterator[BackedUpCell]:
    made = BackedUpCell(tmp_path)
    yield made
    made.writer.close()


def test_everything_comes_back_and_what_stood_there_is_kept(cell: BackedUpCell) -> None:
    cell.writer.execute("BEGIN")  # the daemon is in the midst of writing
    cell.writer.execute("INSERT INTO acts VALUES (99)")
    result = cell.run("backup", str(cell.archive))
    cell.writer.rollback()
    assert result.returncode == 0, result.stderr
    assert stat.S_IMODE(cell.archive.stat().st_mode) == 0o600
    cell.write(2)
    cell.writer.close()
    wanted = cell.config.read_text()
    cell.config.write_text("changed")
    (cell.keys / "server.key").write_text("changed")

    result = cell.run("restore", str(cell.archive))
    assert result.returncode == 0, result.stderr
    assert cell.acts() == [1]
    assert cell.config.read_text() == wanted
    assert (cell.keys / "server.key").read_text() == "secret"
    assert stat.S_IMODE((cell.keys / "server.key").stat().st_mode) == 0o600
    assert stat.S_IMODE(cell.keys.stat().st_mode) == 0o700
    assert (cell.keys / "operators.d" / "ann.pub").read_text() == "public"
    aside = cell.journal.with_name("journal.db.before-restore")
    with closing(sqlite3.connect(aside)) as journal:
        assert journal.execute("SELECT count(*) FROM acts").fetchone() == (2,)
    assert (cell.config.parent / "cell.toml.before-restore").read_text() == "changed"
    assert (cell.config.parent / "keys.before-restore" / "server.key").read_text() == "changed"


def test_a_restore_is_refused_while_a_daemon_runs(cell: BackedUpCell) -> None:
    assert cell.run("backup", str(cell.archive)).returncode == 0
    before = cell.journal.read_bytes()
    with JournalLock(cell.journal):
        result = cell.run("restore", str(cell.archive))
    assert result.returncode == 2
    assert f"process {os.getpid()} uses this journal" in " ".join(result.stderr.split())
    assert cell.journal.read_bytes() == before
    assert not list(cell.folder.rglob("*.before-restore"))


def test_a_restore_is_refused_while_a_daemon_runs_on_another_journal(cell: BackedUpCell) -> None:
    assert cell.run("backup", str(cell.archive)).returncode == 0
    other = cell.folder / "other.db"
    cell.config.write_text(cell.config.read_text().replace(str(cell.journal), str(other)))
    assert str(other) in cell.config.read_text()
    with JournalLock(other):
        result = cell.run("restore", str(cell.archive))
    assert result.returncode == 2
    assert f"process {os.getpid()} uses this journal" in " ".join(result.stderr.split())
    assert not list(cell.folder.rglob("*.before-restore"))


def _changed(archive: Path, member: str, content: bytes) -> None:
    """Replace one member's content; the manifest stays as it was."""
    with tarfile.open(archive) as tar:
        entries = [(entry, tar.extractfile(entry)) for entry in tar]
        contents = [(entry, file.read()) for entry, file in entries if file is not None]
    with tarfile.open(archive, "w:gz") as tar:
        for entry, old in contents:
            new = content if entry.name == member else old
            entry.size = len(new)
            tar.addfile(entry, io.BytesIO(new))


def test_a_damaged_or_foreign_archive_changes_nothing(cell: BackedUpCell) -> None:
    assert cell.run("backup", str(cell.archive)).returncode == 0
    assert cell.run("backup", str(cell.archive)).returncode == 2, "it would replace a backup"
    digest = hashlib.sha256(cell.config.read_bytes()).digest()
    whole = cell.archive.read_bytes()
    half = cell.folder / "half.tar.gz"
    half.write_bytes(whole[: len(whole) // 2])
    other = cell.folder / "other.tar.gz"
    with tarfile.open(other, "w:gz") as tar:
        tar.addfile(tarfile.TarInfo("../../evil"))
    changed = cell.folder / "changed.tar.gz"
    changed.write_bytes(whole)
    _changed(changed, "keys/server.key", b"forged")
    for archive in (half, other, changed, cell.config):
        result = cell.run("restore", str(archive))
        assert result.returncode == 2, result.stderr
        assert "Nothing was changed." in result.stderr
    assert hashlib.sha256(cell.config.read_bytes()).digest() == digest
    assert not list(cell.folder.rglob("*.before-restore"))


def test_a_rule_for_a_board_holds_its_serial_number_and_nothing_else() -> None:
    rule = udev_rule("conveyor=A50285BI")
    assert 'ENV{ID_SERIAL_SHORT}=="A50285BI"' in rule
    assert 'SYMLINK+="cellctl-conveyor"' in rule
    for wish in ("conveyor", "conveyor=", 'conveyor=A", RUN+="x', "disk=A50285BI"):
        with pytest.raises(UsageError, match="NAME=SERIAL"):
            udev_rule(wish)
