"""What an interpreter is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cellctl.assembly import Request
from cellctl.config import CellConfig


@dataclass(frozen=True)
class Setting:
    """What of the cell bears on what a sentence means."""

    pitch_m: float = 0.10
    """Edge of a voxel, which is what a visitor's "ten blocks high" counts."""
    workspace_m: tuple[float, float, float] = (0.60, 0.50, 0.60)
    """What is larger cannot be built as it was said."""
    parts: int = 40
    """How many voxels there are."""

    @classmethod
    def of(cls, config: CellConfig) -> Setting:
        """That of a configured cell."""
        return cls(config.voxel.pitch_m, config.workspace.size_m, config.limits.inventory_parts)


DEFAULT_SETTING = Setting()
"""That of the paper."""


class Interpreter(Protocol):
    """Finds out what a sentence asks for."""

    name: str

    def interpret(self, text: str, setting: Setting) -> Request:
        """Understand one sentence. It may wait for a network; words of command never do.

        Args:
            text: as heard or typed; any characters, any length.
            setting: the cell.

        Returns:
            A request, whatever was said: nothing that a speaker can say is an error.
        """
        ...
