"""Random furniture built of boxes, from a seed; and the paper's objects as boxes."""

from __future__ import annotations

import random

from cellctl.generating.boxes import Box

STOOL = (
    Box(0, 0, 4, 5, 5, 1),
    *(Box(x, y, 0, 1, 1, 4) for x, y in ((1, 1), (2, 1), (1, 3), (2, 3), (3, 2))),
)
SHELF = (
    Box(0, 0, 0, 1, 3, 6),
    Box(5, 0, 0, 1, 3, 6),
    Box(0, 0, 2, 6, 3, 1),
    Box(0, 0, 5, 6, 3, 1),
)
LETTER_T = (Box(1, 0, 0, 1, 1, 6), Box(0, 0, 5, 3, 1, 1))
TABLE = (Box(0, 0, 5, 4, 4, 1), Box(1, 1, 0, 1, 1, 5))


def furniture(rng: random.Random) -> tuple[Box, ...]:
    """A table, chair, shelf, tower, arch or pile within 6 x 5 x 6 cells, at the origin."""
    width, depth, height = rng.randint(3, 6), rng.randint(2, 5), rng.randint(3, 6)
    kind = rng.choice((_table, _chair, _shelf, _tower, _arch, _pile))
    return kind(rng, width, depth, height)


def _table(rng: random.Random, width: int, depth: int, height: int) -> tuple[Box, ...]:
    inset = rng.randint(0, (width - 1) // 2)
    return (
        Box(0, 0, height - 1, width, depth, 1),
        *(
            Box(x, y, 0, 1, 1, height - 1)
            for x in sorted({inset, width - 1 - inset})
            for y in (0, depth - 1)
        ),
    )


def _chair(rng: random.Random, width: int, depth: int, height: int) -> tuple[Box, ...]:
    seat = rng.randint(2, height - 1)
    arms = rng.random() < 0.3 and depth > 2
    return (
        *_table(rng, width, depth, seat),
        Box(0, depth - 1, seat, width, 1, height - seat),
        *(Box(x, 0, seat, 1, depth, 1) for x in (0, width - 1) if arms),
    )


def _shelf(rng: random.Random, width: int, depth: int, height: int) -> tuple[Box, ...]:
    tiers = sorted(rng.sample(range(height), rng.randint(2, 3)))
    return (
        Box(0, 0, 0, 1, depth, height),
        Box(width - 1, 0, 0, 1, depth, height),
        *(Box(0, 0, z, width, depth, 1) for z in tiers),
    )


def _tower(rng: random.Random, width: int, depth: int, height: int) -> tuple[Box, ...]:
    foot = (Box(0, 0, 0, width, depth, 1),) if rng.random() < 0.5 else ()
    return (
        Box(width // 2, depth // 2, 0, 1, 1, height),
        Box(0, 0, height - 1, width, depth, 1),
        *foot,
    )


def _arch(_rng: random.Random, width: int, depth: int, height: int) -> tuple[Box, ...]:
    return (
        Box(0, 0, 0, 1, depth, height),
        Box(width - 1, 0, 0, 1, depth, height),
        Box(0, 0, height - 1, width, depth, 1),
    )


def _pile(rng: random.Random, width: int, depth: int, height: int) -> tuple[Box, ...]:
    boxes = []
    for _ in range(rng.randint(2, 5)):
        x, y, z = rng.randrange(width), rng.randrange(depth), rng.randrange(height)
        boxes.append(
            Box(
                x,
                y,
                z,
                rng.randint(1, width - x),
                rng.randint(1, depth - y),
                rng.randint(1, height - z),
            )
        )
    low = [min(box[axis] for box in boxes) for axis in range(3)]
    return tuple(
        box._replace(x=box.x - low[0], y=box.y - low[1], z=box.z - low[2]) for box in boxes
    )
