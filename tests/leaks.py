"""A pytest plugin: a test that leaves something of its own behind fails.

Looked at, before and after every test and every module: threads, asyncio tasks, child processes
(orphans included), open descriptors (sockets, pipes, pseudo-terminals, files), files in the
repository and in the folder for temporary files, which is a private one while the tests run.

What ends by itself within ``GRACE_S`` is not left behind. What is allowed stands here with its
reason and nowhere else.
"""

from __future__ import annotations

import asyncio
import gc
import os
import shutil
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import psutil
import pytest

GRACE_S = 3.0
REPOSITORY = Path(__file__).resolve().parent.parent
MARK = "CELLCTL_TEST_RUN"
"""Environment variable that processes started by a test inherit, and orphans are known by."""

UNWATCHED_FOLDERS = {
    ".git": "not the tests' business",
    ".venv": "the environment",
    "__pycache__": "Python's compiled modules",
    "build": "the boards' compiled programs, which tests that run them bring up to date",
    ".mypy_cache": "mypy's",
    ".ruff_cache": "ruff's",
    ".pytest_cache": "pytest's",
    ".import_linter_cache": "import-linter's",
    ".hypothesis": "Hypothesis keeps the examples that failed",
}
UNWATCHED_SUFFIXES = (".md", ".py", ".toml")
"""Files that people edit while tests run, which no test writes."""
ALLOWED_TEMPORARY = {
    "pymp-": "multiprocessing removes its folder when the interpreter ends",
    "pulse-": "the sound library that espeak-ng loads keeps its folder where a home has none",
    "pytest-": "pytest's own folders; it keeps the last three runs",
}
ALLOWED_PROCESSES = {
    "multiprocessing.resource_tracker": "one for the interpreter's whole life",
    "multiprocessing.forkserver": "one for the interpreter's whole life",
}
ALLOWED_DESCRIPTORS = {
    "/dev/null": "opened once by subprocess and others",
    "/dev/urandom": "opened once by the interpreter",
    str(Path(sys.prefix).resolve()): "data and code of libraries, opened once",
    str(Path(sys.base_prefix).resolve() / "lib"): "the interpreter's own library",
}
ZMQ_THREAD = "ZMQbg"
"""Names of libzmq's threads, which live as long as their context; threading cannot see them."""


@dataclass(frozen=True)
class Snapshot:
    """What this process holds at one moment, each thing by a name for people."""

    threads: Counter[str]
    processes: Counter[str]
    descriptors: Counter[str]
    files: Counter[str]

    @classmethod
    def take(cls, *, orphans: bool) -> Snapshot:
        """Look at everything; ``orphans`` are looked for among all processes, which costs more."""
        processes = _children()
        if orphans:
            processes |= _orphans()
        return cls(_threads(), processes, _descriptors(), _files())

    def left_behind(self, before: Snapshot) -> list[str]:
        """What is here and was not there before."""
        return [
            f"{kind}: {name}"
            for kind, now, then in (
                ("thread", self.threads, before.threads),
                ("process", self.processes, before.processes),
                ("open", self.descriptors, before.descriptors),
                ("file", self.files, before.files),
            )
            for name in (now - then).elements()
        ]


def _threads() -> Counter[str]:
    found = Counter(f"{thread.name} ({thread.ident})" for thread in threading.enumerate())
    for task in Path("/proc/self/task").iterdir():
        try:
            name = (task / "comm").read_text().strip()
        except OSError:  # it ended while we looked
            continue
        if name.startswith(ZMQ_THREAD):
            found[f"{name} ({task.name}): a ZeroMQ context that was not terminated"] += 1
    return found


def _describe(process: psutil.Process) -> str | None:
    try:
        command = " ".join(process.cmdline())
    except psutil.NoSuchProcess:
        return None
    if any(allowed in command for allowed in ALLOWED_PROCESSES):
        return None
    return f"{process.pid} {command[:160] or process.name()}"


def _children() -> Counter[str]:
    if not Path(f"/proc/self/task/{os.getpid()}/children").exists():  # a kernel without them
        processes = psutil.Process().children(recursive=True)
    else:
        processes = [process for pid in _offspring(os.getpid()) if (process := _process(pid))]
    described = (_describe(process) for process in processes)
    return Counter(name for name in described if name)


def _offspring(pid: int) -> Iterator[int]:
    """Whoever descends from a process; to ask the kernel costs less than to look at every other."""
    try:
        tasks = list(Path(f"/proc/{pid}/task").iterdir())
    except OSError:  # it ended meanwhile
        return
    for task in tasks:
        try:
            children = (task / "children").read_text()
        except OSError:  # it ended meanwhile
            continue
        for child in map(int, children.split()):
            yield child
            yield from _offspring(child)


def _process(pid: int) -> psutil.Process | None:
    try:
        return psutil.Process(pid)
    except psutil.NoSuchProcess:
        return None


def _orphans() -> Counter[str]:
    mark = f"{MARK}={os.getpid()}".encode()
    found: Counter[str] = Counter()
    for folder in Path("/proc").glob("[0-9]*"):
        if int(folder.name) == os.getpid():
            continue
        try:
            variables = (folder / "environ").read_bytes().split(b"\0")
        except OSError:  # it ended, or it is somebody else's
            continue
        if mark in variables and (name := _describe(psutil.Process(int(folder.name)))):
            found[name] = 1
    return found


def _descriptors() -> Counter[str]:
    found: Counter[str] = Counter()
    tracker = _resource_tracker_descriptor()
    for entry in os.scandir("/proc/self/fd"):
        try:
            target = str(Path(entry.path).readlink())
        except OSError:  # the descriptor of this very listing
            continue
        if entry.name != tracker and not target.startswith(tuple(ALLOWED_DESCRIPTORS)):
            found[target] += 1
    return found


def _resource_tracker_descriptor() -> str:
    """The pipe that keeps multiprocessing's resource tracker alive."""
    module = sys.modules.get("multiprocessing.resource_tracker")
    return str(module._resource_tracker._fd) if module else ""


@dataclass(frozen=True)
class _Folder:
    """What lay in a folder when it was last changed."""

    changed_ns: int
    folders: tuple[str, ...]
    files: tuple[str, ...]

    @classmethod
    def look(cls, path: str, changed_ns: int) -> _Folder:
        entries = list(os.scandir(path))
        return cls(
            changed_ns,
            tuple(
                entry.path
                for entry in entries
                if entry.is_dir(follow_symlinks=False)
                and entry.name not in UNWATCHED_FOLDERS
                and not entry.name.endswith(".egg-info")
            ),
            tuple(
                entry.path
                for entry in entries
                if not entry.is_dir(follow_symlinks=False)
                and not entry.name.endswith(UNWATCHED_SUFFIXES)
            ),
        )


_folders: dict[str, _Folder] = {}
_CLOCK_TICK_NS = 20_000_000
"""Two changes within so little time may leave a folder with the same time of its last change."""


def _in_repository(path: str) -> Iterator[str]:
    """Every watched file below a folder; only folders that were changed are listed anew."""
    try:
        changed_ns = Path(path).stat().st_mtime_ns
        known = _folders.get(path)
        if known is None or known.changed_ns != changed_ns:
            known = _Folder.look(path, changed_ns)
            if time.time_ns() - changed_ns > _CLOCK_TICK_NS:
                _folders[path] = known
    except FileNotFoundError:  # another lane's, and gone again
        return
    yield from known.files
    for folder in known.folders:
        yield from _in_repository(folder)


def _files() -> Counter[str]:
    found = Counter(_in_repository(str(REPOSITORY)))
    found.update(
        entry.path
        for entry in os.scandir(tempfile.gettempdir())
        if not entry.name.startswith(tuple(ALLOWED_TEMPORARY))
    )
    return found


def _check(before: Snapshot, what: str, *, orphans: bool) -> None:
    deadline = time.monotonic() + GRACE_S
    pause = threading.Event()
    while left := Snapshot.take(orphans=orphans).left_behind(before):
        gc.collect()  # unclosed things that only wait for the collector warn, and so fail, too
        if time.monotonic() > deadline:
            pytest.fail(f"{what} left behind:\n  " + "\n  ".join(left), pytrace=False)
        pause.wait(0.02)


@pytest.fixture(scope="module", autouse=True)
def module_leaves_nothing() -> Iterator[None]:
    """Fail the last test of a module whose own fixtures left something behind."""
    before = Snapshot.take(orphans=True)
    yield
    _check(before, "this module", orphans=True)


@pytest.fixture(autouse=True)
def test_leaves_nothing(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test that left something behind.

    A test marked ``shared_cell`` works on processes that live as long as its module and replace
    each other meanwhile; what they leave is looked for at the end of the module.
    """
    if request.node.get_closest_marker("shared_cell") is not None:
        yield
        return
    unfinished: list[str] = []
    cancel_all_tasks = asyncio.runners._cancel_all_tasks  # type: ignore[attr-defined]

    def remember_and_cancel(loop: asyncio.AbstractEventLoop) -> None:
        unfinished.extend(repr(task) for task in asyncio.all_tasks(loop))
        cancel_all_tasks(loop)

    before = Snapshot.take(orphans=False)
    with pytest.MonkeyPatch.context() as patch:
        # asyncio.run cancels what is still running without a word: here it is told on.
        patch.setattr(asyncio.runners, "_cancel_all_tasks", remember_and_cancel)
        yield
    _check(before, "this test", orphans=False)
    if unfinished:
        pytest.fail("this test left tasks behind:\n  " + "\n  ".join(unfinished), pytrace=False)


_previous_folder: pytest.StashKey[str] = pytest.StashKey()


def pytest_configure(config: pytest.Config) -> None:
    """Give the tests a folder of their own for temporary files, and mark their processes."""
    system_folder = tempfile.gettempdir()
    config.stash[_previous_folder] = system_folder
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", system_folder)  # tmp_path outlives the run
    tempfile.tempdir = os.environ["TMPDIR"] = tempfile.mkdtemp(prefix="cellctl-tests-")
    os.environ[MARK] = str(os.getpid())


def pytest_unconfigure(config: pytest.Config) -> None:
    """Remove that folder."""
    shutil.rmtree(tempfile.gettempdir(), ignore_errors=True)
    tempfile.tempdir = os.environ["TMPDIR"] = config.stash[_previous_folder]
