"""What the designer process does. Loading the planner takes a second, which the daemon has not."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cellctl.assembly import BuildPlan, Cell, Request
    from cellctl.config import CellConfig
    from cellctl.mesh import GeneratedMesh


def warm_up() -> None:
    """Load everything, so that the first wish is served without delay."""
    # The solver counts against the first plan's budget if that has to load it.
    import ortools.sat.python.cp_model  # noqa: F401, PLC0415

    import cellctl.generating.design  # noqa: PLC0415
    import cellctl.validating.plan  # noqa: F401, PLC0415


def design(request: Request, config: CellConfig) -> GeneratedMesh:
    """A shape for a request; see ``generating.design``."""
    from cellctl.generating import design as designer  # noqa: PLC0415

    return designer.design(request, config)


def redesign(mesh: GeneratedMesh | None, request: Request, config: CellConfig) -> GeneratedMesh:
    """What was designed, as a request with intent ``edit`` wants it; for any other, a new shape.

    Raises:
        DesignError: it cannot be changed so.
        NoObjectError, DesignError: as in ``design``.
    """
    from cellctl.assembly import Intent  # noqa: PLC0415
    from cellctl.errors import DesignError  # noqa: PLC0415
    from cellctl.generating.describing import realise  # noqa: PLC0415
    from cellctl.generating.editing import edited  # noqa: PLC0415

    if request.intent is not Intent.EDIT:
        return design(request, config)
    if mesh is None or mesh.description is None:
        raise DesignError(
            "What I planned has no description that could be changed.",
            "Say the whole wish, with what it should be like.",
        )
    return realise(edited(mesh.description, request, config), config)


def plan_build(
    mesh: GeneratedMesh, config: CellConfig, available: int, progress: Callable[[str], None]
) -> BuildPlan:
    """A plan for a shape; see ``validating.plan``."""
    from cellctl.validating import plan  # noqa: PLC0415

    return plan.plan_build(mesh, config, available, progress)


def plan_upload(
    name: str,
    content: bytes,
    config: CellConfig,
    available: int | None = None,
    progress: Callable[[str], None] | None = None,
) -> BuildPlan:
    """A plan for a file: a mesh, a description, cells or a plan; see ``validating.plan``.

    Raises:
        UsageError: it cannot be read as what it says it is.
        DesignError: it describes what cannot be designed.
        PlanError: what it holds cannot be built in this cell.
    """
    from cellctl.description import is_description, parse_description  # noqa: PLC0415
    from cellctl.validating import plan  # noqa: PLC0415

    if not (name.lower().endswith(".json") and is_description(content)):
        return plan.plan_file(name, content, config, available, progress)
    from cellctl.generating.describing import realise  # noqa: PLC0415

    mesh = realise(parse_description(content, name), config, provenance=f"from {name}")
    return plan.plan_build(mesh, config, available, progress)


def take_apart(
    standing: frozenset[Cell], config: CellConfig, on_belt: int, progress: Callable[[str], None]
) -> BuildPlan:
    """A plan by which what stands goes back to the belt; see ``validating.plan``."""
    from cellctl.validating import plan  # noqa: PLC0415

    progress("checking")
    progress("sequencing")
    return plan.take_apart(standing, config, title="object", parts_on_belt=on_belt)


def change_over(
    wanted: BuildPlan, standing: frozenset[Cell], config: CellConfig, on_belt: int
) -> BuildPlan:
    """A plan by which what stands becomes another object; see ``validating.plan``."""
    from cellctl.validating import plan  # noqa: PLC0415

    return plan.plan_changing_over(wanted, standing, config, on_belt)
