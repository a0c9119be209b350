"""Every family, with every attribute it honours, ends as cells that show what was asked for."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import trimesh

from cellctl.assembly import Cell, Intent, Request
from cellctl.config import CellConfig, load_config
from cellctl.errors import DesignError, NoObjectError, UnknownObjectError
from cellctl.generating.design import design, design_by
from cellctl.generating.families import FAMILIES
from cellctl.generating.families.glyphs import GLYPHS
from cellctl.generating.wording import with_article
from cellctl.listening.request import read_request
from cellctl.validating.fit import fit, size_questions
from cellctl.validating.paper.policy import process
from cellctl.validating.paper.scaling import Rescaled
from cellctl.validating.paper.steadying import longest_overhang
from cellctl.validating.rules import (
    check_access,
    check_connectivity,
    check_count,
    check_grounded,
    check_stack,
    pieces,
    size_of,
)

CONFIG = load_config(Path(__file__).parents[2] / "config" / "sim.toml")

Attributes = Mapping[str, int | str | bool]


def request(
    noun: str,
    attributes: Attributes | None = None,
    *,
    phrase: str = "",
    count: int = 1,
    height_m: float | None = None,
    width_m: float | None = None,
) -> Request:
    return Request(
        text=f"make me a {phrase or noun}",
        intent=Intent.DESIGN,
        phrase=phrase or noun,
        objects=(noun,),
        count=count,
        attributes=dict(attributes or {}),
        dimensions_m={
            **({} if height_m is None else {"height": height_m}),
            **({} if width_m is None else {"width": width_m}),
        },
    )


def built(wish: Request, config: CellConfig = CONFIG) -> Rescaled:
    """What a design becomes by the paper's rules, which are stricter than the joints."""
    return process(fit(design(wish, config), config).shape, config.limits, 40)


def from_front(cells: frozenset[Cell]) -> frozenset[Cell]:
    """The cells as a visitor sees them: the robot stands behind, so designs are turned to front."""
    width, depth, _ = size_of(cells)
    return frozenset(Cell(width - 1 - x, depth - 1 - y, z) for x, y, z in cells)


def layer(cells: frozenset[Cell], z: int) -> frozenset[Cell]:
    return frozenset(cell for cell in cells if cell.z == z)


def feet(cells: frozenset[Cell]) -> int:
    """How many separate things touch the floor."""
    return len(pieces(layer(cells, 0)))


def tiers(cells: frozenset[Cell]) -> int:
    """How many layers reach from side to side."""
    width, depth, height = size_of(cells)
    return sum(len(layer(cells, z)) == width * depth for z in range(height))


FLAGS = [(back, arms) for back in (False, True) for arms in (False, True)]

BY_PAPER = {
    *("stool", "chair", "armchair", "bench", "table", "coffee table", "desk"),
    *("shelf", "bookcase", "box", "tower", "cube"),
}
"""The families whose designs keep the paper's rules too, which count where physics would prove."""

WISHES: list[tuple[str, Attributes]] = [
    *((noun, {}) for family in FAMILIES for noun in family.nouns if family.name in BY_PAPER),
    *((noun, {"legs": n}) for noun in ("stool", "table", "coffee table") for n in range(1, 10)),
    *(("desk", {"legs": n}) for n in range(1, 7)),
    *(("chair", {"legs": n, "back": b, "arms": a}) for n in range(1, 6) for b, a in FLAGS),
    *(("bench", {"legs": n, "back": b, "arms": a}) for n in range(1, 7) for b, a in FLAGS),
    *(("bench", {"back": b, "arms": a}) for b, a in FLAGS),
    *(("shelf", {"tiers": n, "back": b}) for n in (1, 2, 3) for b in (False, True)),
    ("box", {"lid": True}),
    *(("letter", {"glyph": sign}) for sign in GLYPHS),
]


def _name(wish: str | Attributes) -> str:
    return wish if isinstance(wish, str) else "-".join(f"{k}{v}" for k, v in wish.items())


@pytest.mark.parametrize(("noun", "attributes"), WISHES, ids=_name)
def test_every_wish_obeys_every_rule_and_keeps_its_legs(noun: str, attributes: Attributes) -> None:
    cells = built(request(noun, attributes, phrase=noun)).cells
    assert check_count(cells, 40).passed
    assert check_stack(cells, CONFIG.limits.stack_cells).passed
    assert longest_overhang(cells) <= CONFIG.limits.overhang_cells
    assert all(rule(cells).passed for rule in (check_connectivity, check_grounded, check_access))
    assert all(edge <= room for edge, room in zip(size_of(cells), CONFIG.grid, strict=True))
    if "legs" in attributes:
        assert feet(cells) == attributes["legs"]
        under_seat = min(z for z in range(6) if len(pieces(layer(cells, z))) == 1 or z == 5)
        assert all(feet(cells) == len(pieces(layer(cells, z))) for z in range(under_seat))
    if "tiers" in attributes and not attributes["back"]:
        assert tiers(cells) == attributes["tiers"]


@pytest.mark.parametrize("sign", GLYPHS)
def test_a_glyph_shows_its_drawing_and_stands_on_its_foot(sign: str) -> None:
    repaired = built(request("letter", {"glyph": sign.lower()}))
    cells = from_front(repaired.cells)
    rows = GLYPHS[sign]
    drawn = [
        "".join("#" if Cell(x, 0, z) in cells else "." for x in range(len(rows[0])))
        for z in reversed(range(size_of(cells)[2]))
    ]
    if sign == "T":  # the paper's: five parts high on its own is one too many
        assert drawn == ["###", ".#.", ".#.", ".#.", ".#."]
        assert len(repaired.changes) == 1
    else:
        assert tuple(drawn) == rows
        assert repaired.changes == ()
    foot = [cell.x for cell in cells if cell.z == 0]
    weight_at = sum(cell.x + 0.5 for cell in cells) / len(cells)
    assert min(foot) < weight_at < max(foot) + 1


def test_no_two_glyphs_look_the_same() -> None:
    assert len(set(GLYPHS.values())) == 36 == len(GLYPHS)


def test_a_chair_has_its_back_and_arms() -> None:
    plain = from_front(built(request("chair")).cells)
    assert {cell.y for cell in plain if cell.z == 5} == {2}
    without = built(request("chair", {"back": False})).cells
    assert size_of(without)[2] == 3
    arms = from_front(built(request("armchair")).cells)
    width = size_of(arms)[0]
    beside = {Cell(x, y, 3) for x in (0, width - 1) for y in range(3)}
    assert beside <= arms
    assert Cell(1, 0, 3) not in arms


@pytest.mark.parametrize("height_m", [0.2, 0.3, 0.5])
@pytest.mark.parametrize("noun", ["stool", "desk", "tower", "coffee table"])
def test_a_stated_height_is_met_exactly(noun: str, height_m: float) -> None:
    wish = request(noun, phrase=noun, height_m=height_m)
    size = size_of(built(wish).cells)
    assert size[2] == round(height_m * 10)


@pytest.mark.parametrize("sign", ["T", "L", "O", "7"])
def test_a_letter_grows_to_a_stated_height_and_keeps_its_form(sign: str) -> None:
    found = design(request("letter", {"glyph": sign}, height_m=0.6), CONFIG)
    assert np.isclose(np.ptp(found.vertices[:, 2]), 0.6)
    lower = design(request("letter", {"glyph": "T"}, height_m=0.3), CONFIG)
    assert np.isclose(np.ptp(lower.vertices[:, 2]), 0.3)
    cells = built(request("letter", {"glyph": "T"}, height_m=0.3)).cells
    assert sorted(cells) == [(0, 0, 2), (1, 0, 0), (1, 0, 1), (1, 0, 2), (2, 0, 2)]


def test_a_stated_size_beyond_the_workspace_is_built_smaller_and_asked_about() -> None:
    wish = request("stool", height_m=1.0)
    size = size_of(built(wish).cells)
    questions = size_questions(design(wish, CONFIG).stated_dimensions_m, size, 0.1)
    assert len(questions) == 1
    assert "100 cm" in questions[0]
    assert "50 cm" in questions[0]


def test_the_mesh_is_closed_outward_and_metric() -> None:
    found = design(request("stool"), CONFIG)
    assert found.metric
    assert isinstance(found.mesh, trimesh.Trimesh)
    for part in found.mesh.split():
        assert part.is_watertight
        assert part.volume > 0
    assert np.allclose(found.mesh.extents, [0.5, 0.4, 0.5])


def test_a_design_travels_between_processes() -> None:
    found = design(request("table", {"legs": 1}), CONFIG)
    copy = pickle.loads(pickle.dumps(found))  # noqa: S301 - our own bytes
    assert np.array_equal(copy.vertices, found.vertices)
    assert copy.title == "table with one leg"


def test_what_cannot_be_had_is_named() -> None:
    found = design(request("stool", {"drawers": 2, "colour": "red"}, count=2), CONFIG)
    assert [change.what for change in found.changes] == [
        "It is not red.",
        "It comes without the drawers that you asked for.",
        "One stool, not 2.",
    ]
    assert design(request("stool", {"drawers": False}), CONFIG).changes == ()


@pytest.mark.parametrize(
    ("noun", "attributes", "said"),
    [
        ("violin", {}, "I cannot design a violin yet. I can design a stool"),
        ("octopus", {}, "an octopus"),
        ("stool", {"legs": 20}, "at most 9"),
        ("stool", {"legs": 0}, "at least one leg"),
        ("shelf", {"tiers": 4}, "at most 3"),
        ("letter", {"glyph": "AB"}, "one letter or digit at a time"),
        ("letter", {"glyph": "?"}, "'?'"),
        ("letter", {}, "which letter"),
        ("dog", {"legs": 3}, "at least four legs"),
        ("steps", {"steps": 9}, "nine steps"),
        ("pyramid", {"tiers": 5}, "five tiers"),
        ("bridge", {"arches": 4}, "four arches"),
        ("desk", {"drawers": 2, "legs": 4}, "on two legs"),
    ],
)
def test_what_cannot_be_designed_is_refused(noun: str, attributes: Attributes, said: str) -> None:
    with pytest.raises(DesignError) as refusal:
        design(request(noun, attributes), CONFIG)
    assert said in str(refusal.value)


def test_legs_that_do_not_fit_are_refused() -> None:
    with pytest.raises(DesignError, match="six separate legs"):
        design(request("stool", {"legs": 6}, width_m=0.3), CONFIG)


def test_no_object_is_no_design() -> None:
    wish = Request(text="create beauty", intent=Intent.NONE, phrase="false")
    with pytest.raises(NoObjectError, match="create beauty"):
        design(wish, CONFIG)


def test_a_compound_is_closer_than_its_head_noun() -> None:
    assert design(request("table", phrase="coffee table"), CONFIG).title.startswith("coffee table")
    found = design(request("table", phrase="dining table"), CONFIG)
    assert found.title == "dining table with four legs"


@pytest.mark.parametrize(
    ("phrase", "said"),
    [
        ("stool", "a stool"),
        ("elephant", "an elephant"),
        ("unicorn", "a unicorn"),
        ("umbrella stand", "an umbrella stand"),
        ("hourglass", "an hourglass"),
        ("house", "a house"),
        ("steps", "steps"),
    ],
)
def test_articles_go_by_sound(phrase: str, said: str) -> None:
    assert with_article(phrase) == said


@pytest.mark.parametrize(
    ("sentence", "said"),
    [
        ("a penguin", "a penguin yet. I can design a dog, a cat"),
        ("build me batman", "design Batman yet. I can design a person"),
        ("a cactus", "a tree"),
    ],
)
def test_what_is_near_to_it_is_offered(sentence: str, said: str) -> None:
    with pytest.raises(UnknownObjectError) as refusal:
        design_by("description", read_request(sentence), CONFIG)
    assert said in str(refusal.value)


@pytest.mark.parametrize(
    ("sentence", "told"),
    [
        ("a boat with two sails", ["I took no account of the two sails."]),
        ("a boat with a sail", []),
        ("a dog with floppy ears and a long tail", ["I took no account of the floppy ears."]),
        ("my initials, A and C", ["One letter, not 2."]),
        ("write HI", ["The letter H, the first of hi."]),
    ],
)
def test_what_it_has_not_is_told(sentence: str, told: list[str]) -> None:
    found = design(read_request(sentence), CONFIG)
    assert [change.what for change in found.changes] == told
