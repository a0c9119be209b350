"""Algorithm 2: Component-Count Check with Auto-Rescaling."""

from __future__ import annotations

from cellctl.errors import PlanError
from cellctl.validating.paper.scaling import Rescaled, occupy, one_cell_smaller, resized


def within_count(found: Rescaled, most_parts: int) -> Rescaled:
    """Take a cell off every axis until the shape needs no more than ``most_parts``.

    It ends: each pass takes a cell off some axis that is longer than one, and a shape of one cell
    along each axis needs one part.

    Raises:
        PlanError: there is no part at all.
    """
    if most_parts < 1:
        raise PlanError("There are no parts to build with.", "Put parts on the belt.")
    smaller = found
    while len(smaller.cells) > most_parts:
        smaller = occupy(one_cell_smaller(smaller.shape, (0, 1, 2)))
    if smaller is found:
        return found
    why = f"It would take {len(found.cells)} parts, and there are {most_parts}."
    return resized(found.cells, Rescaled(smaller.shape, smaller.cells, found.changes), why)
