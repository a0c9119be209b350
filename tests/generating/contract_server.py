"""A server that speaks Meshy's, Tripo's and a plain model server's contract, and misbehaves.

Real HTTP on loopback. A test says how the next task goes, and reads afterwards what was asked.
"""

from __future__ import annotations

import json
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import urlsplit

KEY = "msy_right"  # of this server alone
TASK = "018a-task"


@dataclass
class Asked:
    """One request as it came."""

    method: str
    path: str
    authorised: bool
    body: Any


@dataclass
class Behaviour:
    """How the server behaves."""

    model: bytes = b""
    refuse_begin: list[tuple[int, dict[str, Any]]] = field(default_factory=list)
    """Answers to the first requests that begin a task: status and body."""
    looks: list[dict[str, Any]] = field(default_factory=list)
    """What is told of the task, look by look; the last one stays."""
    refuse_looks: list[int] = field(default_factory=list)
    """Statuses of the first looks that fail."""
    silent: frozenset[str] = frozenset()
    """Which of ``begin``, ``look``, ``model`` never get an answer."""
    link_status: int = 200
    link_redirects: int = 0
    redirect_begin: bool = False
    listed: list[dict[str, Any]] = field(default_factory=list)
    asked: list[Asked] = field(default_factory=list)
    released: threading.Event = field(default_factory=threading.Event)
    """Set at the end, so that what is silent ends too."""
    looked: threading.Event = field(default_factory=threading.Event)
    cancelled: threading.Event = field(default_factory=threading.Event)

    def count(self, method: str, part: str) -> int:
        """How many requests of that kind came."""
        return sum(a.method == method and part in a.path for a in self.asked)


def glb(payload: bytes = b"") -> bytes:
    """A GLB with a right header and whatever in it."""
    return struct.pack("<4sII", b"glTF", 2, 12 + len(payload)) + payload


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    behaviour: Behaviour
    url: str

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - the base class's
        """Nothing on standard error."""

    def do_GET(self) -> None:
        self._serve("GET")

    def do_POST(self) -> None:
        self._serve("POST")

    def do_DELETE(self) -> None:
        self._serve("DELETE")

    def _serve(self, method: str) -> None:
        it, path = self.behaviour, urlsplit(self.path).path
        length = int(self.headers.get("Content-Length", 0))
        body = json.loads(self.rfile.read(length)) if length else None
        authorised = self.headers.get("Authorization") == f"Bearer {KEY}"
        it.asked.append(Asked(method, self.path, authorised, body))
        if path.startswith("/models/"):
            self._model(path)
        elif not authorised:
            self._json(401, {"message": "Invalid API key", "code": 1002})
        elif method == "POST":
            self._begin(path)
        elif method == "DELETE":
            it.cancelled.set()
            self._json(200, {})
        elif path == "/v2/text-to-3d":
            self._json(200, it.listed)
        else:
            self._look(path)

    def _begin(self, path: str) -> None:
        it = self.behaviour
        if "begin" in it.silent:
            self._stay_silent()
        elif it.redirect_begin:
            self._redirect(f"{self.url}/elsewhere")
        elif it.refuse_begin:
            self._json(*it.refuse_begin.pop(0))
        elif path == "/generate":
            self._bytes(200, it.model)
        elif path.startswith("/v3/"):
            self._json(200, {"code": 0, "data": {"task_id": TASK}})
        else:
            self._json(202, {"result": TASK})

    def _look(self, path: str) -> None:
        it = self.behaviour
        it.looked.set()
        if "look" in it.silent:
            self._stay_silent()
        elif it.refuse_looks:
            self._json(it.refuse_looks.pop(0), {"message": "later"})
        else:
            task = it.looks.pop(0) if len(it.looks) > 1 else it.looks[0]
            self._json(200, {"code": 0, "data": task} if path.startswith("/v3/") else task)

    def _model(self, path: str) -> None:
        it = self.behaviour
        if "model" in it.silent:
            self._stay_silent()
        elif it.link_redirects:
            it.link_redirects -= 1
            self._redirect(f"{self.url}{path}")
        else:
            self._bytes(it.link_status, it.model)

    def _stay_silent(self) -> None:
        self.behaviour.released.wait(30.0)
        self.close_connection = True

    def _redirect(self, to: str) -> None:
        self._bytes(307, b"", {"Location": to})

    def _json(self, status: int, body: object) -> None:
        self._bytes(status, json.dumps(body).encode(), {"Retry-After": "0"})

    def _bytes(self, status: int, content: bytes, more: dict[str, str] | None = None) -> None:
        self.send_response(status)
        self.send_header("Content-Length", str(len(content)))
        for name, value in (more or {}).items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)


@dataclass(frozen=True)
class ContractServer:
    """The running server."""

    url: str
    behaviour: Behaviour

    def meshy_task(self, status: str, progress: int = 0, said: str = "") -> dict[str, Any]:
        """A task as Meshy tells of it."""
        return {
            "id": TASK,
            "status": status,
            "progress": progress,
            "model_urls": {"glb": f"{self.url}/models/a.glb"} if status == "SUCCEEDED" else {},
            "task_error": {"message": said},
        }

    def tripo_task(self, status: str, progress: int = 0, **more: Any) -> dict[str, Any]:
        """A task as Tripo tells of it."""
        output = {"model_url": f"{self.url}/models/a.glb"} if status == "success" else {}
        return {"task_id": TASK, "status": status, "progress": progress, "output": output, **more}


@contextmanager
def contract_server() -> Iterator[ContractServer]:
    """A server on a free port of loopback."""
    behaviour = Behaviour()
    handler = type("Handler", (_Handler,), {"behaviour": behaviour})
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    url = f"http://127.0.0.1:{server.server_port}"
    handler.url = url  # type: ignore[attr-defined]
    # Threads are joined at the end, so that none outlives its test.
    server.daemon_threads = False
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    try:
        yield ContractServer(url, behaviour)
    finally:
        behaviour.released.set()
        server.shutdown()
        server.server_close()
        thread.join()
