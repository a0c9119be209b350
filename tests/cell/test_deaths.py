"""A daemon that is killed at any instant loses no part, doubles none, and the next one goes on."""

from __future__ import annotations

import random
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cell.lives import Lives, many_lives

pytestmark = [pytest.mark.wire]

_BOUNDARIES = 8
_INSTANTS = 3
_FARTHEST = 8
"""Each life ends at most so many writes of the journal after it began."""
_FARTHEST_IN_SOAK = 24
_LONGEST_S = 1.5


@pytest.fixture
def lives() -> Iterator[Lives]:
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name, many_lives(Path(name)) as lives:
        yield lives


def tell(lives: Lives) -> None:
    """Print the figures."""
    times = sorted(lives.settled_s)
    p99_s = times[int(0.99 * (len(times) - 1))]
    print(  # noqa: T201
        f"{lives.built} objects built, found {dict(lives.found)}; "
        f"from start to rest median {statistics.median(times):.2f} s, p99 {p99_s:.2f} s"
    )


def complete(lives: Lives) -> None:
    """A daemon that nobody kills completes what the others began."""
    with lives.life() as life:
        assert life.settle() is not None
        began = lives.built
        while lives.built == began:
            life.go_on(until_s=time.monotonic() + 1.0)


@pytest.mark.timeout(400)
def test_killed_at_the_journals_writes(lives: Lives) -> None:
    """Just before and just after a write: the act is known and not done, or done and not known."""
    for number in range(_BOUNDARIES):
        when, write = ("before", "after")[number % 2], 1 + number // 2 % _FARTHEST
        with lives.life(when, str(write)) as life:
            if life.settle() is not None:
                life.go_on()
            assert life.dead
    complete(lives)
    tell(lives)
    assert lives.built >= 1


@pytest.mark.timeout(400)
def test_killed_at_any_instant(lives: Lives) -> None:
    instants = random.Random(3)  # noqa: S311 - which instants is of no consequence
    for _ in range(_INSTANTS):
        with lives.life() as life:
            if life.settle() is not None:
                life.go_on(until_s=time.monotonic() + instants.uniform(0.0, _LONGEST_S))
    complete(lives)
    tell(lives)


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_killed_at_100_writes_while_taking_apart() -> None:
    with (
        tempfile.TemporaryDirectory(prefix="cellctl-") as name,
        many_lives(Path(name), takes_apart=True) as lives,
    ):
        for number in range(100):
            when, write = ("before", "after")[number % 2], 1 + number // 2 % _FARTHEST
            with lives.life(when, str(write)) as life:
                if life.settle() is not None:
                    life.go_on()
                assert life.dead
        complete(lives)
        tell(lives)


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_killed_at_400_writes_of_many_builds(lives: Lives) -> None:
    """Lives end just before and just after their 1st write, their 2nd, and so on to the 24th: a
    build has some hundred, so that the deaths of one build lie elsewhere than those of the next."""
    for number in range(400):
        when, write = ("before", "after")[number % 2], 1 + number // 2 % _FARTHEST_IN_SOAK
        with lives.life(when, str(write)) as life:
            if life.settle() is not None:
                life.go_on()
            assert life.dead
    complete(lives)
    tell(lives)
    assert lives.built >= 10
