"""Edits change a description, and the change is counted in the cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cellctl.assembly import Attribute, Edit, Intent, Request
from cellctl.config import load_config
from cellctl.description import FamilyDescription, PartsDescription, SpherePart
from cellctl.errors import DesignError
from cellctl.generating.describing import realise
from cellctl.generating.editing import edited
from cellctl.generating.families import FAMILIES
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import fit
from cellctl.validating.rules import size_of
from tests.generating.counting import Cells, feet, from_front, tiers

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
