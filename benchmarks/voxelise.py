"""How long a mesh takes to become cells: ``python -m benchmarks.voxelise [--million] [MESH ...]``.

Every method gets the same shapes in the same run, from vertices and faces in memory, and is
compared with an exact reference: the cells that the solid meets, by closed formulas. ``cellctl``
includes cleaning the mesh; the baselines do not. Times are medians of wall time; the table also has
the time of the processor, which other programs do not distort.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import trimesh

from cellctl.generating.boxes import Box, mesh_of
from cellctl.validating.clean import clean
from cellctl.validating.discretise import voxelise
from cellctl.validating.files import load_mesh
from cellctl.validating.fit import TOLERANCE_M, Shape
from cellctl.validating.orientation import Floats, Ints

Index = tuple[int, ...]
Method = Callable[[Floats, Ints], set[Index]]

PITCH_M = 0.1


class Case(NamedTuple):
    """A solid as a fine mesh, measured in cells from the origin, and the cells that it meets."""

    name: str
    vertices: Floats
    faces: Ints
    exact: set[Index]


def boxes_case(name: str, boxes: tuple[Box, ...], triangles: int) -> Case:
    """Boxes, each face divided until there are about so many triangles."""
    vertices, faces = mesh_of(boxes, 1.0)
    vertices, faces = finer(vertices, faces, triangles)
    exact = set()
    for box in boxes:
        low = np.floor(np.array(box[:3]) + TOLERANCE_M / PITCH_M).astype(int)
        high = np.ceil(np.array(box[:3]) + np.array(box[3:]) - TOLERANCE_M / PITCH_M).astype(int)
        exact |= {tuple((low + step).tolist()) for step in np.ndindex(*(high - low))}
    return Case(name, vertices, faces, exact)


def ball_case(radius: float, triangles: int) -> Case:
    """A ball; its facets lie within it by less than the tolerance at any of these sizes."""
    ball = trimesh.creation.uv_sphere(radius, count=[round((triangles / 4) ** 0.5)] * 2)
    exact = set()
    for index in np.ndindex(*[int(np.ceil(2 * radius))] * 3):
        low = np.array(index) + TOLERANCE_M / PITCH_M
        nearest = np.clip(radius, low, low + 1 - 2 * TOLERANCE_M / PITCH_M)
        if np.linalg.norm(nearest - radius) < radius:
            exact.add(index)
    vertices = np.asarray(ball.vertices) - ball.bounds[0]
    return Case("ball", vertices, np.asarray(ball.faces, dtype=np.int64), exact)


def tilted_cases(count: int, triangles: int) -> list[Case]:
    """Boxes in any attitude; a cell and a box meet unless one of 15 axes separates them."""
    rng = np.random.default_rng(1)
    found = []
    for number in range(count):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        half = rng.uniform(0.1, 1.8, 3)
        centre = np.abs(turn) @ half
        vertices, faces = mesh_of((Box(0, 0, 0, *(2 * half).tolist()),), 1.0)
        vertices, faces = finer((vertices - half) @ turn.T + centre, faces, triangles)
        if np.linalg.det(turn) < 0:
            faces = faces[:, ::-1]
        across = [np.cross(np.eye(3)[i], turn[:, j]) for i in range(3) for j in range(3)]
        axes = np.concatenate([np.eye(3), turn.T, across])
        reach = np.abs(axes @ turn) @ half + np.abs(axes).sum(axis=1) * (
            0.5 - TOLERANCE_M / PITCH_M
        )
        exact = {
            index
            for index in np.ndindex(*np.ceil(2 * centre).astype(int).tolist())
            if np.all(np.abs(axes @ (np.array(index) + 0.5 - centre)) <= reach)
        }
        found.append(Case(f"tilted box {number + 1}", vertices, faces, exact))
    return found


def finer(vertices: Floats, faces: Ints, triangles: int) -> tuple[Floats, Ints]:
    """Divide every triangle into equal parts, to about so many in all; the vertices unwelded."""
    parts = max(1, round((triangles / len(faces)) ** 0.5))
    rows = [(i, j) for i in range(parts) for j in range(parts - i)]
    corners = [((i, j), (i + 1, j), (i, j + 1)) for i, j in rows]
    corners += [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in rows if i + j < parts - 1]
    weights = np.array(corners, dtype=np.float64) / parts
    a, b, c = (vertices[faces[:, corner]][:, None, None] for corner in range(3))
    u, v = weights[None, :, :, :1], weights[None, :, :, 1:]
    points = (a + u * (b - a) + v * (c - a)).reshape(-1, 3)
    return points, np.arange(len(points)).reshape(-1, 3)


def ours(vertices: Floats, faces: Ints) -> set[Index]:
    """Cleaned, oriented, voxelised, with fill fractions."""
    return set(voxelise(Shape(clean(vertices, faces), PITCH_M)).cells)


def voxelized(vertices: Floats, faces: Ints) -> set[Index]:
    """``trimesh``: surface voxels and a fill; its cells are centred on whole numbers."""
    mesh = trimesh.Trimesh(vertices - 0.5, faces, process=False)
    grid = mesh.voxelized(1.0).fill()
    return {(int(x), int(y), int(z)) for x, y, z in np.rint(grid.points)}


def contains(vertices: Floats, faces: Ints) -> set[Index]:
    """``trimesh``: cells whose centre is inside, by rays."""
    size = np.ceil(vertices.max(axis=0)).astype(int)
    index = np.array(list(np.ndindex(*size)))
    mesh = trimesh.Trimesh(vertices, faces, process=True)
    return {(int(x), int(y), int(z)) for x, y, z in index[mesh.contains(index + 0.5)]}


def measure(method: Method, case: Case, repeats: int) -> tuple[float, float, set[Index]]:
    """Medians of wall and processor time in seconds, and the cells."""
    found: set[Index] = set()
    walls, cpus = [], []
    for _ in range(repeats):
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        found = method(case.vertices, case.faces)
        walls.append(time.perf_counter() - wall_s)
        cpus.append(time.process_time() - cpu_s)
    return statistics.median(walls), statistics.median(cpus), found


def cases(triangles: int) -> list[Case]:
    """An off-grid chair, a box on the planes, one half a millimetre too large, a ball."""
    legs = [Box(x, y, 0, 0.35, 0.35, 3.8) for x in (0, 3.4) for y in (0, 3.45)]
    chair = (*legs, Box(0, 0, 3.7, 3.75, 3.8, 0.5), Box(0, 3.5, 4.1, 3.75, 0.3, 4.0))
    return [
        boxes_case("chair off the grid", chair, triangles),
        boxes_case("box on the planes", (Box(0, 0, 0, 3, 2, 2),), triangles),
        boxes_case("box 0.5 mm over", (Box(0, 0, 0, 3.005, 2.005, 2.005),), triangles),
        ball_case(2.9, triangles),
    ]


def line(case: Case, method: str, wall_s: float, cpu_s: float, found: set[Index] | None) -> None:
    """Print a row of the table."""
    errors = "" if found is None else f"{len(case.exact - found):>7} {len(found - case.exact):>6}"
    print(  # noqa: T201 - a program for people
        f"{case.name:<20} {len(case.faces):>9} {method:<26} {wall_s:>8.3f} {cpu_s:>8.3f} {errors}"
    )


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="*", type=Path, help="files to time besides")
    parser.add_argument("--million", action="store_true", help="a million triangles, too")
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    print(  # noqa: T201
        f"{'shape':<20} {'triangles':>9} {'method':<26} {'wall s':>8} {'cpu s':>8} "
        f"{'missed':>7} {'extra':>6}"
    )
    methods: dict[str, Method] = {"cellctl": ours, "trimesh voxelized().fill()": voxelized}
    try:
        trimesh.creation.box().contains(np.zeros((1, 3)))
        methods["trimesh contains(centre)"] = contains
    except ImportError as error:
        print(f"no trimesh contains(): {error}")  # noqa: T201
    for triangles in (2_000, 200_000, *([1_000_000] if arguments.million else [])):
        for case in cases(triangles):
            for name, method in methods.items():
                line(case, name, *measure(method, case, arguments.repeats))
    tilted = tilted_cases(12, 20_000)
    for name, method in methods.items():
        rows = [(case, *measure(method, case, 1)) for case in tilted]
        together = Case(
            "12 tilted boxes",
            np.zeros((0, 3)),
            np.concatenate([case.faces for case in tilted]),
            {(n, *cell) for n, case in enumerate(tilted) for cell in case.exact},
        )
        found = {(n, *cell) for n, (_, _, _, cells) in enumerate(rows) for cell in cells}
        line(together, name, sum(row[1] for row in rows), sum(row[2] for row in rows), found)
    for path in arguments.meshes:
        mesh = load_mesh(path)
        vertices: npt.NDArray[np.float64] = mesh.vertices - np.nanmin(mesh.vertices, axis=0)
        vertices *= 6.0 / np.nanmax(vertices)
        case = Case(path.stem[:20], vertices, mesh.faces, set())
        wall_s, cpu_s, cells = measure(ours, case, arguments.repeats)
        line(case, f"cellctl: {len(cells)} cells", wall_s, cpu_s, None)
    return 0


if __name__ == "__main__":
    sys.exit(main())
