"""The parametric generator: a description in cells, from a family of known objects.

What was asked for holds by construction: legs, tiers and sizes are counted in cells before there
is any mesh, so they are still there after voxelising. It needs no network and no model.
"""

from __future__ import annotations

import json

from cellctl.assembly import Change, Request
from cellctl.errors import DesignError
from cellctl.generating.boxes import mesh_of
from cellctl.generating.families import FAMILIES, find_family
from cellctl.generating.families.brief import Brief
from cellctl.mesh import GeneratedMesh


def repertoire() -> str:
    """What can be designed, as a phrase: ``a stool, a chair, ... or a letter or digit``."""
    names = [f"a {family.name}" for family in FAMILIES if family.name != "letter"]
    return f"{', '.join(names)}, or a letter or digit"


class ParametricGenerator:
    """Designs furniture, boxes, towers, letters and digits from descriptions."""

    name = "parametric"

    def generate(
        self, request: Request, pitch_m: float, workspace_m: tuple[float, float, float]
    ) -> GeneratedMesh:
        """Design what was asked for; metric, z up, its faces on the cells' planes.

        Raises:
            DesignError: no family of that name, or one that cannot have what was asked for.
        """
        found = find_family(request)
        if found is None:
            wish = request.phrase if request.phrase not in ("", "false") else "that"
            raise DesignError(
                f"I cannot design {_article(wish)} yet.", f"I can design {repertoire()}."
            )
        family, noun = found
        brief = Brief.of(noun, request, pitch_m, workspace_m)
        design = family.build(brief)
        description = {
            "family": family.name,
            "attributes": {k: v for k, v in request.attributes.items() if k in brief.used},
            "stated_cells": brief.stated_cells,
        }
        vertices, faces = mesh_of(design.boxes, pitch_m)
        return GeneratedMesh(
            vertices=vertices,
            faces=faces,
            metric=True,
            title=design.title,
            provenance=f"from a description: {json.dumps(description, sort_keys=True)}",
            stated_dimensions_m={str(k): v for k, v in request.dimensions_m.items()},
            changes=_left_out(brief.unused, noun, request.count),
        )


def _article(phrase: str) -> str:
    if phrase == "that":
        return phrase
    return f"{'an' if phrase[0] in 'aeiou' else 'a'} {phrase}"


def _left_out(unused: list[str], noun: str, count: int) -> tuple[Change, ...]:
    changes = [
        Change(
            what=f"It comes without the {name} that you asked for.",
            why=f"I cannot design {name} for a {noun} yet.",
        )
        for name in unused
    ]
    if count > 1:
        changes.append(Change(what=f"One {noun}, not {count}.", why="I build one at a time."))
    return tuple(changes)
