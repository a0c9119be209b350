"""Changes to what was designed before: the description changes, and is made and planned again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cellctl.assembly import Axis, Edit, Request
from cellctl.config import CellConfig
from cellctl.description import FamilyDescription, PartsDescription, Solid
from cellctl.errors import DesignError
from cellctl.generating.describing import describe, draw, realise, size_cells, turned
from cellctl.generating.describing import room as room_of
from cellctl.generating.families import BY_NAME
from cellctl.generating.families.brief import Count, Family, Flag
from cellctl.generating.wording import with_article
from cellctl.mesh import GeneratedMesh

_AXES: tuple[Axis, ...] = ("width", "depth", "height")
_MEASURES = {
    ("roof", "height"): "steepness",
    ("neck", "length"): "neck",
    ("neck", "height"): "neck",
    ("tail", "length"): "tail",
    ("tail", "height"): "tail",
}
"""Attributes that count a size of a part, by part and axis."""
_MEASURED = frozenset(_MEASURES.values())
_NEVER_SIZED = frozenset({"neck", "tail", "roof", "ear", "head", "wing", "trunk", "door", "window"})
"""Parts whose size is not the size of the whole."""
_REMEMBERED = 20
"""Changes that can be taken back, at most."""
_FACTOR = 1.5
"""Of a description of parts, where "larger" is said without a number."""


def change(mesh: GeneratedMesh, request: Request, config: CellConfig) -> GeneratedMesh:
    """A shape as a request with intent ``edit`` wants it; it knows what it was before.

    Args:
        mesh: what was designed; it has a description.
        request: its ``edits`` are made in their order.
        config: the cell, whose parts "taller by one" counts.

    Raises:
        DesignError: a change that this object cannot have, in words for the visitor.
    """
    description, earlier = mesh.description, mesh.earlier
    assert description is not None, "what has no description is not changed"
    if request.edits and request.edits[0].op == "undo":
        if not earlier:
            raise DesignError("Nothing was changed yet that I could take back.")
        *before, description = earlier
        request = request.model_copy(update={"edits": request.edits[1:]})
        earlier = tuple(before)
        description = edited(description, request, config) if request.edits else description
    else:
        earlier = (*earlier, description)[-_REMEMBERED:]
        description = edited(description, request, config)
    return replace(realise(description, config), earlier=earlier)


def edited(
    description: FamilyDescription | PartsDescription, request: Request, config: CellConfig
) -> FamilyDescription | PartsDescription:
    """A description as a request with intent ``edit`` wants it.

    Args:
        description: of what was designed before.
        request: its ``edits`` are made in their order.
        config: the cell, whose parts "taller by one" counts.

    Raises:
        DesignError: a change that this object cannot have, in words for the visitor.
    """
    if not request.edits:
        raise DesignError(
            "I did not understand what to change.", "Say it like: make it taller, or add a tier."
        )
    for edit in request.edits:
        if edit.op == "replace":
            description = _replaced(request, description)
        elif edit.op == "turn":
            description = _turned(description, edit)
        elif isinstance(description, PartsDescription):
            description = _scaled_parts(description, edit)
        elif edit.attribute or edit.part:
            description = _with_attribute(description, edit, config)
        else:
            description = _with_size(description, edit, config)
    return description


def _replaced(
    request: Request, before: FamilyDescription | PartsDescription
) -> FamilyDescription | PartsDescription:
    """Another object; stated sizes of the one before stay, as far as nothing else was said."""
    found = describe(request)
    if found is None:
        wish = request.phrase if request.phrase not in ("", "false") else "that"
        raise DesignError(f"I cannot make {with_article(wish)} of it.", "Say what it should be.")
    if isinstance(before, PartsDescription) or request.dimensions_m:
        return found.description
    return found.description.model_copy(update={"size_m": before.size_m})


def _turned(
    description: FamilyDescription | PartsDescription, edit: Edit
) -> FamilyDescription | PartsDescription:
    """``turn it round``: by quarters about the vertical, so that its faces stay on the cells'."""
    quarters = round((edit.amount or 0.0) / 90)
    if quarters % 4 == 0 or abs(90 * quarters - (edit.amount or 0.0)) > 1:
        raise DesignError(
            "I can turn it by a quarter or by half a turn only.",
            "Say it like: turn it round, or turn it to the left.",
        )
    if isinstance(description, FamilyDescription):
        angle = (description.turned_deg + 90 * quarters) % 360
        return description.model_copy(update={"turned_deg": angle})
    points = np.array([part.at_m for part in description.parts])
    parts = tuple(
        part.model_copy(
            update={
                "at_m": tuple(float(each) for each in at_m),
                "turned_deg": (*part.turned_deg[:2], part.turned_deg[2] + 90.0 * quarters),
            }
        )
        for part, at_m in zip(description.parts, turned(points, 90 * (quarters % 4)), strict=True)
    )
    return description.model_copy(update={"parts": parts})


def _with_attribute(
    description: FamilyDescription, edit: Edit, config: CellConfig
) -> FamilyDescription:
    """``two more tiers``, ``no back``, ``four legs``; ``longer legs`` is a size."""
    family = BY_NAME[description.family]
    name = _attribute(edit, family)
    noun = description.noun or family.name
    if name not in family.takes and edit.part in _NEVER_SIZED:
        raise DesignError(f"I cannot change the {edit.part} of {with_article(noun)}.", _can(family))
    if name not in _MEASURED and edit.axis is not None and edit.op in ("scale", "set"):
        # A longer leg is a taller object; a part has no other size of its own here.
        axis: Axis = "height" if edit.axis == "length" else edit.axis
        return _with_size(description, edit.model_copy(update={"axis": axis}), config)
    known = family.takes.get(name)
    if known is None:
        raise DesignError(f"I cannot change the {name} of {with_article(noun)}.", _can(family))
    values = dict(draw(description, config)[1])
    match edit.op, known:
        case "set", _ if edit.value is not None:
            values[name] = edit.value
        case ("add" | "scale") as op, Count():
            step = int(edit.amount) if edit.amount is not None else 1
            less = op == "scale" and edit.direction == "-"
            now = values.get(name, 0)
            assert isinstance(now, int), "a count is a number"
            if op == "scale" and edit.unit == "times" and edit.amount is not None:
                factor = 1 / edit.amount if less else edit.amount
                values[name] = max(known.least, round(now * factor))
            else:
                values[name] = now - step if less else now + step
        case "remove", Count():
            now = values.get(name, 0)
            assert isinstance(now, int), "a count is a number"
            values[name] = now - int(edit.amount) if edit.amount is not None else 0
        case ("add" | "remove") as op, Flag():
            values[name] = op == "add"
        case _:
            raise DesignError(
                f"I did not understand how to change the {name}.",
                "Say how many, or that it shall be there or not.",
            )
    changed = description.model_copy(update={"attributes": values})
    if values.get(name) == description.attributes.get(name, draw(description, config)[1][name]):
        raise DesignError(f"The {noun} is like that already.")
    return _fitting(changed, config)


def _attribute(edit: Edit, family: Family) -> str:
    """The attribute that an edit is about: a longer neck is a neck of more parts."""
    measured = _MEASURES.get((edit.part, edit.axis or ""), "")
    return measured if measured in family.takes else edit.attribute or edit.part


def _can(family: Family) -> str:
    return f"I can change: {', '.join(('its sizes', *family.takes))}."


def _fitting(description: FamilyDescription, config: CellConfig) -> FamilyDescription:
    """The description, or without its stated height where that leaves no room for the rest."""
    try:
        draw(description, config)
    except DesignError:
        if "height" not in description.size_m:
            raise
        sizes = {k: v for k, v in description.size_m.items() if k != "height"}
        description = description.model_copy(update={"size_m": sizes})
        draw(description, config)
    return description


def _with_size(description: FamilyDescription, edit: Edit, config: CellConfig) -> FamilyDescription:
    """``taller by a voxel``, ``80 cm high``, ``smaller``."""
    if edit.axis is not None:
        return _resized(description, edit, config)
    # What is one part deep stays so, and a chair keeps room for its legs: as many sizes as may be.
    refused: DesignError | None = None
    for axes in (_AXES, ("width", "height"), ("height",), ("width",)):
        try:
            return _resized(description, edit, config, axes)
        except DesignError as refusal:
            refused = refused or refusal
    assert refused is not None, "at least one of them was tried"
    raise refused


def _resized(
    description: FamilyDescription,
    edit: Edit,
    config: CellConfig,
    axes: tuple[Axis, ...] = (),
) -> FamilyDescription:
    pitch_m = config.voxel.pitch_m
    before = dict(zip(_AXES, size_cells(draw(description, config)[0]), strict=True))
    room = dict(zip(_AXES, room_of(description, config), strict=True))
    if edit.axis == "length":
        axes = ("width",) if before["width"] >= before["depth"] else ("depth",)
    elif edit.axis is not None:
        axes = (edit.axis,)
    sizes = dict(description.size_m)
    for axis in axes:
        cells = _cells_after(edit, before[axis], pitch_m)
        if cells < 1:
            raise DesignError(f"It cannot have a {axis} of 0 parts: one part is the least.")
        if cells > room[axis] and len(axes) == 1:
            most = f"{room[axis]} parts"
            raise DesignError(f"It cannot have a {axis} of {cells} parts: {most} is all the room.")
        sizes[axis] = min(cells, room[axis]) * pitch_m
    changed = description.model_copy(update={"size_m": sizes})
    after = size_cells(draw(changed, config)[0])
    if after == tuple(before[axis] for axis in _AXES):
        noun = description.noun or description.family
        raise DesignError(
            f"The {noun} cannot be made so here.",
            "Ask for another size, or for another object.",
        )
    return changed


def _cells_after(edit: Edit, now: int, pitch_m: float) -> int:
    """What a size of so many cells becomes."""
    amount = edit.amount
    if edit.op == "set":
        value = amount if amount is not None else edit.value
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise DesignError("I did not understand what size it should have.", "Say it in cm.")
        metres = edit.unit in (None, "metres")
        return max(1, int(value / pitch_m + 0.5)) if metres else int(value)
    less = edit.direction == "-"
    if amount is None:
        step = 1
    elif edit.unit == "times":
        return max(1, round(now / amount if less else now * amount))
    elif edit.unit == "metres":
        step = max(1, int(amount / pitch_m + 0.5))
    else:
        step = int(amount)
    return now - step if less else now + step


def _scaled_parts(description: PartsDescription, edit: Edit) -> PartsDescription:
    """Parts know no attributes, only sizes: all of them grow alike."""
    if edit.op != "scale" or edit.part or edit.attribute:
        raise DesignError(
            f"Of {with_article(description.title)} I can change the size only.",
            "Say larger or smaller, or ask for another object.",
        )
    factor = edit.amount if edit.unit == "times" and edit.amount is not None else _FACTOR
    return scaled(description, 1 / factor if edit.direction == "-" else factor)


def scaled(description: PartsDescription, factor: float) -> PartsDescription:
    """The same solids, all of them larger by a factor."""
    return description.model_copy(
        update={"parts": tuple(_scaled_part(part, factor) for part in description.parts)}
    )


def _scaled_part(part: Solid, factor: float) -> Solid:
    lengths: dict[str, object] = {}
    for name, value in part:
        if name.endswith("_m"):
            lengths[name] = (
                tuple(v * factor for v in value) if isinstance(value, tuple) else value * factor
            )
    return part.model_copy(update=lengths)
