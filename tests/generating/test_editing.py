"""Edits change a description, and the change is counted in the cells."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cellctl.assembly import Attribute, Edit, Intent, Request
from cellctl.config import load_config
from cellctl.description import FamilyDescription, PartsDescription, SpherePart
from cellctl.errors import DesignError
from cellctl.generating.describing import draw, realise
from cellctl.generating.editing import change, edited
from cellctl.generating.families import BY_NAME, FAMILIES
from cellctl.generating.families.brief import Count, Flag
from cellctl.listening.understanding.embedded import EmbeddedInterpreter
from cellctl.listening.understanding.interpreter import DEFAULT_SETTING
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import fit
from cellctl.validating.rules import size_of
from tests.generating.counting import Cells, eaves, feet, from_front, neck, tail, tiers
from tests.generating.test_families import COUNTERS

CONFIG = load_config(Path(__file__).parents[2] / "config" / "sim.toml")
Made = FamilyDescription | PartsDescription


def wish(*edits: Edit, phrase: str = "false", objects: tuple[str, ...] = ()) -> Request:
    return Request(text="an edit", intent=Intent.EDIT, phrase=phrase, objects=objects, edits=edits)


def family(name: str, height_m: float | None = None, **attributes: Attribute) -> FamilyDescription:
    sizes = {} if height_m is None else {"height": height_m}
    return FamilyDescription(family=name, attributes=attributes, size_m=sizes)  # type: ignore[arg-type]


def cells(description: Made) -> Cells:
    return from_front(discretise(fit(realise(description, CONFIG), CONFIG).shape))


def test_taller_is_one_part_taller_and_keeps_the_rest() -> None:
    stool = family("stool", 0.4, legs=4)
    taller = edited(stool, wish(Edit(op="scale", axis="height", direction="+")), CONFIG)
    before, after = size_of(cells(stool)), size_of(cells(taller))
    assert after == (before[0], before[1], before[2] + 1)
    assert feet(cells(taller)) == 4


@pytest.mark.parametrize(
    ("edit", "height"),
    [
        (Edit(op="scale", axis="height", direction="-", amount=2, unit="voxels"), 3),
        (Edit(op="scale", axis="height", direction="-", amount=0.2, unit="metres"), 3),
        (Edit(op="set", axis="height", amount=0.3, unit="metres"), 3),
        (Edit(op="scale", axis="height", direction="-", amount=2, unit="times"), 2),
        (Edit(op="scale", part="leg", attribute="legs", axis="length", direction="-"), 4),
    ],
)
def test_a_stated_change_of_height(edit: Edit, height: int) -> None:
    assert size_of(cells(edited(family("stool", 0.5), wish(edit), CONFIG)))[2] == height


@pytest.mark.parametrize("name", [family.name for family in FAMILIES])
def test_each_family_can_be_changed_as_it_was_designed(name: str) -> None:
    """What a family decided on by itself is taken back when its description is made again."""
    wanted = family(name, glyph="T") if name == "letter" else family(name)
    designed = realise(wanted, CONFIG)
    assert isinstance(designed.description, FamilyDescription)
    again = realise(designed.description, CONFIG)
    assert again.title.startswith(designed.title)
    assert np.array_equal(again.vertices, designed.vertices)


def test_two_more_tiers_are_two_more_even_where_a_height_was_stated() -> None:
    shelf = family("shelf", 0.3, tiers=1)
    assert tiers(cells(shelf)) == 1
    more = edited(
        shelf, wish(Edit(op="add", part="tier", attribute="tiers", amount=2, unit="parts")), CONFIG
    )
    assert tiers(cells(more)) == 3


@pytest.mark.parametrize(
    ("edit", "values"),
    [
        (Edit(op="set", attribute="legs", value=3), {"legs": 3}),
        (Edit(op="add", part="leg", attribute="legs"), {"legs": 5}),
        (Edit(op="remove", part="leg", attribute="legs", amount=2, unit="parts"), {"legs": 2}),
        (Edit(op="remove", part="back", attribute="back"), {"back": False}),
        (Edit(op="add", part="arm", attribute="arms"), {"arms": True}),
    ],
)
def test_attributes_are_set_added_and_removed(edit: Edit, values: dict[str, Attribute]) -> None:
    changed = edited(family("chair"), wish(edit), CONFIG)
    assert isinstance(changed, FamilyDescription)
    assert changed.attributes.items() >= values.items()
    assert cells(changed) != cells(family("chair"))


def test_another_object_takes_over_the_stated_sizes() -> None:
    bench = edited(
        family("stool", 0.3), wish(Edit(op="replace"), phrase="bench", objects=("bench",)), CONFIG
    )
    assert isinstance(bench, FamilyDescription)
    assert bench.family == "bench"
    assert size_of(cells(bench))[2] == 3


def test_parts_grow_alike() -> None:
    ball = PartsDescription(title="ball", parts=(SpherePart(radius_m=0.1, at_m=(0.1, 0.0, 0.1)),))
    larger = edited(ball, wish(Edit(op="scale", direction="+", amount=2, unit="times")), CONFIG)
    assert np.allclose(np.ptp(realise(larger, CONFIG).vertices, axis=0), 0.4, atol=0.01)
    with pytest.raises(DesignError, match="size only"):
        edited(ball, wish(Edit(op="add", part="leg", attribute="legs")), CONFIG)


@pytest.mark.parametrize(
    ("description", "edit", "said"),
    [
        (family("tower", 0.6), Edit(op="scale", axis="height", direction="+"), "all the room"),
        (family("stool"), Edit(op="add", part="drawer", attribute="drawers"), "drawers of a stool"),
        (family("stool"), Edit(op="set", attribute="legs", value=3), "like that already"),
        (family("stool"), Edit(op="set", attribute="legs", value=20), "at most 9"),
        (family("table"), Edit(op="remove", part="leg", attribute="legs"), "at least one leg"),
        (family("shelf"), Edit(op="add", attribute="tiers", amount=5, unit="parts"), "at most"),
        (family("snake"), Edit(op="scale", axis="width", direction="+"), "all the room"),
        (family("heart"), Edit(op="scale", axis="width", direction="+"), "cannot be made"),
        (family("stool"), Edit(op="replace"), "cannot make"),
    ],
)
def test_what_cannot_be_changed_is_said(description: Made, edit: Edit, said: str) -> None:
    with pytest.raises(DesignError) as refusal:
        edited(description, wish(edit), CONFIG)
    assert said in str(refusal.value)


def test_an_edit_without_a_change_is_asked_about() -> None:
    with pytest.raises(DesignError, match="what to change"):
        edited(family("stool"), wish(), CONFIG)


def asked(sentence: str) -> Request:
    """A visitor's sentence, which wants a change."""
    request = EmbeddedInterpreter().interpret(sentence, DEFAULT_SETTING)
    assert request.intent is Intent.EDIT, request.why
    return request


def said(description: Made, sentence: str) -> Made:
    """A description as a visitor's sentence changes it."""
    return edited(description, asked(sentence), CONFIG)


def as_designed(name: str) -> FamilyDescription:
    return family(name, glyph="R") if "glyph" in BY_NAME[name].takes else family(name)


FURNITURE = ("stool", "chair", "bench", "table", "desk", "coffee table", "box", "tower", "wall")
SIZES: dict[str, tuple[int, Callable[[int], int]]] = {
    "wider": (0, lambda cells: cells + 1),
    "make it two blocks narrower": (0, lambda cells: cells - 2),
    "could it be deeper": (1, lambda cells: cells + 1),
    "make it a block taller": (2, lambda cells: cells + 1),
    "same again but lower": (2, lambda cells: cells - 1),
    "half that height would be better": (2, lambda cells: round(cells / 2)),
}
"""Index of the size that each changes, and how many cells it then has."""


def check_size(name: str, sentence: str) -> bool:
    """Whether a size is changed as said; what is changed less is the nearest that there can be."""
    index, wanted = SIZES[sentence]
    before = size_of(cells(as_designed(name)))
    try:
        changed = said(as_designed(name), sentence)
    except DesignError:
        return False
    after = size_of(cells(changed))
    least, most = sorted((before[index], wanted(before[index])))
    assert after[index] != before[index]
    assert least <= after[index] <= most, (name, sentence, before, after)
    return after[index] == wanted(before[index])


@pytest.mark.parametrize("sentence", SIZES)
def test_a_spoken_change_of_size_is_in_the_cells(sentence: str) -> None:
    made = {name for name in FURNITURE if check_size(name, sentence)}
    assert len(made) >= 4


@pytest.mark.soak
@pytest.mark.parametrize("name", [family.name for family in FAMILIES])
def test_each_family_is_changed_in_size_or_says_why_not(name: str) -> None:
    for sentence in SIZES:
        check_size(name, sentence)


SAID_OF_COUNTS = {
    "legs": "can we have {} legs instead of {}",
    "tiers": "make it {} tiers, not {}",
    "steps": "{} steps rather than {} please",
    "drawers": "only {} drawers instead of {}",
    "arches": "it should have {} arches instead of {}",
}


@pytest.mark.parametrize(
    ("name", "attribute"),
    [
        (each.name, attribute)
        for each in FAMILIES
        for attribute, known in each.takes.items()
        if isinstance(known, Count) and known.most > known.least and attribute in SAID_OF_COUNTS
    ],
)
def test_a_spoken_number_is_counted_in_the_cells(name: str, attribute: str) -> None:
    before = draw(as_designed(name), CONFIG)[1][attribute]
    assert isinstance(before, int)
    wanted = before + 1 if before < 2 or name in ("chair", "armchair") else before - 1
    sentence = SAID_OF_COUNTS[attribute].format(wanted, before)
    assert COUNTERS[name, attribute](cells(said(as_designed(name), sentence))) == wanted


@pytest.mark.parametrize(
    ("name", "attribute"),
    [
        (each.name, attribute)
        for each in FAMILIES
        for attribute, known in each.takes.items()
        if isinstance(known, Flag)
    ],
)
def test_a_part_is_put_on_and_left_out_by_word(name: str, attribute: str) -> None:
    there = said(family(name, **{attribute: False}), f"add {attribute.replace('back', 'a back')}")
    absent = said(there, f"without the {attribute}")
    assert isinstance(there, FamilyDescription)
    assert isinstance(absent, FamilyDescription)
    assert (there.attributes[attribute], absent.attributes[attribute]) == (True, False)
    assert cells(there) != cells(absent)


@pytest.mark.parametrize(
    ("name", "sentence", "count", "number"),
    [
        ("shelf", "one more tier", tiers, 3),
        ("bookcase", "one tier fewer", tiers, 2),
        ("table", "three legs would be better", feet, 3),
        ("house", "could the roof be steeper", eaves, 2),
        ("giraffe", "give it a longer neck", neck, 3),
        ("dinosaur", "make the neck shorter", neck, 2),
        ("dog", "the tail should be longer", tail, 2),
    ],
)
def test_a_spoken_change_of_a_part_is_in_the_cells(
    name: str, sentence: str, count: Callable[[Cells], int], number: int
) -> None:
    assert count(cells(as_designed(name))) != number
    assert count(cells(said(as_designed(name), sentence))) == number


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("stool", "make the seat thicker"),
        ("tower", "could the roof be steeper"),
        ("chair", "give it a longer neck"),
        ("giraffe", "without the back"),
    ],
)
def test_a_part_that_is_not_there_is_not_changed(name: str, sentence: str) -> None:
    with pytest.raises(DesignError) as refusal:
        said(as_designed(name), sentence)
    assert "I can change: its sizes" in refusal.value.hint


def test_smaller_leaves_what_is_one_part_deep() -> None:
    wall = family("wall")
    smaller = size_of(cells(said(wall, "smaller please")))
    assert smaller == tuple(size - (size > 1) for size in size_of(cells(wall)))


def corners(description: Made) -> set[tuple[float, ...]]:
    """Of its shape, from the middle of its floor."""
    points = realise(description, CONFIG).vertices
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return {tuple(point) for point in np.round(points - [*middle[:2], 0.0], 3) + 0.0}


ARMCHAIR, WORM = (
    family("armchair"),
    PartsDescription(
        title="worm",
        parts=tuple(SpherePart(radius_m=0.1, at_m=(0.15 * i, 0.1 * i * i, 0.1)) for i in range(3)),
    ),
)


@pytest.mark.parametrize("description", [ARMCHAIR, WORM], ids=["family", "parts"])
def test_it_is_turned_round_and_by_quarters(description: Made) -> None:
    left, around = said(description, "turn it to the left"), said(description, "turn it round")
    assert corners(left) == {(-y + 0.0, x, z) for x, y, z in corners(description)}
    assert corners(around) == {(-x + 0.0, -y + 0.0, z) for x, y, z in corners(description)}
    assert corners(around) != corners(description) != corners(left)
    back = said(said(around, "rotate it by ninety degrees"), "rotate it clockwise")
    assert corners(back) == corners(description)
    with pytest.raises(DesignError, match="by a quarter"):
        said(description, "turn it by twenty degrees")


def test_what_lies_across_has_the_room_and_the_sizes_of_that_way() -> None:
    sofa = realise(said(said(family("sofa"), "rotate it"), "make it forty cm wide"), CONFIG)
    assert np.allclose(np.ptp(sofa.vertices, axis=0)[1], 0.4)
    assert sofa.stated_dimensions_m == {"depth": 0.4}
    with pytest.raises(DesignError, match="all the room"):
        said(said(family("sofa"), "rotate it"), "make it sixty cm wide")


def test_changes_are_taken_back_one_after_the_other() -> None:
    stool = realise(family("stool"), CONFIG)
    taller = change(stool, asked("make it taller"), CONFIG)
    bench = change(taller, asked("make it a bench"), CONFIG)
    assert bench.title.startswith("bench")
    once = change(bench, asked("undo that"), CONFIG)
    assert once.description == taller.description
    wide = change(once, asked("make it as it was before and make it wider"), CONFIG)
    assert wide.description is not None
    assert corners(wide.description) == corners(said(family("stool"), "make it wider"))
    twice = change(once, asked("put it back as it was"), CONFIG)
    assert twice.description == stool.description
    with pytest.raises(DesignError, match="Nothing was changed"):
        change(twice, asked("undo"), CONFIG)
