from __future__ import annotations

import pytest

from cellctl.listening.dimensions import read_sizes
from cellctl.listening.numbers import read_number


@pytest.mark.parametrize(
    ("words", "value", "used"),
    [
        ("two", 2.0, 1),
        ("12 legs", 12.0, 1),
        ("thirty five legs", 35.0, 2),
        ("a hundred chairs", 100.0, 2),
        ("two hundred and fifty", 250.0, 4),
        ("hundred and", 100.0, 1),
        ("a couple of chairs", 2.0, 3),
        ("a dozen", 12.0, 2),
        ("half a metre", 0.5, 2),
        ("one and a half metres", 1.5, 4),
        ("one point five", 1.5, 3),
        ("1.25", 1.25, 1),
        ("two three", 2.0, 1),
    ],
)
def test_numbers_are_read_as_far_as_they_go(words: str, value: float, used: int) -> None:
    assert read_number(words.split(), 0) == (value, used)


@pytest.mark.parametrize("words", ["", "a stool", "to", "legs", "and a half"])
def test_what_is_no_number_is_none(words: str) -> None:
    assert read_number(words.split(), 0) is None


@pytest.mark.parametrize(
    ("words", "metres"),
    [
        ("a tower half a metre high", {"height": 0.5}),
        ("a tower half a meter high", {"height": 0.5}),
        ("60 cm wide", {"width": 0.6}),
        ("one meter tall", {"height": 1.0}),
        ("a metre and a half tall", {"height": 1.5}),
        ("one and a half meters long", {"width": 1.5}),
        ("forty centimeters deep and sixty centimeters wide", {"depth": 0.4, "width": 0.6}),
        ("30 by 40 by 80 cm", {"width": 0.3, "depth": 0.4, "height": 0.8}),
        ("thirty centimeters by forty centimeters", {"width": 0.3, "depth": 0.4}),
        ("an eighteen inch stool", {"height": 0.4572}),
        ("two feet high", {"height": 0.6096}),
        ("with a height of 50 cm", {"height": 0.5}),
        ("50 cm in width", {"width": 0.5}),
        ("800 mm wide", {"width": 0.8}),
        ("ten blocks high", {"height": 1.0}),
        ("3 by 2 by 4 blocks", {"width": 0.3, "depth": 0.2, "height": 0.4}),
        ("40 cm high no 50 cm high", {"height": 0.5}),
        ("four legs", {}),
        ("three blocks", {}),
        ("0 cm high", {}),
        ("900 meters high", {}),
        ("tall", {}),
    ],
)
def test_stated_sizes_in_metres(words: str, metres: dict[str, float]) -> None:
    assert read_sizes(words.split(), pitch_m=0.10).metres == metres


def test_a_block_is_as_large_as_the_cells_voxel() -> None:
    assert read_sizes(["ten", "blocks", "high"], pitch_m=0.05).metres == {"height": 0.5}
