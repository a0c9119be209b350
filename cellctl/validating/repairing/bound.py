"""Scores that no object of a size exceeds, without looking for one."""

from __future__ import annotations

import numpy as np

from cellctl.validating.repairing.score import VIEWS, Floats, Size, Terms, Wanted


def quick_bounds(wanted: Wanted, most: Size, parts: int) -> Floats:
    """A score that no object of a size exceeds, for all sizes up to one, at a blow.

    So many parts share no more than their own volume, and in each outline their own area; and no
    less is covered than was wanted.

    Returns:
        Shaped like ``most``: that of [i, j, k] is of i + 1 by j + 1 by k + 1 cells.
    """
    edges = [np.arange(1, edge + 1, dtype=np.float64) for edge in most]
    ratios = [np.minimum(e, w) / np.maximum(e, w) for e, w in zip(edges, wanted.size, strict=True)]
    spread = np.ix_(*edges)
    agreement = np.cbrt(np.prod(np.broadcast_arrays(*np.ix_(*ratios)), axis=0))
    cells = spread[0] * spread[1] * spread[2]
    shared = np.minimum(1.0, parts / cells / float(wanted.filled.mean()))
    for view, (a, b) in zip(wanted.views, VIEWS, strict=True):
        pixel = 1.0 / (spread[a] * spread[b]) / float(view.mean())
        shared = shared + np.minimum(1.0, parts * pixel) / 3.0
    bounds: Floats = agreement * shared / 2.0
    return bounds


def relaxed_bound(terms: Terms, parts: int) -> float:
    """A score that no object of that size exceeds, found in a millisecond or two.

    It fills the best cells and the best pixels apart from each other, and asks for nothing else.
    """
    volume = np.sort(terms.volume, axis=None)[::-1][:parts]
    pixels: list[Floats] = [np.sort(o, axis=None)[::-1][:parts] for o in terms.outlines]
    low, high = 0.0, 1.0
    # The best score is where shared - score * covered has its root; 20 halvings are a millionth.
    for _ in range(20):
        ratio = (low + high) / 2
        beyond = -2.0 * ratio
        for shared, covered in ((volume, terms.cell), *zip(pixels, terms.pixels, strict=True)):
            gain = shared * (1.0 + ratio) - ratio * covered
            beyond += float(gain[gain > 0].sum())
        low, high = (ratio, high) if beyond > 0 else (low, ratio)
    return terms.agreement * high
