"""A picture of an object as SVG: the scene of ``scene``, drawn without a plotting library."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any, Final

import numpy as np

from cellctl.assembly import Cell
from cellctl.drawing.cuboctahedron import Points
from cellctl.drawing.scene import (
    FAINT_INK,
    INK,
    LIGHT,
    PAPER,
    PART,
    SHADOW,
    Camera,
    Colour,
    Scene,
    shadow_outline,
)

WIDTH: Final = 1200.0
MARGIN: Final = 60.0
HEADING: Final = 150.0
"""Above the scene, for title and caption."""
LINE: Final = 1.6
"""Width of a line, for each unit of the plotting library's."""


class SvgScene(Scene):
    """Collects polygons and lines, back to front; y is down in the end."""

    def __init__(self, camera: Camera, grid: tuple[int, int, int]) -> None:
        super().__init__(None, camera, grid)
        self._drawn: list[tuple[str, Points, str]] = []

    def polygon(self, points: Points, **style: Any) -> None:
        """One flat polygon, over everything drawn before it."""
        self._drawn.append(("polygon", self.camera.project(points), _paint(**style)))

    def line(self, start: Sequence[float], end: Sequence[float], **style: Any) -> None:
        """One straight line."""
        flat = self.camera.project(np.array([start, end], dtype=np.float64))
        colour, width = style["color"], style["linewidth"]
        self._drawn.append(
            (
                "polyline",
                flat,
                f'fill="none" stroke="{_hex(colour)}" stroke-width="{width * LINE:g}"',
            )
        )

    def _shadows(self, parts: Iterable[Cell]) -> None:
        nx, ny, _ = self.grid
        for cell in parts:
            middle = np.array(cell) + 0.5
            outline = shadow_outline() + (middle - LIGHT * middle[2] / LIGHT[2])
            outline[:, 0] = np.clip(outline[:, 0], 0, nx)
            outline[:, 1] = np.clip(outline[:, 1], 0, ny)
            self.polygon(outline, facecolor=SHADOW, edgecolor=SHADOW, linewidth=0.3)

    def finish(self, title: str, caption: str) -> str:
        """The document: everything fitted below a title and a line about it."""
        everything = np.concatenate([points for _, points, _ in self._drawn])
        low, high = everything.min(axis=0), everything.max(axis=0)
        scale = (WIDTH - 2 * MARGIN) / float(high[0] - low[0])
        height = HEADING + float(high[1] - low[1]) * scale + MARGIN
        body = []
        for tag, points, paint in self._drawn:
            x = MARGIN + (points[:, 0] - low[0]) * scale
            y = HEADING + (high[1] - points[:, 1]) * scale
            at = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
            body.append(f'<{tag} points="{at}" {paint}/>')
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {height:.0f}" '
            f'width="{WIDTH:g}" height="{height:.0f}" stroke-linejoin="round" '
            'font-family="Roboto, system-ui, sans-serif">'
            f'<rect width="100%" height="100%" fill="{_hex(PAPER)}"/>'
            f'<text x="{MARGIN:g}" y="80" font-size="44" font-weight="700" fill="{_hex(INK)}">'
            f"{escape(title)}</text>"
            f'<text x="{MARGIN:g}" y="122" font-size="26" fill="{_hex(FAINT_INK)}">'
            f"{escape(caption)}</text>{''.join(body)}</svg>"
        )


def assembly_svg(
    cells: Iterable[Cell], grid: tuple[int, int, int], *, title: str, caption: str
) -> str:
    """A picture of parts in the workspace.

    Args:
        cells: where they stand; at least one.
        grid: the workspace's size in cells along x, y and z.
        title: what it is.
        caption: a line about it.
    """
    parts = sorted(cells, key=lambda c: (c.z, c.y, c.x))
    occupied = frozenset(parts)
    scene = SvgScene(Camera(grid), grid)
    scene.floor_plate(parts)
    # The camera is beyond the far corner on every axis, so this order is far to near.
    for cell in parts:
        scene.part(cell, PART, occupied)
    return scene.finish(title, caption)


def _paint(facecolor: Colour, edgecolor: Colour, linewidth: float, **_: Any) -> str:
    return (
        f'fill="{_hex(facecolor)}" stroke="{_hex(edgecolor)}" stroke-width="{linewidth * LINE:g}"'
    )


def _hex(colour: Colour) -> str:
    return "#" + "".join(f"{round(255 * min(1.0, max(0.0, share))):02x}" for share in colour[:3])
