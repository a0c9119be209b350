"""Cells and fill fractions of closed shapes are those of exact references, at either pitch."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.errors import PlanError
from cellctl.generating.boxes import Box, mesh_of
from cellctl.validating.clean import Surface, clean
from cellctl.validating.discretise import Voxels, voxelise
from cellctl.validating.fit import TOLERANCE_M, Shape
from cellctl.validating.orientation import Floats
from tests.validating.polytopes import tilted
from tests.validating.shapes import cells_of
from tests.validating.test_discretise import at_origin, sphere

PITCHES_M = (0.1, 0.05)

edges = st.lists(st.floats(0.05, 3.0), min_size=3, max_size=3)
angles = st.lists(st.floats(-180.0, 180.0).map(lambda a: round(a, 6)), min_size=3, max_size=3)


def voxels(*boxes: Box, pitch_m: float = 0.1) -> Voxels:
    return voxelise(Shape(clean(*mesh_of(boxes, 1.0)), pitch_m))


def chair(leg: float, pitch_m: float) -> list[Box]:
    """Off every plane: legs, a seat and a back that overlap each other, 37.5 cm wide."""
    parts = [Box(x, y, 0, leg, leg, 4) for x in (0, 3.75 - leg) for y in (0, 3.8 - leg)]
    parts += [Box(0, 0, 3.7, 3.75, 3.8, 0.5), Box(0, 3.5, 4.0, 3.75, 0.3, 4.1)]
    return [Box(*(number * 0.1 / pitch_m for number in part)) for part in parts]


@pytest.mark.parametrize("pitch_m", PITCHES_M)
@given(edges=edges, angles=angles)
@settings(max_examples=25, deadline=None)
def test_a_tilted_box_has_the_cells_and_fills_of_half_space_geometry(
    pitch_m: float, edges: list[float], angles: list[float]
) -> None:
    box = tilted(edges, angles)
    shape = Shape(box.surface, pitch_m)
    found = voxelise(shape)
    # What the shrunk cells have in common with it, tried a little smaller and a little larger.
    sure = {c for c, v in box.volumes(shape.tolerance + 1e-6).items() if v > 1e-12}
    possible = {c for c, v in box.volumes(shape.tolerance - 1e-6).items() if v > 0.0}
    exact = box.volumes()
    # A box thin enough to slip between two cells gets one of them beside.
    assert sure <= found.cells
    assert all(cell in possible or exact[cell] < 7 * shape.tolerance for cell in found.cells)
    if sure:
        assert len(found.cells - possible) <= 2
    outermost = np.max(list(found.cells), axis=0)
    for cell in found.cells & possible:
        # What overshoots the last row is counted there; a cell that is solid but for a sliver at
        # its edge is full.
        over = 0.0
        if found.fill[cell] == 1.0 or np.any(np.array(cell) == outermost):
            over = 2 * shape.tolerance
        assert exact[cell] - 2e-5 <= found.fill[cell] <= exact[cell] + over + 2e-5


@pytest.mark.parametrize("pitch_m", PITCHES_M)
def test_an_off_grid_chair_has_the_cells_of_its_boxes(pitch_m: float) -> None:
    boxes = chair(0.35, pitch_m)
    found = voxels(*boxes, pitch_m=pitch_m)
    expected = {
        Cell(x, y, z)
        for box in boxes
        for x in range(math.floor(box.x), math.ceil(box.x + box.width - 1e-6))
        for y in range(math.floor(box.y), math.ceil(box.y + box.depth - 1e-6))
        for z in range(math.floor(box.z), math.ceil(box.z + box.height - 1e-6))
    }
    assert found.cells == expected
    # The union: seat and legs share a volume, and so do seat and back.
    scale = (0.1 / pitch_m) ** 3
    solid = 4 * 0.35**2 * 3.7 + 3.75 * 3.8 * 0.5 + 3.75 * 0.3 * 3.9
    assert sum(found.fill.values()) == pytest.approx(solid * scale, rel=0.01)


@pytest.mark.parametrize("pitch_m", PITCHES_M)
@pytest.mark.parametrize("over_m", [-0.0005, 0.0, 0.0002, 0.0005])
def test_half_a_millimetre_too_much_fills_no_further_row(pitch_m: float, over_m: float) -> None:
    over = over_m / pitch_m
    found = voxels(Box(0, 0, 0, 4 + over, 3 + over, 2 + over), pitch_m=pitch_m)
    assert found.cells == cells_of(Box(0, 0, 0, 4, 3, 2))
    assert min(found.fill.values()) > 0.96


@pytest.mark.parametrize("pitch_m", PITCHES_M)
def test_a_millimetre_too_much_is_in_the_next_row(pitch_m: float) -> None:
    over = 0.001 / pitch_m
    found = voxels(Box(0, 0, 0, 4 + over, 3, 2), pitch_m=pitch_m)
    assert found.cells == cells_of(Box(0, 0, 0, 5, 3, 2))
    assert found.fill[Cell(4, 0, 0)] == pytest.approx(over, rel=1e-6)


def test_an_overshoot_inside_the_shape_fills_nothing_either() -> None:
    over = 0.5 * TOLERANCE_M / 0.1
    found = voxels(Box(0, 0, 0, 5, 4, 1), Box(1 - over, 1 - over, 1, 2 + 2 * over, 2 + over, 2))
    assert found.cells == cells_of(Box(0, 0, 0, 5, 4, 1), Box(1, 1, 1, 2, 2, 2))


def test_the_fill_of_a_sphere_adds_up_to_its_volume() -> None:
    surface = sphere(2.5, rings=80)
    found = voxelise(at_origin(surface))
    assert sum(found.fill.values()) == pytest.approx(4 / 3 * math.pi * 2.5**3, rel=0.003)
    assert all(0.0 < fill <= 1.0 for fill in found.fill.values())
    assert set(found.fill) == found.cells
    assert found.fill[Cell(2, 2, 2)] == 1.0


@given(
    st.lists(
        st.builds(Box, *[st.floats(0, 3)] * 3, *[st.floats(0.2, 2.5)] * 3), min_size=1, max_size=4
    )
)
@settings(max_examples=25, deadline=None)
def test_solids_that_overlap_are_united(boxes: list[Box]) -> None:
    vertices, faces = mesh_of(tuple(boxes), 1.0)
    low = vertices.min(axis=0)
    found = voxelise(Shape(clean(vertices - low, faces)))
    expected = union(boxes, low)
    for cell, share in expected.items():
        assert found.fill.get(cell, 0.0) == pytest.approx(share, abs=0.12)
    assert sum(found.fill.values()) == pytest.approx(sum(expected.values()), rel=0.06)


def union(boxes: list[Box], low: Floats) -> dict[Cell, float]:
    """The exact volume of the union in each cell: every slab between two faces or planes."""
    spans = [[(box[i] - low[i], box[i] + box[i + 3] - low[i]) for box in boxes] for i in range(3)]
    cuts = [
        np.unique(np.concatenate([np.ravel(span), np.arange(np.ceil(np.max(span)) + 1)]))
        for span in spans
    ]
    middles = [(cut[1:] + cut[:-1]) / 2 for cut in cuts]
    solid = np.zeros([len(middle) for middle in middles], dtype=bool)
    for sides in zip(*spans, strict=True):
        within = [(m > start) & (m < end) for m, (start, end) in zip(middles, sides, strict=True)]
        solid |= np.einsum("i,j,k->ijk", *within)
    volume = np.einsum("i,j,k->ijk", *(np.diff(cut) for cut in cuts)) * solid
    found: dict[Cell, float] = {}
    for index in np.argwhere(volume > 0):
        cell = Cell(*(int(middles[i][index[i]]) for i in range(3)))
        found[cell] = found.get(cell, 0.0) + float(volume[tuple(index)])
    return found


def test_a_hollow_that_the_mesh_has_stays_hollow() -> None:
    outer, inner = mesh_of((Box(0, 0, 0, 5, 5, 5),), 1.0), mesh_of((Box(1, 1, 1, 3, 3, 3),), 1.0)
    faces = np.concatenate([outer[1], inner[1][:, ::-1] + len(outer[0])])
    found = voxelise(Shape(clean(np.concatenate([outer[0], inner[0]]), faces)))
    assert found.cells == cells_of(Box(0, 0, 0, 5, 5, 5)) - cells_of(Box(1, 1, 1, 3, 3, 3))


def test_a_shell_within_a_solid_changes_nothing() -> None:
    found = voxels(Box(0, 0, 0, 5, 5, 5), Box(1, 1, 1, 3, 3, 3))
    assert found.cells == cells_of(Box(0, 0, 0, 5, 5, 5))
    assert sum(found.fill.values()) == pytest.approx(125)


def test_a_piece_turned_inside_out_takes_nothing_from_the_others() -> None:
    boxes = [Box(0, 0, 0, 4, 4, 4), Box(1.2, 1.2, 1.2, 4, 4, 4)]
    vertices, faces = mesh_of(tuple(boxes), 1.0)
    faces[: len(faces) // 2] = faces[: len(faces) // 2, ::-1]
    found = voxelise(Shape(clean(vertices, faces)))
    assert found == voxels(*boxes)


def test_solids_that_share_whole_faces_are_solid() -> None:
    cubes = [Box(x, y, z, 1, 1, 1) for x in range(3) for y in range(3) for z in range(3)]
    found = voxels(*cubes)
    assert found.cells == cells_of(*cubes)
    assert min(found.fill.values()) == 1.0


def test_a_tangle_of_large_triangles_is_refused() -> None:
    count = 60_000
    vertices = np.random.default_rng(5).uniform(0.0, 6.0, (3 * count, 3))
    surface = Surface(vertices - vertices.min(axis=0), np.arange(3 * count).reshape(-1, 3))
    with pytest.raises(PlanError, match="tangle of 60000 triangles"):
        voxelise(Shape(surface))
