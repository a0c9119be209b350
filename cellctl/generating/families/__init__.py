"""The parametric families, by the nouns that mean them."""

from __future__ import annotations

from cellctl.assembly import Request
from cellctl.generating.families import (
    animals,
    beds,
    buildings,
    climbing,
    figures,
    glyphs,
    plants,
    seats,
    storage,
    tables,
    things,
)
from cellctl.generating.families.brief import Family

FAMILIES: tuple[Family, ...] = (
    *seats.FAMILIES,
    *tables.FAMILIES,
    *storage.FAMILIES,
    *beds.FAMILIES,
    *climbing.FAMILIES,
    *buildings.FAMILIES,
    *animals.FAMILIES,
    *figures.FAMILIES,
    *plants.FAMILIES,
    *things.FAMILIES,
    *glyphs.FAMILIES,
)

BY_NAME = {family.name: family for family in FAMILIES}
_BY_NOUN = {noun: family for family in FAMILIES for noun in family.nouns}


def find_family(request: Request) -> tuple[Family, str] | None:
    """The family that a request asks for, and the noun that said so; None for no family.

    A compound in the phrase (``coffee table``) is closer to what was meant than its head noun.
    """
    words = f" {request.phrase.lower()} "
    compounds = sorted(
        (noun for noun in _BY_NOUN if " " in noun and f" {noun} " in words), key=len, reverse=True
    )
    for noun in (*compounds, *request.objects):
        family = _BY_NOUN.get(noun.lower())
        if family is not None:
            return family, noun.lower()
    if "glyph" in request.attributes:
        return BY_NAME["letter"], "letter"
    return None
