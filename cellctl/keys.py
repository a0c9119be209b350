"""Keys of the bus: who may use end points that more than this machine reaches.

The cell has one CURVE key pair, each client one of its own. The folder ``bus.keys`` holds::

    server.key         the cell's secret: mode 0600, owned by the daemon's user
    server.pub         what clients know the cell by
    operators.d/*.pub  clients that may use both doors and hear status
    visitors.d/*.pub   clients that may use the visitor's door and hear status

A client's key file holds its own pair and the cell's public key, and is kept like the cell's. The
files have the form that other ZeroMQ software writes (``zcert``), keys in Z85 (ZeroMQ RFC 26, 32).
A secret is never part of a message, a ``repr`` or a log line.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import structlog
import zmq
from zmq.utils import z85

from cellctl.assembly import Role
from cellctl.endpoints import is_wide
from cellctl.errors import ConfigError, UsageError

log = structlog.get_logger(__name__)

SECRET_SUFFIX = ".key"  # noqa: S105 - the name of a kind of file
"""Of files that hold a secret; what copies or lists the folder leaves them out."""
_PUBLIC_SUFFIX = ".pub"
_FOLDERS = {Role.VISITOR: "visitors.d", Role.OPERATOR: "operators.d"}
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
_LINE = re.compile(r'^\s*(public-key|secret-key|server-key)\s*=\s*"([^"\s]{40})"\s*$', re.MULTILINE)
_MAX_BYTES = 4096
_MAKE = "Make one with `cellctl keys make`, in the name of the user that the daemon runs as."


@dataclass(frozen=True)
class KeyPair:
    """A CURVE key pair, in Z85."""

    public: bytes
    secret: bytes = field(repr=False)


@dataclass(frozen=True)
class ClientKey:
    """What a client needs: its own pair, and the public key of the cell it trusts."""

    own: KeyPair
    server: bytes


@dataclass(frozen=True)
class Client:
    """A client of the allow-list."""

    name: str
    role: Role
    public: str
    file: Path


def make_server(folder: Path) -> Path:
    """Make the cell's key pair; returns the file of its public key.

    Raises:
        UsageError: it has one already, or the files cannot be written.
    """
    pair = _new_pair()
    _make_folders(folder)
    # The secret comes last: with it the pair counts as made.
    public = folder / f"server{_PUBLIC_SUFFIX}"
    secret = folder / f"server{SECRET_SUFFIX}"
    if secret.exists():
        raise UsageError(
            f"{secret}: the cell has a key already.",
            "With another one all clients need new files; if that is wanted, remove it first.",
        )
    public.unlink(missing_ok=True)
    _write_new(public, _text(pair.public), 0o644)
    _write_new(secret, _text(pair.public, secret=pair.secret), 0o600)
    return public


def make_client(folder: Path, name: str, role: Role, file: Path) -> None:
    """Make a key for a client, allow it, and write the client's key file.

    Args:
        folder: the cell's folder of keys.
        name: of the client: letters, digits, ``_``, ``.`` and ``-``.
        role: which door it may use.
        file: to write; it must not exist.

    Raises:
        ConfigError: the cell has no key of its own.
        UsageError: the name cannot be used or is taken, or a file cannot be written.
    """
    if not _NAME.fullmatch(name):
        raise UsageError(
            f"{name!r} cannot be the name of a client.",
            "Use up to 64 letters, digits, _, . and -, with a letter or digit first.",
        )
    if any(client.name == name for client in clients(folder)):
        raise UsageError(
            f"There is a key for {name} already.",
            f"Take another name, or revoke it first with `cellctl keys revoke {name}`.",
        )
    server = _server_public(folder)
    pair = _new_pair()
    _write_new(file, _text(pair.public, secret=pair.secret, server=server), 0o600)
    try:
        _write_new(folder / _FOLDERS[role] / f"{name}{_PUBLIC_SUFFIX}", _text(pair.public), 0o644)
    except UsageError:
        file.unlink()  # a key that nobody allowed is of no use
        raise


def revoke(folder: Path, name: str) -> None:
    """Take a client off the allow-list.

    Raises:
        UsageError: it is not on the list, or its file cannot be removed.
    """
    known = clients(folder)
    files = [client.file for client in known if client.name == name]
    if not files:
        names = ", ".join(sorted({client.name for client in known})) or "none"
        raise UsageError(f"{name!r} is no client of this cell.", f"Its clients: {names}.")
    for file in files:
        try:
            file.unlink()
        except OSError as error:
            raise UsageError(f"{file}: cannot be removed: {error.strerror}.") from error


def clients(folder: Path) -> tuple[Client, ...]:
    """The clients on the allow-list, operators first; files that hold no key are left out."""
    return tuple(_clients(folder))


def _clients(folder: Path) -> Iterator[Client]:
    for role in (Role.OPERATOR, Role.VISITOR):
        for file in sorted((folder / _FOLDERS[role]).glob(f"[!.]*{_PUBLIC_SUFFIX}")):
            try:
                found = _keys_in(file, file.read_text(encoding="ascii", errors="replace"))
            except (OSError, ConfigError) as error:
                log.warning("a key on the allow-list cannot be used", reason=str(error))
                continue
            yield Client(file.stem, role, found["public-key"].decode(), file)


class AllowList:
    """The clients of one cell, read again whenever a file has changed.

    Args:
        folder: the cell's folder of keys.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._signature: object = None
        self._roles: dict[str, Role] = {}

    def keys(self) -> frozenset[str]:
        """The public keys of all that are allowed, in Z85."""
        self._refresh()
        return frozenset(self._roles)

    def admits(self, key: str, door: Role) -> bool:
        """Whether the client with that public key may use a door; an operator may use both."""
        self._refresh()
        role = self._roles.get(key)
        return role is Role.OPERATOR or (role is not None and role is door)

    def _refresh(self) -> None:
        signature = self._look()
        if signature == self._signature:
            return
        roles: dict[str, Role] = {}
        for client in clients(self._folder):
            roles.setdefault(client.public, client.role)  # operators come first, and win
        self._signature, self._roles = signature, roles

    def _look(self) -> object:
        """What changes with any of the files; cheap, for it is taken at every request."""
        found = []
        for folder in _FOLDERS.values():
            try:
                with os.scandir(self._folder / folder) as entries:
                    for entry in entries:
                        about = entry.stat()
                        found.append((entry.path, about.st_ino, about.st_mtime_ns, about.st_size))
            except OSError:  # no folder, nobody allowed
                continue
        return sorted(found)


def server_key(folder: Path) -> KeyPair:
    """The cell's key pair, for the daemon.

    Raises:
        ConfigError: there is none, or its file is not kept as a secret has to be.
    """
    return _pair(folder / f"server{SECRET_SUFFIX}", _MAKE)[0]


def _server_public(folder: Path) -> bytes:
    """The cell's public key, which whoever may make keys for clients may read."""
    file = folder / f"server{_PUBLIC_SUFFIX}"
    try:
        return _keys_in(file, file.read_text(encoding="ascii", errors="replace"))["public-key"]
    except OSError as error:
        raise ConfigError(f"{file}: cannot be read: {error.strerror}.", _MAKE) from error


def require_server_key(endpoints: Mapping[str, str], folder: Path) -> bool:
    """Whether an end point is wider than ipc and loopback, so that the cell's key is needed.

    Args:
        endpoints: by the names of their options.
        folder: the cell's folder of keys.

    Raises:
        ConfigError: one is, and there is no key.
    """
    wide = next((name for name, endpoint in endpoints.items() if is_wide(endpoint)), None)
    file = folder / f"server{SECRET_SUFFIX}"
    if wide is not None and not file.exists():
        raise ConfigError(
            f"bus.{wide} = {endpoints[wide]!r} is reached by more than this machine, and works "
            f"with keys only; {file} is not there.",
            f"{_MAKE} Or use ipc:// or tcp://127.0.0.1.",
        )
    return wide is not None


def client_key(file: Path) -> ClientKey:
    """A client's key file.

    Raises:
        ConfigError: it is not there, is damaged, or is not kept as a secret has to be.
    """
    hint = "The cell's operator makes one with `cellctl keys make --client NAME`."
    pair, found = _pair(file, hint)
    if "server-key" not in found:
        raise ConfigError(f"{file}: holds no key of the cell (server-key).", hint)
    return ClientKey(pair, found["server-key"])


def _pair(file: Path, hint: str) -> tuple[KeyPair, dict[str, bytes]]:
    found = _keys_in(file, _read_secret(file, hint), hint)
    secret = found.get("secret-key")
    if secret is None or zmq.curve_public(secret) != found["public-key"]:
        raise ConfigError(
            f"{file}: its secret key is missing or does not fit its public key.", hint
        )
    return KeyPair(found["public-key"], secret), found


def _read_secret(file: Path, hint: str) -> str:
    """The text of a file that its owner alone may read."""
    try:
        descriptor = os.open(file, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except OSError as error:
        raise ConfigError(f"{file}: cannot be read: {error.strerror}.", hint) from error
    with os.fdopen(descriptor, "rb") as opened:
        about = os.fstat(descriptor)
        if not stat.S_ISREG(about.st_mode):
            raise ConfigError(f"{file}: is no file.", hint)
        if about.st_uid != os.geteuid():
            raise ConfigError(
                f"{file}: belongs to another user, who could change this secret key.",
                f"Give it to the user who uses it: chown {os.geteuid()} {file}",
            )
        if about.st_mode & 0o077:
            raise ConfigError(
                f"{file}: others may use this secret key (mode {about.st_mode & 0o777:04o}).",
                f"Close it: chmod 600 {file}, and make a new key if somebody may have read it.",
            )
        return opened.read(_MAX_BYTES).decode("ascii", errors="replace")


def _keys_in(file: Path, text: str, hint: str = "") -> dict[str, bytes]:
    found = {name: key.encode() for name, key in _LINE.findall(text)}
    try:
        for key in found.values():
            z85.decode(key)
    except (ValueError, KeyError) as error:
        del error  # it might quote the key
        raise ConfigError(f"{file}: holds something that is no key.", hint) from None
    if "public-key" not in found:
        raise ConfigError(f"{file}: holds no key.", hint)
    return found


def _new_pair() -> KeyPair:
    public, secret = zmq.curve_keypair()
    return KeyPair(public, secret)


def _text(public: bytes, *, secret: bytes | None = None, server: bytes | None = None) -> str:
    lines = ["curve", f'    public-key = "{public.decode()}"']
    if secret is not None:
        lines.insert(0, "# A secret: not to be copied, shown or given away.")
        lines.append(f'    secret-key = "{secret.decode()}"')
    if server is not None:
        lines.append(f'    server-key = "{server.decode()}"')
    return "\n".join(lines) + "\n"


def _make_folders(folder: Path) -> None:
    try:
        for each in (folder, *(folder / name for name in _FOLDERS.values())):
            if not each.is_dir():
                each.mkdir(parents=True, mode=0o755)
                _give_to_owner_of(each.parent, each)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be made: {error.strerror}.") from error


def write_secret(file: Path, text: str) -> None:
    """Write a secret of one's own into a new file that nobody else may read.

    Raises:
        UsageError: it exists, or cannot be written.
    """
    _write_new(file, text, 0o600)


def _write_new(file: Path, text: str, mode: int) -> None:
    """Write a file that did not exist; nobody ever sees half of it, or sees it with another mode.

    Raises:
        UsageError: it exists, or cannot be written.
    """
    half = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        descriptor = os.open(half, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        try:
            with os.fdopen(descriptor, "w", encoding="ascii") as opened:
                opened.write(text)
                opened.flush()
                os.fchmod(descriptor, mode)
                os.fsync(descriptor)
            _give_to_owner_of(file.parent, half)
            os.link(half, file)
        finally:
            half.unlink()
    except FileExistsError as error:
        raise UsageError(f"{file}: exists already.", "Name another file, or remove it.") from error
    except OSError as error:
        raise UsageError(f"{file}: cannot be written: {error.strerror}.") from error


def _give_to_owner_of(folder: Path, path: Path) -> None:
    """What root makes belongs to the owner of the folder: the daemon's user, or the client's."""
    if os.geteuid() == 0:
        about = folder.stat()
        os.chown(path, about.st_uid, about.st_gid, follow_symlinks=False)
