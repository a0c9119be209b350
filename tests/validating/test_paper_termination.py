"""The paper's policy ends on whatever it is given, within its limits or with a refusal."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cellctl.config import LimitsSection
from cellctl.errors import PlanError
from cellctl.generating.boxes import Box
from cellctl.validating.fit import Shape
from cellctl.validating.paper.policy import plan_paper, process
from cellctl.validating.paper.sequencing import connectivity_order
from cellctl.validating.paper.steadying import longest_overhang
from cellctl.validating.rules import unsupported_stacks
from tests.validating.shapes import shape

GRID = (6, 5, 6)
SEED = 20251120
_PLANNED_EACH = 5
"""So many solids are processed for each that is planned from the beginning."""


def random_solid(random: np.random.Generator) -> Shape:
    """One to six boxes anywhere in the workspace, some of them thin as paper, some off the grid."""
    boxes = []
    for _ in range(random.integers(1, 7)):
        low = [random.uniform(0, room - 0.05) for room in GRID]
        size = [random.uniform(0.01, room - at) for room, at in zip(GRID, low, strict=True)]
        if random.random() < 0.4:
            size[random.integers(3)] = 0.01
        if random.random() < 0.4:
            low = [float(math.floor(at)) for at in low]
            size = [max(0.05, float(round(edge))) for edge in size]
        boxes.append((*low, *size))
    corner = np.min(np.array(boxes)[:, :3], axis=0)
    return shape(
        *(Box(x - corner[0], y - corner[1], z - corner[2], *size) for x, y, z, *size in boxes)
    )


def prove(count: int, seed: int) -> dict[str, int]:
    """Process so many random solids and look at each; how many could be built, how many not."""
    random = np.random.default_rng(seed)
    outcomes = {"planned": 0, "refused": 0, "rescaled": 0}
    for number in range(count):
        solid = random_solid(random)
        limits = LimitsSection(
            inventory_parts=40,
            overhang_cells=int(random.integers(0, 5)),
            stack_cells=int(random.integers(1, 6)),
        )
        parts = int(random.integers(1, 60))
        found = process(solid, limits, parts)
        assert 1 <= len(found.cells) <= parts
        assert longest_overhang(found.cells) <= limits.overhang_cells
        assert unsupported_stacks(found.cells, limits.stack_cells)[0] <= limits.stack_cells
        before, after = solid.extent, found.shape.extent
        assert np.all(after <= before + 1e-9)
        assert np.all(after >= np.minimum(before, 1.0) - 1e-9)
        assert np.all(after > 0.0)
        outcomes["rescaled"] += bool(found.changes)

        order = connectivity_order(found.cells)
        assert len(order.cells) == len(found.cells)
        assert frozenset(order.cells) == found.cells
        wrong = (*order.mid_air, *order.beneath)
        outcomes["refused" if wrong else "planned"] += 1
        if number % _PLANNED_EACH:
            continue
        if wrong:
            with pytest.raises(PlanError, match=r"put (into the air|beneath).*\[\d, \d, \d\]"):
                plan_paper(solid, limits, parts)
        else:
            plan = plan_paper(solid, limits, parts)
            assert plan.order == order.cells
            assert plan.changes == found.changes
            assert all(check.passed for check in plan.checks)
    return outcomes


def test_it_ends_on_random_solids_within_its_limits_or_with_a_refusal() -> None:
    outcomes = prove(120, SEED)
    assert min(outcomes.values()) > 5  # each way was really taken


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_it_ends_on_many_more() -> None:
    outcomes = prove(20_000, SEED + 1)
    assert outcomes["planned"] + outcomes["refused"] == 20_000
    assert min(outcomes.values()) > 1000
