"""From a request to a description, and from a description to a shape."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cellctl.assembling.poses import inverse, to_matrix
from cellctl.assembly import Attribute, Change, Request
from cellctl.config import CellConfig
from cellctl.description import FamilyDescription, PartsDescription
from cellctl.errors import DesignError
from cellctl.generating.boxes import mesh_of
from cellctl.generating.families import BY_NAME, find_family
from cellctl.generating.families.brief import Brief, Count, Design, Family, Flag
from cellctl.generating.solids import mesh_of_parts
from cellctl.generating.wording import with_article
from cellctl.mesh import GeneratedMesh

_NEAREST = {
    "animal": ("dog", "cat", "giraffe", "elephant", "duck"),
    "person": ("person", "robot", "bear", "snowman"),
    "character": ("person", "robot", "bear", "snowman"),
    "plant": ("tree", "fir tree", "mushroom"),
    "body": ("person", "heart", "bear"),
    "food": ("mushroom", "mug", "pot", "fish"),
    "shape": ("cube", "pyramid", "ball", "heart", "letter"),
}
"""Families to name to whoever asks for something else of a kind."""
_OTHERWISE = ("stool", "table", "house", "tower", "rocket", "car", "dog", "letter")
_MOST_M = 10.0
"""Beyond this a stated size is only told to be too large; see ``description.Length``."""


@dataclass(frozen=True)
class Described:
    """A description that a request asks for, and what of the request is not in it."""

    description: FamilyDescription
    left_out: tuple[Change, ...]


def repertoire(kind: str) -> str:
    """Some of what can be designed, as a phrase: ``a dog, a cat, or a giraffe``.

    Args:
        kind: that of what cannot, so that the nearest is named; see ``Request.kind``.
    """
    names = [with_article(BY_NAME[name].name) for name in _NEAREST.get(kind, _OTHERWISE)]
    return f"{', '.join(names[:-1])}, or {names[-1]}"


def describe(request: Request) -> Described | None:
    """The description of what was asked for; None where no family means it."""
    found = find_family(request)
    if found is None:
        return None
    family, noun = found
    known = {k: v for k, v in request.attributes.items() if k in family.takes}
    unknown = {k: v for k, v in request.attributes.items() if k not in family.takes}
    description = FamilyDescription(
        family=family.name,
        noun="" if noun == family.name else noun,
        attributes=known,
        size_m={axis: min(size_m, _MOST_M) for axis, size_m in request.dimensions_m.items()},
    )
    left_out = (*_left_out(unknown, noun, request.count), *_not_considered(request, family, noun))
    word = request.phrase.rpartition(" ")[2]
    if family.name == "letter" and request.objects == ("word",):
        what = f"The letter {known.get('glyph', '')}, the first of {word}."
        left_out = (*left_out, Change(what=what, why="I build one at a time."))
    return Described(description, left_out)


def _not_considered(request: Request, family: Family, noun: str) -> tuple[Change, ...]:
    """What it should have that is no part of such designs, as far as they say of themselves."""
    described = set(re.findall(r"[a-z]+", (family.build.__doc__ or "").lower())) | set(family.takes)
    return tuple(
        Change(
            what=f"I took no account of the {feature}.",
            why=f"I know no such part of {with_article(noun)}.",
        )
        for feature in request.features
        if feature.split()[-1] not in described
    )


def _left_out(unknown: dict[str, Attribute], noun: str, count: int) -> tuple[Change, ...]:
    changes = []
    for name, value in sorted(unknown.items()):
        if name in ("colour", "color"):
            changes.append(Change(what=f"It is not {value}.", why="All parts have one colour."))
        elif value is not False and value != 0:
            changes.append(
                Change(
                    what=f"It comes without the {name} that you asked for.",
                    why=f"I cannot design {name} for {with_article(noun)} yet.",
                )
            )
    if count > 1:
        changes.append(Change(what=f"One {noun}, not {count}.", why="I build one at a time."))
    return tuple(changes)


def check_description(description: FamilyDescription) -> Family:
    """The family of a description that somebody wrote, when all it states is known there.

    Raises:
        DesignError: no such family, or an attribute that it does not have.
    """
    family = BY_NAME.get(description.family)
    if family is None:
        raise DesignError(
            f"There is no family {description.family!r}.", f"There are {', '.join(BY_NAME)}."
        )
    for name, value in description.attributes.items():
        known = family.takes.get(name)
        if known is None:
            others = ", ".join(family.takes) or "none"
            raise DesignError(
                f"{with_article(family.name).capitalize()} has no attribute {name!r}.",
                f"Its attributes: {others}.",
            )
        right = (
            isinstance(value, bool)
            if isinstance(known, Flag)
            else isinstance(value, int) and not isinstance(value, bool)
            if isinstance(known, Count)
            else isinstance(value, str | int)
        )
        if not right:
            kind = "true or false" if isinstance(known, Flag) else "a whole number"
            raise DesignError(f"The attribute {name!r} is {kind}, not {value!r}.")
    return family


def realise(
    description: FamilyDescription | PartsDescription,
    config: CellConfig,
    *,
    provenance: str = "from a description",
    left_out: tuple[Change, ...] = (),
    stated_m: dict[str, float] | None = None,
) -> GeneratedMesh:
    """The shape of a description: metric, z up, a family's faces on the cells' planes.

    Args:
        description: what to make.
        config: the cell: its pitch, its room, and on which side its visitors stand.
        provenance: what to say of where it comes from; the description follows.
        left_out: what of a request is not in it.
        stated_m: the sizes to compare the outcome with; the description's own for None.

    Raises:
        DesignError: the family cannot have what the description states.
    """
    if isinstance(description, PartsDescription):
        vertices, faces = mesh_of_parts(description)
        title, stated = description.title, {}
        complete: FamilyDescription | PartsDescription = description
    else:
        design, values = draw(description, config)
        vertices, faces = mesh_of(design.boxes, config.voxel.pitch_m)
        vertices = turned(vertices, description.turned_deg)
        title = design.title
        names = {"width": "depth", "depth": "width"} if lies_across(description) else {}
        stated = {names.get(k, str(k)): v for k, v in description.size_m.items()}
        complete = description.model_copy(update={"attributes": values})
    if faces_visitors_by_turning(config):
        vertices = vertices * np.array([-1.0, -1.0, 1.0])
    return GeneratedMesh(
        vertices=vertices,
        faces=faces,
        metric=True,
        title=title,
        provenance=f"{provenance}: {in_words(complete)}",
        stated_dimensions_m=stated if stated_m is None else stated_m,
        changes=left_out,
        description=complete,
    )


def in_words(description: FamilyDescription | PartsDescription) -> str:
    """``stool, legs 4, no back, height 50 cm``."""
    if isinstance(description, PartsDescription):
        return f"{description.title}, made of {len(description.parts)} solids"
    told = [description.noun or description.family]
    for name, value in description.attributes.items():
        words = name.replace("_", " ")
        if isinstance(value, bool):
            told.append(words if value else f"no {words}")
        else:
            told.append(f"{words} {value}")
    told += [f"{axis} {round(size * 100, 1):g} cm" for axis, size in description.size_m.items()]
    if description.turned_deg:
        told.append(f"turned by {description.turned_deg} degrees")
    return ", ".join(told)


def draw(description: FamilyDescription, config: CellConfig) -> tuple[Design, dict[str, Attribute]]:
    """The boxes of a family's description, and what each of its attributes came to be.

    Raises:
        DesignError: the family cannot have what the description states.
    """
    family = check_description(description)
    brief = Brief.of(description, family, config.voxel.pitch_m, room(description, config))
    return family.build(brief), brief.values


def lies_across(description: FamilyDescription) -> bool:
    """Whether its width lies along y."""
    return description.turned_deg in (90, 270)


def room(description: FamilyDescription, config: CellConfig) -> tuple[int, int, int]:
    """The most cells that its width, depth and height can have."""
    nx, ny, nz = config.grid
    return (ny, nx, nz) if lies_across(description) else (nx, ny, nz)


def turned(vertices: npt.NDArray[np.float64], angle_deg: int) -> npt.NDArray[np.float64]:
    """Points of shape (n, 3), turned by quarters about the vertical, anticlockwise from above."""
    x, y, z = vertices.T
    match angle_deg:
        case 90:
            x, y = -y, x
        case 180:
            x, y = -x, -y
        case 270:
            x, y = y, -x
    return np.column_stack((x, y, z))


def size_cells(design: Design) -> tuple[int, int, int]:
    """Extent of a design in cells along x, y and z."""
    spans = []
    for axis, extent in ((0, 3), (1, 4), (2, 5)):
        low = min(box[axis] for box in design.boxes)
        high = max(box[axis] + box[extent] for box in design.boxes)
        spans.append(math.ceil(high - low - 1e-9))
    return (spans[0], spans[1], spans[2])


def faces_visitors_by_turning(config: CellConfig) -> bool:
    """Whether a design, drawn with its front towards -y, has to be turned about the vertical.

    Visitors stand opposite the robot; a letter is to be read, and a chair seen, from there.
    """
    base = inverse(to_matrix(config.workspace.frame)) @ to_matrix(config.base.frame)
    return bool(base[1, 3] < config.workspace.size_m[1] / 2)
