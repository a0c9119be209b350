"""What a repair changed, in words that a visitor understands."""

from __future__ import annotations

from collections import Counter

import numpy as np
from scipy.optimize import linear_sum_assignment

from cellctl.assembly import Cell, Change
from cellctl.validating.repairing.features import Features, Leg
from cellctl.validating.repairing.reasons import Reason, times
from cellctl.validating.repairing.score import Wanted
from cellctl.validating.rules import Cells

_AXES = (("wider", "narrower"), ("deeper", "shallower"), ("higher", "lower"))

_NUMBERS = ("no", "one", "two", "three", "four", "five", "six")

_LOSSES = ("workspace", "count", "stability", "access", "connectivity")
"""Which rule explains that something became less, the first that was broken; gains and moves are
explained by the same in reverse."""


def describe(wanted: Wanted, built: Cells, why: tuple[Reason, ...]) -> tuple[Change, ...]:
    """Everything that differs, the largest first, each with its reason.

    Args:
        wanted: what was asked for.
        built: what replaces it, from [0, 0, 0].
        why: the rules that the wanted shape breaks; at least one.
    """
    if built == wanted.cells:
        return ()
    new = Wanted(built)
    before = Features(wanted.cells, wanted.size)
    after = Features(built, new.size)
    reason = {found.rule: found.plainly or found.words for found in why}
    broken = [rule for rule in _LOSSES if rule in reason] or list(reason)
    lost, gained = reason[broken[0]], reason[broken[-1]]
    terms = wanted.terms(new.size)
    # The wanted shape at the new size: what differs from it is more than the size.
    resized = Features(
        frozenset(Cell(*cell) for cell in np.argwhere(terms.volume >= terms.cell / 2).tolist()),
        new.size,
    )
    changes = []
    if sentence := _size(before, after):
        changes.append(Change(what=sentence, why=lost))
    legs = _legs(before, after)
    for sentence, less in (*legs, *_plates(resized, after)):
        changes.append(Change(what=sentence, why=lost if less else gained))
    # What was said of the legs as wholes is not said again of their parts.
    told = {"the legs"} if legs else set[str]()
    missing, new_cells = resized.cells - built, built - resized.cells
    changes += [Change(what=said, why=lost) for said in _places(missing, after, "left out", told)]
    changes += [Change(what=said, why=gained) for said in _places(new_cells, after, "added", told)]
    return tuple(changes) or (Change(what="Some parts are elsewhere.", why=gained),)


def _size(before: Features, after: Features) -> str:
    """``It is one part narrower and two parts lower: 5 x 3 x 4 instead of ...``."""
    said = [
        f"{_parts(abs(new - old))} {larger if new > old else smaller}"
        for old, new, (larger, smaller) in zip(before.size, after.size, _AXES, strict=True)
        if new != old
    ]
    if not said:
        return ""
    return (
        f"It is {_and(said)}: {times(after.size)} parts (wide, deep, high) "
        f"instead of {times(before.size)}."
    )


def _legs(before: Features, after: Features) -> list[tuple[str, bool]]:
    """What became of the legs, and whether that is less than before."""
    old, new = before.legs, after.legs
    if not old or not new:
        return []
    if len(old) != len(new):
        legs = "leg" if len(new) == 1 else "legs"
        said = f"It stands on {number(len(new))} {legs} instead of {number(len(old))}."
        return [(said, len(new) < len(old))]
    moves: Counter[str] = Counter()
    thinner = thicker = 0
    for one, other in _paired(old, new):
        if way := _way(one, other, after):
            moves[way] += 1
        expected = float(one.area)
        for axis in range(2):
            expected *= after.size[axis] / before.size[axis]
        thinner += other.area < max(expected, 1.0) - 0.75
        thicker += other.area > max(expected, 1.0) + 0.75
    found = [(f"{_of_legs(count, len(old))} moved {way}.", False) for way, count in moves.items()]
    if thinner:
        found.append((f"{_of_legs(thinner, len(old))} became thinner.", True))
    if thicker:
        found.append((f"{_of_legs(thicker, len(old))} became thicker.", False))
    return found


def _paired(old: tuple[Leg, ...], new: tuple[Leg, ...]) -> list[tuple[Leg, Leg]]:
    """Each leg and what became of it: the pairing with the shortest ways in all."""
    cost = np.array([[abs(a.x - b.x) + abs(a.y - b.y) for b in new] for a in old])
    rows, columns = linear_sum_assignment(cost)
    return [(old[i], new[j]) for i, j in zip(rows.tolist(), columns.tolist(), strict=True)]


def _way(old: Leg, new: Leg, after: Features) -> str:
    """``in``, ``out`` or ``aside``; empty if it moved by less than a part."""
    dx, dy = (new.x - old.x) * after.size[0], (new.y - old.y) * after.size[1]
    if max(abs(dx), abs(dy)) < 0.75:
        return ""
    was = max(abs(old.x - 0.5), abs(old.y - 0.5))
    now = max(abs(new.x - 0.5), abs(new.y - 0.5))
    if abs(now - was) < 0.05:
        return "aside"
    return "in" if now < was else "out"


def _plates(before: Features, after: Features) -> list[tuple[str, bool]]:
    """What became of the tiers and of the top, at the same size."""
    if not before.layer(before.size[2] - 1):
        return []
    found = []
    old, new = len(before.plates), len(after.plates)
    if old != new and max(old, new) > 1 and after.size[2] > 1:
        tiers = "tier" if new == 1 else "tiers"
        found.append((f"It has {number(new)} {tiers} instead of {number(old)}.", new < old))
    for axis in range(2):
        change = after.top[axis] - before.top[axis]
        if change:
            way = _AXES[axis][0] if change > 0 else _AXES[axis][1]
            found.append((f"Its top is {_parts(abs(change))} {way}.", change < 0))
    return found


def _places(cells: Cells, after: Features, done: str, told: set[str]) -> list[str]:
    """``Two parts of the legs are left out.``, for every place that was not told of."""
    where = Counter(place for place in map(after.place, sorted(cells)) if place not in told)
    of = "of" if done == "left out" else "to"
    return [
        f"{_parts(count).capitalize()} {of} {place} {'is' if count == 1 else 'are'} {done}."
        if of == "of"
        else f"{_parts(count).capitalize()} {'is' if count == 1 else 'are'} {done} to {place}."
        for place, count in sorted(where.items(), key=lambda item: (-item[1], item[0]))
    ]


def number(count: int) -> str:
    """In words, up to six."""
    return _NUMBERS[count] if count < len(_NUMBERS) else str(count)


def _parts(count: int) -> str:
    return f"{number(count)} part{'' if count == 1 else 's'}"


def _of_legs(count: int, all_of_them: int) -> str:
    if count == all_of_them:
        return "The leg" if count == 1 else "All legs"
    return f"{number(count)} leg{'' if count == 1 else 's'}".capitalize()


def _and(said: list[str]) -> str:
    return said[0] if len(said) == 1 else f"{', '.join(said[:-1])} and {said[-1]}"
