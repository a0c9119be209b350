"""What is to be made, before there is any shape: a parametric design, or simple solids.

A description is what a design is kept as: it can be written, read, changed and planned again, and
what it states (legs, tiers, sizes) holds by construction. It travels as JSON; the schema is in
``docs/reference/description.schema.json``.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter, ValidationError

from cellctl.assembly import Attribute, Axis, Value
from cellctl.errors import UsageError

SCHEMA_VERSION = 1
MAX_PARTS = 64

Length = Annotated[float, Field(gt=0.0, le=10.0)]
Place = Annotated[float, Field(ge=-10.0, le=10.0)]


class Solid(Value):
    """Base of the simple solids: where one is and how it is turned."""

    at_m: tuple[Place, Place, Place] = (0.0, 0.0, 0.0)
    """Its centre: x to the right, y to the rear, z up."""
    turned_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Turned about x, then y, then z through its centre, in degrees."""


class BoxPart(Solid):
    """A block."""

    shape: Literal["box"] = "box"
    size_m: tuple[Length, Length, Length]
    """Along x, y and z."""


class SpherePart(Solid):
    """A ball."""

    shape: Literal["sphere"] = "sphere"
    radius_m: Length


class EllipsoidPart(Solid):
    """A ball that is stretched."""

    shape: Literal["ellipsoid"] = "ellipsoid"
    size_m: tuple[Length, Length, Length]
    """Along x, y and z, from end to end."""


class CylinderPart(Solid):
    """A cylinder along z."""

    shape: Literal["cylinder"] = "cylinder"
    radius_m: Length
    height_m: Length


class ConePart(Solid):
    """A cone along z, its tip up; a frustum where it has a radius at the top."""

    shape: Literal["cone"] = "cone"
    radius_m: Length
    """Of its base."""
    top_radius_m: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    height_m: Length


class CapsulePart(Solid):
    """A cylinder along z with round ends."""

    shape: Literal["capsule"] = "capsule"
    radius_m: Length
    height_m: Length
    """From end to end."""


class PrismPart(Solid):
    """A gable along y: a triangle, its edge up."""

    shape: Literal["prism"] = "prism"
    size_m: tuple[Length, Length, Length]
    """Along x, y and z."""


class RingPart(Solid):
    """A torus that lies in the plane of x and y."""

    shape: Literal["ring"] = "ring"
    radius_m: Length
    """Of the circle in the middle of the ring."""
    thickness_m: Length
    """Across the ring itself."""


Part = Annotated[
    BoxPart
    | SpherePart
    | EllipsoidPart
    | CylinderPart
    | ConePart
    | CapsulePart
    | PrismPart
    | RingPart,
    Field(discriminator="shape"),
]


class FamilyDescription(Value):
    """One of the families that cellctl knows, with its attributes and sizes."""

    schema_version: Literal[1] = 1
    kind: Literal["family"] = "family"
    family: Annotated[str, Field(min_length=1, max_length=40)]
    """Name of the family, such as ``stool``."""
    noun: Annotated[str, Field(max_length=40)] = ""
    """What it is called, where that is another word of the family (``cottage``)."""
    attributes: dict[str, Attribute] = Field(default_factory=dict)
    """What the family knows, such as ``legs``; the family's own number where it is left out."""
    size_m: dict[Axis, Length] = Field(default_factory=dict)
    """Sizes that were asked for; the family's own where one is left out."""
    turned_deg: Literal[0, 90, 180, 270] = 0
    """Turned about the vertical, anticlockwise seen from above; its sizes turn with it."""


class PartsDescription(Value):
    """Anything, made of simple solids that touch or overlap."""

    schema_version: Literal[1] = 1
    kind: Literal["parts"] = "parts"
    title: Annotated[str, Field(min_length=1, max_length=80)]
    """What it is, for people."""
    parts: Annotated[tuple[Part, ...], Field(min_length=1, max_length=MAX_PARTS)]


Description = Annotated[FamilyDescription | PartsDescription, Field(discriminator="kind")]

_ADAPTER: TypeAdapter[FamilyDescription | PartsDescription] = TypeAdapter(Description)


def is_description(content: str | bytes) -> bool:
    """Whether JSON is meant as a description, right or wrong; what is no JSON is not."""
    try:
        data = json.loads(content)
    except (ValueError, RecursionError):
        return False
    return isinstance(data, dict) and bool({"family", "parts", "kind"} & data.keys())


def parse_description(text: str | bytes, origin: str) -> FamilyDescription | PartsDescription:
    """Read a description from JSON.

    ``kind`` may be left out where a family or parts are named.

    Args:
        text: the JSON.
        origin: what it is called in errors, such as the file's name.

    Raises:
        UsageError: it is none; one line for each thing that is wrong.
    """
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{origin}: is not valid JSON: {error}.") from error
    if isinstance(data, dict) and "kind" not in data:
        kind = "family" if "family" in data else "parts" if "parts" in data else None
        data = data if kind is None else {**data, "kind": kind}
    try:
        return _ADAPTER.validate_json(json.dumps(data))
    except ValidationError as error:
        lines = []
        for item in error.errors():
            where = ".".join(str(part) for part in item["loc"]) or "(whole description)"
            lines.append(f"{origin}: {where}: {item['msg']}.")
        raise UsageError("\n".join(lines), "See docs/designing.md for what it may hold.") from error


def description_schema() -> dict[str, Any]:
    """The JSON schema of a description."""
    return _ADAPTER.json_schema()
