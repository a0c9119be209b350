"""The watch over what tests leave behind sees it, and lets clean tests pass."""

from __future__ import annotations

import os

import pytest

from tests.leaks import REPOSITORY

# It loses a file in the repository, which the watch over other tests that run beside would see.
pytestmark = pytest.mark.wire

LEAKING = """
import asyncio
import os
import socket
import subprocess
import sys
import tempfile
import threading

import pytest
import zmq

kept = []
forever = threading.Event()


def test_thread():
    kept.append(threading.Thread(target=forever.wait, name="lost-thread", daemon=True))
    kept[-1].start()


def test_task():
    async def main():
        kept.append(asyncio.create_task(asyncio.Event().wait(), name="lost-task"))

    asyncio.run(main())


def test_child():
    kept.append(subprocess.Popen([sys.executable, "-c", "input()  # lost-child"],
                                 stdin=subprocess.PIPE))


def test_socket():
    kept.append(socket.socket())


def test_pseudo_terminal():
    kept.append(os.openpty())


def test_zmq_context():
    kept.append(zmq.Context())
    kept[-1].socket(zmq.PUB).close()


def test_temporary_file():
    kept.append(tempfile.mkdtemp(prefix="lost-folder"))


def test_file_in_the_repository():
    with open(LOST_FILE, "w"):
        kept.append(LOST_FILE)


def test_clean(tmp_path):
    thread = threading.Thread(target=lambda: None)
    thread.start()
    thread.join()
    subprocess.run([sys.executable, "-c", ""], check=True)
    (tmp_path / "file").write_text("x")

    async def main():
        await asyncio.create_task(asyncio.to_thread(len, "x"))

    asyncio.run(main())
    with socket.create_server(("127.0.0.1", 0)), tempfile.TemporaryDirectory():
        pass


@pytest.fixture(scope="module", autouse=True)
def tidy():
    yield
    forever.set()
    for thing in kept:
        if isinstance(thing, subprocess.Popen):
            thing.communicate(b"")
        elif isinstance(thing, zmq.Context):
            thing.term()
        elif isinstance(thing, socket.socket):
            thing.close()
        elif isinstance(thing, tuple):
            os.close(thing[0])
            os.close(thing[1])
        elif isinstance(thing, str):
            os.rmdir(thing) if os.path.isdir(thing) else os.remove(thing)
"""

ORPHAN = """
import os
import subprocess
import sys


def test_orphan(tmp_path):
    path = tmp_path / "wait"
    os.mkfifo(path)
    starter = "import subprocess, sys; subprocess.Popen(['cat', sys.argv[1]])"
    subprocess.run([sys.executable, "-c", starter, path], check=True)
    print("FIFO", path)
"""


def run(pytester: pytest.Pytester, source: str) -> pytest.RunResult:
    """Run the source as a test module of its own, in a process of its own, under the watch."""
    pytester.makepyfile(source)
    pytester.makeconftest("import tests.leaks\n\ntests.leaks.GRACE_S = 0.3")
    return pytester.runpytest_subprocess("-p", "tests.leaks", "-p", "no:cacheprovider", timeout=100)


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(REPOSITORY))


def test_each_kind_of_leak_fails_its_own_test(pytester: pytest.Pytester) -> None:
    lost_file = REPOSITORY / f"lost-file-{os.getpid()}"
    result = run(pytester, LEAKING.replace("LOST_FILE", repr(str(lost_file))))
    assert not lost_file.exists()
    result.assert_outcomes(passed=9, errors=8)
    output = result.stdout.str()
    for culprit, left in {
        "test_thread": "lost-thread",
        "test_task": "lost-task",
        "test_child": "lost-child",
        "test_socket": "open: socket:",
        "test_pseudo_terminal": "open: /dev/",
        "test_zmq_context": "ZeroMQ context",
        "test_temporary_file": "lost-folder",
        "test_file_in_the_repository": lost_file.name,
    }.items():
        report = output.partition(f"ERROR at teardown of {culprit} ")[2].partition("___ ERROR")[0]
        assert left in report, f"{culprit} was not told about {left}:\n{report}"


def test_an_orphaned_process_fails_the_module(pytester: pytest.Pytester) -> None:
    result = run(pytester, ORPHAN)
    fifo = next(line.split()[1] for line in result.outlines if line.startswith("FIFO"))
    with open(fifo, "w"):  # noqa: PTH123 - opening and closing the pipe ends the orphan
        pass
    result.assert_outcomes(passed=1, errors=1)
    assert "this module left behind" in result.stdout.str()
