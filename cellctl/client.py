"""The bus client: what the command line, the page and other people's software use.

A ``CellClient`` is synchronous and belongs to one thread. Every wait has a time-out.
"""

from __future__ import annotations

import hashlib
import os
import secrets
import time
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

import zmq
from pydantic import ValidationError

from cellctl.assembly import Role
from cellctl.config import CellConfig
from cellctl.endpoints import is_ipv6, is_wide, reachable, socket_file
from cellctl.errors import CellctlError, RefusedError, UsageError
from cellctl.keys import client_key
from cellctl.messages import (
    MAX_ATTACHMENT,
    MAX_TEXT,
    BuildCommand,
    Command,
    ConfirmCommand,
    ControlReply,
    ControlRequest,
    FileCommand,
    FileData,
    FileKind,
    HearCommand,
    PlainCommand,
    SayCommand,
    Snapshot,
    SnapshotCommand,
    StatusMessage,
    attachment_limit,
)


class NoDaemonError(CellctlError):
    """Nothing answers at the door."""


class CellClient:
    """Talks to one daemon.

    Args:
        door: end point to ask at; the visitor's or the operator's, which decides what is allowed.
        status: end point of the status socket.
        timeout_s: how long to wait for a reply (wall time).
        key: the client's key file, for end points that are locked; used at both.
        max_attachment: largest file that is taken at that door, in bytes.

    Raises:
        ConfigError: the key file is not there, is damaged, or can be read by others.
    """

    def __init__(
        self,
        door: str,
        status: str,
        timeout_s: float = 10.0,
        key: Path | None = None,
        max_attachment: int = MAX_ATTACHMENT,
    ) -> None:
        self._key = client_key(key) if key is not None else None
        self._locked = {door, status} if key is not None else set()
        self._context = zmq.Context()
        self._context.setsockopt(zmq.LINGER, 0)
        self._door = door
        self._status = status
        self._timeout_s = timeout_s
        self._max_attachment = max_attachment
        self.visitor = ""
        """A visitor's secret, up to 64 characters, drawn by whoever asks for that visitor; empty
        for the one in front of the cell."""
        self._subscription: zmq.Socket[bytes] | None = None

    @classmethod
    def for_role(
        cls,
        config: CellConfig,
        role: Role = Role.OPERATOR,
        timeout_s: float = 10.0,
        key: Path | None = None,
    ) -> Self:
        """A client that knocks at that role's door of the cell.

        Args:
            config: the cell's configuration.
            role: whose door; who may use it, the cell decides.
            timeout_s: how long to wait for a reply (wall time).
            key: the client's key file; used at end points wider than ipc and loopback only.

        Raises:
            ConfigError: the key file is needed and is not there, is damaged, or can be read by
                others.
        """
        door, status = config.bus.door(role), config.bus.status
        wide = {reachable(endpoint) for endpoint in (door, status) if is_wide(endpoint)}
        limit = attachment_limit(role, config.hearing.max_audio_s)
        client = cls(reachable(door), reachable(status), timeout_s, key if wide else None, limit)
        client._locked = wide
        return client

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the sockets."""
        self._context.destroy(linger=0)

    def request(
        self, body: Command, attachment: bytes | None = None, timeout_s: float | None = None
    ) -> ControlReply:
        """Send one request and wait for its reply.

        Args:
            body: what to ask.
            attachment: content of the file that goes with it.
            timeout_s: longest wait for the reply (wall time); else the client's own.

        Raises:
            NoDaemonError: no reply within the time-out.
            RefusedError: the daemon does not allow it now, not at this door or not with this key,
                or is too busy.
            UsageError: the daemon could not make sense of it.
        """
        return self._exchange(body, attachment, timeout_s)[0]

    def _exchange(
        self, body: Command, attachment: bytes | None = None, timeout_s: float | None = None
    ) -> tuple[ControlReply, bytes | None]:
        """A request, its reply, and the file that came with it."""
        if attachment is not None and len(attachment) > self._max_attachment:
            raise UsageError(
                f"The file has {len(attachment) / 1e6:.0f} MB; "
                f"{self._max_attachment / 1e6:.0f} MB are taken at most."
            )
        self._refuse_if_closed()
        request = ControlRequest(id=secrets.token_hex(8), body=body, visitor=self.visitor)
        frames = [request.model_dump_json().encode()]
        if attachment is not None:
            frames.append(attachment)
        socket = self._connected(zmq.DEALER, self._door)
        try:
            socket.send_multipart(frames)
            self._await_reply(socket, self._timeout_s if timeout_s is None else timeout_s)
            document, *files = socket.recv_multipart()
            reply = ControlReply.model_validate_json(document)
        except ValidationError as error:
            raise CellctlError(f"{self._door} sent an unreadable reply.") from error
        finally:
            self._close(socket)
        if reply.error is not None:
            kind = RefusedError if reply.error.code in {"refused", "busy"} else UsageError
            if reply.error.code == "internal":
                kind = CellctlError  # type: ignore[assignment]
            raise kind(reply.error.message, reply.error.hint)
        return reply, files[0] if files else None

    def _connected(self, kind: int, endpoint: str) -> zmq.Socket[bytes]:
        if endpoint in self._locked and self._key is None:
            raise UsageError(
                f"{endpoint} takes clients with a key only.",
                "Name your key file with --key or $CELLCTL_KEY; the cell's operator makes one with "
                "`cellctl keys make --client NAME`.",
            )
        socket: zmq.Socket[bytes] = self._context.socket(kind)
        if endpoint in self._locked and self._key is not None:
            socket.curve_secretkey = self._key.own.secret
            socket.curve_publickey = self._key.own.public
            socket.curve_serverkey = self._key.server
        socket.setsockopt(zmq.IPV6, is_ipv6(endpoint))
        if kind == zmq.SUB:
            socket.setsockopt(zmq.RCVHWM, 10_000)
            socket.subscribe(b"")
        if kind == zmq.DEALER and endpoint in self._locked:
            # Before it connects: a refusal that came before somebody listened would be lost.
            socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_FAILED_AUTH)
        try:
            socket.connect(endpoint)
        except zmq.ZMQError as error:
            self._close(socket)
            raise UsageError(
                f"{endpoint} cannot be connected to: {error.strerror}.",
                "Name the cell's address, not that of an interface.",
            ) from error
        return socket

    def _await_reply(self, socket: zmq.Socket[bytes], timeout_s: float) -> None:
        """Wait for a reply, or for the cell to turn the key down."""
        poller = zmq.Poller()
        poller.register(socket, zmq.POLLIN)
        locked = self._door in self._locked
        if locked:
            poller.register(socket.get_monitor_socket(), zmq.POLLIN)
        ready = [found for found, _ in poller.poll(int(timeout_s * 1000))]
        if socket in ready:
            return
        if ready:
            raise RefusedError(
                f"{self._door} does not take this key.",
                "It was revoked, or made for another door; the cell's operator can make another.",
            )
        if locked:
            raise NoDaemonError(
                f"No cell answers on {self._door}, or none that this key is for.",
                "See that it runs there, and that the key was made since it has its own.",
            )
        raise NoDaemonError(
            f"No cell answers on {self._door}.",
            "Start it with `cellctl run`, or name its configuration with --config.",
        )

    def _close(self, socket: zmq.Socket[bytes]) -> None:
        """Close a socket, and what watches it."""
        if socket.type == zmq.DEALER and self._door in self._locked:
            turned_down = socket.get_monitor_socket()
            socket.disable_monitor()
            turned_down.close()
        socket.close()

    def _refuse_if_closed(self) -> None:
        """A door that this user may not open would look like a daemon that does not answer."""
        file = socket_file(self._door)
        if file is not None and file.exists() and not os.access(file, os.W_OK):
            raise RefusedError(
                f"You may not use {self._door}: its group alone may.",
                "Ask in a visitor's name with --role visitor, or have yourself put into its group.",
            )

    def snapshot(self) -> Snapshot:
        """The whole picture."""
        reply = self.request(SnapshotCommand())
        if reply.snapshot is None:
            raise CellctlError(f"{self._door} sent no snapshot.")
        return reply.snapshot

    def file(
        self, kind: FileKind, job_id: str = "", timeout_s: float | None = None
    ) -> tuple[FileData, bytes]:
        """A file of a job, and what is told of it.

        Args:
            kind: which of its files.
            job_id: whose; empty: of the job under way, or of the last one.
            timeout_s: longest wait for the reply (wall time); else the client's own.

        Raises:
            UsageError: there is no such job or no such file.
            RefusedError: that job's files need the operator.
            CellctlError: the file is damaged.
        """
        try:
            command = FileCommand(kind=kind, job_id=job_id)
        except ValidationError as error:
            raise UsageError(f"{job_id[:16]}... is no job.") from error
        reply, content = self._exchange(command, timeout_s=timeout_s)
        if not isinstance(reply.data, FileData) or content is None:
            raise CellctlError(f"{self._door} sent no file.")
        if hashlib.sha256(content).hexdigest() != reply.data.sha256:
            raise CellctlError(f"{self._door} sent a damaged {kind}.")
        return reply.data, content

    def say(self, text: str, asked: str | None = None) -> ControlReply:
        """Give the cell typed words.

        Args:
            text: what is said.
            asked: name of the question that was seen to be open, for words that say yes.

        Raises:
            UsageError: there are none, or more than ``MAX_TEXT`` characters.
        """
        if not text.strip() or len(text) > MAX_TEXT:
            raise UsageError(
                f"The sentence has {len(text)} characters; from 1 to {MAX_TEXT} are taken.",
                'Say what to build in one sentence, for example "a simple stool".',
            )
        return self.request(SayCommand(text=text, asked=asked))

    def hear(self, name: str, wav: bytes) -> ControlReply:
        """Give the cell a wav file to listen to."""
        return self.request(HearCommand(name=name), wav)

    def build(self, name: str, content: bytes) -> ControlReply:
        """Give the cell a mesh or a plan to build."""
        return self.request(BuildCommand(name=name), content)

    def confirm(self, answer: bool, asked: str | None = None) -> ControlReply:
        """Answer "Shall I build it?".

        Args:
            answer: yes or no.
            asked: name of the question that is answered; of the one that is open now when left out.
        """
        if asked is None:
            asked = self.snapshot().dialogue.asked
        return self.request(ConfirmCommand(answer=answer, asked=asked))

    def command(self, name: str) -> ControlReply:
        """Give one of the commands without arguments: pause, resume, stop, cancel, ..."""
        return self.request(PlainCommand.model_validate({"command": name}))

    def subscribe(self) -> None:
        """Begin to receive status messages; ``messages`` does it too."""
        if self._subscription is None:
            self._subscription = self._connected(zmq.SUB, self._status)

    def messages(self, timeout_s: float) -> Iterator[StatusMessage]:
        """Status messages as they come, until none came for ``timeout_s`` (wall time).

        Raises:
            CellctlError: one cannot be read: the daemon is of another version.
        """
        self.subscribe()
        socket = self._subscription
        assert socket is not None
        while socket.poll(int(timeout_s * 1000)):
            try:
                message = StatusMessage.model_validate_json(socket.recv_multipart()[1])
            except ValidationError as error:
                raise CellctlError(f"{self._status} sent an unreadable message.") from error
            yield message

    def wait_ready(self, timeout_s: float) -> Snapshot:
        """Wait until a daemon answers.

        Raises:
            NoDaemonError: none did in time (wall time).
        """
        deadline_s = time.monotonic() + timeout_s
        patience_s, self._timeout_s = self._timeout_s, 0.5
        try:
            while True:
                try:
                    return self.snapshot()
                except NoDaemonError:
                    if time.monotonic() > deadline_s:
                        raise
        finally:
            self._timeout_s = patience_s
