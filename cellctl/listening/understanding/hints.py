"""What is known of a wish before it is designed: sizes that cannot be, and what is unclear."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Literal

from cellctl.assembly import Attribute, Axis
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.understanding.interpreter import Setting
from cellctl.listening.understanding.talk import talk

Hint = Literal["too_small", "too_big", "too_many"]


_PURPOSE = re.compile(
    r"(?:something|anything|(?:a|some|any)(?: \w+)? thing)(?: \w+)? to .+ "
    r"(?P<where>on|onto|in|into)"
)
_HOLLOW = frozenset({"box"})


def hints_of(
    head: str,
    count: int,
    sizes_m: dict[Axis, float],
    attributes: dict[str, Attribute],
    setting: Setting,
) -> tuple[Hint, ...]:
    """What of a wish cannot be as it was said.

    Without a stated size a thing is taken at its usual one: a mug is smaller than a voxel, a house
    larger than the workspace. Both are built all the same, larger or smaller than they are.
    """
    found: list[Hint] = []
    # Width and depth are told apart by no speaker: the longer edge of the floor holds either.
    floor_m = max(setting.workspace_m[:2])
    limits: dict[Axis, float] = {
        "width": floor_m,
        "depth": floor_m,
        "height": setting.workspace_m[2],
    }
    half_m = setting.pitch_m / 2
    if any(size < half_m for size in sizes_m.values()) or (not sizes_m and head in talk().small):
        found.append("too_small")
    if any(size > limits[axis] + half_m for axis, size in sizes_m.items()) or (
        not sizes_m and head in talk().big
    ):
        found.append("too_big")
    most = max(
        (v for v in attributes.values() if isinstance(v, int) and not isinstance(v, bool)),
        default=0,
    )
    if count > 1 or most > setting.parts:
        found.append("too_many")
    return tuple(found)


def question_of(objects: Sequence[str], count: int, *, either: bool) -> str:
    """What should be asked back about a wish for objects; empty where nothing is unclear."""
    if either and len(objects) > 1:
        return f"Which shall it be: {' or '.join(f'a {noun}' for noun in objects)}?"
    if len(objects) > 1:
        return f"I build one thing at a time. Shall I begin with the {objects[0]}?"
    if count > 1:
        return f"I build one thing at a time. Shall I begin with one {objects[0]}?"
    return ""


def meant_by(words: Sequence[str]) -> str:
    """What somebody may mean who wants "something to sit on"; empty when nothing comes to mind."""
    meant = _meant(words)
    return f"Do you mean {meant}?" if meant else ""


def object_for(words: Sequence[str]) -> str:
    """The one object that a purpose leaves: ``something to hang coats on`` is a coat rack.

    Empty where several would do, or none comes to mind.
    """
    purpose = _PURPOSE.fullmatch(" ".join(words))
    if purpose is None or LEXICON.is_physical(singular(words[-2])) is False:
        return ""  # "something to keep my hopes in"
    objects = [each.split(" ", 1)[1] for each in re.split(r", | or ", _meant(words)) if each]
    if purpose["where"] in ("in", "into"):
        objects = [each for each in objects if each in _HOLLOW]
    return objects[0] if len(objects) == 1 else ""


def _meant(words: Sequence[str]) -> str:
    text = f" {' '.join(words)} "
    if " to " not in text and " for " not in text and " where " not in text:
        return ""
    return next((m for said, m in talk().affordances.items() if f" {said} " in text), "")
