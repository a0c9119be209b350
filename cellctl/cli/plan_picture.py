"""The steps of a plan as a picture: what it becomes, and how it grows, coloured by order."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from cellctl.assembly import BuildPlan, Cell, StepKind, Weakest
from cellctl.cli.picture import add_scene_axes, new_figure, save_png
from cellctl.drawing.plan_steps import Life, lives_of, moments, order_colour
from cellctl.drawing.scene import FAINT_INK, INK, PAPER, WRONG, Camera, Colour, Scene, Side

WIDTH_IN: Final = 15.0
HEIGHT_IN: Final = 9.0
DPI: Final = 140
MOMENTS: Final = 6

_MUTED: Final[Colour] = (0.80, 0.80, 0.79)
_MUTE: Final = 0.72
"""How far the parts of earlier panels go towards that grey."""
_MAIN: Final = (0.015, 0.09, 0.47, 0.76)
_ALONE: Final = (0.02, 0.05, 0.96, 0.82)
"""Where the object is drawn if no step leads to it."""
_PANELS: Final = (0.50, 0.035, 0.49, 0.87)
_LABEL_SHARE: Final = 0.13
"""The part of a panel's height that its label takes."""


def draw_steps(
    plan: BuildPlan,
    grid: tuple[int, int, int],
    path: Path,
    *,
    caption: str,
    robot_side: Side = "-y",
) -> None:
    """Draw the finished object and how it is built, and write it as a PNG of 2100 x 1260 pixels.

    Of an object that is taken apart, what stood there is drawn instead.

    Args:
        plan: what to draw; ``MOMENTS`` stages of it are shown, fewer if it has fewer steps, and
            without steps its object alone.
        grid: the workspace's size in cells along x, y and z.
        path: the file to write; its folder must exist.
        caption: a line about it.
        robot_side: the edge of the workspace at which the robot stands.

    Raises:
        UsageError: matplotlib is not installed, or the file cannot be written.
    """
    figure = new_figure(WIDTH_IN, HEIGHT_IN, DPI)
    lives = lives_of(plan)
    total = len(plan.steps)
    axes = add_scene_axes(figure, _MAIN if plan.steps else _ALONE)
    camera = Camera(grid)
    scene = Scene(axes, camera, grid)
    shown = {life.cell: life for life in lives if life.stands_after(total)}
    colours = {cell: order_colour(life.placed, total) for cell, life in shown.items()}
    if not shown:  # all is taken away: what stood there, by the step that takes each part
        shown = {life.cell: life for life in lives if life.placed is None}
        colours = {cell: order_colour(life.removed, total) for cell, life in shown.items()}
    scene.floor(sorted(shown), robot_side, plan.pitch_m)
    _parts(scene, shown, colours)
    if plan.weakest is not None:
        _mark(scene, plan.weakest)
    axes.autoscale_view()
    if plan.steps:
        _panels(figure, plan, lives, camera, grid)
        _legend(figure, plan)
    size = 24.0 if len(plan.title) < 32 else 15.0
    title = plan.title if len(plan.title) < 60 else f"{plan.title[:57]}..."
    figure.text(0.03, 0.945, title, fontsize=size, color=INK, weight="bold", va="center")
    figure.text(0.03, 0.897, caption, fontsize=13, color=FAINT_INK, va="center")
    save_png(figure, path)


def _parts(scene: Scene, here: dict[Cell, Life], colours: dict[Cell, Colour]) -> None:
    occupied = frozenset(here)
    # The camera is beyond the far corner on every axis, so this order is far to near.
    for cell in sorted(here, key=lambda c: (c.z, c.y, c.x)):
        scene.part(cell, colours[cell], occupied)


def _muted(colour: Colour) -> Colour:
    r, g, b = (c + (m - c) * _MUTE for c, m in zip(colour, _MUTED, strict=True))
    return (r, g, b)


def _panels(
    figure: Any,
    plan: BuildPlan,
    lives: Sequence[Life],
    camera: Camera,
    grid: tuple[int, int, int],
) -> None:
    """The build after some of its steps; what is new in a panel has its full colour."""
    total = len(plan.steps)
    window = _window(camera, grid, [life.cell for life in lives])
    at = moments(plan, MOMENTS)
    columns = math.ceil(math.sqrt(len(at)))
    rows = math.ceil(len(at) / columns)
    left, bottom, width, height = _PANELS
    for k, (before, now) in enumerate(zip((0, *at), at, strict=False)):
        row, column = divmod(k, columns)
        corner = (left + column * width / columns, bottom + (rows - 1 - row) * height / rows)
        share = 1.0 - _LABEL_SHARE
        under = height / rows * _LABEL_SHARE
        box = (corner[0], corner[1] + under, width / columns, height / rows * share)
        axes = add_scene_axes(figure, box)
        scene = Scene(axes, camera, grid)
        here = {life.cell: life for life in lives if life.stands_after(now)}
        scene.floor_plate(sorted(here))
        colours = {
            cell: order_colour(life.placed, total)
            if now == 0 or (life.placed is not None and life.placed >= before)
            else _muted(order_colour(life.placed, total))
            for cell, life in here.items()
        }
        _parts(scene, here, colours)
        axes.set_xlim(*window[0])
        axes.set_ylim(*window[1])
        axes.set_anchor("S")
        figure.text(
            corner[0] + 0.5 * width / columns,
            corner[1] + 0.6 * under,
            _words(plan, before, now),
            fontsize=11.5 if columns < 3 else 10.5,
            color=INK,
            ha="center",
            va="center",
        )


def _window(
    camera: Camera, grid: tuple[int, int, int], cells: Sequence[Cell]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """The part of the picture plane (x, y) that shows the floor and all of these cells."""
    nx, ny, _ = grid
    corners = [np.array([(0, 0, 0), (nx, 0, 0), (nx, ny, 0), (0, ny, 0)], dtype=np.float64)]
    corners += [np.array(list(itertools.product(*((c, c + 1) for c in cell)))) for cell in cells]
    flat = camera.project(np.concatenate(corners))
    low, high = flat.min(axis=0) - 0.2, flat.max(axis=0) + 0.2
    return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))


def _words(plan: BuildPlan, before: int, now: int) -> str:
    """What happens between two moments: ``parts 9 to 14, layer 2``."""
    if now == 0:
        return "to begin with"
    steps = plan.steps[before:now]
    counts = f"{before + 1}" if now == before + 1 else f"{before + 1} to {now}"
    some = "s" if now > before + 1 else ""
    kinds = {step.kind for step in plan.steps}
    what = f"part{some}" if kinds == {StepKind.PLACE} else f"step{some}"
    layers = sorted({step.cell.z for step in steps})
    where = f"layer {layers[0]}" if len(layers) == 1 else f"layers {layers[0]} to {layers[-1]}"
    return f"{what} {counts}, {where}"


def _mark(scene: Scene, weakest: Weakest) -> None:
    """A red diamond at the weakest joint, seen through whatever hides it, and what it is."""
    a, b = np.array(weakest.cell) + 0.5, np.array(weakest.other) + 0.5
    middle = (a + b) / 2.0
    axis = int(np.argmax(np.abs(b - a)))
    corners = np.tile(middle, (4, 1))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    corners[[0, 2], u] += (0.5, -0.5)
    corners[[1, 3], v] += (0.5, -0.5)
    scene.polygon(corners, facecolor=(*WRONG, 0.35), edgecolor=PAPER, linewidth=4.5)
    scene.polygon(corners, facecolor="none", edgecolor=WRONG, linewidth=2.2)
    spot = scene.camera.project(middle[None, :])[0]
    scene.axes.annotate(
        f"weakest joint\nmargin {weakest.margin:.2f}, in step {weakest.step + 1}",
        xy=spot,
        xycoords="data",
        xytext=(0.51, 0.925),
        textcoords="figure fraction",
        ha="left",
        va="center",
        fontsize=11.5,
        color=WRONG,
        linespacing=1.4,
        zorder=scene.order + 1,
        arrowprops={
            "arrowstyle": "-",
            "color": WRONG,
            "linewidth": 1.2,
            "relpos": (0.0, 0.5),
            "shrinkB": 7.0,
            "connectionstyle": "arc3,rad=0.2",
        },
    )


def _legend(figure: Any, plan: BuildPlan) -> None:
    """A bar from the first step's colour to the last one's."""
    total = len(plan.steps)
    axes = figure.add_axes((0.12, 0.052, 0.26, 0.014))
    axes.set_axis_off()
    colours = np.array([[order_colour(k, total) for k in range(total)]])
    axes.imshow(colours, aspect="auto", interpolation="nearest")
    style = {"fontsize": 11.5, "color": FAINT_INK, "va": "center"}
    figure.text(0.113, 0.059, "first", ha="right", **style)
    figure.text(0.387, 0.059, f"last, step {total}", ha="left", **style)
