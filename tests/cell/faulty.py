"""What every test of a fault does: see it told, see nothing move, and leave it by its way."""

from __future__ import annotations

import re

import pytest

from cellctl.control.plainly import BY_FAULT
from cellctl.errors import CATALOGUE, RefusedError
from cellctl.wording import load_wording
from tests.cell.harness import RunningCell, bar


def begin(cell: RunningCell, nx: int = 1, ny: int = 1, nz: int = 2) -> None:
    """Have a box of so many parts built."""
    cell.client.build("bar.json", bar(nx, ny, nz))


def expect_fault(cell: RunningCell, code: str) -> None:
    """The cell is in a fault of that code, says so, and nothing moves."""
    snapshot = cell.wait("a fault", lambda now: now.fault.entry is not None)
    assert snapshot.fault.entry is not None
    assert snapshot.fault.entry.code == code, snapshot.fault
    entry = CATALOGUE[code]
    snapshot = cell.wait_state(entry.leads_to)
    assert entry.title in snapshot.state.sentence
    assert entry.remedy in snapshot.state.sentence
    for command in ("resume", "pause", "cancel"):
        with pytest.raises(RefusedError):
            cell.client.command(command)
    with pytest.raises(RefusedError, match="operator"):
        cell.visitor.command("reset")
    plain = load_wording("en").text(BY_FAULT[code])
    assert snapshot.dialogue.waits is not None
    assert snapshot.dialogue.waits.text == plain
    with pytest.raises(RefusedError, match=re.escape(plain)):
        cell.visitor.command("cancel")
    still = cell.wait("rest", lambda now: not now.arm.moving)
    assert still.arm.joints_rad == pytest.approx(cell.client.snapshot().arm.joints_rad, abs=1e-4)


def reset(cell: RunningCell) -> None:
    """An operator has seen to the cause."""
    cell.client.command("reset")
    snapshot = cell.wait_state("paused_resting")
    assert snapshot.fault.entry is None


def reset_and_resume(cell: RunningCell) -> None:
    """And goes on."""
    reset(cell)
    cell.client.command("resume")


def finish_as_planned(cell: RunningCell, taken: int = 0) -> None:
    """The job that the fault cut off ends well."""
    assert cell.finish().outcome == "built"
    cell.assert_as_planned(taken)
