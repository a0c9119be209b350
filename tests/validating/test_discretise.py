"""Meshes become the right cells, spoilt ones too."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.generating.boxes import Box
from cellctl.mesh import GeneratedMesh
from cellctl.validating.clean import MOST_TRIANGLES, Surface, clean
from cellctl.validating.discretise import discretise, voxelise
from cellctl.validating.files import load_mesh
from cellctl.validating.fit import Shape, fit
from cellctl.validating.orientation import Floats, Ints, oriented
from cellctl.validating.winding import winding_numbers
from tests.validating.shapes import CONFIG, cells_of, shape

whole_boxes = st.lists(
    st.builds(
        Box,
        *(st.integers(0, 4) for _ in range(3)),
        *(st.integers(1, 3) for _ in range(3)),
    ),
    min_size=1,
    max_size=5,
)


def at_origin(surface: Surface, pitch_m: float = 0.1) -> Shape:
    return Shape(Surface(surface.vertices - surface.vertices.min(axis=0), surface.faces), pitch_m)


def sphere(radius: float, rings: int = 24) -> Surface:
    """A closed sphere around (radius, radius, radius)."""
    angles = np.linspace(0, np.pi, rings + 1)
    turns = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    points = [
        (np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), np.cos(a)) for a in angles for t in turns
    ]
    across = 2 * rings
    faces = []
    for i in range(rings):
        for j in range(across):
            a, b = i * across + j, i * across + (j + 1) % across
            faces += [(a, a + across, b), (b, a + across, b + across)]
    return clean((np.array(points) + 1.0) * radius, np.array(faces, dtype=np.int64))


@given(whole_boxes)
@settings(max_examples=60, deadline=None)
def test_boxes_on_cell_planes_fill_their_cells_and_no_neighbour(boxes: list[Box]) -> None:
    low = [min(box[i] for box in boxes) for i in range(3)]
    moved = [box._replace(x=box.x - low[0], y=box.y - low[1], z=box.z - low[2]) for box in boxes]
    assert discretise(shape(*moved)) == cells_of(*moved)


@given(st.lists(st.floats(0.05, 4.5), min_size=6, max_size=6))
@settings(max_examples=60, deadline=None)
def test_a_cell_is_occupied_if_any_portion_is_inside(numbers: list[float]) -> None:
    corner, extent = np.array(numbers[:3]), np.array(numbers[3:])
    anchor = Box(0, 0, 0, 1, 1, 1)
    found = discretise(shape(anchor, Box(*corner, *extent)))
    # Within the skin of a plane either answer is right.
    sure = np.floor(corner + 0.01), np.ceil(corner + extent - 0.01)
    for x in range(int(sure[0][0]), int(sure[1][0])):
        for y in range(int(sure[0][1]), int(sure[1][1])):
            for z in range(int(sure[0][2]), int(sure[1][2])):
                assert Cell(x, y, z) in found
    most = np.ceil(corner + extent)
    for cell in found - {Cell(0, 0, 0)}:
        assert all(np.floor(corner)[i] <= cell[i] < most[i] for i in range(3))


def test_a_sphere_fills_every_cell_it_enters() -> None:
    radius = 2.5
    found = discretise(at_origin(sphere(radius)))
    centre = np.full(3, radius)
    for index in np.ndindex(5, 5, 5):
        low = np.array(index, dtype=np.float64)
        nearest = np.clip(centre, low, low + 1)
        away = np.linalg.norm(nearest - centre)
        if abs(away - radius) > 0.05:  # the facets lie a little inside the sphere
            assert (Cell(*index) in found) == (away < radius)


def spoil(kind: str, surface: Surface, rng: np.random.Generator) -> tuple[Floats, Ints]:
    vertices, faces = surface.vertices.copy(), surface.faces.copy()
    if kind == "soup":
        return vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    if kind == "flipped":
        some = rng.random(len(faces)) < 0.3
        faces[some] = faces[some][:, ::-1]
    elif kind == "inside out":
        faces = faces[:, ::-1]
    elif kind == "holes":
        faces = faces[rng.random(len(faces)) > 0.05]
    elif kind == "half flipped, holes, soup":
        vertices, faces = spoil("holes", surface, rng)
        some = rng.random(len(faces)) < 0.5
        faces[some] = faces[some][:, ::-1]
        return spoil("soup", Surface(vertices, faces), rng)
    elif kind == "copied":
        faces = np.concatenate([faces, faces])
    elif kind == "double-sided in part":
        faces = np.concatenate([faces, faces[: len(faces) // 5, ::-1]])
    elif kind == "doubled":
        faces = np.concatenate([faces, faces[:, ::-1]])
    elif kind == "not finite":
        vertices = np.concatenate([vertices, np.full((3, 3), np.nan)])
        faces = np.concatenate([faces, [[len(vertices) - 3, len(vertices) - 2, 0]]])
    elif kind == "degenerate":
        faces = np.concatenate([faces, [[0, 0, 1], [2, 2, 2]]])
    return vertices, faces


SPOILT = (
    "soup",
    "flipped",
    "inside out",
    "holes",
    "half flipped, holes, soup",
    "copied",
    "doubled",
    "double-sided in part",
    "not finite",
    "degenerate",
)


@pytest.mark.parametrize("kind", SPOILT)
@pytest.mark.parametrize("pitch_m", [0.1, 0.05])
def test_a_spoilt_mesh_fills_the_same_cells(kind: str, pitch_m: float) -> None:
    good = sphere(2.5)
    spoilt = clean(*spoil(kind, good, np.random.default_rng(7)))
    found, expected = voxelise(at_origin(spoilt, pitch_m)), voxelise(at_origin(good, pitch_m))
    assert found.cells == expected.cells
    solid = sum(expected.fill.values())
    assert sum(found.fill.values()) == pytest.approx(solid, rel=0.06 if "holes" in kind else 1e-3)


def fitted(
    test_data: Path, pitch_m: float, share: slice = slice(None)
) -> Iterator[tuple[GeneratedMesh, CellConfig]]:
    """The evaluation meshes, as high as they should be, and a cell of that pitch."""
    voxel = CONFIG.voxel.model_copy(update={"pitch_m": pitch_m})
    folder = test_data / "meshes"
    for entry in json.loads((folder / "manifest.json").read_text())[share]:
        height_cm = entry.get("suggested_height_cm")
        mesh = load_mesh(folder / entry["file"], height_m=height_cm / 100 if height_cm else None)
        yield mesh, CONFIG.model_copy(update={"voxel": voxel})


@pytest.mark.parametrize("third", range(3))
@pytest.mark.parametrize("pitch_m", [0.1, 0.05])
def test_meshes_of_generators_fit_the_workspace(
    test_data: Path, pitch_m: float, third: int
) -> None:
    meshes = list(fitted(test_data, pitch_m, slice(third, None, 3)))
    assert meshes
    for mesh, config in meshes:
        found = voxelise(fit(mesh, config).shape)
        size = np.max(list(found.cells), axis=0) + 1
        assert np.all(size <= config.grid)
        assert np.any(size == config.grid)
        assert min(found.fill.values()) > 0.0


@pytest.mark.soak
@pytest.mark.timeout(900)
@pytest.mark.parametrize("pitch_m", [0.1, 0.05])
def test_meshes_of_generators_become_the_same_cells_when_spoilt(
    test_data: Path, pitch_m: float
) -> None:
    rng = np.random.default_rng(11)
    for mesh, config in fitted(test_data, pitch_m):
        found = voxelise(fit(mesh, config).shape)
        for kind in ("soup", "flipped", "inside out", "copied", "doubled", "double-sided in part"):
            vertices, faces = spoil(kind, Surface(mesh.vertices, mesh.faces), rng)
            spoilt = dataclasses.replace(mesh, vertices=vertices, faces=faces)
            cells = voxelise(fit(spoilt, config).shape).cells
            assert cells == found.cells, (mesh.title, kind)


def test_many_small_triangles_are_summed_as_well_as_one_by_one() -> None:
    surface = sphere(2.5, rings=48)
    assert len(surface.faces) > 4000
    inside = np.array([[2.5, 2.5, 2.5], [1.5, 2.5, 2.5], [2.5, 3.9, 2.5]])
    outside = np.array([[0.3, 0.3, 0.3], [9.0, 2.5, 2.5]])
    assert np.allclose(winding_numbers(surface, inside), 1.0, atol=0.02)
    assert np.allclose(winding_numbers(surface, outside), 0.0, atol=0.02)


def test_turning_makes_every_piece_enclose_its_inside() -> None:
    one = sphere(1.0)
    faces = np.concatenate([one.faces, one.faces[:, ::-1] + len(one.vertices)])
    both = Surface(np.concatenate([one.vertices, one.vertices + 5.0]), faces)
    centres = np.array([[1.0, 1.0, 1.0], [6.0, 6.0, 6.0]])
    assert np.allclose(winding_numbers(both, centres), [1.0, -1.0], atol=0.01)
    turned = Surface(both.vertices, oriented(*both))
    assert np.allclose(winding_numbers(turned, centres), 1.0, atol=0.01)


def test_an_open_sheet_on_a_cell_plane_is_not_lost() -> None:
    legs = shape(Box(0, 0, 0, 1, 3, 3), Box(4, 0, 0, 1, 3, 3)).surface
    sheet = np.array([[0, 0, 2], [5, 0, 2], [5, 3, 2], [0, 3, 2]], dtype=np.float64)
    faces = np.array([[0, 1, 2], [0, 2, 3]]) + len(legs.vertices)
    both = Surface(np.concatenate([legs.vertices, sheet]), np.concatenate([legs.faces, faces]))
    found = discretise(Shape(both))
    layers = {z for x, y, z in found if x == 2}
    assert layers == {2}
    assert found == cells_of(Box(0, 0, 0, 1, 3, 3), Box(4, 0, 0, 1, 3, 3), Box(1, 0, 2, 3, 3, 1))


@pytest.mark.parametrize(
    ("vertices", "faces", "said"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3)), "no face"),
        (np.full((3, 3), np.nan), np.array([[0, 1, 2]]), "no face of its mesh has finite"),
        (np.ones((3, 3)), np.array([[0, 1, 2]]), "single point"),
        (np.eye(3), np.array([[0, 0, 1]]), "point or line"),
        (
            np.eye(3) * 1e12,
            np.array([[0, 1, 2]]),
            "absurdly large: its mesh has a coord",
        ),
        (np.eye(3), np.array([[0, 1, 7], [-1, 0, 1]]), "no face of its mesh has finite"),
    ],
)
def test_a_mesh_with_nothing_in_it_is_refused(vertices: Floats, faces: Floats, said: str) -> None:
    with pytest.raises(PlanError, match=said):
        clean(vertices, faces.astype(np.int64))


def test_a_mesh_of_too_many_triangles_is_refused() -> None:
    faces = np.zeros((MOST_TRIANGLES + 1, 3), dtype=np.int64)
    with pytest.raises(PlanError, match="5000001 triangles; at most 5000000"):
        clean(np.eye(3), faces)
