"""An operator's passphrase, kept as a salted hash that is slow to guess (scrypt, RFC 7914)."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import os
from dataclasses import dataclass
from typing import Final, Self

from cellctl.errors import ConfigError, UsageError

OPERATOR_CREDENTIAL: Final = "page-passphrase"
"""Name of the credential that holds the hash of the operators' passphrase."""
SHORTEST: Final = 10
"""Characters that a passphrase has at least."""
_LONGEST: Final = 200
_KIND: Final = "scrypt"
_COST, _BLOCK, _PARALLEL = 2**15, 8, 1
"""About 0.1 s and 32 MiB for one guess."""
_MOST_COST: Final = 2**17
_MEMORY_BYTES: Final = 256 * 1024 * 1024
_SALT_BYTES, _HASH_BYTES = 16, 32


@dataclass(frozen=True)
class PassphraseHash:
    """What is kept of a passphrase."""

    cost: int
    salt: bytes
    digest: bytes

    @classmethod
    def of(cls, passphrase: str) -> Self:
        """Of a new passphrase.

        Raises:
            UsageError: it is too short or too long.
        """
        if not SHORTEST <= len(passphrase) <= _LONGEST:
            raise UsageError(
                f"The passphrase has {len(passphrase)} characters; "
                f"from {SHORTEST} to {_LONGEST} are taken.",
                "A few words in a row are easy to remember and hard to guess.",
            )
        salt = os.urandom(_SALT_BYTES)
        return cls(_COST, salt, _digest(passphrase, _COST, salt))

    @classmethod
    def read(cls, line: str) -> Self:
        """From its line of text, as ``line`` writes it.

        Raises:
            ConfigError: it is none.
        """
        try:
            kind, cost, salt, digest = line.strip().split("$")
            found = cls(int(cost), _bytes(salt), _bytes(digest))
        except (ValueError, binascii.Error):
            found, kind = cls(0, b"", b""), ""
        sound = kind == _KIND and 2**10 <= found.cost <= _MOST_COST
        if not sound or len(found.salt) < _SALT_BYTES or len(found.digest) != _HASH_BYTES:
            raise ConfigError(
                "The operator's passphrase is not kept as it has to be.",
                "Make it with `cellctl keys passphrase FILE`.",
            )
        return found

    @property
    def line(self) -> str:
        """One line of text that does not tell the passphrase."""
        return f"{_KIND}${self.cost}${_text(self.salt)}${_text(self.digest)}"

    def fits(self, passphrase: str) -> bool:
        """Whether it is that passphrase; takes as long for a wrong one."""
        tried = _digest(passphrase[: _LONGEST + 1], self.cost, self.salt)
        return hmac.compare_digest(tried, self.digest)


def _digest(passphrase: str, cost: int, salt: bytes) -> bytes:
    return hashlib.scrypt(
        passphrase.encode(),
        salt=salt,
        n=cost,
        r=_BLOCK,
        p=_PARALLEL,
        maxmem=_MEMORY_BYTES,
        dklen=_HASH_BYTES,
    )


def _text(content: bytes) -> str:
    return base64.b64encode(content).decode()


def _bytes(text: str) -> bytes:
    return base64.b64decode(text, validate=True)
