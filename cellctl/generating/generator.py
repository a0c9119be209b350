"""What a generator is."""

from __future__ import annotations

from typing import Protocol

from cellctl.assembly import Request
from cellctl.mesh import GeneratedMesh


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
