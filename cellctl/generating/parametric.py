"""The parametric generator: a description in cells, from a family of known objects.

What was asked for holds by construction: legs, tiers and sizes are counted in cells before there
is any mesh, so they are still there after voxelising. It needs no network and no model.
"""

from __future__ import annotations

from cellctl.assembly import Request
from cellctl.config import CellConfig
from cellctl.errors import UnknownObjectError
from cellctl.generating.describing import describe, realise, repertoire
from cellctl.generating.wording import with_article
from cellctl.mesh import GeneratedMesh


class ParametricGenerator:
    """Designs what it has a family for, from descriptions."""

    name = "description"

    def generate(self, request: Request, config: CellConfig) -> GeneratedMesh:
        """Design what was asked for; metric, z up, its faces on the cells' planes.

        Raises:
            DesignError: no family of that name, or one that cannot have what was asked for.
        """
        found = describe(request)
        if found is None:
            wish = request.phrase if request.phrase not in ("", "false") else "that"
            if request.kind == "character":
                wish = wish.title()
            elif wish != "that":
                wish = with_article(wish)
            raise UnknownObjectError(
                f"I cannot design {wish} yet.",
                f"I can design {repertoire(request.kind)}, for example.",
            )
        return realise(
            found.description,
            config,
            left_out=found.left_out,
            stated_m={str(k): v for k, v in request.dimensions_m.items()},
        )
