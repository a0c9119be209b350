"""Who may use the operator's view: a passphrase, guessed slowly, and sessions that end.

A session lives in this process alone. Its cookie holds a random token, of which only a hash is
kept; it ends when nobody does anything for a while, at log-out, and with the process.
"""

from __future__ import annotations

import asyncio
import hashlib
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import structlog

from cellctl.errors import RefusedError
from cellctl.passphrase import PassphraseHash

log = structlog.get_logger(__name__)

COOKIE: Final = "cellctl_operator"
_FREE_TRIES: Final = 3
"""Wrong passphrases from one address before it has to wait."""
_LONGEST_WAIT_S: Final = 60.0
_ADDRESSES: Final = 1000
"""So many addresses are remembered."""
_SESSIONS: Final = 20
"""So many operators are logged in at most; the one longest idle goes first."""


class TooSoonError(RefusedError):
    """Another passphrase is taken only after a while."""


class Session:
    """One operator who has logged in.

    Args:
        idle_s: ends it when nothing is done for so long (wall time).
        now: seconds of a clock that never goes back.
    """

    def __init__(self, idle_s: float, now: Callable[[], float]) -> None:
        self._idle_s = idle_s
        self._now = now
        self._used_s = now()
        self._ended = False

    @property
    def left_s(self) -> float:
        """How long it lasts if nothing is done; 0 when it has ended."""
        return 0.0 if self._ended else max(0.0, self._used_s + self._idle_s - self._now())

    def use(self) -> None:
        """Something is done in it.

        Raises:
            RefusedError: it has ended.
        """
        if not self.left_s:
            raise RefusedError("You are logged out.", "Log in again.")
        self._used_s = self._now()

    def end(self) -> None:
        """Log out."""
        self._ended = True


@dataclass
class _Tries:
    """Wrong passphrases from one address."""

    count: int = 0
    next_s: float = 0.0


class Access:
    """Lets operators in.

    Args:
        passphrase: what is kept of it; None lets nobody in.
        idle_s: a session ends when nothing is done for so long (wall time).
        now: seconds of a clock that never goes back.
    """

    def __init__(
        self,
        passphrase: PassphraseHash | None,
        idle_s: float,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._passphrase = passphrase
        self._idle_s = idle_s
        self._now = now
        self._sessions: OrderedDict[bytes, Session] = OrderedDict()
        self._tries: OrderedDict[str, _Tries] = OrderedDict()
        self._trying = asyncio.Lock()

    @property
    def is_open(self) -> bool:
        """Whether there is a passphrase at all."""
        return self._passphrase is not None

    async def log_in(self, passphrase: str, address: str) -> str:
        """Let somebody in.

        Args:
            passphrase: as it was typed.
            address: where it came from.

        Returns:
            The token for the cookie.

        Raises:
            TooSoonError: it came too soon after wrong ones.
            RefusedError: it is wrong.
        """
        if self._passphrase is None:
            raise RefusedError("No passphrase is set for operators.")
        # One at a time: many guesses at once take no more of the computer than one.
        async with self._trying:
            wait_s = self._tries[address].next_s - self._now() if address in self._tries else 0.0
            if wait_s > 0:
                raise TooSoonError(
                    "Too many wrong passphrases.", f"Try again in {wait_s:.0f} seconds."
                )
            if not await asyncio.to_thread(self._passphrase.fits, passphrase):
                self._note_wrong(address)
                raise RefusedError("That is not the passphrase.")
        self._tries.pop(address, None)
        token = secrets.token_urlsafe(32)
        self._sessions[_hashed(token)] = Session(self._idle_s, self._now)
        self._forget_ended()
        log.info("operator logged in", address=address)
        return token

    def session(self, token: str | None) -> Session | None:
        """The session of a cookie's token; None when it has none that lasts."""
        found = self._sessions.get(_hashed(token)) if token else None
        return found if found is not None and found.left_s else None

    def log_out(self, token: str | None) -> None:
        """End the session of a cookie's token."""
        if token and (session := self._sessions.pop(_hashed(token), None)):
            session.end()
            log.info("operator logged out")

    def _note_wrong(self, address: str) -> None:
        tries = self._tries.setdefault(address, _Tries())
        self._tries.move_to_end(address)
        tries.count += 1
        if tries.count >= _FREE_TRIES:
            wait_s = min(_LONGEST_WAIT_S, 2.0 ** (tries.count - _FREE_TRIES + 1))
            tries.next_s = self._now() + wait_s
        log.warning("wrong passphrase for the operator's view", address=address)
        if len(self._tries) > _ADDRESSES:
            self._tries.popitem(last=False)

    def _forget_ended(self) -> None:
        for key in [key for key, session in self._sessions.items() if not session.left_s]:
            del self._sessions[key]
        while len(self._sessions) > _SESSIONS:
            key = min(self._sessions, key=lambda known: self._sessions[known].left_s)
            self._sessions.pop(key).end()


def _hashed(token: str) -> bytes:
    return hashlib.sha256(token.encode()).digest()
