"""Orders in which one layer can be laid, found without any statics.

Every part rests on something or touches a part of its layer that is already there. A sweep in one
direction never puts a part between two others: of any three in a row it reaches the middle one
second. Only where parts have to wait for a neighbour may that fail.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from collections.abc import Set as AbstractSet
from typing import NamedTuple

from cellctl.assembly import Cell
from cellctl.validating.rules import lateral, reach_steps, steps_from

_SLOPES = ((8, 1), (1, 8), (2, 1), (1, 2))
"""Directions of sweeps, with each of the four signs: nearly along an axis, or between."""
_REACHES = (3, 2, 1)
"""How far an unfinished layer may hang out before its far side is begun too."""


class LayerOrder(NamedTuple):
    """One way to lay a layer, and how good it looks."""

    tight: int
    """Parts that go between two that stand on opposite sides of them."""
    reach: int
    """How far from support a part hangs at most when it is placed."""
    reach_sum: int
    cells: tuple[Cell, ...]


def layer_orders(layer: AbstractSet[Cell], standing: AbstractSet[Cell]) -> list[LayerOrder]:
    """Different orders of a layer's cells; the most promising first, none where none exists.

    Args:
        layer: what is to be placed, all of one z.
        standing: what stands, of this layer and of those beneath.
    """
    around = {cell for cell in standing if layer and cell.z == next(iter(layer)).z}
    resting = {cell for cell in layer | around if cell.z == 0 or cell.below() in standing}
    distances = steps_from(layer | around, resting)
    if not layer <= distances.keys():
        return []
    costs: list[Callable[[Cell], int]] = []
    for a, b in _SLOPES:
        for sx, sy in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            costs.append(lambda c, i=a * sx, j=b * sy: i * c.x + j * c.y)  # type: ignore[misc]
    costs.append(lambda c: distances[c])
    orders = {_sweep(layer, around, resting, cost) for cost in costs}
    for limit in _REACHES:
        orders.add(_grow(layer, around, resting, limit))
    judged = [_judge(order, around, resting) for order in orders]
    return sorted(judged)


def distinct(orders: Sequence[LayerOrder], standing: AbstractSet[Cell]) -> list[LayerOrder]:
    """Without those that are the image of one before, mirrored or turned, by a symmetry of the
    layer and of what stands: they stand as well as that one."""
    if len(orders) < 2:
        return list(orders)
    images = _symmetries(frozenset(orders[0].cells), standing)
    seen: set[tuple[Cell, ...]] = set()
    found = []
    for order in orders:
        if order.cells not in seen:
            found.append(order)
            seen.update(tuple(image[cell] for cell in order.cells) for image in images)
    return found


def _symmetries(layer: AbstractSet[Cell], standing: AbstractSet[Cell]) -> list[dict[Cell, Cell]]:
    """Where each cell of a layer lands by each symmetry, the identity among them."""
    cells = frozenset(layer | standing)
    across = [min(axis) + max(axis) for axis in list(zip(*cells, strict=True))[:2]]
    found = []
    for turned in (False, True) if (across[0] - across[1]) % 2 == 0 else (False,):
        for i in (1, -1):
            for j in (1, -1):
                image = {cell: _image(cell, across, (i, j), turned=turned) for cell in cells}
                if all((to in standing) is (cell in standing) for cell, to in image.items()) and (
                    cells.issuperset(image.values())
                ):
                    found.append({cell: image[cell] for cell in layer})
    return found


def _image(cell: Cell, across: list[int], signs: tuple[int, int], *, turned: bool) -> Cell:
    """A cell mirrored about the middles, twice which is given, after swapping x and y if turned."""
    x, y = 2 * cell.x - across[0], 2 * cell.y - across[1]
    if turned:
        x, y = y, x
    return Cell((signs[0] * x + across[0]) // 2, (signs[1] * y + across[1]) // 2, cell.z)


def tight_fits(order: Iterable[Cell], standing: Iterable[Cell] = ()) -> tuple[Cell, ...]:
    """Cells that are placed between two parts that already stand on opposite sides of them."""
    placed = set(standing)
    found = []
    for cell in order:
        if is_between(cell, placed):
            found.append(cell)
        placed.add(cell)
    return tuple(found)


def is_between(cell: Cell, placed: AbstractSet[Cell]) -> bool:
    """Whether parts stand on opposite sides of a cell, in its layer."""
    x, y, z = cell
    return ((x + 1, y, z) in placed and (x - 1, y, z) in placed) or (
        (x, y + 1, z) in placed and (x, y - 1, z) in placed
    )


def gaps_left(cell: Cell, placed: AbstractSet[Cell], wanted: AbstractSet[Cell]) -> int:
    """How many cells that are still wanted have a part on opposite sides once this one stands."""
    x, y, z = cell
    count = 0
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        # Plain tuples are equal to cells, and made in a fraction of the time.
        far = (x + 2 * dx, y + 2 * dy, z)
        if far in placed:
            gap = (x + dx, y + dy, z)
            count += gap in wanted and gap not in placed
    return count


def _sweep(
    layer: AbstractSet[Cell],
    around: AbstractSet[Cell],
    resting: AbstractSet[Cell],
    cost: Callable[[Cell], int],
) -> tuple[Cell, ...]:
    """Always the cheapest cell that can be placed and leaves no gap; with a gap if it must."""
    placed = set(around)
    left = sorted(layer, key=lambda c: (cost(c), c.x, c.y))
    order: list[Cell] = []
    while left:
        ready = (
            cell
            for cell in left
            if cell in resting or any(beside in placed for beside in lateral(cell))
        )
        first = None
        best = None
        for cell in ready:
            first = first or cell
            if not is_between(cell, placed) and not gaps_left(cell, placed, layer):
                best = cell
                break
        chosen = best or first
        assert chosen is not None  # every cell is joined to one that rests on something
        left.remove(chosen)
        placed.add(chosen)
        order.append(chosen)
    return tuple(order)


def _grow(
    layer: AbstractSet[Cell], around: AbstractSet[Cell], resting: AbstractSet[Cell], limit: int
) -> tuple[Cell, ...]:
    """One front from one place, that begins another one rather than hang out beyond the limit."""
    placed = set(around)
    reach: dict[Cell, int] = _reaches(around, resting)
    order: list[Cell] = []
    left = set(layer)

    def out(cell: Cell) -> int:
        if cell in resting:
            return 0
        near = [reach[c] for c in reach_steps(cell, placed | {cell}) if c in reach]
        return 1 + min(near)

    def price(cell: Cell) -> tuple[int, int, int, int, int, int]:
        attached = any(beside in placed for beside in lateral(cell))
        far = out(cell)
        tight = int(is_between(cell, placed)) + gaps_left(cell, placed, layer)
        return (max(0, far - limit), tight, int(bool(order) and not attached), far, cell.x, cell.y)

    while left:
        ready = [
            cell
            for cell in left
            if cell in resting or any(beside in placed for beside in lateral(cell))
        ]
        chosen = min(ready, key=price)
        reach[chosen] = out(chosen)
        left.discard(chosen)
        placed.add(chosen)
        order.append(chosen)
    return tuple(order)


def _reaches(cells: AbstractSet[Cell], resting: AbstractSet[Cell]) -> dict[Cell, int]:
    """How far out each cell hangs, of all that are joined to one that rests on something."""
    return steps_from(cells, {cell for cell in resting if cell in cells})


def _judge(
    order: tuple[Cell, ...], around: AbstractSet[Cell], resting: AbstractSet[Cell]
) -> LayerOrder:
    """How the order looks: tight fits, and reach at each step."""
    reach = _reaches(around, resting)
    farthest = total = 0
    for cell in order:
        near = [reach[beside] for beside in lateral(cell) if beside in reach]
        reach[cell] = 0 if cell in resting else 1 + min(near)
        farthest = max(farthest, reach[cell])
        total += reach[cell]
    return LayerOrder(len(tight_fits(order, around)), farthest, total, order)
