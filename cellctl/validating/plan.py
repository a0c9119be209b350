"""From a shape to a build plan: fit, voxelise, check and repair, order, reach.

Everything here is importable by name, so that it can run in a worker process, and depends on its
arguments only; but for the budget of a repair, which is wall time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import BuildPlan, Cell, Check, Closeness, StepKind
from cellctl.beside import stand_by
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.mesh import GeneratedMesh
from cellctl.validating.access import Gripper
from cellctl.validating.changing.plans import plan_change_over, plan_removal
from cellctl.validating.changing.reaching import ArmAccess
from cellctl.validating.changing.routing import routed
from cellctl.validating.checker import verify
from cellctl.validating.discretise import discretise
from cellctl.validating.draft import Draft, draft, paper_draft, paper_redraft, redraft
from cellctl.validating.files import read_json_plan, read_mesh
from cellctl.validating.fit import Shape, fit, size_changes, size_questions
from cellctl.validating.marking import laid_over
from cellctl.validating.paper.policy import plan_paper, plan_paper_cells, process
from cellctl.validating.repairing import repair_shape
from cellctl.validating.rules import Cells, size_of
from cellctl.validating.siting import site, site_here
from cellctl.validating.stability import Physics, assess
from cellctl.validating.words import named, times

Progress = Callable[[str], None]
"""Receives the name of each stage when it begins: discretising, checking, sequencing."""

_FORESEEN_PARTS = 60
_STAYS = "I could not take it apart again by myself; somebody would have to hold it."


def plan_build(
    generated: GeneratedMesh,
    config: CellConfig,
    inventory_parts: int | None = None,
    progress: Progress | None = None,
) -> BuildPlan:
    """Plan a generated shape; it is changed where it must be, as little as can be, and told.

    Args:
        generated: the shape, z up.
        config: the cell; ``planning`` has the policy and how long a plan may be improved.
        inventory_parts: how many parts there are now, where that is known to be fewer than the
            configured inventory.
        progress: told each stage as it begins.

    Raises:
        PlanError: it cannot be built; the message says which rule, and where.
    """
    tell = progress or _silent
    tell("discretising")
    stand_by("cellctl.validating.siting")
    fitted = fit(generated, config)
    tell("checking")
    parts = _parts(config, inventory_parts)
    found = _drafted(fitted.shape, config, parts)
    size, pitch_m = size_of(found.cells), config.voxel.pitch_m
    stated_m = generated.stated_dimensions_m
    changes = (
        *generated.changes,
        *fitted.changes,
        *found.changes,
        *size_changes(stated_m, size, pitch_m),
    )
    questions = (*size_questions(stated_m, size, pitch_m), *found.questions)
    tell("sequencing")
    found = replace(found, changes=changes, questions=questions)
    return _passed(*site(found, config, generated.title, generated.provenance, parts))


def plan_cells(
    cells: Iterable[Cell],
    config: CellConfig,
    inventory_parts: int | None = None,
    *,
    title: str = "object",
    provenance: str = "from cells",
) -> BuildPlan:
    """Plan cells exactly as given, apart from where in the workspace they stand.

    Raises:
        PlanError: they break a rule; cells are not repaired, only shapes are.
    """
    wanted = frozenset(Cell(*cell) for cell in cells)
    if not wanted:
        raise PlanError("There are no cells to build.", "Name at least one cell.")
    size, grid = size_of(wanted), config.grid
    if any(edge > room for edge, room in zip(size, grid, strict=True)):
        raise PlanError(
            f"The object is {times(size)} cells large; the workspace has {times(grid)}.",
            "Make it smaller.",
        )
    parts = _parts(config, inventory_parts)
    # Checked where they were given, so that a refusal names them as its reader knows them.
    x, y, z = (min(axis) for axis in zip(*wanted, strict=True))
    found = _drafted_cells(frozenset(c._replace(z=c.z - z) for c in wanted), config, parts)
    return _passed(*site(found.moved(-x, -y), config, title, provenance, parts))


def plan_file(
    name: str,
    content: bytes,
    config: CellConfig,
    inventory_parts: int | None = None,
    progress: Progress | None = None,
) -> BuildPlan:
    """Plan what a file holds: a mesh (.glb, .gltf, .obj, .ply, .stl), or a plan or cells (.json).

    A plan is not taken on trust: it is checked anew for this cell, in its own order and place.

    Args:
        name: the file's name; its suffix says what it holds.
        content: the file's bytes.
        config: the cell.
        inventory_parts: as in ``plan_build``.
        progress: as in ``plan_build``.

    Raises:
        UsageError: the file cannot be read as what it says it is.
        PlanError: what it holds cannot be built in this cell.
    """
    if Path(name).suffix.lower() != ".json":
        return plan_build(read_mesh(name, content), config, inventory_parts, progress)
    tell = progress or _silent
    tell("checking")
    found = read_json_plan(name, content)
    if isinstance(found, BuildPlan):
        tell("sequencing")
        return recheck(found, config, inventory_parts)
    if abs(found.pitch_m - config.voxel.pitch_m) > 1e-6:
        raise _other_pitch(name, found.pitch_m, config)
    tell("sequencing")
    return plan_cells(
        found.cells, config, inventory_parts, title=Path(name).stem, provenance=f"from {name}"
    )


def recheck(plan: BuildPlan, config: CellConfig, inventory_parts: int | None = None) -> BuildPlan:
    """Check a plan that came from elsewhere, with its own order and place, for this cell.

    It is judged by this cell's policy, whatever it says of itself.

    Returns:
        The same steps, with checks, clearances and durations of this cell.

    Raises:
        PlanError: it breaks a rule, or it was made for another cell.
    """
    if abs(plan.pitch_m - config.voxel.pitch_m) > 1e-6:
        raise _other_pitch(f"The plan {plan.title!r}", plan.pitch_m, config)
    if any(step.kind is not StepKind.PLACE for step in plan.steps):
        raise PlanError(
            "The plan takes parts away; only plans that build from nothing can be run.",
            "Plan the object anew.",
        )
    order = tuple(step.cell for step in plan.steps)
    cells = frozenset(order)
    if len(cells) != len(order) or cells != frozenset(plan.assembly.cells):
        raise PlanError("The plan's steps do not build its own assembly.", "Plan it anew.")
    if not cells:
        raise PlanError("The plan has no steps.", "Plan it anew.")
    parts, physics = _parts(config, inventory_parts), Physics.of(config)
    found = (
        paper_redraft(order, physics, config.limits, parts)
        if config.planning.policy == "paper"
        else redraft(order, physics, Gripper.of(config), parts)
    )
    asked = (*plan.questions, *(q for q in found.questions if q not in plan.questions))
    found = replace(found, changes=plan.changes, questions=asked, closeness=plan.closeness)
    found = replace(found, wanted=frozenset(plan.wanted))
    return _passed(*site_here(found, config, plan.title, plan.provenance, parts))


def plan_taking_apart(name: str, content: bytes, config: CellConfig) -> BuildPlan:
    """Plan how what stands goes back to the belt, part by part.

    Args:
        name: of the file, for people.
        content: the cells that stand, or the plan that built them (.json).
        config: the cell.

    Raises:
        UsageError: the file is neither.
        PlanError: there is no way in which every state on the way stands.
    """
    return take_apart(standing_cells(name, content, config), config, title=Path(name).stem)


def take_apart(
    standing: Cells, config: CellConfig, *, title: str, parts_on_belt: int | None = None
) -> BuildPlan:
    """As ``plan_taking_apart``, by the cells that stand.

    Args:
        standing: what stands, at least one part.
        config: the cell.
        title: of the object that stands.
        parts_on_belt: how many lie there; what its capacity leaves, if None.

    Raises:
        PlanError: there is no way in which every state on the way stands, or no room on the belt.
    """
    _refuse_fallen(standing, config)
    planner = RoutePlanner(config)
    access = ArmAccess(Gripper.of(config), planner)
    plan = plan_removal(standing, config, title=title, parts_on_belt=parts_on_belt, access=access)
    plan = _verified(plan, config, config.limits.inventory_parts, standing)
    return routed(plan, standing, config, planner)


def foresee_removal(plan: BuildPlan, config: CellConfig) -> BuildPlan:
    """The same plan, with a question where what it builds could not be taken apart: what is
    top-heavy on one stem stands, and does not bear that parts are pulled or tilted off.

    Only forces are looked at, for where they allow it the arm has found a way. Of more than 60
    parts nothing is foreseen, for an order is long in coming; nor of a plan by the paper's policy,
    which knows no forces.
    """
    if plan.policy == "paper" or plan.parts > _FORESEEN_PARTS:
        return plan
    try:
        plan_removal(frozenset(plan.assembly.cells), config, parts_on_belt=0)
    except PlanError:
        return plan.model_copy(update={"questions": (*plan.questions, _STAYS)})
    return plan


def plan_changing_over(
    plan: BuildPlan, standing: Cells, config: CellConfig, parts_on_belt: int | None = None
) -> BuildPlan:
    """Plan how what stands becomes the object of another plan, with as few moves as can be.

    Args:
        plan: of the object that is wanted, made for an empty workspace.
        standing: what stands.
        config: the cell.
        parts_on_belt: how many lie there; what its capacity leaves, if None.

    Raises:
        PlanError: there is no way in which every state on the way stands.
    """
    _refuse_fallen(standing, config)
    planner = RoutePlanner(config)

    def reachable(cell: Cell) -> bool:
        try:
            planner.place_stance(cell)
        except PlanError:
            return False
        return True

    changed = plan_change_over(
        standing,
        frozenset(plan.assembly.cells),
        config,
        title=plan.title,
        provenance=plan.provenance,
        parts_on_belt=parts_on_belt,
        reachable=reachable,
        access=ArmAccess(Gripper.of(config), planner),
    )
    told = changed.model_copy(
        update={
            "changes": (*plan.changes, *changed.changes),
            "questions": plan.questions,
            "closeness": plan.closeness,
            "wanted": plan.wanted,
        }
    )
    spare = config.limits.inventory_parts - len(standing)
    return routed(_verified(told, config, spare, standing), standing, config, planner)


def _refuse_fallen(standing: Cells, config: CellConfig) -> None:
    """Raises PlanError where what is said to stand could not."""
    physics = Physics.of(config)
    verdict = assess(standing, physics)
    if verdict.margin < physics.least_margin:
        cells = tuple(sorted(verdict.moving, key=lambda c: (c.z, c.x, c.y)))
        raise PlanError(
            f"What is said to stand would not: its joints bear {verdict.margin:.2f} times what is "
            f"asked of them, and {physics.least_margin:g} times is due. Cells: {named(cells)}.",
            "Look what really stands, and name its cells.",
            rule="stability",
            cells=cells,
        )


def standing_cells(name: str, content: bytes, config: CellConfig) -> Cells:
    """The cells of a file of cells, or those that a plan leaves.

    Raises:
        UsageError: it is neither.
        PlanError: they are of another size, or outside the workspace.
    """
    found = read_json_plan(name, content)
    assembly = found.assembly if isinstance(found, BuildPlan) else found
    if abs(assembly.pitch_m - config.voxel.pitch_m) > 1e-6:
        raise _other_pitch(name, assembly.pitch_m, config)
    outside = [
        cell
        for cell in assembly.cells
        if not all(0 <= index < room for index, room in zip(cell, config.grid, strict=True))
    ]
    if outside:
        raise PlanError(
            f"{name}: {list(outside[0])} is outside the workspace of {times(config.grid)} cells.",
            "Name what stands by its cells in the workspace.",
            rule="workspace",
            cells=tuple(outside),
        )
    return frozenset(assembly.cells)


def _drafted(shape: Shape, config: CellConfig, parts: int) -> Draft:
    """A shape's cells, changed until they can be built, and ordered."""
    physics = Physics.of(config)
    if config.planning.policy == "paper":
        return paper_draft(plan_paper(shape, config.limits, parts), physics)
    gripper = Gripper.of(config)
    wanted = discretise(shape)
    repaired = repair_shape(
        wanted,
        physics,
        gripper,
        parts=parts,
        grid=config.grid,
        budget_s=config.planning.budget_s,
        rescaled=lambda: process(shape, config.limits, parts, occupied=wanted).cells,
    )
    found = redraft(repaired.order, physics, gripper, parts, repaired.verdicts)
    if not repaired.changes:
        return found
    closeness = Closeness(
        score=repaired.score,
        baseline_score=repaired.baseline_score,
        bound=min(1.0, repaired.bound),
        proven=repaired.proven,
    )
    return replace(
        found,
        changes=repaired.changes,
        closeness=closeness,
        wanted=laid_over(wanted, found.cells),
    )


def _drafted_cells(cells: Cells, config: CellConfig, parts: int) -> Draft:
    """Cells whose lowest layer is 0, as they are, ordered."""
    physics = Physics.of(config)
    if config.planning.policy == "paper":
        x, y = (min(axis) for axis in list(zip(*cells, strict=True))[:2])
        found = paper_draft(plan_paper_cells(cells, config.limits, parts), physics)
        return found.moved(x, y)
    return draft(cells, physics, Gripper.of(config), parts)


def _verified(plan: BuildPlan, config: CellConfig, parts: int, standing: Cells) -> BuildPlan:
    """A plan that begins with what stands, if the independent checker finds nothing wrong with it.

    Raises:
        PlanError: it does, which is a defect of the planner.
    """
    return _passed(plan, verify(plan, config, parts, standing))


def _passed(plan: BuildPlan, judgement: Iterable[Check]) -> BuildPlan:
    """The plan, if the independent checker found nothing wrong with it.

    Raises:
        PlanError: it did, which is a defect of the planner.
    """
    for check in judgement:
        # By the paper's rules, counts decide; how it stands is asked about.
        if not check.passed and not (plan.policy == "paper" and check.name == "stability"):
            raise PlanError(
                f"The plan failed when it was checked anew, by the rule of {check.name}: "
                f"{check.message}",
                "This is a defect of the planner; please report it with what was asked for.",
                rule=check.name,
                cells=check.cells,
            )
    return plan


def _parts(config: CellConfig, inventory_parts: int | None) -> int:
    if inventory_parts is None:
        return config.limits.inventory_parts
    return min(inventory_parts, config.limits.inventory_parts)


def _other_pitch(what: str, pitch_m: float, config: CellConfig) -> PlanError:
    return PlanError(
        f"{what} is for parts of {pitch_m * 100:g} cm; this cell has parts of "
        f"{config.voxel.pitch_m * 100:g} cm.",
        "Plan it anew.",
    )


def _silent(_name: str) -> None:
    """For whoever wants no progress."""
