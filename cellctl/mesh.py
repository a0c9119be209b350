"""The shape that travels from the generators to the planner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Change
from cellctl.description import FamilyDescription, PartsDescription

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True, eq=False)
class GeneratedMesh:
    """A shape as it came from a generator, z up, before anything fits it to the cell.

    It holds plain arrays, so that whoever only passes it on need not load a mesh library.
    """

    vertices: npt.NDArray[np.float64]
    """Shape (n, 3)."""
    faces: npt.NDArray[np.int64]
    """Shape (m, 3): indices into the vertices, counter-clockwise seen from outside."""
    metric: bool
    """True: vertices are metres. False: the mesh has no unit."""
    title: str
    """What it is, for people: ``stool with three legs``."""
    provenance: str
    """Which generator, with what description, and why that one, in words for people."""
    stated_dimensions_m: dict[str, float]
    """Sizes that the speaker asked for, by ``width``, ``depth``, ``height``; often empty."""
    changes: tuple[Change, ...] = ()
    """What the generator had to leave out or do differently; the plan passes it on."""
    description: FamilyDescription | PartsDescription | None = None
    """What it was made from, to be changed and made again; None where there is none."""
    earlier: tuple[FamilyDescription | PartsDescription, ...] = ()
    """What it was made from before each change, the latest last; for taking changes back."""

    @property
    def mesh(self) -> trimesh.Trimesh:
        """The same shape for a mesh library, vertices and faces as they are."""
        import trimesh  # noqa: PLC0415 - takes a second to load, and few need it

        return trimesh.Trimesh(vertices=self.vertices, faces=self.faces, process=False)
