"""Letters and digits as standing signs, one cell thick.

Each glyph is five or six rows of at most five cells, drawn so that its cells hang together by
faces, every row can be laid on the one below from above, and its weight lies over its foot. A T
is the paper's: a bar three wide on a column five high.
"""

from __future__ import annotations

from cellctl.errors import DesignError
from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Design, Family

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


def _runs(row: str) -> list[tuple[int, int]]:
    """Start and length of each run of cells in a row."""
    starts = [x for x, cell in enumerate(row) if cell == "#" and (x == 0 or row[x - 1] != "#")]
    return [(x, len(row[x:]) - len(row[x:].lstrip("#"))) for x in starts]


def _at_height(rows: tuple[str, ...], height: int) -> tuple[str, ...]:
    """The same glyph taller or lower by whole rows of its thinnest strokes, as far as that goes.

    A repeated row rests on its twin, and one of two twins can go: neither parts the glyph.
    """
    drawn = list(rows)
    while len(drawn) < height:
        thinnest = min(range(len(drawn)), key=lambda i: (drawn[i].count("#"), -i))
        drawn.insert(thinnest, drawn[thinnest])
    while len(drawn) > height:
        twins = [i for i in range(1, len(drawn)) if drawn[i] == drawn[i - 1]]
        if not twins:
            break
        del drawn[twins[0]]
    return tuple(drawn)


def glyph(brief: Brief) -> Design:
    """One letter or digit, read from the front (looking along y).

    A stated height is met by whole rows and a stated depth by thickness; its width is its own.
    """
    brief.used.add("glyph")
    sign = str(brief.attributes.get("glyph", "")).strip().upper()
    if len(sign) > 1:
        raise DesignError(f"I can design one letter or digit at a time, not {sign!r}.")
    if sign not in GLYPHS:
        known = "Say which: A to Z, or 0 to 9."
        if not sign:
            raise DesignError("I did not hear which letter or digit to design.", known)
        raise DesignError(f"I cannot design the sign {sign!r} yet.", known)
    _, depth, height = brief.size(len(GLYPHS[sign][0]), 1, len(GLYPHS[sign]))
    rows = _at_height(GLYPHS[sign], height)
    boxes = tuple(
        Box(start, 0, len(rows) - 1 - index, length, depth, 1)
        for index, row in enumerate(rows)
        for start, length in _runs(row)
    )
    return Design(f"{'number' if sign.isdigit() else 'letter'} {sign}", boxes)


FAMILIES = (
    Family(
        "letter",
        ("letter", "number", "digit", "numeral", "sign", "glyph"),
        glyph,
    ),
)
