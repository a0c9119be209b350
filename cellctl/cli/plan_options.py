"""What the input of ``cellctl plan`` is, and which options go with it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

from cellctl.assembly import BuildPlan
from cellctl.cli.job_commands import read_file
from cellctl.cli.plan_report import InputKind
from cellctl.config import CellConfig
from cellctl.description import is_description
from cellctl.errors import UsageError

Up = Literal["auto", "y", "z"]
PlanPolicy = Literal["cellctl", "paper"]


def input_kind(given: str) -> InputKind:
    """What an input is: a file by its suffix, and JSON by what it holds, else a sentence."""
    from cellctl.validating.files import MESH_SUFFIXES  # noqa: PLC0415 - heavy

    suffix = Path(given).suffix.lower()
    if suffix in MESH_SUFFIXES:
        return "mesh"
    if suffix != ".json":
        return "sentence"
    return "description" if _is_description(Path(given)) else "cells"


def refuse_misfit(kind: InputKind, height_m: float | None, up: Up) -> None:
    """Refuse options that the input has no use for, rather than overlook them.

    Raises:
        UsageError: one of them makes no sense.
    """
    if height_m is not None and not (math.isfinite(height_m) and height_m > 0.0):
        raise UsageError(f"--height-m {height_m:g}: no height.", "Give metres, such as 0.45.")
    if height_m is not None and kind in ("cells", "description"):
        has = "cells have their" if kind == "cells" else "a description has its"
        raise UsageError(f"--height-m: {has} size already.", "Leave it out.")
    if up != "auto" and kind != "mesh":
        raise UsageError("--up: only a mesh can be turned upright.", "Leave it out.")


def refuse_idle(
    given: str,
    *,
    policy: PlanPolicy | None,
    budget_s: float | None,
    standing: bool = False,
    take_apart: bool = False,
    configured: PlanPolicy = "cellctl",
) -> None:
    """Refuse a policy or a budget that would change nothing, rather than overlook it.

    Args:
        given: the sentence or the file.
        policy, budget_s: as asked for beside it.
        standing: whether something stands that is to become what is given.
        take_apart: whether what is given stands, and is to be taken apart.
        configured: the policy without ``policy``.

    Raises:
        UsageError: one of them cannot matter, or the file that decides it cannot be read.
    """
    cells = input_kind(given) == "cells"
    if budget_s is not None and cells:
        raise UsageError(
            "--budget-s: cells and plans are taken as they are, never improved.", "Leave it out."
        )
    if budget_s is not None and (policy or configured) == "paper":
        raise UsageError(
            "--budget-s: the policy paper, of the Speech-to-Reality paper, improves nothing.",
            "Leave it out.",
        )
    if policy == "paper" and (standing or take_apart):
        raise UsageError(
            "--policy paper: changing over and taking apart are proven by the policy cellctl only.",
            "Leave it out.",
        )
    if policy is not None and cells and not take_apart and _is_plan(Path(given)):
        raise UsageError(
            "--policy: a plan is checked by the policy that the cell is configured for.",
            "Leave it out, set planning.policy, or name the plan's cells to plan them anew.",
        )


def _is_description(path: Path) -> bool:
    """Whether a file describes what to make; one that cannot be read is told of later."""
    try:
        return is_description(path.read_bytes())
    except OSError:
        return False


def _is_plan(path: Path) -> bool:
    """Whether a file has steps; one that is missing is told of when it is planned."""
    from cellctl.validating.files import read_json_plan  # noqa: PLC0415 - heavy

    return path.is_file() and isinstance(read_json_plan(path.name, read_file(path)), BuildPlan)


def adjusted(config: CellConfig, budget_s: float | None, policy: PlanPolicy | None) -> CellConfig:
    """The configuration with another budget or policy for this plan.

    Raises:
        UsageError: that is no budget.
    """
    changes: dict[str, object] = {} if policy is None else {"policy": policy}
    if budget_s is not None:
        if not (math.isfinite(budget_s) and budget_s > 0.0):
            raise UsageError(f"--budget-s {budget_s:g}: no budget.", "Give seconds, such as 20.")
        changes["budget_s"] = budget_s
    return config.model_copy(update={"planning": config.planning.model_copy(update=changes)})
