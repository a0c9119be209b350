"""Things that are built to stay: tower, wall, arch, bridge, pyramid, house, castle, cross."""

from __future__ import annotations

from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Count, Design, Family, Flag, counted, titled
from cellctl.generating.families.forms import ring, without


def tower(brief: Brief) -> Design:
    """A keep with hollow walls and a battlement on each corner; a solid shaft where it is slim."""
    width, depth, height = brief.size(3, 3, 5, least=(1, 1, 2))
    if min(width, depth) < 3:
        return Design("tower", (Box(0, 0, 0, width, depth, height),))
    right, rear, wall = width - 1, depth - 1, height - 1
    boxes = (
        *ring(0, 0, 0, width, depth, wall),
        *(Box(x, y, wall, 1, 1, 1) for x in (0, right) for y in (0, rear)),
    )
    return Design(brief.noun, boxes)


def cube(brief: Brief) -> Design:
    """A solid block."""
    width, depth, height = brief.size(3, 3, 3)
    return Design(brief.noun, (Box(0, 0, 0, width, depth, height),))


def wall(brief: Brief) -> Design:
    """A straight wall, one cell thick, with a battlement."""
    width, depth, height = brief.size(6, 1, 4, least=(2, 1, 1))
    if height < 3:
        return Design(brief.noun, (Box(0, 0, 0, width, depth, height),))
    merlons = (
        range(0, width, 2)
        if width % 2
        else (*range(0, width // 2, 2), *range(width - 1, width // 2, -2))
    )
    boxes = (
        Box(0, 0, 0, width, depth, height - 1),
        *(Box(x, 0, height - 1, 1, depth, 1) for x in sorted(set(merlons))),
    )
    return Design(brief.noun, boxes)


def arch(brief: Brief) -> Design:
    """Two piers that lean together over an opening."""
    width, depth, height = brief.size(5, 2, 5, least=(3, 1, 3))
    boxes = [
        *(Box(x, 0, 0, 1, depth, height - 1) for x in (0, width - 1)),
        Box(1, 0, height - 1, width - 2, depth, 1),
    ]
    if width >= 4:
        boxes += [Box(x, 0, height - 2, 1, depth, 1) for x in (1, width - 2)]
    else:
        boxes.append(Box(0, 0, height - 1, width, depth, 1))
    return Design(brief.noun, tuple(boxes))


def bridge(brief: Brief) -> Design:
    """A deck with kerbs over one opening, or as many as asked for, between piers."""
    arches = brief.count("arches", 1)
    default = 6 if arches == 1 else 2 * arches + 1
    width, depth, height = brief.size(default, 3, 4, least=(3, 1, 2))
    if width < 2 * arches + 1:
        raise brief.refuse_short(counted(arches, "arch"), width)
    deck = height - 2 if height >= 4 else height - 1
    piers = sorted({round(k * (width - 1) / arches) for k in range(arches + 1)})
    boxes = [
        Box(0, 0, deck, width, depth, 1),
        *(Box(x, 0, 0, 1, depth, deck) for x in piers),
    ]
    if deck < height - 1:
        sides = (0, depth - 1) if depth >= 3 else (depth - 1,)
        boxes += [Box(x, y, deck + 1, 1, 1, 1) for x in (0, width - 1) for y in sides]
    if arches == 1 and deck >= 2 and width >= 5:
        boxes += [Box(x, 0, deck - 1, 1, depth, 1) for x in (1, width - 2)]
    return Design(titled(brief.noun, counted(arches, "arch") if arches > 1 else ""), tuple(boxes))


def pyramid(brief: Brief) -> Design:
    """Square tiers, each two cells narrower than the one below, up to a single part."""
    tiers = brief.count("tiers", min(3, brief.stated_cells.get("height", 3)))
    most = min((min(brief.grid[:2]) + 1) // 2, brief.grid[2])
    if tiers > most:
        raise brief.refuse_short(counted(tiers, "tier"), most)
    width, depth, height = brief.size(
        2 * tiers - 1, 2 * tiers - 1, tiers, least=(2 * tiers - 1, 2 * tiers - 1, tiers)
    )
    extra = height - tiers
    boxes = tuple(
        Box(
            k,
            k,
            0 if k == 0 else k + extra,
            width - 2 * k,
            depth - 2 * k,
            1 + (extra if k == 0 else 0),
        )
        for k in range(tiers)
    )
    return Design(brief.noun, boxes)


def house(brief: Brief) -> Design:
    """Four walls with a door, a gable roof that overhangs them, and a chimney where asked for."""
    chimney = brief.flag("chimney", False)
    steep = brief.count("steepness", 1)
    wanted = min(brief.stated_cells.get("width", 5), brief.grid[0])
    highest = (max(5, wanted) // 2) * steep + 1
    # A steep roof of three rows would take more parts than there are.
    rows = 2 if steep > 1 else 3
    width, depth, height = brief.size(5, rows, max(5, highest + 1), least=(5, rows, highest + 1))
    if height < highest + 1:
        raise brief.refuse_short("so steep a roof", brief.grid[2])
    gable = width // 2 + 1
    walls = height - highest
    door = width // 2
    opening = range(min(2, walls))
    rooms = without(ring(1, 0, 0, width - 2, depth, walls), [(door, 0, z) for z in opening])
    gables = [
        Box(k, 0, walls + k * steep, width - 2 * k, depth, steep if k < gable - 1 else 1)
        for k in range(gable)
    ]
    # Hollow below the ridge, for what nobody sees is not worth its parts.
    loft = [
        (x, y, walls + z)
        for z in range((gable - 1) * steep)
        for y in range(1, depth - 1)
        for x in range(z // steep + 2, width - z // steep - 2)
    ]
    roof = without(gables, loft)
    top = walls + highest - 1
    stack = (Box(door + 1, depth - 1, top, 1, 1, 1),) if chimney else ()
    title = titled(brief.noun, "a steep roof" if steep > 1 else "", "a chimney" if chimney else "")
    return Design(title, (*rooms, *roof, *stack))


def castle(brief: Brief) -> Design:
    """A square of walls with a gate, and a tower on each corner."""
    width, depth, height = brief.size(5, 5, 4, least=(5, 4, 3))
    wall, gate = height - 2, width // 2
    walls = without(ring(0, 0, 0, width, depth, wall), [(gate, 0, z) for z in range(wall)])
    corners = [(x, y) for x in (0, width - 1) for y in (0, depth - 1)]
    towers = [Box(x, y, 0, 1, 1, height) for x, y in corners]
    return Design(brief.noun, (*walls, *towers))


def cross(brief: Brief) -> Design:
    """An upright beam and a cross beam, on a square foot."""
    width, depth, height = brief.size(3, 3, 6, least=(3, 1, 4))
    middle, line = (width - 1) // 2, (depth - 1) // 2
    bar = height - 3 if height >= 6 else height - 2
    boxes = (
        Box(0, 0, 0, width, depth, 1),
        Box(middle, line, 1, 1 + (width + 1) % 2, 1, height - 1),
        Box(0, line, bar + (height >= 6), width, 1, 1),
    )
    return Design(brief.noun, boxes)


FAMILIES = (
    Family("castle", ("castle", "fortress", "fort", "sandcastle"), castle),
    Family("tower", ("tower", "keep", "skyscraper"), tower),
    Family("cube", ("cube", "block", "brick"), cube),
    Family("wall", ("wall", "partition", "divider", "room divider"), wall),
    Family("arch", ("arch", "archway", "doorway", "gate", "portal"), arch),
    Family(
        "bridge",
        ("bridge", "footbridge", "viaduct", "aqueduct"),
        bridge,
        {"arches": Count(1, 5, "Openings between its piers.")},
    ),
    Family(
        "pyramid",
        ("pyramid", "ziggurat"),
        pyramid,
        {"tiers": Count(1, 6, "Square layers, each narrower than the one below.")},
    ),
    Family(
        "house",
        (
            "house",
            "home",
            "cottage",
            "hut",
            "cabin",
            "doghouse",
            "birdhouse",
            "dollhouse",
            "dolls house",
            "playhouse",
            "kennel",
            "shed",
            "barn",
            "garage",
            "shelter",
        ),
        house,
        {
            "chimney": Flag("A chimney on the roof."),
            "steepness": Count(1, 2, "How far its roof rises at each step inwards."),
        },
    ),
    Family("cross", ("cross", "crucifix"), cross),
)
