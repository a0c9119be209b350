"""A second process that takes a share: the same outcome, and no process left behind."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import time

import pytest

from cellctl.beside import Beside, Task, share, stand_by

_PATIENCE_S = 60.0
_MUCH = 100_000


def work(number: int) -> tuple[int, int]:
    """The number, and the process that had it, after some milliseconds."""
    assert sum(range(_MUCH)) > 0
    return number, os.getpid()


def end(pid: int) -> tuple[None, int]:
    """Kill a process, which may be the one that does this."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
    return None, os.getpid()


WORK = [Task(work, (number,)) for number in range(20)]


def begun() -> int:
    """Wait until a second process takes its share, and tell which one."""
    until_s = time.monotonic() + _PATIENCE_S
    while time.monotonic() < until_s:
        stand_by("math")
        others: set[int] = {pid for _, pid in share(WORK)} - {os.getpid()}
        if others:
            return others.pop()
    raise AssertionError("no second process took a share")


def gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def test_two_processes_share_and_nothing_is_done_twice_or_left_out() -> None:
    with Beside():
        other = begun()
        assert [number for number, _ in share(WORK)] == list(range(20))
    assert gone(other)


def test_large_tasks_and_outcomes_pass_each_other() -> None:
    much = bytes(1_000_000)
    with Beside():
        begun()
        assert share([Task(bytes, (much,))] * 12) == [much] * 12


def test_without_a_second_process_all_is_done_here() -> None:
    stand_by("math")
    assert share(WORK) == [(number, os.getpid()) for number in range(20)]
    with Beside():
        assert share(WORK) == [(number, os.getpid()) for number in range(20)]  # none was started


def test_the_first_failure_in_order_is_raised_whoever_met_it() -> None:
    failing = [*WORK[:6], Task(math.sqrt, (-1.0,)), *WORK[:6], Task(int, ("one",)), *WORK]
    with Beside():
        begun()
        for _ in range(5):
            with pytest.raises(ValueError, match="math domain error"):
                share(failing)
            assert [number for number, _ in share(WORK)] == list(range(20))


def test_a_second_process_that_dies_leaves_its_share_to_the_first() -> None:
    with Beside():
        other = begun()
        values = share([*WORK[:10], Task(end, (other,)), *WORK[10:]])
        assert [number for number, _ in values] == [*range(10), None, *range(10, 20)]
        assert begun() != other
