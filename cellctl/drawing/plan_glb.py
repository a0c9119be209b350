"""The steps of a plan as a GLB: a node for each part, coloured by order, and an animation.

Without its animation the file shows the finished object; played, each part comes down to its place
in its turn, and what is taken away goes up. After the glTF 2.0 specification: metres, y up, so that
a point ``(x, y, z)`` of the cell's workspace is ``(x, z, -y)`` there.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from cellctl.assembly import BuildPlan, Weakest
from cellctl.drawing.cuboctahedron import faces
from cellctl.drawing.glb import TRIANGLES, VERTICES, Buffer, material, packed
from cellctl.drawing.plan_steps import Life, lives_of, order_colour
from cellctl.drawing.scene import WRONG, Colour

Floats = npt.NDArray[np.float64]

STEP_S: Final = 0.5
"""From one step of the animation to the next, in seconds of the viewer's time."""
LONGEST_S: Final = 40.0
"""All steps together take no longer than this; many steps follow each other faster."""
REST_S: Final = 2.0
"""How long the finished object is seen before a viewer begins anew."""
DROP_CELLS: Final = 1.5
"""From how high above its place a part comes down."""


class _Document:
    """The scene under construction: nodes with a mesh and a colour of their own, and a movement."""

    def __init__(self) -> None:
        self.buffer = Buffer()
        self.materials: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.nodes: list[dict[str, Any]] = []
        self.samplers: list[dict[str, Any]] = []
        self.channels: list[dict[str, Any]] = []

    def add_node(
        self, name: str, geometry: dict[str, Any], colour: Colour, extras: dict[str, Any]
    ) -> dict[str, Any]:
        """A new node of that name; returns it, to be placed."""
        self.materials.append(_material(colour))
        primitive = {**geometry, "material": len(self.materials) - 1}
        self.meshes.append({"name": name, "primitives": [primitive]})
        node = {"name": name, "mesh": len(self.meshes) - 1, "extras": extras}
        self.nodes.append(node)
        return node

    def move_last_node(self, path: str, times: Floats, values: Floats) -> None:
        """Let a property of the node that was added last go through values at times."""
        self.samplers.append(
            {
                "input": self.buffer.add(times, "SCALAR"),
                "output": self.buffer.add(values, "VEC3"),
                "interpolation": "LINEAR",
            }
        )
        target = {"node": len(self.nodes) - 1, "path": path}
        self.channels.append({"sampler": len(self.samplers) - 1, "target": target})

    def packed(self, title: str, extras: dict[str, Any]) -> bytes:
        """The content of a GLB file."""
        tree: dict[str, Any] = {
            "scene": 0,
            "scenes": [{"name": title, "nodes": list(range(len(self.nodes))), "extras": extras}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
        }
        if self.channels:
            build = {"name": "build", "samplers": self.samplers, "channels": self.channels}
            tree["animations"] = [build]
        return packed(tree, self.buffer)


def steps_glb(plan: BuildPlan) -> bytes:
    """The plan's steps as the content of a GLB file.

    Nodes are named ``part 07 [2, 3, 0]``, numbered from 1 as the parts are placed, or ``standing
    [2, 3, 0]`` for what stood before; their ``extras`` have ``part``, ``index`` (of the step, from
    0), ``cell``, ``margin`` and ``removed`` (the index of the step that takes it away). A plate
    named ``weakest joint`` lies in the joint of that name where the plan has one.

    A plan without steps gives its object alone, standing, without an animation.
    """
    document = _Document()
    geometry = _part_geometry(document.buffer, plan.pitch_m)
    lives = lives_of(plan)
    total = len(plan.steps)
    pace_s = min(STEP_S, LONGEST_S / max(1, total))
    margins = {step.index: step.margin for step in plan.steps}
    digits = max(2, len(str(total)))
    number = 0
    for life in lives:
        if life.placed is None:
            what, part = "standing", None
        else:
            number += 1
            what, part = f"part {number:0{digits}d}", number
        extras = {
            "part": part,
            "index": life.placed,
            "cell": list(life.cell),
            "margin": _finite(margins[life.placed]) if life.placed is not None else None,
            "removed": life.removed,
        }
        colour = order_colour(life.placed, total)
        node = document.add_node(f"{what} {list(life.cell)}", geometry, colour, extras)
        at = _place(np.array(life.cell) + 0.5, plan.pitch_m)
        node["translation"] = at.tolist()
        if life.removed is not None:
            node["scale"] = [0.0, 0.0, 0.0]  # the file at rest shows the finished object
        for path, times, values in _movement(life, at, plan.pitch_m, pace_s, total):
            document.move_last_node(path, times, values)
    if (weakest := plan.weakest) is not None:
        plate = _weak_plate(document.buffer, weakest, plan.pitch_m)
        between = [list(weakest.cell), list(weakest.other)]
        joint = {"between": between, "margin": weakest.margin, "index": weakest.step}
        document.add_node("weakest joint", plate, WRONG, joint)
    about = {"plan_id": plan.plan_id, "pitch_m": plan.pitch_m, "steps": total}
    return document.packed(plan.title, about)


def _place(point: Floats, pitch_m: float) -> Floats:
    """A point in cells as metres of glTF, y up."""
    x, y, z = point * pitch_m
    return np.array([x, z, -y])


def _part_geometry(buffer: Buffer, pitch_m: float) -> dict[str, Any]:
    """The one shape that all parts share, flat faces with corners of their own."""
    polygons = [(_place(n, 1.0), [_place(c, pitch_m) for c in corners]) for n, corners in faces()]
    return _primitive(buffer, polygons)


def _weak_plate(buffer: Buffer, weakest: Weakest, pitch_m: float) -> dict[str, Any]:
    """A thin plate in the joint, wider than the faces that touch there, so that it is seen."""
    a, b = np.array(weakest.cell) + 0.5, np.array(weakest.other) + 0.5
    axis = int(np.argmax(np.abs(b - a)))
    middle = (a + b) / 2.0
    # The form of a part, pressed flat: it shows all around in the groove between the two.
    stretch = np.full(3, 0.94)
    stretch[axis] = 0.05
    polygons = []
    for normal, corners in faces():
        leaning = normal / stretch
        polygons.append(
            (
                _place(leaning / np.linalg.norm(leaning), 1.0),
                [_place(middle + corner * stretch, pitch_m) for corner in corners],
            )
        )
    return _primitive(buffer, polygons)


def _primitive(buffer: Buffer, polygons: list[tuple[Floats, list[Floats]]]) -> dict[str, Any]:
    """Convex polygons, each a normal and its corners, as triangles."""
    vertices: list[Floats] = []
    normals: list[Floats] = []
    triangles: list[tuple[int, int, int]] = []
    for normal, corners in polygons:
        first = len(vertices)
        vertices += corners
        normals += [normal / np.linalg.norm(normal)] * len(corners)
        triangles += [(first, first + k, first + k + 1) for k in range(1, len(corners) - 1)]
    return {
        "attributes": {
            "POSITION": buffer.add(np.array(vertices), "VEC3", VERTICES),
            "NORMAL": buffer.add(np.array(normals), "VEC3", VERTICES),
        },
        "indices": buffer.add(
            np.array(triangles, dtype=np.uint16).reshape(-1), "SCALAR", TRIANGLES
        ),
    }


def _material(colour: Colour) -> dict[str, Any]:
    """A matt surface of a screen's colour."""
    linear = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour)
    return material(tuple(linear))


def _movement(
    life: Life, at: Floats, pitch_m: float, pace_s: float, total: int
) -> list[tuple[str, Floats, Floats]]:
    """How a part comes and goes: (property, times (n,), values (n, 3)); nothing if it stays."""
    above = at + np.array([0.0, DROP_CELLS * pitch_m, 0.0])
    gone, there = np.zeros(3), np.ones(3)
    keys: list[tuple[float, Floats, Floats]] = []
    if life.placed is not None:
        began_s = life.placed * pace_s
        if began_s > 0.0:
            keys.append((0.0, gone, above))
        keys += [
            (began_s, gone, above),
            (began_s + 0.3 * pace_s, there, above),
            (began_s + pace_s, there, at),
        ]
    elif life.removed is not None:
        keys.append((0.0, there, at))
    if life.removed is not None:
        began_s = life.removed * pace_s
        if began_s > keys[-1][0]:
            keys.append((began_s, there, at))
        keys += [(began_s + 0.7 * pace_s, there, above), (began_s + pace_s, gone, above)]
    if not keys:
        return []
    end_s = total * pace_s + REST_S
    keys.append((end_s, keys[-1][1], keys[-1][2]))
    times = np.array([key[0] for key in keys])
    return [
        ("scale", times, np.array([key[1] for key in keys])),
        ("translation", times, np.array([key[2] for key in keys])),
    ]


def _finite(margin: float | None) -> float | None:
    """JSON knows no infinity: a step that needs no magnet has no margin."""
    return margin if margin is not None and np.isfinite(margin) else None
