"""Stated sizes: ``half a metre high``, ``60 cm wide``, ``thirty by forty by eighty cm``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from cellctl.assembly import Axis
from cellctl.listening.numbers import read_number

Source = Literal["stated", "voxels", "axis_assumed"]

UNITS_M = {
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), 0.001),
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetre", "centimetres"), 0.01),
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **dict.fromkeys(("inch", "inches"), 0.0254),
    **dict.fromkeys(("foot", "feet", "ft"), 0.3048),
}
_VOXELS = frozenset({"block", "blocks", "voxel", "voxels", "cube", "cubes"})
_AXES: dict[str, Axis] = {
    **dict.fromkeys(("tall", "high", "height"), "height"),
    **dict.fromkeys(("wide", "width", "long", "length", "across", "broad"), "width"),
    **dict.fromkeys(("deep", "depth", "thick"), "depth"),
}
_SQUARE = tuple(
    tuple(each.split())
    for each in ("on each side", "on every side", "on a side", "each side", "each way", "a side",
                 "per side", "square", "in square")
)  # fmt: skip
_TRIPLE: tuple[Axis, ...] = ("width", "depth", "height")
_LARGEST_M = 100.0
_LEAST_CM = 12
"""From here on a number without a unit counts centimetres rather than blocks."""


@dataclass
class Sizes:
    """The sizes of one sentence, and the words that stated them."""

    metres: dict[Axis, float] = field(default_factory=dict)
    sources: dict[Axis, Source] = field(default_factory=dict)
    """How each of them was said."""
    spans: list[tuple[int, int]] = field(default_factory=list)
    """Ranges of words, start to end, that state a size."""


def read_sizes(words: Sequence[str], pitch_m: float) -> Sizes:
    """Find every stated size; later ones correct earlier ones.

    A size without an axis is a height. ``N by N`` are width and depth, a third is the height.

    Args:
        words: lower case, without punctuation.
        pitch_m: what a speaker calls a block.
    """
    sizes = Sizes()
    index = 0
    while index < len(words):
        end = _read_size(words, index, pitch_m, sizes)
        index = end if end is not None else index + 1
    return sizes


def _read_size(words: Sequence[str], start: int, pitch_m: float, sizes: Sizes) -> int | None:
    values: list[float] = []
    end = start
    while (number := _number(words, end)) is not None:
        values.append(number[0])
        end = number[1]
        # "thirty centimeters by forty centimeters" repeats its unit.
        repeated = end + 1 < len(words) and words[end] in UNITS_M and words[end + 1] == "by"
        end += repeated
        if end >= len(words) or words[end] != "by" or len(values) == 3:
            break
        end += 1
    if not values:
        return None
    unit_m = _unit_m(words, end, pitch_m, len(values)) if end < len(words) else None
    if unit_m is None:
        if len(values) > 1:
            return _without_unit(values, end, pitch_m, sizes, start)
        return _counted(words, values[0], (start, end), pitch_m, sizes)
    source: Source = "voxels" if words[end] in _VOXELS else "stated"
    end += 1
    if list(words[end : end + 3]) == ["and", "a", "half"]:
        values[-1] += 0.5
        end += 3
    elif unit_m == 1.0 and (more := read_number(words, end)) is not None and _is_rest(words, more):
        # "a metre twenty"
        values[-1] += more[0] / 100
        end = more[1]
    if len(values) > 1:
        for axis, value in zip(_TRIPLE, values, strict=False):
            _store(sizes, axis, value * unit_m, source)
    else:
        said, end = _axis(words, start, end)
        if said is None and (square := _square(words, end)) is not None:
            _store(sizes, "width", values[0] * unit_m, source)
            _store(sizes, "depth", values[0] * unit_m, source)
            end = square
        else:
            _store(sizes, said or "height", values[0] * unit_m, source if said else "axis_assumed")
    sizes.spans.append((start, end))
    return end


def _counted(
    words: Sequence[str], value: float, span: tuple[int, int], pitch_m: float, sizes: Sizes
) -> int | None:
    """``seven high`` counts blocks, ``eighty high`` centimetres."""
    start, end = span
    if end >= len(words) or words[end] not in _AXES or value < 1:
        return None
    few = value < _LEAST_CM
    _store(
        sizes, _AXES[words[end]], value * (pitch_m if few else 0.01), "voxels" if few else "stated"
    )
    sizes.spans.append((start, end + 1))
    return end + 1


def _without_unit(
    values: list[float], end: int, pitch_m: float, sizes: Sizes, start: int
) -> int | None:
    """``eighty by forty`` are centimetres; ``three by three`` are counted in blocks."""
    if all(value >= _LEAST_CM for value in values):
        unit_m: float = 0.01
        source: Source = "stated"
    elif all(value < _LEAST_CM for value in values):
        unit_m, source = pitch_m, "voxels"
    else:
        return None
    for axis, value in zip(_TRIPLE, values, strict=False):
        _store(sizes, axis, value * unit_m, source)
    sizes.spans.append((start, end))
    return end


def _is_rest(words: Sequence[str], number: tuple[float, int]) -> bool:
    """Whether a number after metres counts the centimetres: ``a metre twenty``, with no unit."""
    value, end = number
    following = words[end] if end < len(words) else ""
    return 10 <= value < 100 and (following in _AXES or following in ("", "and", "with", "by"))


def _number(words: Sequence[str], start: int) -> tuple[float, int] | None:
    if (number := read_number(words, start)) is not None:
        return number
    if start + 1 < len(words) and words[start] in ("a", "an") and words[start + 1] in UNITS_M:
        return 1.0, start + 1
    return None


def _unit_m(words: Sequence[str], index: int, pitch_m: float, values: int) -> float | None:
    word = words[index]
    if word in UNITS_M:
        return UNITS_M[word]
    if word in _VOXELS and (values > 1 or (index + 1 < len(words) and words[index + 1] in _AXES)):
        return pitch_m
    return None


def _axis(words: Sequence[str], start: int, end: int) -> tuple[Axis | None, int]:
    """``60 cm wide``, ``60 cm in width``, ``a width of 60 cm``; None where nobody said which."""
    after = end + 1 if end < len(words) and words[end] == "in" else end
    if after < len(words) and words[after] in _AXES:
        return _AXES[words[after]], after + 1
    if start >= 2 and words[start - 1] == "of" and words[start - 2] in _AXES:
        return _AXES[words[start - 2]], end
    return None, end


def _square(words: Sequence[str], index: int) -> int | None:
    """Where ``square`` or ``on each side`` ends that stands at ``index``; None for neither."""
    for said in _SQUARE:
        if tuple(words[index : index + len(said)]) == said:
            return index + len(said)
    return None


def _store(sizes: Sizes, axis: Axis, value_m: float, source: Source) -> None:
    if 0.0 < value_m <= _LARGEST_M:
        sizes.sources[axis] = source
        sizes.metres[axis] = round(value_m, 4)
