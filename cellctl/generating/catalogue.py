"""Retrieval of real furniture at its real size, with the names of those who modelled it.

The catalogue is a file of coarse solids, made by ``cellctl catalogue build`` from the models of
Sweet Home 3D. Nothing is loaded before somebody asks for something.
"""

from __future__ import annotations

import base64
import gzip
import json
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, ValidationError

from cellctl.assembly import Change, Request, Value
from cellctl.config import CellConfig
from cellctl.errors import ConfigError, UnknownObjectError
from cellctl.generating.boxes import Box, mesh_of
from cellctl.generating.describing import faces_visitors_by_turning
from cellctl.generating.wording import with_article
from cellctl.mesh import GeneratedMesh

PACKAGED = "catalogue.json.gz"


class Entry(Value):
    """One object."""

    entry_id: str
    name: str
    """What it is, lower case: ``rocking chair``."""
    tags: tuple[str, ...] = ()
    creator: str
    licence: str
    size_m: tuple[float, float, float]
    """Real width, depth and height."""
    parts: Annotated[int, Field(ge=1)]
    """How many cells it fills at its real size."""
    grid: tuple[int, int, int]
    solid: str
    """Occupied cells of the grid at ``Catalogue.resolution_m``: bits, x slowest, in base 64."""


class Catalogue(Value):
    """All objects, and what they were made from."""

    schema_version: Literal[1] = 1
    source: str
    resolution_m: Annotated[float, Field(gt=0.0)]
    entries: tuple[Entry, ...]


def occupied(entry: Entry) -> npt.NDArray[np.bool_]:
    """The object's cells, shape ``entry.grid``."""
    bits = np.frombuffer(base64.b64decode(entry.solid), dtype=np.uint8)
    count = int(np.prod(entry.grid))
    return np.unpackbits(bits, count=count).astype(bool).reshape(entry.grid)


def packed(cells: npt.NDArray[np.bool_]) -> str:
    """Cells as ``Entry.solid``."""
    return base64.b64encode(np.packbits(cells.reshape(-1)).tobytes()).decode("ascii")


@lru_cache(maxsize=2)
def load_catalogue(path: str = "") -> Catalogue:
    """Read a catalogue; the one that comes with cellctl for an empty path.

    Raises:
        ConfigError: it is not there, or is no catalogue.
    """
    hint = "Make one with `cellctl catalogue build`, or leave generating.catalogue out."
    try:
        if path:
            content = Path(path).read_bytes()
        else:
            content = files("cellctl.generating").joinpath(PACKAGED).read_bytes()
        return Catalogue.model_validate_json(gzip.decompress(content))
    except OSError as error:
        reason = error.strerror or str(error)
        raise ConfigError(f"{path or PACKAGED}: cannot be read: {reason}.", hint) from error
    except (EOFError, ValidationError) as error:
        raise ConfigError(f"{path or PACKAGED}: is no catalogue.", hint) from error


def write_catalogue(catalogue: Catalogue, path: Path) -> None:
    """Write a catalogue so that the same one has the same bytes."""
    text = json.dumps(catalogue.model_dump(mode="json"), ensure_ascii=False, sort_keys=True)
    path.write_bytes(gzip.compress(text.encode("utf-8"), 9, mtime=0))


def shape_of(
    entry: Entry, resolution_m: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Vertices in metres and faces: a block for each upright run of cells."""
    solid = occupied(entry)
    boxes = []
    for x, y in zip(*np.nonzero(solid.any(axis=2)), strict=True):
        column = np.concatenate(([0], solid[x, y].view(np.int8), [0]))
        steps = np.diff(column)
        for start, end in zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1), strict=True):
            boxes.append(Box(float(x), float(y), float(start), 1.0, 1.0, float(end - start)))
    return mesh_of(tuple(boxes), resolution_m)


def find_entries(request: Request, catalogue: Catalogue, most_parts: int) -> list[Entry]:
    """The objects that a request may mean, the best first.

    The whole phrase counts most, then the noun; among those that mean the same, one that needs no
    more parts than there are, then the one nearest to the stated sizes, then the smallest.
    """
    phrase = request.phrase.lower()
    nouns = [noun.lower() for noun in request.objects[:1]]

    def meaning(entry: Entry) -> int:
        if entry.name == phrase:
            return 3
        if f" {entry.name} " in f" {phrase} ":
            return 2
        last = entry.name.split()[-1]
        return 1 if any(noun == last or noun in entry.tags for noun in nouns) else 0

    def rank(entry: Entry) -> tuple[int, bool, float, int, str]:
        wanted = dict(zip(("width", "depth", "height"), entry.size_m, strict=True))
        off = sum(abs(wanted[axis] - size) for axis, size in request.dimensions_m.items())
        return (-meaning(entry), entry.parts > most_parts, off, entry.parts, entry.entry_id)

    return sorted((entry for entry in catalogue.entries if meaning(entry)), key=rank)


class CatalogueGenerator:
    """Finds real furniture."""

    name = "catalogue"

    def generate(self, request: Request, config: CellConfig) -> GeneratedMesh:
        """The object at its real size; where the cell has no room for it, planning makes it fit.

        Raises:
            UnknownObjectError: it is not in the catalogue.
            ConfigError: there is no catalogue that can be read.
        """
        catalogue = load_catalogue(config.generating.catalogue)
        found = find_entries(request, catalogue, config.limits.inventory_parts)
        if not found:
            wish = request.phrase if request.phrase not in ("", "false") else "that"
            raise UnknownObjectError(f"There is no {wish} in the catalogue.")
        return mesh_of_entry(found[0], request, config)


def mesh_of_entry(entry: Entry, request: Request, config: CellConfig) -> GeneratedMesh:
    """One object of the configured catalogue, as the shape for a request."""
    vertices, faces = shape_of(entry, load_catalogue(config.generating.catalogue).resolution_m)
    if faces_visitors_by_turning(config):
        vertices = vertices * np.array([-1.0, -1.0, 1.0])
    return GeneratedMesh(
        vertices=vertices,
        faces=faces,
        metric=not request.dimensions_m,
        title=entry.name,
        provenance=f"from the catalogue, by {entry.creator}, {entry.licence} ({entry.entry_id})",
        stated_dimensions_m={str(k): v for k, v in request.dimensions_m.items()},
        changes=unpromised(request, f"{with_article(entry.name)} of the catalogue"),
    )


def unpromised(request: Request, what: str) -> tuple[Change, ...]:
    """What a shape that is not made from a description cannot be asked for."""
    return tuple(
        Change(
            what=f"Nobody counted its {name}.",
            why=f"The shape is {what}, taken as it is.",
        )
        for name in (
            *(name for name, value in sorted(request.attributes.items()) if value is not False),
            *request.features,
        )
    )
