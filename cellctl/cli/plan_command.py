"""``cellctl plan``: what would be built, without a cell."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from cellctl.assembly import BuildPlan
from cellctl.beside import Beside
from cellctl.cli.designing_here import design_here
from cellctl.cli.job_commands import read_file
from cellctl.cli.options import ConfigOption, configuration
from cellctl.cli.plan_files import Outputs
from cellctl.cli.plan_options import (
    PlanPolicy,
    Up,
    adjusted,
    input_kind,
    refuse_idle,
    refuse_misfit,
)
from cellctl.cli.plan_progress import PlanProgress
from cellctl.cli.plan_report import PlanInput, report_plan, report_refusal
from cellctl.cli.plan_screen import report_console, show_refusal, show_report
from cellctl.config import CellConfig
from cellctl.errors import CellctlError, NoObjectError, UsageError

Progress = Callable[[str], None]


def make_plan(
    given: str,
    config: CellConfig,
    *,
    height_m: float | None = None,
    up: Up = "auto",
    progress: Progress | None = None,
) -> BuildPlan:
    """Plan a sentence, or the mesh, description, cells or plan file of that name.

    Args:
        given: the sentence or the file.
        config: the cell; its planning section has the policy and the budget.
        height_m: how high a sentence's object or a mesh shall be.
        up: which axis of a mesh points up; ``auto`` goes by its format.
        progress: told each stage as it begins.

    Raises:
        NoObjectError, DesignError, PlanError: it cannot be built.
        UsageError: there is no such file, it cannot be read, or an option does not go with it.
    """
    kind = input_kind(given)
    refuse_misfit(kind, height_m, up)
    inventory = config.limits.inventory_parts
    if kind == "sentence":
        if os.path.isfile(given):  # noqa: PTH113 - unlike pathlib's, it takes any sentence
            from cellctl.validating.files import MESH_SUFFIXES  # noqa: PLC0415

            raise UsageError(
                f"{given}: not a kind of file that can be planned.",
                f"Use one of .json, {', '.join(MESH_SUFFIXES)}.",
            )
        from cellctl.listening.request import read_request  # noqa: PLC0415
        from cellctl.listening.understanding.interpreter import Setting  # noqa: PLC0415
        from cellctl.validating.plan import plan_build  # noqa: PLC0415 - heavy

        request = read_request(given, Setting.of(config)).with_nothing_to_change()
        if not request.buildable:
            raise NoObjectError(request.refusal or request.reason)
        if height_m is not None:
            sizes = {**request.dimensions_m, "height": height_m}
            request = request.model_copy(update={"dimensions_m": sizes})
        return plan_build(design_here(request, config), config, inventory, progress)

    from cellctl.control.designing import plan_upload  # noqa: PLC0415
    from cellctl.validating.files import read_mesh  # noqa: PLC0415
    from cellctl.validating.plan import plan_build  # noqa: PLC0415 - heavy

    path = Path(given)
    if not path.is_file():
        raise UsageError(f"{path}: there is no such file.")
    if kind == "mesh":
        mesh = read_mesh(path.name, read_file(path), up=up, height_m=height_m)
        return plan_build(mesh, config, inventory, progress)
    return plan_upload(path.name, read_file(path), config, inventory, progress)


def make_change(
    given: str,
    config: CellConfig,
    *,
    standing: Path | None,
    take_apart: bool,
    height_m: float | None = None,
    up: Up = "auto",
    progress: Progress | None = None,
) -> BuildPlan:
    """As ``make_plan``, where something stands in the workspace already.

    Args:
        given: what is wanted; with ``take_apart`` the file of what stands.
        config: the cell.
        standing: the file of what stands and is to become what is wanted, if anything.
        take_apart: whether what stands is to be taken away.
        height_m, up, progress: as in ``make_plan``.

    Raises:
        UsageError: a file is missing or unusable, or the options do not go together.
        CellctlError: as from ``make_plan``.
    """
    if not take_apart and standing is None:
        return make_plan(given, config, height_m=height_m, up=up, progress=progress)
    from cellctl.validating.plan import (  # noqa: PLC0415 - heavy
        plan_changing_over,
        plan_taking_apart,
        standing_cells,
    )

    if take_apart:
        if standing is not None or input_kind(given) != "cells":
            raise UsageError(
                "--take-apart takes apart what INPUT says: the cells that stand, or the plan that "
                "built them (.json).",
                "Name such a file, without --standing.",
            )
        refuse_misfit("cells", height_m, up)
        return plan_taking_apart(Path(given).name, read_file(Path(given)), config)
    assert standing is not None, "one of both is asked for"
    stands = standing_cells(standing.name, read_file(standing), config)
    wanted = make_plan(given, config, height_m=height_m, up=up, progress=progress)
    return plan_changing_over(wanted, stands, config)


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def plan(
        given: Annotated[
            str,
            typer.Argument(
                metavar="INPUT",
                help="A sentence, a mesh (glb, gltf, obj, ply, stl), or a description, cells or a "
                "plan (json).",
            ),
        ],
        height_m: Annotated[
            float | None, typer.Option("--height-m", help="How high it shall be, in metres.")
        ] = None,
        up: Annotated[
            Up, typer.Option("--up", help="Which axis of a mesh points up; auto: as its format.")
        ] = "auto",
        json: Annotated[
            str | None,
            typer.Option("--json", metavar="FILE", help="Write the report (JSON); - prints it."),
        ] = None,
        plan_file: Annotated[
            Path | None,
            typer.Option("--plan", metavar="FILE", help="Write a plan for `cellctl build`."),
        ] = None,
        picture: Annotated[
            Path | None,
            typer.Option("--picture", metavar="FILE.png", help="Draw the steps."),
        ] = None,
        steps: Annotated[
            Path | None,
            typer.Option("--steps", metavar="FILE.glb", help="Write the steps as an animation."),
        ] = None,
        budget_s: Annotated[
            float | None,
            typer.Option("--budget-s", help="How long it may be improved, in seconds."),
        ] = None,
        policy: Annotated[
            PlanPolicy | None,
            typer.Option(
                "--policy",
                help="By whose rules to plan: cellctl's own, or the Speech-to-Reality paper's.",
            ),
        ] = None,
        standing: Annotated[
            Path | None,
            typer.Option(
                "--standing", metavar="FILE", help="What stands (json) and is to become INPUT."
            ),
        ] = None,
        take_apart: Annotated[
            bool, typer.Option("--take-apart", help="INPUT (json) stands; plan to take it away.")
        ] = False,
        config: ConfigOption = None,
    ) -> None:
        """Plan a wish without a cell, and show what was checked and changed."""
        configured = configuration(config)
        settings = adjusted(configured, budget_s, policy)
        outputs = Outputs(json=json, plan=plan_file, picture=picture, steps=steps)
        outputs.check()
        asked = PlanInput(
            given=given,
            kind=input_kind(given),
            height_m=height_m,
            up=up,
            standing=str(standing) if standing is not None else None,
            take_apart=take_apart,
        )
        screen = None if outputs.prints_json else report_console()
        aside = Console(stderr=True, highlight=False)
        began_s = time.monotonic()
        try:
            refuse_idle(
                given,
                policy=policy,
                budget_s=budget_s,
                standing=standing is not None,
                take_apart=take_apart,
                configured=configured.planning.policy,
            )
            with Beside(), PlanProgress(aside, "reading what is wanted") as progress:
                made = make_change(
                    given,
                    settings,
                    standing=standing,
                    take_apart=take_apart,
                    height_m=height_m,
                    up=up,
                    progress=progress.stage,
                )
        except CellctlError as error:
            refusal = report_refusal(error, asked, settings, time.monotonic() - began_s)
            outputs.write_report(refusal)
            if screen is not None and refusal.refused is not None:
                show_refusal(screen, refusal.refused)
            raise
        report = report_plan(made, asked, settings, time.monotonic() - began_s)
        outputs.write_report(report)
        if screen is not None:
            show_report(screen, report, settings.grid)
            if made.policy != settings.planning.policy:
                screen.print(
                    f"planning.policy is {settings.planning.policy!r}, which knows no taking apart "
                    f"and no changing over: these steps follow the policy {made.policy!r}.",
                    style="yellow",
                )
        with PlanProgress(aside, "drawing the steps"):
            written = tuple(outputs.write_plan(made, report, settings))
        if screen is not None:
            for line in written:
                screen.print(line, markup=False)
