"""Changes that leave the shape as it is: turned about, or as it was before the last change."""

from __future__ import annotations

import re

from cellctl.assembly import Edit
from cellctl.listening.numbers import read_number

_IT = r"(?:it|that|this|the (?:whole thing|\w+))"
_AROUND = r"(?:round|around|about|back to front|the other way(?: round| around)?|backwards?)"
_LEFT = r"(?:(?:to (?:the|its) )?left|anti ?clockwise|counter ?clockwise)"
_RIGHT = r"(?:(?:to (?:the|its) )?right|clockwise|sideways|a quarter(?: turn)?)"
_AWAY = r"(?:towards? )?(?:the (?:other way|other side|back|wall)|away)"
_TURN = re.compile(
    rf"(?:rotate|turn|spin|swivel|flip|swing|twist) {_IT}(?: a (?:bit|little))?"
    rf"(?: (?:(?P<around>{_AROUND}|to face {_AWAY}|half ?way(?: round)?)|"
    rf"(?P<left>{_LEFT})|(?P<right>{_RIGHT})|(?:by )?(?P<angle>[\w ]+?) degrees?"
    rf"(?: (?:(?P<anti>{_LEFT})|{_RIGHT}))?))?"
)
_FACE = re.compile(
    rf"(?:(?:make|have|let) {_IT} (?:face|look|point)|{_IT} (?:should|could|must|has to|needs to)"
    rf" (?:face|look|point)|face {_IT}|(?:can|could|should) {_IT} (?:face|look|point)) "
    rf"(?:(?P<around>{_AWAY}|{_AROUND})|(?P<left>{_LEFT})|(?P<right>{_RIGHT}))"
)
_ITS_WAY = r"(?:(?:to |like )?(?:as|how|what|the way) it was|to (?:normal|before|the (?:original|"
_ITS_WAY += r"old one|first one|last one))|again)(?: before| again)?"
_UNDO = re.compile(
    rf"(?:undo|revert)(?: (?:it|that|this|everything|the (?:last )?(?:change|step|edit|one)))?|"
    rf"(?:put|change|turn|make|have|get|set|switch|bring) {_IT} back(?: {_ITS_WAY})?|"
    rf"(?:leave|have|make|put|keep) {_IT} (?:as|how|the way|like) it was(?: before| again)?|"
    rf"(?:(?:go )?back to )?(?:as|how|what|the way|like) it was(?: before)?|"
    rf"(?:go )?back to before|(?:like|as) before|"
    rf"(?:it|that) was (?:better|nicer|prettier)(?: (?:before|the way it was|as it was))?|"
    rf"(?:it|that) was (?:good|fine) (?:before|the way it was|as it was)"
    rf"|(?:i|we) (?:liked|preferred) (?:it (?:better |more )?(?:before|as it was|the way it was|"
    rf"how it was)|the (?:old|first|previous|last|other) (?:one|version)(?: better| more)?)|"
    rf"(?:take|bring|have|show|go)(?: me)? (?:back )?(?:to )?the (?:previous|old|last|"
    rf"first|original) (?:one|version|design)"
    rf"(?: back| again)?"
)


def read_turn(text: str) -> Edit | None:
    """``turn it round``, ``rotate it by ninety degrees``, ``put it back as it was``.

    Args:
        text: lower-case words, without what leads to a change ("could you please").

    Returns:
        A change with the op ``turn`` or ``undo``; None for what is neither.
    """
    if _UNDO.fullmatch(text):
        return Edit(op="undo")
    match = _TURN.fullmatch(text) or _FACE.fullmatch(text)
    if match is None:
        return None
    found = match.groupdict()
    if found.get("angle"):
        words = found["angle"].split()
        number = read_number(words, 0)
        if number is None or number[1] != len(words) or not 0 < number[0] <= 360:
            return None
        angle = number[0] if found["anti"] else 360 - number[0]
    else:
        angle = 180 if found["around"] else 90 if found["left"] else 270
    return Edit(op="turn", amount=float(angle) or 360.0, unit="degrees")
