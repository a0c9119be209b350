"""One daemon for one journal: a lock that ends with its process, however that ends."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from cellctl.errors import ConfigError

_PID_WIDTH = 20
"""The process's number always takes the same bytes, so that a full disk has room for it."""


class JournalLock:
    """Exclusive use of a journal, by flock(2) on ``<path>.lock``.

    The file stays when the lock is released: a lock file that is removed can be locked twice.

    Args:
        path: the journal.
    """

    def __init__(self, path: Path) -> None:
        self.path = path.with_name(path.name + ".lock")
        self._descriptor: int | None = None

    def acquire(self) -> None:
        """Take the lock; its folder is made if need be.

        Raises:
            ConfigError: another process has it (the message names its number), or it cannot be
                written.
        """
        assert self._descriptor is None, "a lock is taken once"
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise ConfigError(
                f"{self.path}: cannot be written: {error.strerror}.",
                "Make its folder writable for this user, or name another journal.path.",
            ) from error
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            give_to_owner_of_folder(self.path)
            os.pwrite(descriptor, f"{os.getpid():<{_PID_WIDTH}}\n".encode(), 0)
        except BlockingIOError as error:
            holder = _pid_in(descriptor)
            os.close(descriptor)
            raise ConfigError(
                f"{self.path}: process {holder or '(unknown)'} uses this journal.",
                "One cell has one daemon: stop the other one (`systemctl stop cellctl`), "
                "or name another journal.path.",
            ) from error
        except OSError as error:
            os.close(descriptor)
            raise ConfigError(f"{self.path}: cannot be locked: {error.strerror}.") from error
        self._descriptor = descriptor

    def release(self) -> None:
        """Let go of the lock; nothing happens when it is not held."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def holder(self) -> int | None:
        """Number of the process that has the lock now; None for none, or one that is not known."""
        with suppress(FileNotFoundError):
            descriptor = os.open(self.path, os.O_RDONLY | os.O_CLOEXEC)
            try:
                fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                return _pid_in(descriptor)
            finally:
                os.close(descriptor)
        return None

    def __enter__(self) -> Self:
        self.acquire()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()


def _pid_in(descriptor: int) -> int | None:
    text = os.pread(descriptor, _PID_WIDTH, 0).strip()
    return int(text) if text.isdigit() else None


def give_to_owner_of_folder(path: Path) -> None:
    """What root makes in the daemon's folder must stay usable for the daemon's own user."""
    if os.geteuid() == 0:
        folder = path.parent.stat()
        os.chown(path, folder.st_uid, folder.st_gid)
