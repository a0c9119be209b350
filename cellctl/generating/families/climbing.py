"""Things to climb: steps, a spiral staircase, a ladder, a pedestal to stand on."""

from __future__ import annotations

from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Count, Design, Family, counted, titled
from cellctl.generating.families.forms import lying

_MOST_STEPS = 12


def steps(brief: Brief) -> Design:
    """Solid steps that rise to the right, each one cell high and one deep."""
    number = brief.count("steps", min(4, brief.stated_cells.get("height", 4)))
    most = min(brief.grid[0], brief.grid[2])
    if number > most:
        raise brief.refuse_short(counted(number, "step"), most)
    wide = 3 if number <= 4 else 2 if number <= 5 else 1
    _, depth, height = brief.size(number, wide, number, least=(1, 1, number))
    rise = height - number  # a stated height above its steps is a plinth under all of them
    width = brief.size(number, 1, 1, least=(number, 1, 1))[0]
    run = width // number
    boxes = tuple(
        Box(k * run, 0, 0, width - k * run if k == number - 1 else run, depth, k + 1 + rise)
        for k in range(number)
    )
    return Design(titled(brief.noun, counted(number, "step")), boxes)


_AROUND = ((0, 2), (0, 1), (0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2))
"""Cells about the middle of three by three, in the order in which a spiral climbs them."""


def spiral(brief: Brief) -> Design:
    """Steps that climb about a column, each carried from the floor."""
    number = brief.count("steps", min(6, brief.stated_cells.get("height", 6)))
    most = min(len(_AROUND), brief.grid[2])
    if number > most:
        raise brief.refuse_short(counted(number, "step"), most)
    boxes = [Box(*_AROUND[k], 0, 1, 1, k + 1) for k in range(number)]
    boxes.append(Box(1, 1, 0, 1, 1, number))
    return Design(titled(brief.noun, counted(number, "step")), tuple(boxes))


def ladder(brief: Brief) -> Design:
    """Two rails and rungs between them, a cell of room under each."""
    number = brief.count("steps", max(1, min(3, brief.stated_cells.get("height", 6) // 2)))
    width, depth, height = brief.size(
        3, 1, min(2 * number + 1, max(6, 2 * number)), least=(3, 1, 2)
    )
    if height < 2 * number:
        raise brief.refuse_short(counted(number, "rung"), height)
    rungs = [1 + 2 * k for k in range(number)]
    boxes = [Box(x, 0, 0, 1, depth, height) for x in (0, width - 1)]
    boxes += [Box(1, 0, z, width - 2, depth, 1) for z in rungs]
    return Design(titled(brief.noun, counted(number, "rung")), tuple(boxes))


def pedestal(brief: Brief) -> Design:
    """A column between a broad foot and a broad top, each of three by three cells."""
    width, depth, height = brief.size(3, 3, 5, least=(3, 3, 3))
    boxes = (
        Box(0, 0, 0, width, depth, 1),
        Box((width - 1) // 2, (depth - 1) // 2, 1, 1 + (width + 1) % 2, 1, height - 2),
        Box(0, 0, height - 1, width, depth, 1),
    )
    return Design(brief.noun, boxes)


def podium(brief: Brief) -> Design:
    """Three places: the first in the middle and highest, the second at its right, the third."""
    _, depth, height = brief.size(6, 2, 3, least=(6, 1, 3))
    boxes = (
        Box(0, 0, 0, 2, depth, height - 1),
        Box(2, 0, 0, 2, depth, height),
        Box(4, 0, 0, 2, depth, height - 2),
    )
    return Design(brief.noun, boxes)


def fence(brief: Brief) -> Design:
    """Pales on the floor and one rail across them."""
    width, depth, height = brief.size(5, 1, 3, least=(3, 1, 3))
    rail = lying(("#" * width,), height - 2)
    pales = [Box(x, 0, 0, 1, depth, height) for x in range(0, width, 2)]
    return Design(brief.noun, (*(box._replace(depth=depth) for box in rail), *pales))


FAMILIES = (
    Family(
        "spiral staircase",
        ("spiral staircase", "spiral stairs", "winding staircase"),
        spiral,
        {"steps": Count(2, 8, "Steps, each one part higher than the one before.")},
    ),
    Family(
        "steps",
        ("steps", "step", "staircase", "stairs", "stair", "stepladder", "step stool", "stile"),
        steps,
        {"steps": Count(1, _MOST_STEPS, "Steps, each one part higher than the one before.")},
    ),
    Family(
        "ladder",
        ("ladder",),
        ladder,
        {"steps": Count(1, _MOST_STEPS, "Rungs, with room between them.")},
    ),
    Family("pedestal", ("pedestal", "plinth", "column", "pillar", "stand", "lectern"), pedestal),
    Family("podium", ("podium",), podium),
    Family("fence", ("fence", "railing", "barrier", "barricade"), fence),
)
