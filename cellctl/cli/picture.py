"""A picture of what stands in the workspace, for the report and for the people who built it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from cellctl.assembly import Cell
from cellctl.drawing.scene import FAINT_INK, INK, PAPER, PART, WRONG, Camera, Scene, Side
from cellctl.errors import UsageError

WIDTH_IN: Final = 8.0
HEIGHT_IN: Final = 7.0
DPI: Final = 150


def new_figure(width_in: float, height_in: float, dpi: int) -> Any:
    """An empty matplotlib figure with the paper's colour, drawn without a screen.

    Raises:
        UsageError: matplotlib is not installed.
    """
    try:  # An extra: a cell without a screen needs no pictures.
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
        from matplotlib.figure import Figure  # noqa: PLC0415
    except ImportError as error:
        raise UsageError(
            "A picture needs matplotlib, which is not installed.",
            "Install cellctl with its extra: cellctl[picture].",
        ) from error

    figure = Figure(figsize=(width_in, height_in), dpi=dpi, facecolor=PAPER)
    FigureCanvasAgg(figure)
    return figure


def add_scene_axes(figure: Any, box: tuple[float, float, float, float]) -> Any:
    """Axes for one scene, at [left, bottom, width, height] in parts of the figure."""
    axes = figure.add_axes(box)
    axes.set_axis_off()
    axes.set_aspect("equal")
    return axes


def save_png(figure: Any, path: Path) -> None:
    """Write a figure as a PNG.

    Raises:
        UsageError: the file cannot be written.
    """
    try:
        figure.savefig(path, format="png", facecolor=PAPER)
    except OSError as error:
        raise UsageError(f"{path}: the picture cannot be written: {error.strerror}.") from error


def draw_assembly(
    cells: Sequence[Cell],
    grid: tuple[int, int, int],
    path: Path,
    *,
    title: str,
    caption: str,
    pitch_m: float,
    wrong: Sequence[Cell] = (),
    missing: Sequence[Cell] = (),
    robot_side: Side = "-y",
) -> None:
    """Draw what stands in the workspace and write it as a PNG of 1200 x 1050 pixels.

    Args:
        cells: where parts stand as they should.
        grid: the workspace's size in cells along x, y and z.
        path: the file to write; its folder must exist.
        title: what it is.
        caption: a line about it.
        pitch_m: edge of a cell.
        wrong: where parts stand that should not, drawn red.
        missing: where parts should stand and do not, drawn as outlines.
        robot_side: the edge of the workspace at which the robot stands.

    Raises:
        UsageError: matplotlib is not installed, or the file cannot be written.
    """
    figure = new_figure(WIDTH_IN, HEIGHT_IN, DPI)
    axes = add_scene_axes(figure, (0.03, 0.02, 0.94, 0.83))

    good, bad, absent = set(cells) - set(wrong), set(wrong), set(missing)
    occupied = frozenset(good | bad)
    scene = Scene(axes, Camera(grid), grid)
    scene.floor(sorted(occupied), robot_side, pitch_m)
    # The camera is beyond the far corner on every axis, so this order is far to near.
    for cell in sorted(occupied | absent, key=lambda c: (c.z, c.y, c.x)):
        if cell in absent - occupied:
            scene.outline(cell)
        else:
            scene.part(cell, WRONG if cell in bad else PART, occupied)

    axes.autoscale_view()
    figure.text(0.05, 0.945, title, fontsize=20, color=INK, weight="bold", va="center")
    figure.text(0.05, 0.895, caption, fontsize=11.5, color=FAINT_INK, va="center")
    notes = []
    if bad:
        notes.append(f"red: {len(bad)} not where planned")
    if absent:
        notes.append(f"dotted: {len(absent)} missing")
    if notes:
        figure.text(0.05, 0.855, "; ".join(notes), fontsize=11.5, color=WRONG, va="center")
    save_png(figure, path)
