"""The bus client: what the command line, the page and other people's software use.

A ``CellClient`` is synchronous and belongs to one thread. Every wait has a time-out.
"""

from __future__ import annotations

import os
import secrets
import time
from collections.abc import Iterator
from types import TracebackType
from typing import Self

import zmq
from pydantic import ValidationError

from cellctl.assembly import Role
from cellctl.config import CellConfig
from cellctl.endpoints import socket_file
from cellctl.errors import CellctlError, RefusedError, UsageError
from cellctl.messages import (
    MAX_ATTACHMENT,
    MAX_TEXT,
    BuildCommand,
    Command,
    ConfirmCommand,
    ControlReply,
    ControlRequest,
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
        max_attachment: largest file that is taken at that door, in bytes.
    """

    def __init__(
        self,
        door: str,
        status: str,
        timeout_s: float = 10.0,
        max_attachment: int = MAX_ATTACHMENT,
    ) -> None:
        self._context = zmq.Context()
        self._context.setsockopt(zmq.LINGER, 0)
        self._door = door
        self._status = status
        self._timeout_s = timeout_s
        self._max_attachment = max_attachment
        self._subscription: zmq.Socket[bytes] | None = None

    @classmethod
    def for_role(
        cls, config: CellConfig, role: Role = Role.OPERATOR, timeout_s: float = 10.0
    ) -> Self:
        """A client that knocks at that role's door of the cell.

        Args:
            config: the cell's configuration.
            role: whose door; who may use it, the cell decides.
            timeout_s: how long to wait for a reply (wall time).
        """
        limit = attachment_limit(role, config.hearing.max_audio_s)
        return cls(config.bus.door(role), config.bus.status, timeout_s, limit)

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

    def request(self, body: Command, attachment: bytes | None = None) -> ControlReply:
        """Send one request and wait for its reply.

        Raises:
            NoDaemonError: no reply within the time-out.
            RefusedError: the daemon does not allow it now, or not to this role, or is too busy.
            UsageError: the daemon could not make sense of it.
        """
        if attachment is not None and len(attachment) > self._max_attachment:
            raise UsageError(
                f"The file has {len(attachment) / 1e6:.0f} MB; "
                f"{self._max_attachment / 1e6:.0f} MB are taken at most."
            )
        self._refuse_if_closed()
        request = ControlRequest(id=secrets.token_hex(8), body=body)
        frames = [request.model_dump_json().encode()]
        if attachment is not None:
            frames.append(attachment)
        socket: zmq.Socket[bytes] = self._context.socket(zmq.DEALER)
        try:
            socket.connect(self._door)
            socket.send_multipart(frames)
            if not socket.poll(int(self._timeout_s * 1000)):
                raise NoDaemonError(
                    f"No cell answers on {self._door}.",
                    "Start it with `cellctl run`, or name its configuration with --config.",
                )
            reply = ControlReply.model_validate_json(socket.recv_multipart()[-1])
        except ValidationError as error:
            raise CellctlError(f"{self._door} sent an unreadable reply.") from error
        finally:
            socket.close()
        if reply.error is not None:
            kind = RefusedError if reply.error.code in {"refused", "busy"} else UsageError
            if reply.error.code == "internal":
                kind = CellctlError  # type: ignore[assignment]
            raise kind(reply.error.message, reply.error.hint)
        return reply

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

    def say(self, text: str) -> ControlReply:
        """Give the cell typed words.

        Raises:
            UsageError: there are none, or more than ``MAX_TEXT`` characters.
        """
        if not text.strip() or len(text) > MAX_TEXT:
            raise UsageError(
                f"The sentence has {len(text)} characters; from 1 to {MAX_TEXT} are taken.",
                'Say what to build in one sentence, for example "a simple stool".',
            )
        return self.request(SayCommand(text=text))

    def hear(self, name: str, wav: bytes) -> ControlReply:
        """Give the cell a wav file to listen to."""
        return self.request(HearCommand(name=name), wav)

    def build(self, name: str, content: bytes) -> ControlReply:
        """Give the cell a mesh or a plan to build."""
        return self.request(BuildCommand(name=name), content)

    def confirm(self, answer: bool) -> ControlReply:
        """Answer "Shall I build it?"."""
        return self.request(ConfirmCommand(answer=answer))

    def command(self, name: str) -> ControlReply:
        """Give one of the commands without arguments: pause, resume, stop, cancel, ..."""
        return self.request(PlainCommand.model_validate({"command": name}))

    def subscribe(self) -> None:
        """Begin to receive status messages; ``messages`` does it too."""
        if self._subscription is None:
            socket: zmq.Socket[bytes] = self._context.socket(zmq.SUB)
            socket.setsockopt(zmq.RCVHWM, 10_000)
            socket.connect(self._status)
            socket.subscribe(b"")
            self._subscription = socket

    def messages(self, timeout_s: float) -> Iterator[StatusMessage]:
        """Status messages as they come, until none came for ``timeout_s`` (wall time)."""
        self.subscribe()
        socket = self._subscription
        assert socket is not None
        while socket.poll(int(timeout_s * 1000)):
            yield StatusMessage.model_validate_json(socket.recv_multipart()[1])

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
