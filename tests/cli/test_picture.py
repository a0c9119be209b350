"""The picture of what stands: a PNG that shows parts, wrong parts and missing ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from matplotlib.image import imread

from cellctl.assembly import Cell
from cellctl.cli.picture import DPI, HEIGHT_IN, WIDTH_IN, draw_assembly
from cellctl.drawing.scene import Side
from cellctl.errors import UsageError

GRID = (6, 5, 6)
COLUMN = [Cell(2, 2, z) for z in range(3)]


def draw(path: Path, cells: list[Cell], **options: list[Cell] | Side) -> npt.NDArray[np.int16]:
    draw_assembly(
        cells,
        GRID,
        path,
        title="A column",
        caption="three parts",
        pitch_m=0.1,
        **options,  # type: ignore[arg-type]
    )
    assert path.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    return np.asarray(imread(path)[..., :3] * 255.0, dtype=np.int16)


def count_like(pixels: npt.NDArray[np.int16], name: str) -> int:
    """How many pixels are clearly teal (parts) or red (wrong parts, outlines, notes)."""
    red, green = pixels[..., 0], pixels[..., 1]
    return int(np.sum(green - red > 40) if name == "teal" else np.sum(red - green > 60))


def test_parts_are_drawn_and_nothing_is_red(tmp_path: Path) -> None:
    one = draw(tmp_path / "one.png", COLUMN[:1])
    three = draw(tmp_path / "three.png", COLUMN)
    assert three.shape == (round(HEIGHT_IN * DPI), round(WIDTH_IN * DPI), 3)
    assert count_like(three, "teal") > 2 * count_like(one, "teal") > 0
    assert count_like(three, "red") == 0


def test_wrong_parts_are_red(tmp_path: Path) -> None:
    pixels = draw(tmp_path / "wrong.png", COLUMN, wrong=[Cell(4, 4, 0)])
    assert count_like(pixels, "red") > 5000


def test_a_wrong_part_that_is_also_listed_as_standing_is_red(tmp_path: Path) -> None:
    pixels = draw(tmp_path / "all.png", COLUMN, wrong=COLUMN)
    assert count_like(pixels, "teal") == 0
    assert count_like(pixels, "red") > 5000


def test_missing_parts_are_outlined(tmp_path: Path) -> None:
    pixels = draw(tmp_path / "missing.png", COLUMN[:2], missing=COLUMN[2:])
    assert 100 < count_like(pixels, "red") < 10_000


def test_an_empty_workspace_has_a_picture_too(tmp_path: Path) -> None:
    assert count_like(draw(tmp_path / "empty.png", []), "teal") == 0


@pytest.mark.parametrize("side", ["-x", "+x", "-y", "+y"])
def test_the_robots_side_is_marked(tmp_path: Path, side: Side) -> None:
    other: Side = "-y" if side != "-y" else "-x"
    here, there = (draw(tmp_path / "side.png", [], robot_side=name) for name in (side, other))
    assert np.any(here != there)


def test_a_folder_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"nowhere/x\.png: the picture cannot be written"):
        draw(tmp_path / "nowhere" / "x.png", COLUMN)
