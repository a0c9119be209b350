"""Whole plans: from a wish or a file to steps that the arm can take."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

from cellctl.assembly import BuildPlan, Cell, Intent, Request, StepKind
from cellctl.beside import Beside, stand_by
from cellctl.config import CellConfig
from cellctl.errors import PlanError, UsageError
from cellctl.generating.boxes import Box
from cellctl.generating.design import design
from cellctl.validating.files import load_mesh, load_plan, read_mesh
from cellctl.validating.plan import (
    plan_build,
    plan_cells,
    plan_changing_over,
    plan_file,
    plan_taking_apart,
)
from tests.validating.shapes import CONFIG as IMPATIENT
from tests.validating.shapes import cells_of, generated, paper

CONFIG = IMPATIENT.model_copy(
    update={"planning": IMPATIENT.planning.model_copy(update={"budget_s": 60.0})}
)
"""What is the best within any time must not depend on how busy the machine is."""
CHECKS = ["count", "connectivity", "grounded", "access", "order", "stability", "reach"]
PAPER = CONFIG.model_copy(
    update={"planning": CONFIG.planning.model_copy(update={"policy": "paper"})}
)

PAPER_CHECKS = ["count", "overhang", "stack", "connectivity", "access", "reach"]


def weakly_held(config: CellConfig) -> CellConfig:
    """The same cell with magnets that do not bear a table on one leg."""
    weak = config.stability.model_copy(update={"magnet_force_n": 8.0})
    return config.model_copy(update={"stability": weak})


def wish(
    noun: str,
    attributes: dict[str, int | str] | None = None,
    height_m: float | None = None,
    config: CellConfig = CONFIG,
) -> BuildPlan:
    request = Request(
        text=noun,
        intent=Intent.DESIGN,
        phrase=noun,
        objects=(noun,),
        attributes={**(attributes or {})},
        dimensions_m={} if height_m is None else {"height": height_m},
    )
    return plan_build(design(request, config), config)


@pytest.mark.parametrize(
    ("config", "noun", "attributes", "parts", "size"),
    [
        (CONFIG, "stool", {}, 30, (5, 4, 5)),
        (CONFIG, "shelf", {"tiers": 2}, 40, (6, 2, 6)),  # full width and height
        (CONFIG, "letter", {"glyph": "T"}, 7, (3, 1, 5)),
        (CONFIG, "table", {"legs": 1}, 23, (4, 4, 6)),
        (PAPER, "stool", {}, 30, (5, 4, 5)),
        (PAPER, "shelf", {"tiers": 2}, 32, (5, 2, 5)),
        (PAPER, "letter", {"glyph": "T"}, 7, (3, 1, 5)),
        (PAPER, "table", {"legs": 1}, 20, (4, 4, 5)),
    ],
)
def test_the_papers_prompts(
    config: CellConfig,
    noun: str,
    attributes: dict[str, int | str],
    parts: int,
    size: tuple[int, int, int],
) -> None:
    plan = wish(noun, attributes, config=config)
    assert plan.parts == parts
    assert plan.assembly.size == size
    assert plan.policy == config.planning.policy
    assert [check.name for check in plan.checks] == (PAPER_CHECKS if config is PAPER else CHECKS)
    assert all(check.passed and not check.cells for check in plan.checks)
    assert [step.index for step in plan.steps] == list(range(parts))
    assert {step.cell for step in plan.steps} == set(plan.assembly.cells)
    assert all(step.kind is StepKind.PLACE for step in plan.steps)
    for step in plan.steps:
        assert step.clearance_m is not None
        assert step.clearance_m >= (step.cell.z + 1) * 0.1
        assert step.duration_s is not None
        assert 1.0 < step.duration_s < 30.0


def test_an_object_stands_where_its_parts_have_the_shortest_way() -> None:
    plan = plan_build(generated(Box(0, 0, 0, 2, 1, 1)), CONFIG)
    assert plan.assembly.cells == (Cell(0, 0, 0), Cell(1, 0, 0))


def test_parts_are_placed_from_far_to_near_where_that_stands_as_well() -> None:
    plan = plan_build(generated(Box(0, 0, 0, 4, 1, 1)), CONFIG)
    assert [step.cell.x for step in plan.steps] == [3, 2, 1, 0]


def test_the_same_object_has_the_same_plan_and_another_has_another() -> None:
    one = plan_build(generated(Box(0, 0, 0, 2, 1, 1)), CONFIG)
    again = plan_build(generated(Box(3, 1, 4, 2, 1, 1)), CONFIG)
    other = plan_build(generated(Box(0, 0, 0, 2, 2, 1)), CONFIG)
    assert one == again
    assert one.plan_id != other.plan_id


def test_two_processes_come_to_the_same_plan_as_one() -> None:
    alone = wish("table", {"legs": 1})
    with Beside():
        stand_by("cellctl.validating.siting")
        assert wish("table", {"legs": 1}) == alone


def test_changes_and_questions_reach_the_plan() -> None:
    plan = wish("stool", height_m=1.0)
    assert len(plan.questions) == 1
    assert "100 cm" in plan.questions[0]
    shelf = wish("shelf")
    assert [(change.what, change.why) for change in shelf.changes] == [
        (
            "It is one part shallower: 6 x 2 x 6 parts (wide, deep, high) instead of 6 x 3 x 6.",
            "It would take 60 parts, and there are 40.",
        ),
    ]
    assert shelf.closeness is not None
    assert shelf.closeness.proven
    assert shelf.closeness.baseline_score is not None
    assert shelf.closeness.score > shelf.closeness.baseline_score


def test_a_plan_names_its_weakest_joint_and_when_it_bears_most() -> None:
    plan = wish("letter", {"glyph": "T"})
    margins = [step.margin for step in plan.steps if step.margin is not None]
    assert plan.weakest is not None
    assert plan.weakest.margin == min(margins) >= CONFIG.stability.least_margin
    assert plan.steps[plan.weakest.step].margin == plan.weakest.margin
    standing = {step.cell for step in plan.steps[: plan.weakest.step + 1]}
    assert plan.weakest.cell in standing
    assert plan.weakest.other in standing | {plan.weakest.cell.below()}


def test_the_papers_policy_asks_before_it_builds_what_its_joints_cannot_bear() -> None:
    (question,) = wish("table", {"legs": 1}, config=weakly_held(PAPER)).questions
    assert "come apart in step" in question
    assert wish("letter", {"glyph": "T"}, config=PAPER).questions == ()


def test_fewer_parts_on_hand_make_a_smaller_object() -> None:
    box = generated(Box(0, 0, 0, 3, 3, 3))
    assert plan_build(box, CONFIG, 27).parts == 27
    assert plan_build(box, CONFIG, 10).parts == 9
    assert plan_build(box, PAPER, 10).parts == 8
    with pytest.raises(PlanError, match="no parts"):
        plan_build(box, CONFIG, 0)


def test_each_stage_is_told_as_it_begins() -> None:
    told: list[str] = []
    plan_build(generated(Box(0, 0, 0, 1, 1, 1)), CONFIG, None, told.append)
    assert told == ["discretising", "checking", "sequencing"]


def test_an_arm_that_cannot_reach_refuses_the_plan() -> None:
    base = CONFIG.base.model_copy(update={"frame": (0.30, -3.0, 0.35, 0.0, 0.0, 0.0)})
    far = CONFIG.model_copy(update={"base": base})
    with pytest.raises(PlanError, match="reach"):
        plan_build(generated(Box(0, 0, 0, 1, 1, 1)), far)


def test_cells_are_planned_as_given_or_refused_with_the_rule() -> None:
    plan = plan_cells(cells_of(Box(0, 0, 0, 2, 2, 2)), CONFIG)
    assert plan.parts == 8
    with pytest.raises(PlanError, match="rule of stability") as refused:
        plan_cells(cells_of(Box(0, 0, 0, 1, 1, 6)), CONFIG)
    assert refused.value.rule == "stability"
    assert Cell(0, 0, 5) in refused.value.cells
    with pytest.raises(PlanError, match="paper's rule of stack"):
        plan_cells(cells_of(Box(0, 0, 0, 1, 1, 5)), PAPER)
    assert plan_cells(cells_of(Box(0, 0, 0, 1, 1, 5)), CONFIG).parts == 5
    with pytest.raises(PlanError, match="workspace has 6 x 5 x 6"):
        plan_cells(cells_of(Box(0, 0, 0, 7, 1, 1)), CONFIG)
    with pytest.raises(PlanError, match="no cells"):
        plan_cells([], CONFIG)


@pytest.mark.parametrize(("name", "rule"), [("stool", "count"), ("letter_t", "stack")])
def test_the_papers_cells_break_the_rules_they_broke(test_data: Path, name: str, rule: str) -> None:
    cells, _ = paper(test_data, name)
    with pytest.raises(PlanError, match=f"rule of {rule}") as refused:
        plan_cells(cells, PAPER)
    assert refused.value.rule == rule


def test_a_plan_survives_its_file(tmp_path: Path) -> None:
    plan = wish("letter", {"glyph": "T"})
    file = tmp_path / "t.json"
    file.write_text(plan.model_dump_json())
    assert load_plan(file) == plan
    assert plan_file("t.json", file.read_bytes(), CONFIG) == plan
    paper = wish("table", {"legs": 1}, config=PAPER)
    assert plan_file("t.json", paper.model_dump_json().encode(), PAPER) == paper
    assert pickle.loads(pickle.dumps(plan)) == plan  # noqa: S301 - our own bytes


def test_a_plan_from_elsewhere_is_not_taken_on_trust() -> None:
    plan = wish("letter", {"glyph": "T"})
    floating = plan.model_copy(update={"steps": plan.steps[::-1]})
    with pytest.raises(PlanError, match="rule of order"):
        plan_file("t.json", floating.model_dump_json().encode(), CONFIG)
    partial = plan.model_copy(update={"steps": plan.steps[:-1]})
    with pytest.raises(PlanError, match="own assembly"):
        plan_file("t.json", partial.model_dump_json().encode(), CONFIG)
    half = plan.model_copy(update={"pitch_m": 0.05})
    with pytest.raises(PlanError, match="parts of 5 cm"):
        plan_file("t.json", half.model_dump_json().encode(), CONFIG)
    away = [s.model_copy(update={"cell": Cell(s.cell.x + 4, *s.cell[1:])}) for s in plan.steps]
    moved = plan.model_copy(
        update={
            "steps": tuple(away),
            "assembly": plan.assembly.of([s.cell for s in away], 0.1),
        }
    )
    with pytest.raises(PlanError, match="outside the workspace"):
        plan_file("t.json", moved.model_dump_json().encode(), CONFIG)


def test_a_plan_is_judged_by_the_policy_of_the_cell_and_not_by_its_own() -> None:
    weak = weakly_held(PAPER)
    paper = wish("table", {"legs": 1}, config=weak)
    forged = paper.model_copy(update={"questions": ()})
    with pytest.raises(PlanError, match="rule of stability"):
        plan_file("t.json", forged.model_dump_json().encode(), weakly_held(CONFIG))
    (question,) = plan_file("t.json", forged.model_dump_json().encode(), weak).questions
    assert "come apart in step" in question


def test_a_refusal_names_the_cells_as_they_were_given() -> None:
    arm = [Cell(1, 2, 0), *(Cell(x, 2, 1) for x in range(1, 6))]
    with pytest.raises(PlanError, match="stability") as refused:
        plan_cells(arm, CONFIG)
    assert refused.value.cells
    assert set(refused.value.cells) <= set(arm)
    with pytest.raises(PlanError, match="paper's rule of overhang"):
        plan_cells(arm, PAPER)


@pytest.mark.parametrize("cells", [[(0, 0, 3)], [(0, 0, 0), (1, 0, 0), (3, 3, 1)]])
def test_what_could_not_stand_is_not_taken_apart(cells: list[tuple[int, int, int]]) -> None:
    content = json.dumps({"cells": cells, "pitch_m": 0.1}).encode()
    with pytest.raises(PlanError, match="said to stand would not") as refused:
        plan_taking_apart("s.json", content, CONFIG)
    assert refused.value.cells
    post = plan_cells([Cell(0, 0, 0)], CONFIG)
    with pytest.raises(PlanError, match="said to stand would not"):
        plan_changing_over(post, frozenset(Cell(*cell) for cell in cells), CONFIG)


@pytest.mark.parametrize("noun", ["stool", "snake"])
def test_what_the_arm_built_it_takes_apart(noun: str) -> None:
    """A stool's legs are tilted away from the arm's wrist; a snake's head is high and far."""
    built = wish(noun)
    apart = plan_taking_apart("built.json", built.model_dump_json().encode(), CONFIG)
    assert {step.cell for step in apart.steps} == set(built.assembly.cells)
    assert apart.parts == 0
    assert [check.name for check in apart.checks if check.passed][-1] == "reach"


def test_cells_in_a_file_are_planned() -> None:
    content = json.dumps({"cells": [[0, 0, 0], [0, 0, 1]], "pitch_m": 0.1}).encode()
    plan = plan_file("post.json", content, CONFIG)
    assert plan.title == "post"
    assert plan.parts == 2


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.json", b"{", "not valid JSON: .* in line 1"),
        ("a.json", b"\xff\xfe", "not UTF-8"),
        ("a.json", b"[1, 2]", "neither a build plan, cells nor a description"),
        ("a.json", b'{"placements": [], "cells": []}', "the report of a plan"),
        ("a.json", b"[" * 100_000, "not JSON that can be read"),
        ("a.json", b"1" * 5000, "not JSON that can be read"),
        ("a.json", b'{"steps": []}', "plan_id"),
        ("a.json", b'{"cells": [[0, 0]], "pitch_m": 0.1}', "cells.0"),
        ("a.step", b"", "not a kind of mesh file"),
        ("a.glb", b"glTF but not really", "cannot be read as GLB"),
        ("a.obj", b"# nothing\n", "a.obj"),
        ("a.stl", b"", "a.stl"),
    ],
)
def test_a_file_that_holds_nothing_useful_is_refused_by_name(
    name: str, content: bytes, said: str
) -> None:
    with pytest.raises(UsageError, match=said):
        plan_file(name, content, CONFIG)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot be read: No such file"):
        load_mesh(tmp_path / "none.glb")
    with pytest.raises(UsageError, match="cannot be read: No such file"):
        load_plan(tmp_path / "none.json")


@pytest.mark.parametrize("kind", ["glb", "stl", "obj", "ply"])
def test_a_mesh_file_stands_upright_and_has_no_unit(tmp_path: Path, kind: str) -> None:
    chair = generated(Box(0, 0, 0, 1, 1, 4), Box(0, 0, 0, 3, 1, 1)).mesh
    if kind == "glb":  # y is up in glTF
        chair.vertices = np.array(chair.vertices)[:, [0, 2, 1]] * np.array([1.0, 1.0, -1.0])
    file = tmp_path / f"thing.{kind}"
    chair.export(file)
    found = load_mesh(file, height_m=0.4)
    assert not found.metric
    plan = plan_build(found, CONFIG)
    assert plan.assembly.size == (3, 1, 4)
    assert plan.parts == 6


def test_the_up_axis_can_be_said(tmp_path: Path) -> None:
    file = tmp_path / "a.stl"
    generated(Box(0, 0, 0, 1, 4, 2)).mesh.export(file)
    content = file.read_bytes()
    assert plan_build(read_mesh("a.stl", content, height_m=0.2), CONFIG).assembly.size == (1, 4, 2)
    turned = read_mesh("a.stl", content, up="y", height_m=0.4)
    assert plan_build(turned, CONFIG).assembly.size == (1, 2, 4)


@pytest.mark.parametrize(
    "name",
    [
        "control_painted_wooden_stool.glb",
        pytest.param("hunyuan_sheep.glb", marks=pytest.mark.soak),
        "meshy_chair.glb",
        "trellis_oven.glb",
    ],
)
def test_a_real_generated_mesh_becomes_a_plan(test_data: Path, name: str) -> None:
    plan = plan_build(load_mesh(test_data / "meshes" / name), IMPATIENT)
    assert 8 <= plan.parts <= 40
    assert all(check.passed for check in plan.checks)
    assert all(
        0 <= index < count
        for cell in plan.assembly.cells
        for index, count in zip(cell, CONFIG.grid, strict=True)
    )
