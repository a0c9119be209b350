"""A service that speaks OpenAI's chat completions, and misbehaves in every way it is told to."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

KEY = "sk-test-123"


@dataclass
class Reply:
    """One answer of the service."""

    status: int = 200
    content: str | None = None
    """What the model says; None where ``body`` is the whole answer."""
    body: bytes = b""
    headers: dict[str, str] = field(default_factory=dict)
    finish_reason: str = "stop"
    silent: bool = False
    """Accepts the request and never answers."""
    trickle: bool = False
    """Sends a byte now and then, for ever."""
    drop: bool = False
    """Hangs up without a word."""

    @property
    def raw(self) -> bytes:
        """The body on the wire."""
        if self.content is None:
            return self.body
        choice = {
            "index": 0,
            "message": {"role": "assistant", "content": self.content, "refusal": None},
            "finish_reason": self.finish_reason,
        }
        return json.dumps({"id": "chatcmpl-1", "choices": [choice]}).encode()


def error(status: int, code: str, message: str = "no", **headers: str) -> Reply:
    """An error as the contract has it."""
    body = json.dumps({"error": {"message": message, "type": code, "code": code}}).encode()
    return Reply(status, body=body, headers={k.replace("_", "-"): v for k, v in headers.items()})


class ModelServer:
    """Answers with what ``replies`` hold, one after another; the last one for ever."""

    def __init__(self) -> None:
        self.replies: list[Reply] = [Reply(content="false")]
        self.requests: list[dict[str, Any]] = []
        """Bodies that came in, in order."""
        self.keys: list[str | None] = []
        self.asked = threading.Semaphore(0)
        """Counts them, for who waits for one."""
        self.ended = threading.Event()
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), self._handler())
        self._server.daemon_threads = False
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.01,))

    @property
    def url(self) -> str:
        """For ``model_url``."""
        return f"http://127.0.0.1:{self._server.server_port}/v1"

    def start(self) -> None:
        """Serve."""
        self._thread.start()

    def close(self) -> None:
        """End every connection, those that never answer too."""
        self.ended.set()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def _next(self, body: dict[str, Any], key: str | None) -> Reply:
        self.requests.append(body)
        self.keys.append(key)
        self.asked.release()
        return self.replies.pop(0) if len(self.replies) > 1 else self.replies[0]

    def _handler(self) -> Callable[..., BaseHTTPRequestHandler]:
        service = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self) -> None:
                length = int(self.headers["content-length"])
                body = json.loads(self.rfile.read(length))
                self.close_connection = True
                if self.path != "/v1/chat/completions":
                    self.send_error(404)
                    return
                reply = service._next(body, self.headers["authorization"])
                if reply.drop:
                    return
                if reply.silent:
                    service.ended.wait()
                    return
                self.send_response(reply.status)
                for name, value in reply.headers.items():
                    self.send_header(name, value)
                if reply.trickle:
                    self.send_header("content-length", "1000000")
                    self.end_headers()
                    self._trickle()
                    return
                self.send_header("content-type", "application/json")
                self.send_header("content-length", str(len(reply.raw)))
                self.end_headers()
                self._write(reply.raw)

            def _trickle(self) -> None:
                while not service.ended.wait(0.02):
                    if not self._write(b" "):
                        return

            def _write(self, data: bytes) -> bool:
                try:
                    self.wfile.write(data)
                    self.wfile.flush()
                except OSError:
                    return False  # whoever asked has gone
                return True

            def log_message(self, format: str, *args: object) -> None:  # noqa: A002
                """Say nothing."""

        return Handler


@contextmanager
def model_server() -> Iterator[ModelServer]:
    """A service on a port of its own."""
    server = ModelServer()
    server.start()
    try:
        yield server
    finally:
        server.close()
