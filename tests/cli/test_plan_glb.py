"""The GLB of the steps, read back by a mesh library and by the letter of its format."""

from __future__ import annotations

import io
import json
import struct
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import trimesh

from cellctl.assembly import BuildPlan, Cell
from cellctl.drawing.plan_glb import LONGEST_S, STEP_S, steps_glb
from cellctl.drawing.plan_steps import lives_of
from tests.cli.plans import (
    BEAM,
    WEAKEST,
    beam,
    changeover,
    placing,
    plan_of,
    standing_already,
    taking_apart,
)

TYPES = {"SCALAR": 1, "VEC3": 3}


class Parsed:
    """The two chunks of a GLB, taken apart by the specification alone."""

    def __init__(self, content: bytes) -> None:
        magic, version, length = struct.unpack_from("<4sII", content, 0)
        assert (magic, version, length) == (b"glTF", 2, len(content))
        size, kind = struct.unpack_from("<I4s", content, 12)
        assert kind == b"JSON"
        assert size % 4 == 0
        self.tree: dict[str, Any] = json.loads(content[20 : 20 + size])
        binary, kind = struct.unpack_from("<I4s", content, 20 + size)
        assert kind == b"BIN\x00"
        self.binary = content[28 + size :]
        assert len(self.binary) == binary == self.tree["buffers"][0]["byteLength"]

    def accessor(self, index: int) -> npt.NDArray[Any]:
        entry = self.tree["accessors"][index]
        view = self.tree["bufferViews"][entry["bufferView"]]
        dtype = "<f4" if entry["componentType"] == 5126 else "<u2"
        width = TYPES[entry["type"]]
        flat = np.frombuffer(
            self.binary, dtype, count=entry["count"] * width, offset=view["byteOffset"]
        )
        values = flat.reshape(-1, width)
        assert values.min(axis=0).tolist() == pytest.approx(entry["min"])
        assert values.max(axis=0).tolist() == pytest.approx(entry["max"])
        return values

    def sampled(self, path: str, seconds: float) -> dict[str, npt.NDArray[np.float64]]:
        """A property of every node at a time of the animation, by the node's name."""
        found = {}
        animation = self.tree["animations"][0]
        for channel in animation["channels"]:
            if channel["target"]["path"] == path:
                sampler = animation["samplers"][channel["sampler"]]
                times = self.accessor(sampler["input"])[:, 0]
                assert (np.diff(times) > 0).all()
                values = self.accessor(sampler["output"])
                name = self.tree["nodes"][channel["target"]["node"]]["name"]
                found[name] = np.array([np.interp(seconds, times, axis) for axis in values.T])
        return found


def seen_at(parsed: Parsed, seconds: float) -> set[Cell]:
    """The cells in which a part is at its full size and in its place."""
    scales = parsed.sampled("scale", seconds)
    places = parsed.sampled("translation", seconds)
    seen = set()
    for node in parsed.tree["nodes"]:
        if node["name"] == "weakest joint":
            continue
        at = places.get(node["name"], np.array(node["translation"]))
        scale = scales.get(node["name"], np.ones(3))
        cell = Cell(*node["extras"]["cell"])
        centre = np.array([cell.x + 0.5, cell.z + 0.5, -cell.y - 0.5]) * 0.1
        if scale == pytest.approx(np.ones(3)) and at == pytest.approx(centre, abs=1e-6):
            seen.add(cell)
    return seen


def test_a_mesh_library_reads_names_places_and_metres() -> None:
    scene = trimesh.load_scene(io.BytesIO(steps_glb(beam())), file_type="glb")
    names = [f"part {k:02d} {list(cell)}" for k, cell in enumerate(BEAM, start=1)]
    assert sorted(scene.graph.nodes_geometry) == sorted([*names, "weakest joint"])
    for name, cell in zip(names, BEAM, strict=True):
        matrix, _ = scene.graph[name]
        # y is up, and metres: the cell's z is the file's y, its y goes away from the viewer.
        centre = [(cell.x + 0.5) * 0.1, (cell.z + 0.5) * 0.1, -(cell.y + 0.5) * 0.1]
        assert matrix[:3, 3] == pytest.approx(centre)
    assert scene.bounds == pytest.approx(np.array([[0.0, 0.0, -0.1], [0.3, 0.2, 0.0]]), abs=1e-6)
    part = scene.geometry[scene.graph[names[0]][1]]
    # A cuboctahedron of edge a has 5/3 sqrt(2) a^3, here with a = 0.1 / sqrt(2).
    assert part.volume == pytest.approx(5 / 3 * 2**0.5 * (0.1 / 2**0.5) ** 3)


def test_the_colours_tell_the_order() -> None:
    tree = Parsed(steps_glb(beam())).tree
    colours = [
        tree["materials"][tree["meshes"][node["mesh"]]["primitives"][0]["material"]][
            "pbrMetallicRoughness"
        ]["baseColorFactor"]
        for node in tree["nodes"]
    ]
    assert len({tuple(colour) for colour in colours}) == len(BEAM) + 1
    brightness = [sum(colour[:3]) for colour in colours[: len(BEAM)]]
    assert brightness == sorted(brightness)


def test_the_weakest_joint_is_marked_where_it_is() -> None:
    parsed = Parsed(steps_glb(beam()))
    node = parsed.tree["nodes"][-1]
    assert node["name"] == "weakest joint"
    assert node["extras"] == {"between": [[1, 0, 1], [0, 0, 1]], "margin": 1.5, "index": 3}
    primitive = parsed.tree["meshes"][node["mesh"]]["primitives"][0]
    points = parsed.accessor(primitive["attributes"]["POSITION"])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    assert middle == pytest.approx([0.1, 0.15, -0.05], abs=1e-6)
    assert np.ptp(points, axis=0)[0] < 0.01 < np.ptp(points, axis=0)[1]


def test_faces_look_outward_with_normals_of_length_one() -> None:
    parsed = Parsed(steps_glb(beam()))
    for mesh in (parsed.tree["meshes"][0], parsed.tree["meshes"][-1]):
        primitive = mesh["primitives"][0]
        points = parsed.accessor(primitive["attributes"]["POSITION"]).astype(np.float64)
        normals = parsed.accessor(primitive["attributes"]["NORMAL"]).astype(np.float64)
        corners = points[parsed.accessor(primitive["indices"]).reshape(-1, 3)]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        told = normals[parsed.accessor(primitive["indices"]).reshape(-1, 3)[:, 0]]
        assert across == pytest.approx(told, abs=1e-4)
        outward = corners.mean(axis=1) - points.mean(axis=0)
        assert (np.einsum("ij,ij->i", outward, told) > 0).all()


@pytest.mark.parametrize("plan", [beam(), changeover(), taking_apart()], ids=lambda p: p.steps[0])
def test_the_animation_plays_the_steps(plan: BuildPlan) -> None:
    parsed = Parsed(steps_glb(plan))
    for done in range(len(plan.steps) + 1):
        expected = {life.cell for life in lives_of(plan) if life.stands_after(done)}
        assert seen_at(parsed, done * STEP_S) == expected


def test_without_its_animation_the_file_shows_the_finished_object() -> None:
    for plan in (beam(), changeover(), taking_apart()):
        nodes = Parsed(steps_glb(plan)).tree["nodes"]
        visible = [
            tuple(node["extras"]["cell"])
            for node in nodes
            if node["name"] != "weakest joint" and node.get("scale") != [0.0, 0.0, 0.0]
        ]
        assert sorted(visible) == sorted(plan.assembly.cells)


def test_a_plan_without_steps_is_its_object_at_rest() -> None:
    parsed = Parsed(steps_glb(standing_already()))
    assert [node["name"] for node in parsed.tree["nodes"]] == [
        f"standing {list(cell)}" for cell in sorted(BEAM, key=lambda c: (c.z, c.x, c.y))
    ]
    assert "animations" not in parsed.tree


def test_many_steps_follow_each_other_faster() -> None:
    cells = [Cell(x, y, 0) for x in range(20) for y in range(10)]
    parsed = Parsed(steps_glb(plan_of(placing(cells), cells)))
    assert seen_at(parsed, LONGEST_S) == set(cells)
    assert len(seen_at(parsed, LONGEST_S / 2)) == pytest.approx(100, abs=1)
    assert parsed.tree["nodes"][0]["name"] == "part 001 [0, 0, 0]"


def test_a_joint_with_the_floor_lies_on_the_floor() -> None:
    weakest = WEAKEST.model_copy(update={"cell": Cell(0, 0, 0), "other": Cell(0, 0, -1)})
    parsed = Parsed(steps_glb(beam().model_copy(update={"weakest": weakest})))
    primitive = parsed.tree["meshes"][-1]["primitives"][0]
    points = parsed.accessor(primitive["attributes"]["POSITION"])
    assert points[:, 1].mean() == pytest.approx(0.0, abs=1e-6)
