"""Letters and digits as standing signs, one cell thick.

Each glyph is five or six rows of at most five cells, drawn so that its cells hang together by
faces, every row can be laid on the one below from above, and its weight lies over its foot. A T
is the paper's: a bar three wide on a column five high.
"""

from __future__ import annotations

from cellctl.errors import DesignError
from cellctl.generating.families.brief import Brief, Design, Family, Sign
from cellctl.generating.families.forms import at_height, standing

GLYPHS: dict[str, tuple[str, ...]] = {
    "A": (".###.", "##.##", "#...#", "#####", "#...#"),
    "B": ("###.", "#.##", "###.", "#.##", "###."),
    "C": ("####", "#...", "#...", "#...", "####"),
    "D": ("###.", "#.##", "#..#", "#.##", "###."),
    "E": ("###", "#..", "###", "#..", "###"),
    "F": (".####", ".#...", ".###.", ".#...", "###.."),
    "G": ("####", "#...", "#.##", "#..#", "####"),
    "H": ("#..#", "#..#", "####", "#..#", "#..#"),
    "I": ("###", ".#.", ".#.", ".#.", "###"),
    "J": ("..#", "..#", "..#", "#.#", "###"),
    "K": ("#..#", "#.##", "###.", "#.##", "#..#"),
    "L": ("#..", "#..", "#..", "#..", "###"),
    "M": ("#...#", "##.##", "#####", "#...#", "#...#"),
    "N": ("#...#", "##..#", "###.#", "#.###", "#..##", "#...#"),
    "O": ("####", "#..#", "#..#", "#..#", "####"),
    "P": (".###.", ".#.##", ".###.", ".#...", "###.."),
    "Q": ("####.", "#..#.", "#..#.", "#.##.", "#####"),
    "R": ("###.", "#.##", "###.", "#.##", "#..#"),
    "S": (".###", "##..", ".##.", "..##", "###."),
    "T": ("###", ".#.", ".#.", ".#.", ".#.", ".#."),
    "U": ("#..#", "#..#", "#..#", "#..#", "####"),
    "V": ("#...#", "#...#", "##.##", ".###.", "..#.."),
    "W": ("#...#", "#...#", "#.#.#", "#.#.#", "#####"),
    "X": ("#...#", "##.##", ".###.", "##.##", "#...#"),
    "Y": ("#...#", "##.##", ".###.", "..#..", "..#.."),
    "Z": ("####", "..##", ".##.", "##..", "####"),
    "0": ("###", "#.#", "#.#", "#.#", "###"),
    "1": (".#.", "##.", ".#.", ".#.", "###"),
    "2": ("###", "..#", "###", "#..", "###"),
    "3": ("###", "..#", "###", "..#", "###"),
    "4": ("#.#.", "#.#.", "####", "..#.", ".###"),
    "5": ("###", "#..", "###", "..#", "###"),
    "6": ("###", "#..", "###", "#.#", "###"),
    "7": ("###", "..#", "..#", "..#", "..#"),
    "8": ("###", "#.#", "###", "#.#", "###"),
    "9": ("###", "#.#", "###", "..#", "###"),
}


def glyph(brief: Brief) -> Design:
    """One letter or digit, read from the front (looking along y).

    A stated height is met by whole rows and a stated depth by thickness; its width is its own.
    """
    sign = str(brief.attributes.get("glyph", "")).strip().upper()
    if len(sign) > 1:
        raise DesignError(f"I can design one letter or digit at a time, not {sign!r}.")
    if sign not in GLYPHS:
        known = "Say which: A to Z, or 0 to 9."
        if not sign:
            raise DesignError("I did not hear which letter or digit to design.", known)
        raise DesignError(f"I cannot design the sign {sign!r} yet.", known)
    _, depth, height = brief.size(len(GLYPHS[sign][0]), 1, len(GLYPHS[sign]))
    brief.values["glyph"] = sign
    boxes = standing(at_height(GLYPHS[sign], height), depth)
    return Design(f"{'number' if sign.isdigit() else 'letter'} {sign}", boxes)


FAMILIES = (
    Family(
        "letter",
        ("letter", "number", "digit", "numeral", "sign", "glyph"),
        glyph,
        {"glyph": Sign("The letter A to Z or the digit 0 to 9.")},
    ),
)
