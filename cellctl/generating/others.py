"""Other shapes for a wish: what its description leaves open, the catalogue, other proportions."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from cellctl.assembly import Attribute, Axis, Request
from cellctl.config import CellConfig
from cellctl.description import FamilyDescription
from cellctl.errors import DesignError
from cellctl.generating.catalogue import find_entries, load_catalogue, mesh_of_entry
from cellctl.generating.describing import draw, realise, size_cells
from cellctl.generating.families import BY_NAME
from cellctl.generating.families.brief import Count, Flag
from cellctl.mesh import GeneratedMesh

MOST_FROM_CATALOGUE = 3
"""How many objects of the catalogue are shown for one wish."""
_AXES: tuple[Axis, ...] = ("height", "width", "depth")
_MANY_LEGS = 4
"""What stands on panels unless told otherwise is tried on so many legs."""
_SCALES = (0.75, 1.25)
"""Other sizes of a shape that has no description, against its own."""


def others(
    request: Request | None, asked: GeneratedMesh, config: CellConfig
) -> Iterator[GeneratedMesh]:
    """Other shapes for the same wish, always in the same order; some may be alike.

    What was stated stays: sizes, legs, tiers. First what else the description may be, then the
    catalogue, then other proportions.

    Args:
        request: what was asked for, with the changes that were made to it; None for a file.
        asked: what was designed for it first.
        config: the cell; ``generating.chain`` says whether descriptions and catalogue are used.
    """
    chain = config.generating.chain
    described = asked.description if isinstance(asked.description, FamilyDescription) else None
    if described is not None and "description" in chain:
        for attributes in _attributes(described, _stated(request), config):
            yield from _realised(described, attributes, {}, asked, config)
    if request is not None and "catalogue" in chain:
        catalogue = load_catalogue(config.generating.catalogue)
        found = find_entries(request, catalogue, config.limits.inventory_parts)
        for entry in found[:MOST_FROM_CATALOGUE]:
            yield mesh_of_entry(entry, request, config)
    if described is not None and "description" in chain:
        for size_m in _sizes(described, config):
            yield from _realised(described, {}, size_m, asked, config)
    elif asked.metric and not asked.stated_dimensions_m:
        for scale in _SCALES:
            yield dataclasses.replace(
                asked,
                vertices=asked.vertices * scale,
                provenance=f"{asked.provenance}, at {scale:.0%} of its size",
            )


def _stated(request: Request | None) -> frozenset[str]:
    """The attributes that somebody named."""
    if request is None:
        return frozenset()
    changed = (name for edit in request.edits for name in (edit.attribute, edit.part) if name)
    return frozenset((*request.attributes, *changed))


def _attributes(
    described: FamilyDescription, stated: frozenset[str], config: CellConfig
) -> Iterator[dict[str, Attribute]]:
    """Attributes that nobody named, each with another value."""
    values = draw(described, config)[1]
    takes = BY_NAME[described.family].takes
    for name, known in sorted(takes.items(), key=lambda item: not isinstance(item[1], Flag)):
        if name in stated or name not in values:
            continue
        value = values[name]
        if isinstance(known, Flag):
            yield {name: not value}
        elif isinstance(known, Count) and isinstance(value, int):
            near = (value + 1, value - 1) if value else (_MANY_LEGS if name == "legs" else 1,)
            for number in near:
                if max(1, known.least) <= number <= known.most:
                    yield {name: number}


def _sizes(described: FamilyDescription, config: CellConfig) -> Iterator[dict[Axis, float]]:
    """Sizes that nobody stated, each a part more or less."""
    pitch_m = config.voxel.pitch_m
    width, depth, height = size_cells(draw(described, config)[0])
    cells = {"width": width, "depth": depth, "height": height}
    for step in (1, -1):
        for axis in _AXES:
            if axis not in described.size_m and cells[axis] + step > 0:
                yield {axis: (cells[axis] + step) * pitch_m}


def _realised(
    described: FamilyDescription,
    attributes: dict[str, Attribute],
    size_m: dict[Axis, float],
    asked: GeneratedMesh,
    config: CellConfig,
) -> Iterator[GeneratedMesh]:
    """The description with these changes, unless its family cannot have them."""
    changed = described.model_copy(
        update={
            "attributes": {**described.attributes, **attributes},
            "size_m": {**described.size_m, **size_m},
        }
    )
    try:
        yield realise(changed, config, left_out=asked.changes, stated_m=asked.stated_dimensions_m)
    except DesignError:
        return
