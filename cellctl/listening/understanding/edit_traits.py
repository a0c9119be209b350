"""What a comparison changes and by how much: ``a bit taller``, ``twice as wide``, ``too big``."""

from __future__ import annotations

from cellctl.listening.numbers import read_number
from cellctl.listening.understanding.edit_words import (
    BASES,
    COMPARATIVES,
    Direction,
    Trait,
    amount_of,
    opposite,
    split_degree,
)

_FRACTIONS = {"third": 1 / 3, "quarter": 1 / 4}
_ALONE = frozenset(
    {"tall", "high", "short", "low", "wide", "broad", "narrow", "thin", "thick", "deep", "long",
     "big", "large", "small", "huge", "strong", "sturdy"}
)  # fmt: skip


def _counting_one(how: list[str]) -> list[str]:
    """``a block lower`` is "one block lower"; "a bit lower" stays."""
    counts = how[1:2] and (how[1] in _FRACTIONS or amount_of(how)[1] is not None)
    return ["one", *how[1:]] if counts and how[0] in ("a", "an") else how


def _by_a_fraction(how: list[str]) -> Trait | None:
    """``one third higher``."""
    if len(how) != 3 or how[0] != "one" or how[1] not in _FRACTIONS:
        return None
    found = COMPARATIVES.get(how[2])
    if found is None or found.attribute:
        return None
    part = _FRACTIONS[how[1]]
    factor = 1 + part if found.direction == "+" else 1 / (1 - part)
    return found.by(found.direction, round(factor, 4), "times")


def read_trait(  # noqa: PLR0911, PLR0912 - one a way to say it
    how: list[str], *, told: bool
) -> Trait | None:
    """``a bit taller``, ``two blocks wider``, ``twice as tall``, ``too big``, ``not so high``."""
    how = _counting_one(how)
    if (by_part := _by_a_fraction(how)) is not None:
        return by_part
    degree, rest = split_degree(how)
    if not rest:
        return None
    factor = {"twice": 2.0, "double": 2.0, "half": 2.0}.get(rest[0])
    number = read_number(rest, 0)
    if number is not None and rest[number[1] : number[1] + 1] == ["times"]:
        factor, rest = number[0], rest[number[1] :]
    if factor is not None and rest[1:2] in (["as"], ["the"]) and len(rest) > 2:
        base = BASES.get(rest[2]) or COMPARATIVES.get(rest[2])
        if base is None or len(rest) not in (3, 5):
            return None
        direction: Direction = "-" if rest[0] == "half" else "+"
        return Trait(base.axis, direction, base.attribute, factor, "times")
    amount, unit, rest = amount_of(rest)
    if rest[:1] in (["more"], ["less"]) and len(rest) == 2 and rest[1] in BASES:
        base = BASES[rest[1]]
        direction = base.direction if rest[0] == "more" else opposite(base.direction)
        return base.by(direction, amount, unit)
    if len(rest) > 1 and rest[0] in COMPARATIVES and rest[1] == "by":
        amount, unit, after = amount_of(rest[2:])
        rest = rest[:1] if amount is not None and not after else rest
    if len(rest) > 1 and rest[-1] == "than":
        rest = rest[:-1]
    if len(rest) == 1 and rest[0] in COMPARATIVES:
        found = COMPARATIVES[rest[0]]
        return found.by(found.direction, amount, unit)
    if len(rest) in (1, 2) and rest[0] in BASES and rest[1:] in ([], ["enough"]):
        base = BASES[rest[0]]
        if degree & {"too"}:
            return base.by(opposite(base.direction), None, None)
        if degree & {"not"}:
            more = rest[1:] == ["enough"]
            return base.by(base.direction if more else opposite(base.direction), None, None)
        if rest[0] in _ALONE and told:
            return base.by(base.direction, None, None)
    return None
