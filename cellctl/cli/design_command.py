"""``cellctl design``: what a sentence asks for, as a description and a shape, without a cell."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from cellctl.assembly import Intent, Request
from cellctl.cli.designing_here import design_here
from cellctl.cli.job_commands import read_file
from cellctl.cli.options import ConfigOption, configuration
from cellctl.config import CellConfig
from cellctl.description import FamilyDescription, PartsDescription, parse_description
from cellctl.errors import DesignError, UsageError
from cellctl.mesh import GeneratedMesh

Made = FamilyDescription | PartsDescription


def _read(text: str, config: CellConfig) -> Request:
    from cellctl.listening.request import read_request  # noqa: PLC0415
    from cellctl.listening.understanding.interpreter import Setting  # noqa: PLC0415

    return read_request(text, Setting.of(config))


def _changed(mesh: GeneratedMesh, sentences: list[str], config: CellConfig) -> GeneratedMesh:
    """The shape after every change that was asked for."""
    from cellctl.generating.editing import change  # noqa: PLC0415 - heavy

    for sentence in sentences:
        request = _read(sentence, config)
        if request.intent is not Intent.EDIT:
            raise UsageError(
                f"--edit {sentence!r}: that is no change of something.",
                "Say it like: make it taller, or two more tiers.",
            )
        if mesh.description is None:
            raise DesignError(
                f"The {mesh.title} has no description that could be changed.",
                "Ask for it anew, with what it should be like.",
            )
        mesh = change(mesh, request, config)
    return mesh


def _write_glb(mesh: GeneratedMesh, path: Path) -> None:
    """glTF is in metres and y up, by its standard."""
    import numpy as np  # noqa: PLC0415 - heavy
    import trimesh  # noqa: PLC0415

    upright = mesh.vertices[:, [0, 2, 1]] * np.array([1.0, 1.0, -1.0])
    solid = trimesh.Trimesh(vertices=upright, faces=mesh.faces, process=False)
    content = solid.export(file_type="glb")
    assert isinstance(content, bytes), "GLB is binary"
    _write(path, content)


def _write(path: Path, content: bytes) -> None:
    try:
        path.write_bytes(content)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}.") from error


def _check_suffix(option: str, path: Path | None, suffix: str) -> None:
    if path is not None and path.suffix.lower() != suffix:
        raise UsageError(f"{option} {path}: writes {suffix[1:].upper()} files only.")


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def design(
        given: Annotated[
            str | None,
            typer.Argument(metavar="INPUT", help="A sentence, or a description (json)."),
        ] = None,
        edit: Annotated[
            list[str] | None,
            typer.Option("--edit", help='Change it: "make it taller"; may be repeated.'),
        ] = None,
        description: Annotated[
            Path | None,
            typer.Option("--description", metavar="FILE.json", help="Write the description."),
        ] = None,
        mesh: Annotated[
            Path | None, typer.Option("--mesh", metavar="FILE.glb", help="Write the shape.")
        ] = None,
        picture: Annotated[
            Path | None, typer.Option("--picture", metavar="FILE.png", help="Draw its parts.")
        ] = None,
        everything: Annotated[
            Path | None,
            typer.Option("--all", metavar="FILE.png", help="Draw one of every family, no INPUT."),
        ] = None,
        nameless: Annotated[
            bool, typer.Option("--nameless", help="With --all: numbers only, to guess from.")
        ] = False,
        config: ConfigOption = None,
    ) -> None:
        """Design a wish without a cell; write its description, its shape, a picture of it."""
        settings = configuration(config)
        screen = Console(highlight=False, soft_wrap=True)
        _check_suffix("--mesh", mesh, ".glb")
        _check_suffix("--picture", picture, ".png")
        _check_suffix("--all", everything, ".png")
        if (given is None) == (everything is None):
            raise UsageError("Name a sentence or a description, or give --all FILE.png.")
        if everything is not None:
            from cellctl.cli.contact_sheet import draw_sheet, every_family  # noqa: PLC0415

            exhibits = every_family(settings)
            draw_sheet(exhibits, settings, everything, named=not nameless)
            screen.print(f"{len(exhibits)} families drawn in {everything}", markup=False)
            return
        assert given is not None, "one of both is given"
        made = _changed(_made(given, settings, screen), edit or [], settings)
        _show(made, screen)
        if description is not None:
            if made.description is None:
                raise UsageError(f"The {made.title} has no description to write.")
            text = made.description.model_dump_json(indent=2, exclude_defaults=False)
            _write(description, f"{text}\n".encode())
        if mesh is not None:
            _write_glb(made, mesh)
        if picture is not None:
            _draw(made, settings, picture)


def _made(given: str, config: CellConfig, screen: Console) -> GeneratedMesh:
    """The shape of a sentence or of a description's file."""
    if Path(given).suffix.lower() == ".json":
        from cellctl.generating.describing import realise  # noqa: PLC0415 - heavy

        path = Path(given)
        read = parse_description(read_file(path), path.name)
        return realise(read, config, provenance=f"from {path.name}")
    request = _read(given, config).with_nothing_to_change()
    screen.print(
        f"understood   {request.intent.value}: {request.phrase}"
        + (f" ({request.reason})" if request.reason else ""),
        markup=False,
    )
    return design_here(request, config)


def _show(made: GeneratedMesh, screen: Console) -> None:
    screen.print(f"designed     {made.title}", markup=False)
    screen.print(f"provenance   {made.provenance}", markup=False)
    for change in made.changes:
        screen.print(f"change       {change.what} {change.why}", markup=False)


def _draw(made: GeneratedMesh, config: CellConfig, path: Path) -> None:
    from cellctl.cli.contact_sheet import cells_in_workspace  # noqa: PLC0415 - heavy
    from cellctl.cli.picture import draw_assembly  # noqa: PLC0415 - optional part

    cells = cells_in_workspace(made, config)
    draw_assembly(
        sorted(cells),
        config.grid,
        path,
        title=made.title,
        caption=f"{len(cells)} parts, before planning",
        pitch_m=config.voxel.pitch_m,
    )
