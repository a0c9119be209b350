from __future__ import annotations

import hashlib
import io
import threading
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from cellctl.config import HearingSection
from cellctl.errors import HearingError
from cellctl.listening.download import PinnedArchive, fetch
from cellctl.listening.models import find_model

FOLDER = "vosk-model-small-en-us-0.15"


def model_zip() -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name in ("am/final.mdl", "conf/model.conf", "graph/HCLG.fst"):
            archive.writestr(f"{FOLDER}/{name}", "model")
    return buffer.getvalue()


@contextmanager
def served(body: bytes, *, stall: bool = False) -> Iterator[str]:
    """A web server on the loopback that answers everything with ``body``; yields its address.

    With ``stall`` it sends half, and nothing more until the test is over.
    """
    over = threading.Event()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            if stall:
                self.wfile.write(body[: len(body) // 2])
                self.wfile.flush()
                over.wait(30.0)
            else:
                self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = False
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/model.zip"
    finally:
        over.set()
        server.shutdown()
        server.server_close()
        thread.join()


def pinned(url: str, body: bytes) -> PinnedArchive:
    return PinnedArchive(url, len(body), hashlib.sha256(body).hexdigest(), FOLDER)


def test_an_allowed_download_is_checked_unpacked_and_found_again(no_models: Path) -> None:
    body = model_zip()
    settings = HearingSection(model_folder=str(no_models), allow_download=True)
    with served(body) as url:
        archive = pinned(url, body)
        found = find_model(settings, archive)
    assert found.folder == no_models / FOLDER
    assert (found.folder / "am/final.mdl").read_text() == "model"
    assert [entry.name for entry in no_models.iterdir()] == [FOLDER], "nothing temporary is left"
    assert find_model(settings, archive).folder == found.folder, "the server is gone by now"


def test_nothing_is_downloaded_unless_allowed(no_models: Path) -> None:
    body = model_zip()
    with served(body) as url:
        found = find_model(HearingSection(model_folder=str(no_models)), pinned(url, body))
    assert found.engine == "whisper"
    assert list(no_models.iterdir()) == []


@pytest.mark.parametrize("change", ["content", "shorter", "longer"])
def test_another_archive_than_the_pinned_one_is_not_used(no_models: Path, change: str) -> None:
    body = model_zip()
    wrong = {"content": body[:-1] + b"?", "shorter": body[:-1], "longer": body + b"?"}[change]
    with served(wrong) as url, pytest.raises(HearingError, match="size or sha256 differ"):
        fetch(pinned(url, body), no_models)
    assert list(no_models.iterdir()) == []


def test_a_failed_download_falls_back_to_the_packaged_model(no_models: Path) -> None:
    body = model_zip()
    with served(body) as url:
        gone = pinned(url, body)
    found = find_model(HearingSection(model_folder=str(no_models), allow_download=True), gone)
    assert found.engine == "whisper"


def test_a_server_that_stalls_does_not_hold_the_cell(
    no_models: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cellctl.listening.download._STALL_TIMEOUT_S", 0.2)
    body = model_zip()
    with served(body, stall=True) as url, pytest.raises(HearingError, match="download failed"):
        fetch(pinned(url, body), no_models)
    assert list(no_models.iterdir()) == []
