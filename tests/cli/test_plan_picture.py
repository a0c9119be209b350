"""The picture of the steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from matplotlib.image import imread

from cellctl.assembly import BuildPlan
from cellctl.cli.plan_picture import DPI, HEIGHT_IN, WIDTH_IN, draw_steps
from cellctl.errors import UsageError
from tests.cli.plans import beam, changeover, placing, plan_of, standing_already, taking_apart

GRID = (4, 3, 4)


def draw(path: Path, plan: BuildPlan) -> npt.NDArray[np.int16]:
    draw_steps(plan, GRID, path, caption="four parts")
    return np.asarray(imread(path)[..., :3] * 255.0, dtype=np.int16)


def red(pixels: npt.NDArray[np.int16]) -> int:
    """How many pixels are clearly the red of the mark, which no part has."""
    r, g, b = (pixels[..., k] for k in range(3))
    return int(np.sum((r - g > 80) & (r - b > 80)))


def yellow(pixels: npt.NDArray[np.int16]) -> int:
    """How many pixels are clearly those of the last part."""
    r, g, b = (pixels[..., k] for k in range(3))
    return int(np.sum((r - b > 90) & (g - b > 60)))


def test_the_weakest_joint_is_red_and_nothing_else(tmp_path: Path) -> None:
    marked = draw(tmp_path / "marked.png", beam())
    plain = draw(tmp_path / "plain.png", beam().model_copy(update={"weakest": None}))
    assert marked.shape == (round(HEIGHT_IN * DPI), round(WIDTH_IN * DPI), 3)
    assert red(marked) > 500
    assert red(plain) == 0


def test_the_last_part_is_in_the_object_and_in_the_last_panel_only(tmp_path: Path) -> None:
    pixels = draw(tmp_path / "steps.png", beam().model_copy(update={"weakest": None}))
    height, width, _ = pixels.shape
    above_the_legend = pixels[: round(height * 0.9)]
    assert yellow(above_the_legend[:, : width // 2]) > 1000
    panels = pixels[:, width // 2 :]
    last = panels[height // 2 :, width // 4 :]
    assert yellow(last) > 300
    assert yellow(panels) == yellow(last)


@pytest.mark.parametrize("plan", [changeover(), taking_apart()], ids=["changeover", "apart"])
def test_plans_that_take_away_can_be_drawn(tmp_path: Path, plan: BuildPlan) -> None:
    pixels = draw(tmp_path / "steps.png", plan)
    # Everything but the paper, which is the same grey in all corners and hardly coloured.
    height, width, _ = pixels.shape
    for half in (pixels[: height // 2, width // 2 :], pixels[:, : width // 2]):
        assert int(np.sum(np.abs(half - pixels[0, 0]).max(axis=2) > 20)) > 5000


def test_what_is_taken_apart_is_drawn_whole_in_colours_of_the_order(tmp_path: Path) -> None:
    pixels = draw(tmp_path / "steps.png", taking_apart())
    height, width, _ = pixels.shape
    assert yellow(pixels[: round(height * 0.9), : width // 2]) > 1000


def test_a_plan_without_steps_is_drawn_as_its_object_alone(tmp_path: Path) -> None:
    pixels = draw(tmp_path / "steps.png", standing_already())
    inked = np.abs(pixels - pixels[0, 0]).max(axis=2) > 20
    inked[: inked.shape[0] // 5] = False  # title and caption
    columns = np.flatnonzero(inked.any(axis=0))
    assert abs(columns.mean() / pixels.shape[1] - 0.5) < 0.1  # in the middle, and nothing beside it
    assert inked.sum() > 20000


def test_one_part_and_a_long_title_can_be_drawn(tmp_path: Path) -> None:
    cells = beam().assembly.cells[:1]
    plan = plan_of(placing(cells), cells).model_copy(update={"title": "beam " * 40})
    assert draw(tmp_path / "one.png", plan).shape[0] == round(HEIGHT_IN * DPI)


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"nowhere/x\.png: the picture cannot be written"):
        draw_steps(beam(), GRID, tmp_path / "nowhere" / "x.png", caption="")
