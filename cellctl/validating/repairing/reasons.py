"""Which rules a wanted shape breaks, in words for the visitor."""

from __future__ import annotations

from typing import NamedTuple

from cellctl.assembly import Cell
from cellctl.validating.repairing.collapse import Collapses
from cellctl.validating.repairing.score import Size
from cellctl.validating.rules import Cells, hanging, pieces


class Reason(NamedTuple):
    """A rule that the wanted shape breaks."""

    rule: str
    """workspace, count, connectivity, access or stability."""
    words: str
    cells: tuple[Cell, ...]
    """Where; sorted."""
    plainly: str = ""
    """The same without figures, for who only wants the object; empty where ``words`` has none."""


def reasons(cells: Cells, size: Size, parts: int, grid: Size) -> tuple[Reason, ...]:
    """The rules that cells from [0, 0, 0] break, without stability; in that order.

    Args:
        cells: the wanted shape.
        size: of its box.
        parts: how many there are.
        grid: the workspace in cells.
    """
    found = []
    outside = [c for c in cells if any(at >= room for at, room in zip(c, grid, strict=True))]
    if outside:
        found.append(
            _reason(
                "workspace",
                f"It would be {times(size)} parts large (wide, deep, high), and the workspace has "
                f"{times(grid)}.",
                outside,
            )
        )
    if len(cells) > parts:
        words = f"It would take {len(cells)} parts, and there are {parts}."
        found.append(_reason("count", words, cells))
    apart = pieces(cells)
    if len(apart) > 1:
        words = f"It would fall into {len(apart)} pieces."
        found.append(_reason("connectivity", words, frozenset[Cell]().union(*apart[1:])))
    if loose := hanging(cells):
        words = (
            "One part would have to hang from a part above it, and cannot be placed there."
            if len(loose) == 1
            else f"{len(loose)} parts would have to hang from parts above them, and cannot be "
            "placed there."
        )
        found.append(_reason("access", words, loose))
    return tuple(found)


def unstable(collapse: Collapses, least_margin: float) -> Reason:
    """The reason that a collapse is.

    Args:
        collapse: what comes loose.
        least_margin: how many times the strength that it takes is asked for.
    """
    where = f" at the joint {collapse.joint}" if collapse.joint else ""
    when = "it would come apart" if collapse.placed is None else "it would come apart while built"
    strength = ""
    if collapse.margin >= 1.0:
        when = when.replace("it would", "it could")
        strength = (
            f": the magnets have {collapse.margin:.2f} times the strength that it takes, and "
            f"{least_margin:g} times is asked for"
        )
    elif collapse.margin > 0.0:
        strength = f": the magnets have {collapse.margin:.0%} of the strength that it takes"
    words = f"{when[0].upper()}{when[1:]}{where}{strength}."
    plainly = f"{when[0].upper()}{when[1:]}."
    return _reason("stability", words, collapse.moving)._replace(plainly=plainly)


def times(size: Size) -> str:
    """``6 x 3 x 6``."""
    return " x ".join(str(edge) for edge in size)


def _reason(rule: str, words: str, cells: Cells | list[Cell]) -> Reason:
    return Reason(rule, words, tuple(sorted(cells, key=lambda c: (c.z, c.x, c.y))))
