"""What becomes of each part of a plan, and which moments of a build are shown."""

from __future__ import annotations

import pytest

from cellctl.assembly import Cell, Step, StepKind
from cellctl.drawing.plan_steps import (
    FIRST_TO_LAST,
    STANDING,
    Life,
    lives_of,
    moments,
    order_colour,
)
from tests.cli.plans import BEAM, beam, changeover, placing, plan_of, standing_already, taking_apart


def standing(lives: tuple[Life, ...], steps: int) -> set[Cell]:
    return {life.cell for life in lives if life.stands_after(steps)}


def test_parts_stand_from_the_step_that_places_them_on() -> None:
    lives = lives_of(beam())
    for done in range(len(BEAM) + 1):
        assert standing(lives, done) == set(BEAM[:done])


def test_without_steps_everything_stood_before_and_no_moment_is_shown() -> None:
    plan = standing_already()
    assert standing(lives_of(plan), 0) == set(BEAM)
    assert moments(plan, 6) == ()


def test_what_is_taken_away_stood_before_and_what_has_no_step_stays() -> None:
    lives = lives_of(changeover())
    assert standing(lives, 0) == set(BEAM)
    assert standing(lives, 1) == set(BEAM[:3])
    assert standing(lives, 2) == set(BEAM[:2])
    assert standing(lives, 3) == {*BEAM[:2], Cell(0, 0, 2)}
    apart = lives_of(taking_apart())
    assert standing(apart, 0) == set(BEAM)
    assert standing(apart, len(BEAM)) == set()


def test_a_cell_that_is_emptied_and_filled_again_has_two_parts() -> None:
    removed = taking_apart().steps[:1]
    again = placing([BEAM[-1]])[0].model_copy(update={"index": 1})
    lives = lives_of(plan_of((*removed, again), BEAM))
    assert {(life.placed, life.removed) for life in lives if life.cell == BEAM[-1]} == {
        (None, 0),
        (1, None),
    }
    assert standing(lives, 1) == set(BEAM[:3])
    assert standing(lives, 2) == set(BEAM)


def test_colours_go_from_the_first_to_the_last_and_become_lighter() -> None:
    assert order_colour(0, 30) == FIRST_TO_LAST[0]
    assert order_colour(29, 30) == pytest.approx(FIRST_TO_LAST[-1])
    assert order_colour(None, 30) == STANDING
    assert order_colour(0, 1) == FIRST_TO_LAST[0]
    light = [
        0.2126 * r + 0.7152 * g + 0.0722 * b
        for r, g, b in (order_colour(k, 100) for k in range(100))
    ]
    assert light == sorted(light)


def tower(layers: int, wide: int) -> list[Cell]:
    return [Cell(x, 0, z) for z in range(layers) for x in range(wide)]


@pytest.mark.parametrize(
    ("layers", "wide", "expected"),
    [
        (6, 3, (3, 6, 9, 12, 15, 18)),  # each layer's end
        (12, 2, (4, 8, 12, 16, 20, 24)),  # every second layer's
        (2, 6, (1, 3, 4, 6, 9, 12)),  # layers in parts
        (1, 2, (1, 2)),  # fewer steps than moments
    ],
)
def test_moments_are_the_ends_of_layers_or_evenly_between(
    layers: int, wide: int, expected: tuple[int, ...]
) -> None:
    cells = tower(layers, wide)
    assert moments(plan_of(placing(cells), cells), 6) == expected


def test_what_stands_before_is_shown_whole_first() -> None:
    assert moments(taking_apart(), 6) == (0, 1, 2, 3, 4)
    assert moments(changeover(), 6)[0] == 0
    cells = tower(6, 3)
    apart = tuple(
        Step(index=index, kind=StepKind.REMOVE, cell=cell)
        for index, cell in enumerate(reversed(cells))
    )
    assert moments(plan_of(apart, ()), 6) == (0, 3, 6, 12, 15, 18)
