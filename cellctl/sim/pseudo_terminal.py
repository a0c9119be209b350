"""A serial port that is no hardware: a pseudo-terminal under a name of its own."""

from __future__ import annotations

import os
import tty
from contextlib import suppress
from pathlib import Path
from typing import Final

from cellctl.errors import UsageError

_READ_BYTES: Final = 4096


class PseudoTerminal:
    """The far end of a serial port. Neither reading nor writing ever waits.

    Args:
        link: the port's name; a symbolic link is made there, and folders that are missing.
        option: which option of cell.toml names it, for messages.
    """

    def __init__(self, link: Path, option: str) -> None:
        self._link = link
        self._option = option
        self._made: list[Path] = []
        """Folders to remove again, the innermost first."""
        self._master = self._slave = -1

    @property
    def is_open(self) -> bool:
        """Whether the port exists."""
        return self._master >= 0

    def open(self) -> None:
        """Make the port; a link that an earlier run left behind is replaced.

        Raises:
            UsageError: its name is taken by something else, or cannot be made.
        """
        assert not self.is_open, "the port is open already"
        if self._link.exists() and not self._link.is_symlink():
            raise UsageError(
                f"{self._link} is in the way of the emulated port.",
                f"Remove it or choose another {self._option}.",
            )
        self._master, self._slave = os.openpty()
        try:
            tty.setraw(self._slave)  # no echo, no translation, before anybody opens it
            os.set_blocking(self._master, False)
            self._make_folder(self._link.parent)
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(os.ttyname(self._slave))
        except OSError as error:
            self.close()
            raise UsageError(
                f"{self._link} cannot be made: {error.strerror}.",
                f"Choose another {self._option}.",
            ) from error

    def close(self) -> None:
        """Take the port away, as if its cable were pulled; safe to repeat."""
        if not self.is_open:
            return
        with suppress(OSError):
            if self._link.readlink() == Path(os.ttyname(self._slave)):
                self._link.unlink()
        while self._made:
            with suppress(OSError):  # somebody else put something there: it stays
                self._made[-1].rmdir()
            self._made.pop()
        os.close(self._slave)
        os.close(self._master)
        self._master = self._slave = -1

    def read(self) -> bytes:
        """What has arrived; empty when nothing has."""
        # The slave side is held open here, so an absent host is no end of file.
        with suppress(BlockingIOError):
            return os.read(self._master, _READ_BYTES)
        return b""

    def write(self, data: bytes) -> None:
        """Send bytes; what a host leaves unread for too long is lost, as in a real adapter."""
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def _make_folder(self, folder: Path) -> None:
        if not folder.exists():
            self._make_folder(folder.parent)
            folder.mkdir()
            self._made.append(folder)
