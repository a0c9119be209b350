"""What the designer process does. Loading the planner takes a second, which the daemon has not."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cellctl.assembly import BuildPlan, Request
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


def plan_build(
    mesh: GeneratedMesh, config: CellConfig, available: int, progress: Callable[[str], None]
) -> BuildPlan:
    """A plan for a shape; see ``validating.plan``."""
    from cellctl.validating import plan  # noqa: PLC0415

    return plan.plan_build(mesh, config, available, progress)


def plan_file(
    name: str,
    content: bytes,
    config: CellConfig,
    available: int,
    progress: Callable[[str], None],
) -> BuildPlan:
    """A plan for a mesh or plan file; see ``validating.plan``."""
    from cellctl.validating import plan  # noqa: PLC0415

    return plan.plan_file(name, content, config, available, progress)
