"""Meshes for the tests of the planner."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell
from cellctl.config import CellConfig, load_config
from cellctl.generating.boxes import Box, mesh_of
from cellctl.mesh import GeneratedMesh
from cellctl.validating.clean import Surface
from cellctl.validating.fit import Shape

CONFIG: CellConfig = load_config(Path(__file__).parents[2] / "config" / "sim.toml")


def generated(
    *boxes: Box,
    unit_m: float = 0.1,
    metric: bool = True,
    stated: dict[str, float] | None = None,
) -> GeneratedMesh:
    """A mesh of boxes, in cells of 10 cm."""
    vertices, faces = mesh_of(boxes, unit_m)
    return of_arrays(vertices, faces, metric=metric, stated=stated)


def of_arrays(
    vertices: npt.NDArray[np.float64],
    faces: npt.NDArray[np.int64],
    *,
    metric: bool = True,
    stated: dict[str, float] | None = None,
) -> GeneratedMesh:
    return GeneratedMesh(
        vertices=vertices,
        faces=faces,
        metric=metric,
        title="thing",
        provenance="a test",
        stated_dimensions_m=stated or {},
    )


def shape(*boxes: Box) -> Shape:
    """Boxes measured in cells, as the planner sees them; the lowest corner must be the origin."""
    return Shape(Surface(*mesh_of(boxes, 1.0)))


def cells_of(*boxes: Box) -> frozenset[Cell]:
    """What whole-numbered boxes fill, said without any geometry."""
    return frozenset(
        Cell(int(box.x) + i, int(box.y) + j, int(box.z) + k)
        for box in boxes
        for i in range(int(box.width))
        for j in range(int(box.depth))
        for k in range(int(box.height))
    )


def paper(test_data: Path, name: str) -> tuple[frozenset[Cell], dict[str, int]]:
    """One of the paper's objects: its cells, and what was computed for them."""
    found = json.loads((test_data / "paper.json").read_text())["objects"][name]
    return frozenset(Cell(*cell) for cell in found["cells"]), found["computed"]
