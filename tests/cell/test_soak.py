"""Long proofs of the whole cell, for `make soak`."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest

from cellctl.assembly import StepKind
from cellctl.errors import PlanError
from cellctl.messages import CountCommand
from cellctl.sim.world_values import Imperfections, Where
from cellctl.validating.plan import plan_cells
from tests.cell.faulty import reset_and_resume
from tests.cell.harness import RunningCell, running_cell
from tests.cell.test_prompts import spoken
from tests.validating.solids import random_solid

pytestmark = [pytest.mark.wire, pytest.mark.soak]

PROMPTS = (
    "I want a simple stool",
    "a shelf with two tiers",
    "the letter T",
    "assemble me a table with one leg",
)
CB3 = {
    "robot": {"model": "ur10", "rtde_frequency_hz": 125},
    "emulation": {"controller_version": "3.15"},
}


@pytest.mark.parametrize("sections", [{}, CB3], ids=["ur10e", "ur10"])
def test_the_four_prompts_at_real_speed(
    sections: dict[str, dict[str, object]], tmp_path: Path
) -> None:
    with running_cell(speed=1.0, patience_s=900.0, **sections) as cell:
        for prompt in PROMPTS:
            cell.begin_test()
            cell.visitor.hear(*spoken(prompt, tmp_path))
            job = cell.finish()
            assert job.outcome == "built", prompt
            cell.assert_as_planned()
            seconds = [part.seconds for part in cell.client.snapshot().parts]
            last_s = max(seen.cell_time_s for seen in cell.seen if seen.topic == "part")
            assert job.end_of_speech_s is not None
            print(  # noqa: T201
                f"{prompt}: {len(seconds)} parts, {sum(seconds) / len(seconds):.2f} s a part, "
                f"{last_s - job.end_of_speech_s:.0f} s from the end of speech to the last part"
            )
            cell.clear_workspace()


@pytest.mark.timeout(3600)
def test_twenty_random_solids_through_the_whole_cell() -> None:
    with running_cell(speed=10.0, patience_s=600.0) as cell:
        built, told_s, took_s = 0, 0.0, 0.0
        for seed in itertools.count():
            if built == 20:
                break
            cells = random_solid(seed)
            try:
                plan_cells(cells, cell.config)
            except PlanError:
                continue
            cell.begin_test()
            rows = json.dumps({"cells": sorted(cells), "pitch_m": cell.config.voxel.pitch_m})
            cell.client.build("solid.json", rows.encode())
            assert cell.finish().outcome == "built", seed
            cell.assert_as_planned()
            parts = cell.client.snapshot().parts
            told_s += sum(part.predicted_s or 0.0 for part in parts)
            took_s += sum(part.seconds - part.waited_s for part in parts)
            built += 1
            cell.clear_workspace()
    print(f"20 solids: told {told_s:.0f} s, took {took_s:.0f} s")  # noqa: T201


@pytest.mark.parametrize("seed", range(8))
def test_imperfect_cells_build_what_was_planned(seed: int) -> None:
    rough = Imperfections(belt_slip=0.2, pitch_drift_m=0.02, missing_share=0.2, sticky_share=0.3)
    with running_cell(emulation={"seed": seed + 1}) as cell:
        for wish in ("a chair", "the letter H"):
            cell.begin_test()
            cell.world.set_imperfections(rough, relay=True)
            there = cell.truth().counts  # who lays parts with gaps between them counts them
            count = CountCommand(stock=there[Where.STOCK], belt=there[Where.BELT])
            cell.client.request(count)
            cell.visitor.say(wish)
            look_after(cell)
            assert cell.finish().outcome == "built"
            cell.assert_as_planned()
            cell.clear_workspace()


def look_after(cell: RunningCell) -> None:
    """Until the job ends: a wide gap is taken for a jam, and somebody looks and goes on."""
    while True:
        now = cell.wait(
            "the end, or a jam",
            lambda now: (
                now.fault.entry is not None or (now.job is not None and bool(now.job.outcome))
            ),
        )
        if now.fault.entry is None:
            return
        assert now.fault.entry.code == "belt_jam"
        reset_and_resume(cell)


@pytest.mark.timeout(2400)
def test_one_object_becomes_the_next_from_the_same_parts() -> None:
    """Stool, shelf, letter, table and dog in a row, and apart again; nobody touches a part."""
    wishes = ("a stool", "a shelf with two tiers", "the letter T", "a table with one leg", "a dog")
    with running_cell(speed=10.0, patience_s=900.0) as cell:
        for wish in wishes:
            cell.begin_test()
            cell.visitor.say(wish)
            assert cell.finish().outcome == "built", wish
            cell.assert_as_planned()
            tell_steps(wish, cell)
        cell.begin_test()
        cell.visitor.command("take_apart")
        assert cell.finish().outcome == "taken_apart"
        cell.assert_as_planned()
        tell_steps("apart", cell)
        assert cell.client.snapshot().inventory["belt"] == cell.config.limits.inventory_parts


def tell_steps(wish: str, cell: RunningCell) -> None:
    """Print how many steps it took, and how long they took."""
    snapshot = cell.client.snapshot()
    assert snapshot.plan is not None
    taken = [part.seconds for part in snapshot.parts if part.kind is StepKind.REMOVE]
    placed = [part.seconds for part in snapshot.parts if part.kind is StepKind.PLACE]
    predicted_s = sum(step.duration_s or 0.0 for step in snapshot.plan.steps)
    print(  # noqa: T201
        f"{wish}: {len(taken)} parts taken off in {sum(taken):.0f} s, {len(placed)} placed in "
        f"{sum(placed):.0f} s; {predicted_s:.0f} s predicted"
    )
