"""``cellctl plan``: what would be built, without a cell."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from cellctl.assembly import BuildPlan, Cell, Intent
from cellctl.cli.options import ConfigOption, JsonOption, configuration
from cellctl.config import CellConfig
from cellctl.errors import NoObjectError, UsageError

FILE_SUFFIXES = (".glb", ".gltf", ".stl", ".obj", ".ply", ".json")


def make_plan(wish: str, config: CellConfig) -> BuildPlan:
    """Plan a sentence, or the mesh or plan file of that name.

    Raises:
        NoObjectError, DesignError, PlanError: it cannot be built.
        UsageError: it looks like a file and there is none.
    """
    from cellctl.generating.design import design  # noqa: PLC0415 - heavy
    from cellctl.listening.request import read_request  # noqa: PLC0415
    from cellctl.validating.plan import plan_build, plan_file  # noqa: PLC0415 - heavy

    inventory = config.limits.inventory_parts
    path = Path(wish)
    if path.suffix.lower() in FILE_SUFFIXES:
        if not path.is_file():
            raise UsageError(f"{path}: there is no such file.")
        return plan_file(path.name, path.read_bytes(), config, inventory)
    request = read_request(wish, config.voxel.pitch_m)
    if request.intent is not Intent.DESIGN:
        raise NoObjectError(request.reason)
    return plan_build(design(request, config), config, inventory)


def layers(cells: tuple[Cell, ...], grid: tuple[int, int, int]) -> list[str]:
    """The layers from the floor up as text; y runs up the page, # is a part."""
    occupied = set(cells)
    nx, ny, _ = grid
    height = max((cell.z for cell in cells), default=-1) + 1
    blocks = [
        [f"layer {z}"]
        + ["".join(" #" if Cell(x, y, z) in occupied else " ." for x in range(nx)) for y in rows]
        for z in range(height)
        for rows in [range(ny - 1, -1, -1)]
    ]
    width = max(8, 2 * nx)
    return ["   ".join(line.ljust(width) for line in row) for row in zip(*blocks, strict=True)]


def show_plan(console: Console, plan: BuildPlan, grid: tuple[int, int, int]) -> None:
    """Print a plan for people."""
    edges = " x ".join(f"{edge * plan.pitch_m * 100:.0f}" for edge in plan.assembly.size)
    console.print(f"[bold]{plan.title}[/]: {plan.parts} parts, {edges} cm ({plan.provenance})")
    for check in plan.checks:
        mark = "[green]pass[/]" if check.passed else "[red]fail[/]"
        console.print(f"  {mark} {check.name}: {check.message}")
    for change in plan.changes:
        console.print(f"  [yellow]changed[/] {change.what} {change.why}")
    for question in plan.questions:
        console.print(f"  [yellow]to ask[/] {question}")
    for line in layers(plan.assembly.cells, grid):
        console.print(f"  {line}", markup=False, no_wrap=True, overflow="ignore", crop=False)
    known = [step.duration_s for step in plan.steps if step.duration_s is not None]
    if known and len(known) == len(plan.steps):
        console.print(f"  about {sum(known):.0f} s, {sum(known) / len(known):.1f} s a part")


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def plan(
        wish: Annotated[str, typer.Argument(help="A sentence, or a mesh or plan file.")],
        config: ConfigOption = None,
        json: JsonOption = False,
        output: Annotated[
            Path | None, typer.Option(help="Write the plan (JSON) to this file.")
        ] = None,
    ) -> None:
        """Plan a wish without a cell, and show what was checked and changed."""
        settings = configuration(config)
        made = make_plan(wish, settings)
        text = made.model_dump_json(indent=2)
        if output is not None:
            try:
                output.write_text(text + "\n", encoding="utf-8")
            except OSError as error:
                raise UsageError(f"{output}: cannot be written: {error.strerror}.") from error
        if json:
            typer.echo(text)
        else:
            show_plan(Console(highlight=False), made, settings.grid)
