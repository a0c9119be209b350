"""A contact sheet: many designs as what they would be built of, in one picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cellctl.assembly import Attribute, Cell
from cellctl.cli.picture import add_scene_axes, new_figure, save_png
from cellctl.cli.picture_scene import FAINT_INK, INK, PART, Camera, Scene
from cellctl.config import CellConfig
from cellctl.description import FamilyDescription
from cellctl.generating.describing import realise
from cellctl.generating.families import FAMILIES
from cellctl.mesh import GeneratedMesh
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import fit

COLUMNS: Final = 6
_CELL_IN: Final = (2.6, 2.5)
_DPI: Final = 80


@dataclass(frozen=True)
class Exhibit:
    """One design of the sheet."""

    name: str
    cells: frozenset[Cell]


def cells_in_workspace(mesh: GeneratedMesh, config: CellConfig) -> frozenset[Cell]:
    """The cells of a shape before anything is planned, in the middle of the workspace."""
    cells = discretise(fit(mesh, config).shape)
    size = [max(axis) + 1 for axis in zip(*cells, strict=True)]
    dx, dy = ((room - edge) // 2 for room, edge in zip(config.grid[:2], size[:2], strict=True))
    return frozenset(Cell(x + dx, y + dy, z) for x, y, z in cells)


def every_family(config: CellConfig) -> list[Exhibit]:
    """One of each family, as it is without anything being said of it; a letter is an R."""
    exhibits = []
    for family in FAMILIES:
        attributes: dict[str, Attribute] = {"glyph": "R"} if "glyph" in family.takes else {}
        mesh = realise(FamilyDescription(family=family.name, attributes=attributes), config)
        exhibits.append(Exhibit(family.name, cells_in_workspace(mesh, config)))
    return exhibits


def draw_sheet(
    exhibits: Sequence[Exhibit], config: CellConfig, path: Path, *, named: bool = True
) -> None:
    """Draw them from where visitors stand and write a PNG.

    Args:
        exhibits: in the order in which they are shown, row by row.
        config: the cell.
        path: the file to write; its folder must exist.
        named: without it they are only numbered, for whoever wants to guess.

    Raises:
        UsageError: matplotlib is not installed, or the file cannot be written.
    """
    rows = math.ceil(len(exhibits) / COLUMNS)
    figure = new_figure(COLUMNS * _CELL_IN[0], rows * _CELL_IN[1], _DPI)
    for index, exhibit in enumerate(exhibits):
        row, column = divmod(index, COLUMNS)
        left, bottom = column / COLUMNS, 1.0 - (row + 1) / rows
        axes = add_scene_axes(figure, (left, bottom, 1.0 / COLUMNS, 0.9 / rows))
        scene = Scene(axes, Camera(config.grid), config.grid)
        scene.floor(sorted(exhibit.cells), "-y", config.voxel.pitch_m)
        # The camera is beyond the far corner on every axis, so this order is far to near.
        for cell in sorted(exhibit.cells, key=lambda c: (c.z, c.y, c.x)):
            scene.part(cell, PART, exhibit.cells)
        axes.autoscale_view()
        number = f"{index + 1}"
        text = f"{number}  {exhibit.name}" if named else number
        at = (left + 0.04 / COLUMNS, bottom + 0.94 / rows)
        figure.text(*at, text, fontsize=11, color=INK, va="center")
        parts = f"{len(exhibit.cells)} parts"
        figure.text(left + 0.72 / COLUMNS, at[1], parts, fontsize=8, color=FAINT_INK, va="center")
    save_png(figure, path)
