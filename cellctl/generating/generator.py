"""What a generator is, and what it returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from cellctl.assembly import Request

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class GeneratedMesh:
    """A shape as it came from a generator, z up, before anything fits it to the cell."""

    mesh: trimesh.Trimesh
    metric: bool
    """True: vertices are metres. False: the mesh has no unit."""
    title: str
    """What it is, for people: ``stool with three legs``."""
    provenance: str
    """Which generator, with what description."""
    stated_dimensions_m: dict[str, float]
    """Sizes that the speaker asked for, by ``width``, ``depth``, ``height``; often empty."""


class Generator(Protocol):
    """Turns a request into a mesh."""

    name: str

    def generate(
        self, request: Request, pitch_m: float, workspace_m: tuple[float, float, float]
    ) -> GeneratedMesh:
        """Design what was asked for.

        Args:
            request: with intent ``design``.
            pitch_m: the cell's voxel pitch, a hint for wall thicknesses.
            workspace_m: the building space, a hint for default sizes.

        Raises:
            DesignError: this generator cannot design that; the message says so to the visitor.
        """
        ...
