"""Long proofs of the whole cell, for `make soak`."""

from __future__ import annotations

from pathlib import Path

import pytest

from cellctl.assembly import StepKind
from cellctl.sim.world_values import Imperfections
from tests.cell.harness import RunningCell, running_cell
from tests.cell.test_prompts import spoken

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
            assert cell.finish().outcome == "built", prompt
            cell.assert_as_planned()
            seconds = [part.seconds for part in cell.client.snapshot().parts]
            print(f"{prompt}: {len(seconds)} parts, {sum(seconds) / len(seconds):.2f} s a part")  # noqa: T201
            cell.clear_workspace()


@pytest.mark.parametrize("seed", range(8))
def test_imperfect_cells_build_what_was_planned(seed: int) -> None:
    rough = Imperfections(belt_slip=0.2, pitch_drift_m=0.02, missing_share=0.2, sticky_share=0.3)
    with running_cell(emulation={"seed": seed + 1}) as cell:
        for wish in ("a chair", "the letter H"):
            cell.begin_test()
            cell.world.set_imperfections(rough, relay=True)
            cell.visitor.say(wish)
            assert cell.finish().outcome == "built"
            cell.assert_as_planned()
            cell.clear_workspace()


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
        f"{sum(placed):.0f} s; {predicted_s:.0f} s predicted without the latch"
    )
