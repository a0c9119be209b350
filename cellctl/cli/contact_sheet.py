"""A contact sheet: many designs as what they would be built of, in one picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cellctl.assembly import Attribute, Cell
from cellctl.cli.picture import add_scene_axes, new_figure, save_png
from cellctl.config import CellConfig
from cellctl.description import FamilyDescription
from cellctl.drawing.scene import FAINT_INK, INK, PAPER, PART, Camera, Scene
from cellctl.generating.describing import realise
from cellctl.generating.families import FAMILIES
from cellctl.mesh import GeneratedMesh
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import fit

COLUMNS: Final = 7
_CELL_IN: Final = (3.1, 2.3)
_DPI: Final = 80
_OBLIQUE_SHARE: Final = 0.66
"""How much of its field's width a design has; its flat views have the rest."""
_DIMMER: Final = 0.75
"""Brightness of a flat view one cell further away."""
_GAP: Final = 0.6
"""Between front view and plan, in cells."""


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
    """Draw each from where visitors stand, with front view and plan beside it, and write a PNG.

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
        width, height = 1.0 / COLUMNS, 1.0 / rows
        oblique = (left, bottom, _OBLIQUE_SHARE * width, 0.9 * height)
        _draw_oblique(add_scene_axes(figure, oblique), exhibit.cells, config.grid)
        flat = (left + oblique[2], bottom, 0.98 * width - oblique[2], 0.9 * height)
        _draw_flat(add_scene_axes(figure, flat), exhibit.cells, config.grid)
        number = f"{index + 1}"
        text = f"{number}  {exhibit.name}" if named else number
        at = (left + 0.04 / COLUMNS, bottom + 0.94 / rows)
        figure.text(*at, text, fontsize=11, color=INK, va="center")
        parts = f"{len(exhibit.cells)} parts"
        figure.text(left + 0.76 / COLUMNS, at[1], parts, fontsize=8, color=FAINT_INK, va="center")
    save_png(figure, path)


def _draw_oblique(axes: Any, cells: frozenset[Cell], grid: tuple[int, int, int]) -> None:
    """One design as its parts, on the workspace's floor."""
    scene = Scene(axes, Camera(grid), grid)
    scene.floor_plate(sorted(cells))
    # The camera is beyond the far corner on every axis, so this order is far to near.
    for cell in sorted(cells, key=lambda c: (c.z, c.y, c.x)):
        scene.part(cell, PART, cells)
    axes.autoscale_view()


def _draw_flat(axes: Any, cells: frozenset[Cell], grid: tuple[int, int, int]) -> None:
    """The front view of one design, and its plan below, for somebody who has x to the left.

    What is further away is darker, so that what stands out can be told.
    """
    width, depth, height = grid
    front = {(width - 1 - x, z): depth - 1 - y for x, y, z in sorted(cells, key=lambda c: c.y)}
    plan = {(width - 1 - x, -1 - _GAP - y): height - 1 - z for x, y, z in sorted(cells)}
    for view in (front, plan):
        nearest = min(view.values())
        for at, distance in view.items():
            dimmed = tuple(_DIMMER ** (distance - nearest) * channel for channel in PART)
            _square(axes, at, facecolor=dimmed, edgecolor=PAPER)
    axes.plot((0, width), (0, 0), color=FAINT_INK, linewidth=0.8)
    axes.set_xlim(-0.1, width + 0.1)
    axes.set_ylim(-depth - _GAP - 0.1, height + 0.1)


def _square(axes: Any, at: tuple[float, float], **style: Any) -> None:
    from matplotlib.patches import Rectangle  # noqa: PLC0415 - an extra

    axes.add_patch(Rectangle(at, 1, 1, linewidth=0.5, **style))
