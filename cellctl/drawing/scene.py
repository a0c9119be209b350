"""Draws parts in the workspace, as what they are: cuboctahedra that touch at their square faces.

A small renderer of its own: on a grid and from a corner, drawing from the farthest cell to the
nearest is exact, which a general 3D plot does not offer.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any, Final, Literal

import numpy as np

from cellctl.assembly import Cell
from cellctl.drawing.cuboctahedron import Points, faces

Colour = tuple[float, float, float]
"""Red, green and blue from 0 to 1, as a screen shows them (sRGB)."""
Side = Literal["-x", "+x", "-y", "+y"]

PAPER: Final[Colour] = (0.975, 0.973, 0.965)
FLOOR: Final[Colour] = (0.925, 0.922, 0.910)
GRID_LINE: Final[Colour] = (0.80, 0.79, 0.77)
SHADOW: Final[Colour] = (0.80, 0.795, 0.785)
INK: Final[Colour] = (0.16, 0.18, 0.21)
FAINT_INK: Final[Colour] = (0.45, 0.46, 0.48)
PART: Final[Colour] = (0.18, 0.58, 0.64)
WRONG: Final[Colour] = (0.84, 0.22, 0.18)

AZIMUTH_RAD: Final = math.radians(32.0)
"""The camera stands beyond the far corner, so that -y, the robot's usual side, is at the back."""
ELEVATION_RAD: Final = math.radians(24.0)
DISTANCE: Final = 5.0
"""From the workspace's centre, in workspace diagonals; near enough for some perspective."""
LIGHT: Final = np.array([0.55, 0.35, 0.95]) / np.linalg.norm([0.55, 0.35, 0.95])
"""Direction towards the light."""


class Camera:
    """A pinhole that looks at the middle of the workspace from beyond its far corner."""

    def __init__(self, grid: tuple[int, int, int]) -> None:
        self.centre = np.array([grid[0] / 2.0, grid[1] / 2.0, grid[2] / 2.4])
        self.distance = DISTANCE * float(np.linalg.norm(grid))
        self.towards = np.array(
            [
                math.sin(AZIMUTH_RAD) * math.cos(ELEVATION_RAD),
                math.cos(AZIMUTH_RAD) * math.cos(ELEVATION_RAD),
                math.sin(ELEVATION_RAD),
            ]
        )
        self.position = self.centre + self.distance * self.towards
        right = np.cross([0.0, 0.0, 1.0], self.towards)
        self.right = right / np.linalg.norm(right)
        self.up = np.cross(self.towards, self.right)

    def project(self, points: Points) -> Points:
        """Points (n, 3) in cells -> picture coordinates (n, 2)."""
        seen = np.asarray(points, dtype=np.float64) - self.position
        depth = -(seen @ self.towards)
        scale = self.distance / depth
        return np.stack([(seen @ self.right) * scale, (seen @ self.up) * scale], axis=1)


def _light_on(cell: Cell, normal: Points, occupied: frozenset[Cell]) -> float:
    """How bright a face is, from 0 to about 1.15: sun, shade of other parts, and nooks."""
    unit = normal / np.linalg.norm(normal)
    start = np.array(cell) + 0.5 + 0.55 * unit
    steps = np.arange(0.15, 8.0, 0.2)[:, None]
    on_the_way = {Cell(*map(int, at)) for at in np.floor(start + steps * LIGHT)} - {cell}
    sun = 0.0 if on_the_way & occupied else max(0.0, float(unit @ LIGHT))
    sky = 0.5 + 0.5 * float(unit[2])
    step = np.sign(normal).astype(int)
    outward = [
        Cell(cell.x + dx, cell.y + dy, cell.z + dz)
        for dx, dy, dz in itertools.product((-1, 0, 1), repeat=3)
        if (dx, dy, dz) != (0, 0, 0) and int(step @ (dx, dy, dz)) > 0
    ]
    nook = sum(other in occupied or other.z < 0 for other in outward) / len(outward)
    return (0.50 + 0.26 * sky) * (1.0 - 0.36 * nook) + 0.50 * sun


def _closed_off(cell: Cell, normal: Points, occupied: frozenset[Cell]) -> bool:
    """Whether a face touches another part, or the hollow that it looks into is closed all around.

    A triangle looks into the hollow about a corner of the cell, which eight parts close.
    """
    steps = ((0, int(n)) if n else (0,) for n in normal)
    around = (Cell(cell.x + a, cell.y + b, cell.z + c) for a, b, c in itertools.product(*steps))
    return all(other in occupied for other in around)


@cache
def shadow_outline() -> Points:
    """The shade of a part about the origin on a floor through it: an octagon (8, 3)."""
    corners = {
        tuple(np.round(corner - LIGHT * corner[2] / LIGHT[2], 6))
        for _, face in faces()
        for corner in face
    }
    flat = np.array(sorted(corners))
    return np.asarray(flat[hull_of(flat[:, :2])])


def _shade(colour: Colour, brightness: float) -> Colour:
    """The colour in that light; beyond 0.9 it goes towards white."""
    base = np.array(colour) * min(brightness, 0.9) / 0.9
    glow = max(0.0, brightness - 0.75) * 0.9
    r, g, b = (float(v) for v in np.clip(base + (1.0 - base) * glow, 0.0, 1.0))
    return (r, g, b)


class Scene:
    """Everything that is drawn on one matplotlib axes, back to front."""

    def __init__(self, axes: Any, camera: Camera, grid: tuple[int, int, int]) -> None:
        self.axes = axes
        self.camera = camera
        self.grid = grid
        self.order = 0

    def polygon(self, points: Points, **style: Any) -> None:
        """One flat polygon, over everything drawn before it."""
        from matplotlib.patches import Polygon  # noqa: PLC0415 - an extra

        self.order += 1
        flat = self.camera.project(points)
        self.axes.add_patch(Polygon(flat, closed=True, zorder=self.order, **style))

    def line(self, start: Sequence[float], end: Sequence[float], **style: Any) -> None:
        """One straight line."""
        self.order += 1
        flat = self.camera.project(np.array([start, end], dtype=np.float64))
        self.axes.plot(flat[:, 0], flat[:, 1], zorder=self.order, **style)

    def floor_text(
        self,
        text: str,
        at: Points,
        along: Points,
        height: float,
        *,
        before: bool = False,
        **style: Any,
    ) -> None:
        """Words that lie on the floor in perspective, from a point on or ``before`` it."""
        from matplotlib.patches import PathPatch  # noqa: PLC0415 - an extra
        from matplotlib.path import Path as Outline  # noqa: PLC0415
        from matplotlib.textpath import TextPath  # noqa: PLC0415

        self.order += 1
        letters = TextPath((0, 0), text, size=height)
        letters_xy = np.asarray(letters.vertices)
        if before:
            letters_xy = letters_xy - [letters.get_extents().x1, 0.0]
        away = np.array([-along[1], along[0], 0.0])
        points = at + letters_xy[:, :1] * along + letters_xy[:, 1:] * away
        outline = Outline(self.camera.project(points), letters.codes)
        self.axes.add_patch(PathPatch(outline, zorder=self.order, linewidth=0, **style))

    def floor_plate(self, parts: Iterable[Cell]) -> None:
        """The workspace's floor with its grid, and the shade of parts on it."""
        nx, ny, _ = self.grid
        corners = np.array([[0, 0, 0], [nx, 0, 0], [nx, ny, 0], [0, ny, 0]], dtype=np.float64)
        self.polygon(corners, facecolor=FLOOR, edgecolor=GRID_LINE, linewidth=1.0)
        self._shadows(parts)
        for x in range(nx + 1):
            self.line((x, 0, 0), (x, ny, 0), color=GRID_LINE, linewidth=0.7)
        for y in range(ny + 1):
            self.line((0, y, 0), (nx, y, 0), color=GRID_LINE, linewidth=0.7)

    def floor(self, parts: Iterable[Cell], robot_side: Side, pitch_m: float) -> None:
        """As ``floor_plate``, with words: where the robot is, and how large the cells are."""
        self.floor_plate(parts)
        nx, ny, _ = self.grid
        start, end = {
            "-y": ((0, 0, 0), (nx, 0, 0)),
            "+y": ((0, ny, 0), (nx, ny, 0)),
            "-x": ((0, 0, 0), (0, ny, 0)),
            "+x": ((nx, 0, 0), (nx, ny, 0)),
        }[robot_side]
        self.line(start, end, color=INK, linewidth=3.0, solid_capstyle="round")
        # Letters read from left to right for the camera. They stand beyond the end of the edge
        # that is nearest to it, where nothing that is built can hide them.
        x_edge, y_edge = np.array([-1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
        if robot_side[1] == "y":
            at = np.array(end) - 0.2 * x_edge - 0.15 * y_edge
            self.floor_text("ROBOT", at, x_edge, 0.42, before=True, facecolor=INK)
        else:
            at = np.array(end) + 0.2 * y_edge - 0.15 * x_edge
            self.floor_text("ROBOT", at, y_edge, 0.42, facecolor=INK)
        if robot_side != "+y":
            at = np.array([nx - 0.1, ny + 0.55, 0.0])
            label = f"{nx} x {ny} cells of {pitch_m * 100:g} cm"
            self.floor_text(label, at, x_edge, 0.32, facecolor=FAINT_INK)

    def _shadows(self, parts: Iterable[Cell]) -> None:
        """The shade of all parts on the floor: of each its outline from the light."""
        from matplotlib.collections import PolyCollection  # noqa: PLC0415 - an extra

        self.order += 1
        nx, ny, _ = self.grid
        outlines = []
        for cell in parts:
            middle = np.array(cell) + 0.5
            outline = shadow_outline() + (middle - LIGHT * middle[2] / LIGHT[2])
            outline[:, 0] = np.clip(outline[:, 0], 0, nx)
            outline[:, 1] = np.clip(outline[:, 1], 0, ny)
            outlines.append(self.camera.project(outline))
        self.axes.add_collection(
            PolyCollection(
                outlines, facecolor=SHADOW, edgecolor=SHADOW, linewidth=0.3, zorder=self.order
            )
        )

    def part(self, cell: Cell, colour: Colour, occupied: frozenset[Cell]) -> None:
        """One part, in its place."""
        middle = np.array(cell) + 0.5
        edge = _shade(colour, 0.42)
        for normal, corners in faces():
            points = middle + corners
            if normal @ (self.camera.position - points.mean(axis=0)) <= 0.0:
                continue
            if _closed_off(cell, normal, occupied):
                continue
            brightness = _light_on(cell, normal, occupied)
            self.polygon(
                points,
                facecolor=_shade(colour, brightness),
                edgecolor=edge,
                linewidth=0.6,
                joinstyle="round",
            )

    def outline(self, cell: Cell) -> None:
        """Where a part should be and is not."""
        middle = np.array(cell) + 0.5
        for normal, corners in faces():
            points = middle + corners
            if normal @ (self.camera.position - points.mean(axis=0)) > 0.0:
                self.polygon(
                    points, facecolor=(*WRONG, 0.10), edgecolor=WRONG, linewidth=0.8, linestyle=":"
                )


def hull_of(points: Points) -> list[int]:
    """Indices of the convex hull of points (n, 2), counter-clockwise (Andrew's monotone chain)."""
    order = sorted(range(len(points)), key=lambda i: (points[i][0], points[i][1]))

    def chain(indices: Iterable[int]) -> list[int]:
        kept: list[int] = []
        for i in indices:
            while len(kept) > 1:
                a, b = points[kept[-1]] - points[kept[-2]], points[i] - points[kept[-2]]
                if a[0] * b[1] - a[1] * b[0] > 0.0:
                    break
                kept.pop()
            kept.append(i)
        return kept[:-1]

    return chain(order) + chain(reversed(order))
