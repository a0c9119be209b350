"""The locked environment: complete, hashed, without host names, and what the project asks for."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import version

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.leaks import REPOSITORY

LOCKS = ("requirements-build.lock", "requirements.lock")
PROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))


def entries(name: str) -> list[tuple[Requirement, list[str]]]:
    """The locked requirements of a file, each with its hashes."""
    text = (REPOSITORY / name).read_text(encoding="utf-8").replace("\\\n", " ")
    found = []
    for line in text.splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            requirement, *hashes = re.split(r"\s+--hash=", line.strip())
            found.append((Requirement(requirement), hashes))
    return found


def asked_for() -> list[Requirement]:
    """What pyproject.toml asks for, itself through its own extras left out."""
    project = PROJECT["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    groups.append(PROJECT["build-system"]["requires"])
    wishes = [Requirement(line) for group in groups for line in group]
    return [wish for wish in wishes if wish.name != project["name"]]


@pytest.mark.parametrize("name", LOCKS)
def test_every_entry_is_one_version_with_hashes(name: str) -> None:
    for requirement, hashes in entries(name):
        assert re.fullmatch(r"==[^*,]+", str(requirement.specifier)), requirement
        assert requirement.url is None
        assert hashes, requirement
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", digest) for digest in hashes)


@pytest.mark.parametrize("name", LOCKS)
def test_a_lock_names_no_host(name: str) -> None:
    text = (REPOSITORY / name).read_text(encoding="utf-8")
    assert "://" not in text
    assert not re.search(r"^\s*--(?!hash)", text, flags=re.MULTILINE)


def test_the_lock_holds_everything_that_the_project_asks_for() -> None:
    locked: dict[str, list[Requirement]] = {}
    for name in LOCKS:
        for requirement, _ in entries(name):
            locked.setdefault(canonicalize_name(requirement.name), []).append(requirement)
    for wish in asked_for():
        found = locked.get(canonicalize_name(wish.name))
        assert found, f"{wish} is not locked: run `make lock`"
        for requirement in found:
            pin = str(requirement.specifier).removeprefix("==")
            assert wish.specifier.contains(pin, prereleases=True), f"{wish}: locked {requirement}"


def test_what_is_installed_is_what_is_locked() -> None:
    for name in LOCKS:
        for requirement, _ in entries(name):
            if requirement.marker is None or requirement.marker.evaluate():
                installed = version(requirement.name)
                assert requirement.specifier.contains(installed, prereleases=True), requirement
