"""How long a whole plan takes: ``python -m benchmarks.planning [--solids N]``.

From a mesh to a verified plan, arm's way included, with the inventory of the emulated cell: the
wishes that the generators can draw, random furniture, and the meshes in
``$CELLCTL_TEST_DATA/meshes``. Prints median, 90th percentile and worst of each, how many had to be
changed, and how many of those are proven to be the closest.
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from cellctl.assembly import BuildPlan, Intent, Request
from cellctl.config import load_config
from cellctl.errors import PlanError
from cellctl.generating.boxes import mesh_of
from cellctl.generating.design import design
from cellctl.mesh import GeneratedMesh
from cellctl.validating.files import MESH_SUFFIXES, load_mesh
from cellctl.validating.plan import plan_build
from tests.validating.furniture import furniture

_CONFIG = load_config(Path(__file__).parents[1] / "config" / "sim.toml")
_WISHES: tuple[tuple[str, dict[str, int | str]], ...] = (
    ("stool", {}),
    ("stool", {"legs": 4}),
    ("shelf", {"tiers": 2}),
    ("shelf", {"tiers": 3}),
    ("table", {"legs": 1}),
    ("table", {"legs": 4}),
    ("chair", {}),
    ("bench", {}),
    ("box", {}),
    ("tower", {}),
    *(("letter", {"glyph": sign}) for sign in "AETOKX47"),
)


def wishes() -> Iterator[GeneratedMesh]:
    """What people ask for."""
    for noun, attributes in _WISHES:
        wish = Request(
            text=noun,
            intent=Intent.DESIGN,
            phrase=noun,
            objects=(noun,),
            attributes={**attributes},
        )
        yield design(wish, _CONFIG)


def solids(count: int) -> Iterator[GeneratedMesh]:
    """Random furniture, in cells of 10 cm."""
    rng = random.Random(5)  # noqa: S311 - which solids is of no consequence
    for number in range(count):
        vertices, faces = mesh_of(furniture(rng), _CONFIG.voxel.pitch_m)
        yield GeneratedMesh(
            vertices=vertices,
            faces=faces,
            metric=True,
            title=f"solid {number}",
            provenance="made by chance",
            stated_dimensions_m={},
        )


def meshes() -> Iterator[GeneratedMesh]:
    """The meshes of the evaluation data; none without it."""
    folder = os.environ.get("CELLCTL_TEST_DATA")
    for path in sorted(Path(folder, "meshes").iterdir()) if folder else ():
        if path.suffix in MESH_SUFFIXES:
            yield load_mesh(path)


def measure(name: str, found: Iterator[GeneratedMesh]) -> None:
    """Plan them all and print a line."""
    times_s: list[float] = []
    plans: list[BuildPlan] = []
    refused = 0
    for mesh in found:
        began_s = time.perf_counter()
        try:
            plans.append(plan_build(mesh, _CONFIG))
        except PlanError:
            refused += 1
        times_s.append(time.perf_counter() - began_s)
    if not times_s:
        sys.stdout.write(f"{name}: none at hand\n")
        return
    times_s.sort()
    changed = [plan.closeness for plan in plans if plan.closeness is not None]
    proven = sum(near.proven for near in changed)
    sys.stdout.write(
        f"{name}, {len(times_s)}: median {statistics.median(times_s):.2f} s, 90th percentile "
        f"{times_s[int(0.9 * (len(times_s) - 1))]:.2f} s, worst {times_s[-1]:.2f} s; "
        f"{len(changed)} changed, {proven} of them proven closest, {refused} refused\n"
    )
    sys.stdout.flush()


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solids", type=int, default=60, help="of random furniture")
    options = parser.parse_args()
    plan_build(next(wishes()), _CONFIG)  # loads everything
    measure("wishes", wishes())
    measure("random furniture", solids(options.solids))
    measure("meshes", meshes())
    return 0


if __name__ == "__main__":
    sys.exit(main())
