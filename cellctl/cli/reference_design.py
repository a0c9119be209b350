"""Reference pages of designs, from the families and the models themselves."""

from __future__ import annotations

import json

from cellctl.description import description_schema
from cellctl.generating.families import FAMILIES
from cellctl.generating.families.brief import Count, Family, Flag, Takes


def schema_page() -> str:
    """JSON schema of a description."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    schema |= description_schema()
    return json.dumps(schema, indent=2) + "\n"


def families_page(note: str) -> str:
    """Every family, the words that mean it, and its attributes."""
    rows = [
        f"| `{family.name}` | {_about(family)} | {', '.join(family.nouns)} "
        f"| {_attributes(family.takes)} |"
        for family in sorted(FAMILIES, key=lambda family: family.name)
    ]
    return "\n".join(
        [
            note,
            "# Families of designs\n",
            f"What is designed from a description, without a network: {len(FAMILIES)} families. "
            "All take the sizes `width`, `depth` and `height`; what one cannot have is told, and "
            "asked about. See [Designing](../designing.md).\n",
            "| family | what it is | words that mean it | attributes |",
            "| --- | --- | --- | --- |",
            *rows,
            "",
        ]
    )


def _about(family: Family) -> str:
    return (family.build.__doc__ or "").strip().splitlines()[0]


def _attributes(takes: Takes) -> str:
    texts = []
    for name, known in takes.items():
        if isinstance(known, Count):
            span = (
                f"{known.least}" if known.least == known.most else f"{known.least} to {known.most}"
            )
        else:
            span = "true or false" if isinstance(known, Flag) else "one sign"
        texts.append(f"`{name}` ({span}): {known.meaning}")
    return "<br>".join(texts) or "none"
