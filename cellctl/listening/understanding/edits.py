"""Edits: what a sentence changes of an object that was designed before.

``make it two blocks taller and add a leg`` are two changes. A sentence is one of edits only when
every clause of it is; what a clause is about must be a size, a part, a colour or another object, so
that "make the room warmer" changes nothing here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from cellctl.assembly import Edit
from cellctl.listening.dimensions import read_sizes
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import read_number
from cellctl.listening.understanding.edit_phrasing import phrasings
from cellctl.listening.understanding.edit_traits import read_trait
from cellctl.listening.understanding.edit_turns import read_turn
from cellctl.listening.understanding.edit_words import (
    BASES,
    COMPARATIVES,
    VERBS,
    amount_of,
    part_of,
    split_degree,
)

_LEAD = re.compile(
    r"^(?:(?:please|possibly|almost|nearly|actually|no|ok|okay|and|then|now|so|but|oh|well|hmm|"
    r"maybe|perhaps|just|also|"
    r"only|sorry|wait|rather|let's|let us|(?:can|could|would|will) (?:you|we)(?: please)?"
    r"(?: just| also| possibly| maybe)?(?! be\b)(?: have it(?= (?:with|without)\b))?|"
    r"i(?: want| need| would like| would prefer|'d like|'d prefer)"
    r"(?: you)?(?: to)?(?= (?:it|that|them|make|add|remove|change)\b)) )+"
)
_TRAIL = re.compile(
    r" (?:please|this time|now|thanks|thank you|then|too|as well|if you can|if possible|to it|"
    r"on it|from it|of it|for me|(?:would|could|can|will) you)$"
)
_SUBJECT = r"(?P<subject>it|that|this|them|everything|the whole thing|the \w+(?: \w+)??)"
_MAKE = re.compile(rf"(?:make|get|have|build|do) {_SUBJECT} (?:to be )?(?P<how>.+)")
_TELL = re.compile(
    rf"(?:(?:it|that)(?= (?:a bit|a little|much|slightly|even|\w+er)\b)|"
    rf"{_SUBJECT} (?:is|are|looks?|seems?|needs? to be|should be|must be|has to be|have to be|"
    r"could be|can be|needs to get|should get)|it's|that's|they're|(?:can|could|should) it be) "
    r"(?P<how>.+)"
)
_DO = re.compile(
    rf"(?P<verb>{'|'.join(VERBS)}) (?:{_SUBJECT}|the (?P<size>height|width|depth|length|size))"
    r"(?: (?P<how>.+))?"
)
_HAVE = re.compile(
    rf"(?:(?:give|gives) (?:it|that|them)|{_SUBJECT} (?:needs?|should have|must have|has to have|"
    r"could have|could use)|can it have|with|having) (?P<what>.+)"
)
_ADD = re.compile(r"(?:add|put|attach|include)(?: on| in)? (?P<what>.+?)(?: on| to the \w+)?")
_REMOVE = re.compile(
    r"(?:remove|delete|drop|lose|get rid of|take off|take away|without|no|skip|leave out|leave off|"
    r"(?:take|leave) (?=.* (?:off|away|out)$)) ?(?P<what>.+?)(?: off| away| out)?"
)
_SET = re.compile(
    rf"(?:change the number of (?P<named>\w+) to |(?:only|just|exactly) |(?:make|change|turn) "
    rf"{_SUBJECT} (?:to |into )?)(?P<what>.+)"
)
_REPLACE = re.compile(
    rf"(?:(?:make|turn|change|transform) {_SUBJECT} (?:(?:in)?to )?"
    r"(?P<a>(?:an?|the letter|the number) .+)|(?:replace|swap|exchange) \w+ (?:with|by|for) "
    r"(?P<b>.+)|(?:rather|no|make that) (?P<c>an? .+)|(?P<d>an? .+) instead)"
)
_COUNT = re.compile(r"make (?:that|it) (?P<number>[\w ]+)")
_COLOUR = re.compile(
    rf"(?:(?:make|paint|colour|color|turn) {_SUBJECT} |in )(?P<colour>\w+)(?: instead)?"
)
_SAME = re.compile(
    r"(?:(?:make |do |build )?(?:exactly )?(?:the )?same(?: thing| one| again)*|that one|this "
    r"one|that(?= but\b)|"
    r"(?:exactly |just |much )?like (?:that|this|it|before)(?: one)?(?= (?:but|only|just)\b)|"
    r"this(?= but\b)|it(?= but\b)|another(?: one)?(?= but\b)|again(?= but\b))"
    r"(?: but| only| just)? (?P<rest>(?!to you).+)"
)
_INSTEAD = re.compile(r" instead(?: of .+)?$| rather than .+$")
_MORE_PARTS = re.compile(
    r"(?:(?P<number>\w+) more|(?P<another>another|an extra|an additional|one extra)|(?P<more>more|"
    r"some more)) (?P<part>.+)"
)
_FEWER_PARTS = re.compile(
    r"(?:(?P<number>\w+) )?(?:fewer|less) (?P<part>\w+)|"
    r"(?P<count>\w+) (?P<named>\w+) (?:fewer|less)"
)
_WHERE = frozenset({"at", "on", "in", "near", "to"})
_SHARES = {
    **dict.fromkeys(("half", "a half"), "50 percent"),
    **dict.fromkeys(("third", "a third", "one third"), "33.33 percent"),
    **dict.fromkeys(("a quarter", "one quarter"), "25 percent"),
}
_NAMED_BEFORE = frozenset({"with", "without", "for", "that", "of", "not", "but", "instead"})
"""What follows the noun of another object."""
_THICKNESS = frozenset({"thick", "thin", "thicker", "thinner"})
_BARE_COUNTS = frozenset({"legs", "tiers", "drawers"})


@dataclass(frozen=True)
class Editing:
    """What a sentence changes."""

    edits: tuple[Edit, ...]
    replacement: tuple[str, ...] = ()
    """The words that name another object; empty unless one of the edits is ``replace``."""


def read_edits(words: tuple[str, ...], pitch_m: float) -> Editing | None:
    """Read a sentence as changes.

    Args:
        words: lower case, without greetings and fillers.
        pitch_m: what a speaker calls a block.

    Returns:
        None for a sentence that is no edit.
    """
    text = " ".join(words)
    for lead in (False, True):
        for plain in (*phrasings(_trimmed(text, lead=lead)), *phrasings(text)[1:]):
            if (found := _replacement(plain)) is not None:
                return found
            if (edits := _clauses(plain, pitch_m)) is not None:
                return Editing(edits)
    return None


def _trimmed(text: str, *, lead: bool) -> str:
    plain = _LEAD.sub("", f"{text} ").strip() if lead else text
    while (shorter := _TRAIL.sub("", plain)) != plain:
        plain = shorter
    return plain


def _replacement(text: str) -> Editing | None:
    match = _REPLACE.fullmatch(text)
    if match is None:
        return None
    named = next(group for group in match.group("a", "b", "c", "d") if group)
    named = _INSTEAD.sub("", named)
    words = named.split()
    ends = (i for i, word in enumerate(words) if word in _NAMED_BEFORE)
    noun = singular(words[next(ends, len(words)) - 1])
    if words[-1] in COMPARATIVES or words[-1] in BASES:
        return None  # "make it a bit taller", "a little less deep"
    known = part_of(noun) or noun in LEXICON.vague
    if (known and noun not in LEXICON.families) or words[1:] in (["bit"], ["little"], ["lot"]):
        return None
    return Editing((Edit(op="replace", part=noun),), tuple(words))


def _clauses(text: str, pitch_m: float) -> tuple[Edit, ...] | None:
    """All changes of a sentence; None as soon as one clause is none."""
    if match := _SAME.fullmatch(text):
        return _clauses(match["rest"], pitch_m)
    whole = _clause(text, pitch_m)
    if whole is not None:
        return whole
    for between in (" and ", " but "):
        head, joint, tail = text.partition(between)
        first = _clause(head, pitch_m) if joint else None
        rest = _clauses(_trimmed(tail, lead=True), pitch_m) if first is not None else None
        if first is not None and rest is not None:
            return (*first, *rest)
    return None


def _clause(text: str, pitch_m: float) -> tuple[Edit, ...] | None:
    for reader in (
        _colour,
        _count,
        _size,
        _resized,
        _done,
        _fewer,
        _more,
        _fixed,
        _removed,
        _added,
        _turned,
    ):
        edit = reader(text, pitch_m)
        if edit is not None:
            return (edit,)
    return None


def _colour(text: str, _pitch_m: float) -> Edit | None:
    match = _COLOUR.fullmatch(text)
    if match is None or match["colour"] not in LEXICON.colours:
        return None
    return Edit(op="set", attribute="colour", value=match["colour"])


def _count(text: str, _pitch_m: float) -> Edit | None:
    match = _COUNT.fullmatch(text)
    number = _whole(match["number"].split()) if match else None
    return None if number is None else Edit(op="set", attribute="count", value=number)


def _size(text: str, pitch_m: float) -> Edit | None:
    """``make it half a metre tall``; "two blocks taller" is no such size."""
    match = _MAKE.fullmatch(text) or _TELL.fullmatch(text)
    how = (match["how"] if match else text).split()
    if how and how[-1] in COMPARATIVES:
        return None
    sizes = read_sizes(how, pitch_m)
    if len(sizes.metres) != 1 or sizes.spans != [(0, len(how))]:
        return None
    if match is None and "axis_assumed" in sizes.sources.values():
        return None  # "a foot" alone is more likely one to stand on
    axis, size_m = next(iter(sizes.metres.items()))
    part = _part_named(match)
    return None if part is None else Edit(
        op="set", axis=axis, amount=size_m, unit="metres", part=part
    )  # fmt: skip


def _resized(text: str, _pitch_m: float) -> Edit | None:
    match = _MAKE.fullmatch(text) or _TELL.fullmatch(text)
    part = _part_named(match)
    if part is None:
        return None
    how = (match["how"] if match else text).split()
    if match is None and len(how) > 1 and (named := part_of(singular(how[-1]))):
        # "longer legs", "a higher back"
        start = 1 if how[0] in ("a", "an", "with") else 0
        part, how = named.part, how[start:-1]
    trait = read_trait(how, told=match is not None and match.re is _TELL)
    if trait is None:
        return None
    if part and trait.axis == "depth" and how[-1] in _THICKNESS:
        trait = replace(trait, axis=None, attribute="thickness")
    axis = trait.axis
    if axis == "height" and part in ("leg", "neck", "tail"):
        axis = "length"
    return Edit(
        op="scale",
        part=part,
        attribute=trait.attribute,
        axis=axis,
        direction=trait.direction,
        amount=trait.amount,
        unit=trait.unit,
    )


def _done(text: str, _pitch_m: float) -> Edit | None:
    """``lower it``, ``raise it by ten centimetres``, ``shrink the seat a bit``."""
    match = _DO.fullmatch(text)
    if match is None:
        return None
    size = BASES[match["size"]] if match["size"] else None
    subject = match["subject"]
    if size is None and subject and (base := BASES.get(subject.split()[-1])):
        size, subject = base, "it"
    part = _part_named(match) if size is None else ""
    if part is None:
        return None
    verb = VERBS[match["verb"]]
    axis = size.axis if size is not None else verb.axis
    how = (match["how"] or "").removeprefix("by ")
    _, rest = split_degree(_SHARES.get(how, how).split())
    amount, unit, rest = amount_of([*rest, ""]) if rest else (None, None, [])
    if [word for word in rest if word]:
        return None
    if match["verb"] in ("double", "halve"):
        amount, unit = 2.0, "times"
    trait = verb.by(verb.direction, amount, unit)
    return Edit(
        op="scale", part=part, attribute=trait.attribute, axis=axis,
        direction=trait.direction, amount=trait.amount, unit=trait.unit,
    )  # fmt: skip


def _part_named(match: re.Match[str] | None) -> str | None:
    """The part a clause is about; empty for the object, None for what is no part of one."""
    subject = (match.groupdict().get("subject") or "it") if match else "it"
    if not subject.startswith("the ") or subject == "the whole thing":
        return ""
    noun = singular(subject.split()[-1])
    if noun in LEXICON.families or noun in ("object", "model", "design", "thing"):
        named = part_of(noun)
        return named.part if named and noun not in LEXICON.families else ""
    named = part_of(noun)
    return named.part if named else None


def _more(text: str, _pitch_m: float) -> Edit | None:
    """``two more tiers``, ``another leg``, ``more legs``; with "add" and the like before it."""
    match = _HAVE.fullmatch(text) or _ADD.fullmatch(text)
    what = match["what"] if match else text
    # "one tier more" is "one more tier".
    what = re.sub(r"^(\w+) (\w+) more$", r"\1 more \2", what)
    found = _MORE_PARTS.fullmatch(what)
    if found is None or _WHERE & set(found["part"].split()):
        return None
    named = part_of(singular(found["part"].split()[-1]))
    if named is None or (match is None and found["another"] and named.part in LEXICON.families):
        return None
    number = 1 if found["another"] else _whole([found["number"]]) if found["number"] else None
    if number is None and not found["more"]:
        return None
    return Edit(
        op="add", part=named.part, attribute=named.attribute, amount=number,
        unit="parts" if number else None,
    )  # fmt: skip


def _fewer(text: str, _pitch_m: float) -> Edit | None:
    match = _HAVE.fullmatch(text)
    found = _FEWER_PARTS.fullmatch(match["what"] if match else text)
    named = part_of(singular(found["part"] or found["named"])) if found else None
    if found is None or named is None:
        return None
    said = found["number"] or found["count"]
    number = _whole([said]) if said else 1
    return None if number is None else Edit(
        op="remove", part=named.part, attribute=named.attribute, amount=number, unit="parts"
    )  # fmt: skip


def _fixed(text: str, _pitch_m: float) -> Edit | None:
    """``with three legs``, ``make it four tiers``, ``change the number of legs to four``."""
    match = _HAVE.fullmatch(text) or _SET.fullmatch(text)
    what = _INSTEAD.sub("", match["what"] if match else text).split()
    if match is None and _INSTEAD.search(text) is None and not _is_count(what):
        return None
    if what[:1] in (["only"], ["just"], ["exactly"]):
        what = what[1:]
    number = read_number(what, 0) if what and what[0] not in ("a", "an") else None
    if number is None or number[0] != int(number[0]):
        return None
    groups = match.groupdict() if match else {}
    noun = groups.get("named") or (what[-1] if number[1] < len(what) else "")
    named = part_of(singular(noun)) if noun else None
    if named is None or len(what) - number[1] > 2:
        return None
    return Edit(op="set", part=named.part, attribute=named.attribute, value=int(number[0]))


def _is_count(what: list[str]) -> bool:
    """Whether it says how many of a part and nothing else: ``four legs``; two shelves are two."""
    number = read_number(what, 0)
    part = part_of(singular(what[-1])) if number and number[1] == len(what) - 1 else None
    return part is not None and part.attribute in _BARE_COUNTS and part.part not in LEXICON.families


def _added(text: str, _pitch_m: float) -> Edit | None:
    match = _ADD.fullmatch(text) or _HAVE.fullmatch(text)
    what = match["what"].split() if match else []
    if set(what) & (COMPARATIVES.keys() | _WHERE):
        return None  # "give it a longer neck"
    number = read_number(what, 0)
    start = number[1] if number and number[0] == int(number[0]) else 0
    if start == 0:
        if what[:1] not in (["a"], ["an"], ["some"]) and len(what) != 1:
            return None
        start = 1 if what[:1] in (["a"], ["an"], ["some"]) else 0
    named = part_of(singular(what[-1])) if start < len(what) <= start + 3 else None
    if named is None:
        return None
    amount = int(number[0]) if number and start == number[1] else None
    if amount is None and named.counted and what[0] in ("a", "an"):
        amount = 1
    return Edit(
        op="add", part=named.part, attribute=named.attribute, amount=amount or None,
        unit="parts" if amount else None,
    )  # fmt: skip


def _removed(text: str, _pitch_m: float) -> Edit | None:
    match = _REMOVE.fullmatch(text)
    what = match["what"].split() if match else []
    number = read_number(what, 0)
    amount = int(number[0]) if number and number[0] >= 1 else None
    rest = what[number[1] :] if number and amount else what
    while rest[:1] in (["the"], ["all"], ["of"], ["a"], ["an"], ["its"], ["one"], ["any"]):
        if rest[0] in ("a", "an", "one"):
            amount = 1
        rest = rest[1:]
    named = part_of(singular(rest[-1])) if 0 < len(rest) <= 2 else None
    if named is None:
        return None
    if not named.counted:
        amount = None
    return Edit(
        op="remove", part=named.part, attribute=named.attribute, amount=amount,
        unit="parts" if amount else None,
    )  # fmt: skip


def _turned(text: str, _pitch_m: float) -> Edit | None:
    return read_turn(text)


def _whole(words: list[str]) -> int | None:
    number = read_number(words, 0)
    if number is None or number[1] != len(words) or number[0] != int(number[0]) or number[0] < 1:
        return None
    return int(number[0])
