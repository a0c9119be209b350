"""Makes the catalogue of real furniture from the models of Sweet Home 3D (``*.sh3f``).

A ``.sh3f`` is a ZIP with a table of objects (Java properties, sizes in cm) and their models (OBJ,
y up). Debian has them in the package ``sweethome3d-furniture``.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cellctl.errors import CellctlError, UsageError
from cellctl.generating.catalogue import Catalogue, Entry, packed
from cellctl.validating.clean import Surface, clean
from cellctl.validating.discretise import discretise
from cellctl.validating.files import read_mesh
from cellctl.validating.fit import Shape
from cellctl.validating.rules import pieces

RESOLUTION_M = 0.10
LEAST_PARTS, MOST_PARTS = 8, 200
_LARGEST_M = 2.5
_TABLE = "PluginFurnitureCatalog.properties"
_LICENCES = (
    ("public domain", "CC0 1.0"),
    ("3.0 united states", "CC BY 3.0 US"),
    ("attribution 3.0", "CC BY 3.0"),
)
_SKIPPED = re.compile(r"gun|pistol|rifle|sword|weapon|cannon|knife|grenade", re.IGNORECASE)
"""What the cell does not build for anybody."""


@dataclass(frozen=True)
class _Row:
    values: dict[str, str]
    licence: str
    archive: zipfile.ZipFile

    def size_m(self) -> tuple[float, float, float]:
        width, depth, height = (float(self.values[k]) / 100.0 for k in ("width", "depth", "height"))
        return (width, depth, height)


def build_catalogue(folder: Path, tell: Callable[[str], None]) -> Catalogue:
    """Read every ``.sh3f`` of a folder.

    Args:
        folder: such as ``/usr/share/sweethome3d/furniture``.
        tell: told each object that is left out, and why.

    Raises:
        UsageError: there is none, or one cannot be read.
    """
    archives = sorted(folder.glob("*.sh3f"))
    if not archives:
        raise UsageError(
            f"{folder}: holds no .sh3f file.",
            "Debian's package sweethome3d-furniture has them in /usr/share/sweethome3d/furniture.",
        )
    entries = []
    for path in archives:
        try:
            with zipfile.ZipFile(path) as archive:
                for row in _rows(archive):
                    entry = _entry(row, tell)
                    if entry is not None:
                        entries.append(entry)
        except (OSError, zipfile.BadZipFile, KeyError, ValueError) as error:
            raise UsageError(f"{path}: cannot be read as a furniture library: {error}.") from error
    return Catalogue(
        source="Sweet Home 3D furniture libraries, Debian package sweethome3d-furniture 1.8",
        resolution_m=RESOLUTION_M,
        entries=tuple(sorted(entries, key=lambda entry: entry.entry_id)),
    )


def _rows(archive: zipfile.ZipFile) -> Iterator[_Row]:
    table = _properties(archive.read(_TABLE).decode("latin-1"))
    said = table.get("license", "").lower()
    licence = next((name for words, name in _LICENCES if words in said), "")
    if "3.0 unported" in said:
        licence = "CC BY 3.0"
    if not licence:
        raise ValueError(f"its licence is not known: {said[:80]!r}")
    numbers = sorted(int(key[3:]) for key in table if key.startswith("id#"))
    for number in numbers:
        suffix = f"#{number}"
        values = {k.removesuffix(suffix): v for k, v in table.items() if k.endswith(suffix)}
        yield _Row(values, licence, archive)


def _properties(text: str) -> dict[str, str]:
    found = {}
    for line in text.splitlines():
        key, equals, value = line.partition("=")
        if equals and not key.lstrip().startswith(("#", "!")):
            plain = re.sub(r"\\u([0-9a-fA-F]{4})", lambda m: chr(int(m[1], 16)), value)
            found[key.strip()] = plain.strip()
    return found


def _entry(row: _Row, tell: Callable[[str], None]) -> Entry | None:
    values, size_m = row.values, row.size_m()
    label = f"{values['id']} ({values['name']})"
    if values.get("doorOrWindow") == "true" or _SKIPPED.search(values["name"]):
        tell(f"{label}: nothing that is built here")
        return None
    if max(size_m) > _LARGEST_M:
        tell(f"{label}: {max(size_m):g} m is too large")
        return None
    try:
        surface = _surface(row, size_m)
        cells = discretise(Shape(surface, RESOLUTION_M))
    except CellctlError as error:
        tell(f"{label}: {error.message}")
        return None
    if not LEAST_PARTS <= len(cells) <= MOST_PARTS:
        tell(f"{label}: {len(cells)} parts of {RESOLUTION_M * 100:g} cm")
        return None
    if len(pieces(cells)) > 1:
        tell(f"{label}: {len(pieces(cells))} pieces")
        return None
    grid = np.max(np.array(list(cells)), axis=0) + 1
    solid = np.zeros(grid, dtype=bool)
    solid[tuple(np.array(list(cells)).T)] = True
    name = re.sub(r"\s*\(.*?\)|\s+\d+$", "", values["name"]).strip().lower()
    tags = tuple(t.strip().lower() for t in values.get("tags", "").split(",") if t.strip())
    return Entry(
        entry_id=values["id"],
        name=name,
        tags=tuple(t for t in tags if t != "blend swap"),
        creator=values.get("creator", "unknown"),
        licence=row.licence,
        size_m=tuple(round(edge, 3) for edge in size_m),  # type: ignore[arg-type]
        parts=len(cells),
        grid=(int(grid[0]), int(grid[1]), int(grid[2])),
        solid=packed(solid),
    )


def _surface(row: _Row, size_m: tuple[float, float, float]) -> Surface:
    """The model at its real size, z up, measured in cells of the resolution from its corner."""
    model = row.values["model"].lstrip("/")
    mesh = read_mesh("model.obj", row.archive.read(model), up="y")
    vertices = mesh.vertices
    if "modelRotation" in row.values:
        turn = np.array([float(v) for v in row.values["modelRotation"].split()]).reshape(3, 3)
        upright = vertices[:, [0, 2, 1]] * np.array([1.0, 1.0, -1.0]) @ turn.T
        vertices = upright[:, [0, 2, 1]] * np.array([1.0, -1.0, 1.0])
    surface = clean(vertices, mesh.faces)
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    extent: npt.NDArray[np.float64] = np.maximum(high - low, 1e-9)
    scaled = (surface.vertices - low) * (np.array(size_m) / extent / RESOLUTION_M)
    return Surface(scaled, surface.faces)
