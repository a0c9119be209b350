"""What has been shown for one wish, and what the designer process answers with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cellctl.assembly import BuildPlan, Request
    from cellctl.errors import CellctlError
    from cellctl.mesh import GeneratedMesh


@dataclass(frozen=True, eq=False)
class Proposals:
    """One wish and what was made of it so far."""

    request: Request | None = None
    """With the changes that were made to it; None for a file."""
    asked: GeneratedMesh | None = None
    """What was designed first."""
    shown: frozenset[str] = frozenset()
    """Fingerprints of the shapes that were shown, or that could not be planned."""
    services: frozenset[str] = frozenset()
    """Generators with a network that were asked; each is asked once for one wish."""


@dataclass(frozen=True, eq=False)
class Chosen:
    """The shape that the planner's verdict chose among several."""

    mesh: GeneratedMesh | None
    """None for the one to begin with."""
    plan: BuildPlan | None
    """None where none of them could be planned."""
    refusal: CellctlError | None
    """Why the first one could not be planned; None where it could."""
    tried: frozenset[str]
    """Fingerprints of all that were planned or refused."""
