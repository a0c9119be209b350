"""From a line on the screen to what is read aloud: signs become words."""

from __future__ import annotations

import re

_BY = {"en": "by", "de": "mal"}
_SIZE = re.compile(r"(?<=\d)\s*[x\N{MULTIPLICATION SIGN}]\s*(?=\d)")
_SIGNS = str.maketrans(
    dict.fromkeys('`\N{LEFT DOUBLE QUOTATION MARK}\N{RIGHT DOUBLE QUOTATION MARK}"', "")
)


def read_aloud(text: str, language: str) -> str:
    """What a voice shall read; it makes words of numbers and units by itself.

    Args:
        text: as it stands on the screen: "30 x 30 x 40 cm, `cellctl refill`".
        language: its code.
    """
    by = _BY.get(language)
    said = _SIZE.sub(f" {by} ", text) if by is not None else text
    return " ".join(said.translate(_SIGNS).split())
