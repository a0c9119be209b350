"""Who may connect to the bus's wide end points: CURVE keys, checked against the allow-list.

libzmq asks before it lets a client in (ZAP, ZeroMQ RFC 27). Nobody to ask means nobody comes in:
without ``ZAP_ENFORCE_DOMAIN`` it would mean everybody.
"""

from __future__ import annotations

from typing import Any

import zmq
import zmq.asyncio
from zmq.auth import Authenticator

from cellctl.assembly import Role
from cellctl.keys import AllowList, KeyPair

_KEEPALIVE_IDLE_S = 60


class Gatekeeper:
    """Answers libzmq's questions about clients, and locks sockets.

    Args:
        context: of the sockets.
        key: the cell's own.
        allowed: the clients that may come in.
    """

    def __init__(self, context: zmq.asyncio.Context, key: KeyPair, allowed: AllowList) -> None:
        self._key = key
        self._allowed = allowed
        self._authenticator = Authenticator(zmq.Context(context))
        for domain in ("status", *Role):
            self._authenticator.configure_curve_callback(domain, self)

    def open(self) -> None:
        """Be there to be asked; before any socket is bound."""
        self._authenticator.start()

    def lock(self, socket: zmq.Socket[Any], domain: str) -> None:
        """Let a socket that is not yet bound take allowed clients only.

        Args:
            socket: the one to lock.
            domain: ``status``, or the role whose door it is.
        """
        socket.curve_server = True
        socket.curve_secretkey = self._key.secret
        socket.curve_publickey = self._key.public
        socket.setsockopt_string(zmq.ZAP_DOMAIN, domain)
        socket.setsockopt(zmq.ZAP_ENFORCE_DOMAIN, 1)
        # A client that vanished without a word is noticed, and its queue given back.
        socket.setsockopt(zmq.TCP_KEEPALIVE, 1)
        socket.setsockopt(zmq.TCP_KEEPALIVE_IDLE, _KEEPALIVE_IDLE_S)

    def callback(self, domain: str, key: bytes) -> bool:
        """Whether the client with that public key may connect; the authenticator asks."""
        # Whoever may use any door may hear status.
        door = Role.VISITOR if domain == "status" else Role(domain)
        return self.admits(key.decode(), door)

    def admits(self, key: str, door: Role) -> bool:
        """Whether the client with that public key may use a door now."""
        return self._allowed.admits(key, door)

    def keys(self) -> frozenset[str]:
        """The public keys of all that are allowed now."""
        return self._allowed.keys()

    async def serve(self) -> None:
        """Answer until cancelled."""
        asked = self._authenticator.zap_socket
        poller = zmq.asyncio.Poller()
        poller.register(asked, zmq.POLLIN)
        while True:
            await poller.poll()
            await self._authenticator.handle_zap_message(asked.recv_multipart(zmq.NOBLOCK))

    def close(self) -> None:
        """Be there no more: from now on nobody new comes in."""
        self._authenticator.stop()
