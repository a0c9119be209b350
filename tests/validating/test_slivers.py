"""Thin things on the planes between cells: there once, and always on the same side."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.generating.boxes import Box, mesh_of
from cellctl.validating.clean import Surface, clean
from cellctl.validating.discretise import Voxels, voxelise
from cellctl.validating.fit import TOLERANCE_M, Shape
from tests.validating.shapes import cells_of

LEGS = [Box(x, y, 0, 1, 1, 4) for x in (0, 4) for y in (0, 3)]
BACK = [Box(0, 3, 4, 1, 1, 3), Box(4, 3, 4, 1, 1, 3)]


def voxels(*boxes: Box, pitch_m: float = 0.1) -> Voxels:
    return voxelise(Shape(clean(*mesh_of(boxes, 1.0)), pitch_m))


def with_sheet(corners: list[list[float]], *boxes: Box) -> Voxels:
    """Boxes, and an open four-cornered sheet."""
    vertices, faces = mesh_of(boxes, 1.0)
    sheet = np.array([[0, 1, 2], [0, 2, 3]]) + len(vertices)
    both = np.concatenate([vertices, np.array(corners)]), np.concatenate([faces, sheet])
    return voxelise(Shape(clean(*both)))


@given(st.floats(0.02, 0.95), st.floats(0.01, 0.99), st.sampled_from([0.1, 0.05]))
@settings(max_examples=30, deadline=None)
def test_a_thin_seat_on_a_plane_joins_its_legs_and_is_there_once(
    thickness: float, place: float, pitch_m: float
) -> None:
    """Up to 1 mm thick, anywhere within half a millimetre of the plane."""
    tolerance = TOLERANCE_M / pitch_m
    thick = thickness * 2 * tolerance
    low = 4 - tolerance + place * (2 * tolerance - thick)
    found = voxels(*LEGS, *BACK, Box(0, 0, low, 5, 4, thick), pitch_m=pitch_m)
    seat = cells_of(Box(0, 0, 3, 5, 4, 1))
    assert found.cells == cells_of(*LEGS, *BACK) | seat
    assert all(0.0 < found.fill[cell] < 0.02 for cell in seat - cells_of(*LEGS))


@pytest.mark.parametrize("axis", [0, 1, 2])
@given(st.integers(1, 3), st.floats(-1, 1))
@settings(max_examples=20, deadline=None)
def test_a_thin_rod_on_planes_is_one_cell_thick(axis: int, plane: int, off: float) -> None:
    """Standing on, or lying between, two blocks; 0.4 mm thick, up to 0.3 mm off the line."""
    thick = 0.004
    corner, edges = np.full(3, plane - thick / 2 + off * 0.003), np.full(3, thick)
    corner[axis], edges[axis] = 1.0, 3.0
    ends = []
    for start in (0.0, 4.0):
        low, size = np.zeros(3), np.full(3, 5.0)
        low[axis], size[axis] = start, 1.0
        ends.append(Box(*low, *size))
    found = voxels(*ends, Box(*corner, *edges))
    rod = found.cells - cells_of(*ends)
    assert sorted(cell[axis] for cell in rod) == [1, 2, 3]
    others = [i for i in range(3) if i != axis]
    assert len({tuple(cell[i] for i in others) for cell in rod}) == 1
    assert all(cell[i] in (plane - 1, plane) for cell in rod for i in others)


def test_a_rod_that_ends_in_a_layer_does_not_grow_into_the_next_cell() -> None:
    found = voxels(Box(0, 0, 0, 4, 4, 1), Box(1.998, 1.3, 1, 0.004, 0.004, 2.004))
    assert len(found.cells) == 16 + 2


def test_thin_panels_that_mirror_each_other_stay_mirrored() -> None:
    panels = [Box(x - 0.002, 0, 1, 0.004, 6, 3) for x in (1, 5)]
    found = voxels(Box(0, 0, 0, 6, 6, 1), *panels)
    assert {cell.x for cell in found.cells if cell.z > 0} == {1, 4}
    assert len(found.cells) == 36 + 2 * 6 * 3


@pytest.mark.parametrize("height", [1.0, 2.0, 3.0])
def test_an_open_sheet_between_panels_is_one_layer(height: float) -> None:
    sides = [Box(0, 0, 0, 1, 3, 4), Box(4, 0, 0, 1, 3, 4)]
    corners = [[0.0, 0.0, height], [5.0, 0.0, height], [5.0, 3.0, height], [0.0, 3.0, height]]
    found = with_sheet(corners, *sides)
    assert found.cells == cells_of(*sides, Box(1, 0, int(height), 3, 3, 1))
    assert all(0.0 < fill <= 1.0 for fill in found.fill.values())


def test_an_open_sheet_on_the_outermost_plane_is_within() -> None:
    corners = [[0.0, 0.0, 3.0], [5.0, 0.0, 3.0], [5.0, 3.0, 3.0], [0.0, 3.0, 3.0]]
    posts = [Box(x, y, 0, 1, 1, 3) for x in (0, 4) for y in (0, 2)]
    assert with_sheet(corners, *posts).cells == cells_of(*posts, Box(0, 0, 2, 5, 3, 1))


def test_a_nearly_level_sheet_that_crosses_a_plane_has_no_gap() -> None:
    """It rises by 3 mm over 50 cm: below the plane, in its layer, above it."""
    corners = [[0.0, 0.0, 1.985], [5.0, 0.0, 2.015], [5.0, 2.0, 2.015], [0.0, 2.0, 1.985]]
    found = with_sheet(corners, Box(0, 0, 0, 1, 2, 1), Box(4, 0, 3, 1, 2, 1))
    sheet = {cell for cell in found.cells if cell.z in (1, 2)}
    assert {(cell.x, cell.y) for cell in sheet} == {(x, y) for x in range(5) for y in range(2)}


def test_a_lone_sheet_thinner_than_the_layer_is_a_layer() -> None:
    assert voxels(Box(0, 0, 0, 3, 2, 0.004)).cells == cells_of(Box(0, 0, 0, 3, 2, 1))


def test_an_overshoot_is_no_thin_thing() -> None:
    """A lip of half a millimetre around a board is no sheet beside it."""
    lip = 0.005
    board = Box(1 - lip, 1 - lip, 1, 4 + 2 * lip, 4 + 2 * lip, 1 + lip)
    found = voxels(Box(0, 0, 0, 6, 6, 1), board)
    assert Cell(0, 1, 1) not in found.cells
    assert found.cells == cells_of(Box(0, 0, 0, 6, 6, 1), Box(1, 1, 1, 4, 4, 1))


def test_the_order_of_triangles_does_not_matter() -> None:
    surface = clean(*mesh_of((*LEGS, Box(0, 0, 3.998, 5, 4, 0.004)), 1.0))
    order = np.random.default_rng(2).permutation(len(surface.faces))
    mixed = Surface(surface.vertices, surface.faces[order])
    assert voxelise(Shape(mixed)).cells == voxelise(Shape(surface)).cells
