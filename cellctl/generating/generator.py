"""What a generator is."""

from __future__ import annotations

from typing import Protocol

from cellctl.assembly import Request
from cellctl.config import CellConfig
from cellctl.mesh import GeneratedMesh


class Generator(Protocol):
    """Turns a request into a mesh."""

    name: str

    def generate(self, request: Request, config: CellConfig) -> GeneratedMesh:
        """Design what was asked for.

        Args:
            request: with intent ``design``.
            config: the cell: its pitch and its room, for thicknesses and default sizes.

        Raises:
            DesignError: this generator cannot design that; the message says so to the visitor.
        """
        ...
