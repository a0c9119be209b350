"""How long a whole plan takes: ``python -m benchmarks.planning [--solids N]``.

From a mesh to a verified plan, arm's way included, with the inventory of the emulated cell: the
wishes that the generators can draw, random furniture, and the meshes in
``$CELLCTL_TEST_DATA/meshes``. Prints median, 90th percentile and worst of each, how many had to be
changed, how many of those are proven to be the closest, and how much of the shape the plans keep.
Below each, the median of what each stage takes. A second process stands by, as it does in the cell;
``--alone`` does without.
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, nullcontext
from pathlib import Path
from typing import ParamSpec, Self, TypeVar
from unittest import mock

from cellctl.assembly import BuildPlan, Intent, Request
from cellctl.beside import Beside
from cellctl.config import load_config
from cellctl.errors import PlanError
from cellctl.generating.boxes import mesh_of
from cellctl.generating.design import design
from cellctl.mesh import GeneratedMesh
from cellctl.validating import plan as planning
from cellctl.validating.files import MESH_SUFFIXES, load_mesh
from cellctl.validating.plan import plan_build
from tests.validating.furniture import furniture

P = ParamSpec("P")
T = TypeVar("T")

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

_STAGES = {
    "size": "fit",
    "voxels": "discretise",
    "search and repair": "repair_shape",
    "rules": "redraft",
    "arm's way, margins, checker": "site",
}
"""What a plan is made of, in turn, and the names by which ``plan_build`` calls it."""


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


class Stages:
    """What each stage of each plan takes, in seconds; use as a context."""

    def __init__(self) -> None:
        self.times_s: dict[str, list[float]] = {name: [] for name in (*_STAGES, "whole")}
        self._spent_s: dict[str, float] = defaultdict(float)
        self._patches = ExitStack()

    def __enter__(self) -> Self:
        for name, function in _STAGES.items():
            timed = self._timed(name, getattr(planning, function))
            self._patches.enter_context(mock.patch.object(planning, function, timed))
        return self

    def __exit__(self, *_: object) -> None:
        self._patches.close()

    def plan(self, mesh: GeneratedMesh) -> BuildPlan:
        """Plan a mesh, and note what each stage took.

        Raises:
            PlanError: it cannot be built.
        """
        self._spent_s.clear()
        try:
            return self._timed("whole", plan_build)(mesh, _CONFIG)
        finally:
            for name, times_s in self.times_s.items():
                times_s.append(self._spent_s[name])

    def _timed(self, name: str, function: Callable[P, T]) -> Callable[P, T]:
        def timed(*args: P.args, **kwargs: P.kwargs) -> T:
            began_s = time.perf_counter()
            try:
                return function(*args, **kwargs)
            finally:
                self._spent_s[name] += time.perf_counter() - began_s

        return timed


def measure(name: str, found: Iterator[GeneratedMesh]) -> None:
    """Plan them all and print what it took."""
    times_s: list[float] = []
    plans: list[BuildPlan] = []
    refused = 0
    with Stages() as stages:
        for mesh in found:
            began_s = time.perf_counter()
            try:
                plans.append(stages.plan(mesh))
            except PlanError:
                refused += 1
            times_s.append(time.perf_counter() - began_s)
    if not times_s:
        sys.stdout.write(f"{name}: none at hand\n")
        return
    changed = [plan.closeness for plan in plans if plan.closeness is not None]
    kept = [1.0 if plan.closeness is None else plan.closeness.score for plan in plans]
    margins = [plan.weakest.margin for plan in plans if plan.weakest is not None]
    proven = sum(near.proven for near in changed)
    del stages.times_s["whole"]
    each = ", ".join(
        f"{stage} {statistics.median(spent_s):.3f}" for stage, spent_s in stages.times_s.items()
    )
    sys.stdout.write(
        f"{name}, {len(times_s)}: {_spread(times_s)}; "
        f"{len(changed)} changed, {proven} of them proven closest, {refused} refused\n"
        f"  medians of the stages: {each}\n"
        f"  kept of the shapes: {statistics.mean(kept):.4f} in the mean, least {min(kept):.4f}; "
        f"margins: median {statistics.median(margins):.3f}, least {min(margins):.3f}\n"
    )
    sys.stdout.flush()


def _spread(times_s: list[float]) -> str:
    times_s = sorted(times_s)
    return (
        f"median {statistics.median(times_s):.2f} s, 90th percentile "
        f"{times_s[int(0.9 * (len(times_s) - 1))]:.2f} s, worst {times_s[-1]:.2f} s"
    )


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solids", type=int, default=60, help="of random furniture")
    parser.add_argument("--alone", action="store_true", help="without a second process")
    options = parser.parse_args()
    with nullcontext() if options.alone else Beside():
        plan_build(next(wishes()), _CONFIG)  # loads everything
        measure("wishes", wishes())
        measure("random furniture", solids(options.solids))
        measure("meshes", meshes())
    return 0


if __name__ == "__main__":
    sys.exit(main())
