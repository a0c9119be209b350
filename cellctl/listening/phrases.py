"""The noun phrase of a wish: its words, its head noun, how many there are."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from cellctl.listening.attributes import GLYPH_NOUNS
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import read_number
from cellctl.listening.understanding.judging import acts_at, is_participle, judge
from cellctl.listening.understanding.words import look_up

_HESITATION = r"(?:er|erm|um|uh|hmm|oh|well|you know|let's say|maybe|yes|yeah|ah|but|so)"
_CORRECTION = (
    r"(?:(?:no|actually) make (?:it|that)|(?:no )?scrap that|(?:no )?forget (?:that|it)|no "
    r"wait|wait no|"
    r"(?:no )?(?:hang|hold) on|no sorry|sorry|i mean|i meant|no|nope|nah|or rather|or better|"
    r"rather|better|make (?:that|it)|actually|wait|on second thoughts?|correction|"
    r"(?:no )?(?:scratch|strike|ignore|drop|cancel) (?:that|it)|i take (?:that|it) back)"
)
_REPAIR_MARK = rf"(?:{_HESITATION} )*{_CORRECTION}(?: (?:{_HESITATION}|{_CORRECTION}))*"
_NUMBER_REPAIR = re.compile(rf"\b(\w+) (\w+) {_REPAIR_MARK} (\w+) (\w+)\b")
_COUNT_REPAIR = re.compile(
    rf"\b(?P<first>\w+) (?:{_REPAIR_MARK}|{_HESITATION}) (?P<then>\w+)(?= (?P<noun>\w+))"
)
_BARE_REPAIR = re.compile(rf"(?P<first>\w+) {_REPAIR_MARK} (?P<then>\w+)")
_OBJECT_REPAIR = re.compile(
    rf"\b(?:a|an|the) [a-z ]+? {_REPAIR_MARK} "
    r"(?:(?:i (?:want|need)|(?:make|build|give|do)(?: me| us)?|let's have|have) )?"
    r"((?:a|an|the) \w+)"
)
_RESTATED = re.compile(
    rf"\b(?:(?:an?|the) )?(?P<noun>\w+) (?:(?:{_HESITATION}|{_CORRECTION}|like) )*"
    r"(?P<again>(?:an?|the) (?:(?!(?:an?|the)\b)[\w-]+ ){0,3}(?P=noun))\b"
    r"(?P<after> (?:i mean|i meant|actually|rather|that is|to be (?:exact|precise)))?"
)
"""``a tree, a christmas tree I mean``, ``a duck, yes, a duck``."""
_RETRACTED = re.compile(
    r"\b(?:i|we) (?:was|were) (?:just )?(?:going to|gonna|about to|thinking of) (?:\w+ ){1,2}?"
    r"(?:an?|the) (?:\w+ ){1,4}?but (?:(?:now|actually|rather|then|instead) )*(?:make (?:it|"
    r"that) )?"
)
"""``I was going to say a car but actually, make it a truck``."""
_TRAILING = frozenset(
    {"please", "instead", "now", "today", "then", "thanks", "again", "too", "quickly", "possible",
     "first", "next", "soon", "ever", "immediately", "robot", "ok", "okay"}
)  # fmt: skip
_COMPANY = frozenset({"me", "us", "you", "him", "her", "them"})
_GLYPHS = GLYPH_NOUNS
_CASES = frozenset({"capital", "uppercase", "lowercase"})
_PAIRED = LEXICON.colours | LEXICON.comparatives
_AFTER_CAN = frozenset({"with", "for", "of", "to", "in", "on", "and", "without", "that"})
_AFTER_NOUNS = (LEXICON.comparatives | LEXICON.colours | {"round", "square"}) - {"light"}
"""What describes a noun from behind in many a language; a "street light" is a noun."""
_ADVERBS = frozenset({"up", "down", "out", "all", "standing"})
_HAD_IN_NUMBERS = frozenset(
    {"wing", "wheel", "head", "eye", "corner", "side", "point", "horn", "door", "mast", "storey",
     "stori", "seat", "sail", "tine", "prong", "room", "floor"}
)  # fmt: skip
_PLACED = frozenset({"on", "in", "at", "by", "under", "with", "of", "from", "into"})
_BEFORE_OF = frozenset({"full", "fit", "suitable", "big", "large", "high", "tall", "small", "good",
                        "similar", "ready", "made", "wide", "long", "strong"})  # fmt: skip
_SIZED = frozenset({"about", "around", "roughly", "approximately", "is", "measuring", "be"})
"""Words that only lead to a size, and go with it."""


@dataclass(frozen=True)
class NounPhrase:
    """What a wish names."""

    text: str
    """Lower case, without its article."""
    objects: tuple[str, ...]
    """Head nouns, singular."""
    count: int
    core: tuple[str, ...]
    """The words up to its noun, without the article."""
    determiner: str
    """The word before them, such as ``a`` or ``my``; a number for a counted one; or empty."""
    rest: tuple[str, ...]
    """All that follows the core in the sentence, less its sizes."""
    either: bool = False
    """Whether it names several of which one is wanted: ``a bench or a stool``."""


def repair(words: list[str]) -> list[str]:
    """Obey what speakers correct: ``four legs no wait three legs``, ``a shelf no a bench``."""
    text = _RETRACTED.sub("", " ".join(words))
    text = _RESTATED.sub(_keep_again, text)
    text = _COUNT_REPAIR.sub(_keep_later_count, text)
    text = _NUMBER_REPAIR.sub(_keep_later_number, text)
    text = _OBJECT_REPAIR.sub(lambda match: match[1], text)
    if (bare := _BARE_REPAIR.fullmatch(text)) and {bare["first"], bare["then"]} <= LEXICON.families:
        return [bare["then"]]  # "table no chair"
    return text.split()


def _keep_again(match: re.Match[str]) -> str:
    noun = singular(match["noun"])
    is_thing = match["noun"] not in LEXICON.enders and judge((noun,), noun).physical
    return match["again"] if is_thing else match[0]


def _keep_later_count(match: re.Match[str]) -> str:
    """``three, I mean four legs``."""
    counts = all(read_number([match[one]], 0) is not None for one in ("first", "then"))
    return match["then"] if counts and singular(match["noun"]) in LEXICON.parts else match[0]


def _keep_later_number(match: re.Match[str]) -> str:
    earlier, noun, later, again = match.groups()
    is_count = read_number([earlier], 0) is not None and read_number([later], 0) is not None
    return f"{later} {again}" if is_count and singular(noun) == singular(again) else match[0]


def read_phrase(words: Sequence[str], size_spans: Sequence[tuple[int, int]]) -> NounPhrase | None:
    """Read the phrase that a wish starts with.

    Args:
        words: the wish, without what asks for it.
        size_spans: ranges of words that state a size; they are no part of the phrase.

    Returns:
        None when there is no noun phrase.
    """
    kept = _without_sizes(words, size_spans)
    while len(kept) > 1 and kept[-1] in _TRAILING and not _describes(kept[-2]):
        kept.pop()
    count, start, determiner = _determiner(kept)
    numeral = _numeral(kept, start) if count > 1 else []
    end = start
    stops = LEXICON.enders | LEXICON.finite
    while end < len(kept) and (kept[end] not in stops or _is_noun_here(kept, start, end)):
        if (
            end > start
            and read_number(kept, end) is not None
            and not set(kept[start:end]) & _GLYPHS
        ):
            break
        if end > start and determiner in ("a", "an") and kept[end] in ("the", "my", "your", "our"):
            break  # "a bench the length of my arm"
        if end > start and (is_participle(kept, end) or _follows_noun(kept, end)):
            break
        end += 1
    core = kept[start:end]
    if core and not core[-1].isalpha() and not (len(core) > 1 and core[-2] in _GLYPHS):
        return None
    if not core:
        return None
    rest = tuple(kept[end:])
    head, tail = _head(core, kept[end:])
    others, more, tail, either = _others(tail, rest)
    return NounPhrase(
        text=" ".join([*numeral, *core, *tail]),
        objects=(head, *others),
        count=count + more,
        core=tuple(core),
        determiner=determiner,
        rest=rest,
        either=either,
    )


def _follows_noun(words: Sequence[str], index: int) -> bool:
    """Whether what follows a noun tells more of it: ``a box full of``, ``a bench long enough``,
    ``a throne fit for``; or does something with it: ``a desk make it``."""
    word, after = words[index], words[index + 1 : index + 2]
    entry = look_up(word)
    if word in ("twice", "half") and after[:1] in (["as"], ["the"]):
        return True
    ends = not after or after[0] in LEXICON.enders
    if (
        (word in _AFTER_NOUNS and (ends or _counts(words, index)))  # "a table small"
        or (word in _ADVERBS and after and ends)  # "a tower up to the sky"
        or _measured(words, index)  # "a stool knee high"
        or (after and after[0] in _PLACED and _is_past_adjective(word))  # "a bag left on a bench"
    ):
        noun = singular(words[index - 1])
        return judge((noun,), noun).physical is True
    if entry is None or not after or word in LEXICON.physical:
        return False
    if after[0] in ("it", "them"):
        return "v" in entry.parts
    noun = singular(words[index - 1])
    if "a" not in entry.parts or not judge((noun,), noun).physical:
        return False
    return after[0] == "enough" or (word in _BEFORE_OF and after[0] in ("of", "for", "to", "as"))


def _is_past_adjective(word: str) -> bool:
    entry = look_up(word)
    return entry is not None and {"p", "a"} <= set(entry.parts) and word not in LEXICON.colours


def _measured(words: Sequence[str], index: int) -> bool:
    """Whether a size is told by a body: ``knee high``, at the end of what is said of the thing."""
    entry = look_up(words[index])
    return (
        entry is not None
        and entry.kind == "b"
        and set(words[index + 1 : index + 2]) <= {"high", "deep", "tall", "wide", "length"}
        and set(words[index + 2 : index + 3]) <= LEXICON.enders
        and index + 1 < len(words)
    )


def _counts(words: Sequence[str], index: int) -> bool:
    return read_number(words, index + 1) is not None


def _describes(word: str) -> bool:
    """Whether a noun must follow: "a big robot" speaks to nobody."""
    entry = look_up(word)
    return word in LEXICON.determiners or (entry is not None and entry.parts[:1] == "a")


def _is_noun_here(words: Sequence[str], start: int, index: int) -> bool:
    """A ``plus sign`` and a ``trash can`` have words that elsewhere end a phrase."""
    if words[index] == "plus":
        return index == start
    if words[index] == "and" and index > start:  # "a red and blue box"
        return {words[index - 1], *words[index + 1 : index + 2]} <= _PAIRED
    following = words[index + 1 : index + 2]
    if words[index] == "next":
        return following != ["to"]
    if words[index] != "can" or index <= start:
        return False
    after = following[0] if following else ""
    return not after or after in _AFTER_CAN or (after.endswith("ed") and len(after) > 4)


def _without_sizes(words: Sequence[str], spans: Sequence[tuple[int, int]]) -> list[str]:
    sized = {index for start, end in spans for index in range(start, end)}
    for start, _ in spans:
        before = start - 1
        while before > 0 and words[before] in _SIZED and before not in sized:
            sized.add(before)
            before -= 1
    return [word for index, word in enumerate(words) if index not in sized]


def _determiner(words: Sequence[str]) -> tuple[int, int, str]:
    """Count, index of the first word after the determiner, and the determiner."""
    start, determiner = 0, ""
    while start < len(words) and words[start] in LEXICON.determiners:
        number = read_number(words, start)
        if number is not None:
            break
        start, determiner = start + 1, words[start]
    number = read_number(words, start)
    if number is None:
        return 1, start, determiner
    value, end = number
    following = words[end] if end < len(words) else ""
    counts_part = singular(following) in LEXICON.parts and end + 1 < len(words)
    counts_part = counts_part and (value > 1 or bool(determiner) or following in LEXICON.families)
    if value == 1 and not determiner and following in LEXICON.families:
        counts_part = False  # "one shelf, three tiers"
    # "a three seat sofa" is one.
    adjective = determiner in ("a", "an") and value > 1
    adjective = adjective or _has_so_many(following) or following in ("seater", "person", "story")
    if counts_part or adjective or end >= len(words) or words[end] in LEXICON.enders:
        return (
            1,
            start,
            determiner or "a",
        )  # "a three tier shelf", "a three legged stool", "a seven"
    return max(1, int(value)), end, determiner or "one"


def _has_so_many(word: str) -> bool:
    """Whether a number before it counts parts: ``three legged``; two painted stools are two."""
    stems = {word[:-2], word[:-1], word[:-3]} if word.endswith("ed") else set()
    return bool(stems & (LEXICON.parts.keys() | _HAD_IN_NUMBERS))


def _numeral(words: Sequence[str], end: int) -> list[str]:
    """The words of the number that ends before ``end``, without an article."""
    start = next(i for i in range(end) if (read_number(words, i) or (0, 0))[1] == end)
    return list(words[start + (words[start] in ("a", "an", "the")) : end])


def _head(core: list[str], rest: Sequence[str]) -> tuple[str, list[str]]:
    """The head noun, and the words after the core that belong to the phrase."""
    nouns = [word for word in core if not (len(word) == 1 and word.isalnum())]
    glyph = next((i for i, word in enumerate(core[:-1]) if word in _GLYPHS), None)
    if glyph is not None and (len(core[-1]) == 1 or read_number(core, len(core) - 1) is not None):
        nouns = ["letter" if core[glyph] in {"letter", *_CASES} else "number"]
        if core[glyph] in _CASES:
            core[glyph : glyph + 1 + (core[glyph + 1] == "letter")] = ["letter"]
    if core[0] == "word" and len(core) > 1:
        return "word", _with(rest)
    head = singular(nouns[-1] if nouns else core[-1])
    if rest[:1] == ["of"]:
        after = list(rest[1:])
        stops = LEXICON.enders | LEXICON.finite
        stop = next(
            (i for i, word in enumerate(after) if word in stops or (i and is_participle(after, i))),
            len(after),
        )
        if after[:1] == ["the"] and after[stop : stop + 1] == ["of"] and len(after) > stop + 1:
            stop += 2  # "a replica of the tower of pisa"
        inner = after[: acts_at(after[:stop]) or stop]
        if inner:
            noun = singular(inner[-1])
            # "a model of a lighthouse" is about the lighthouse; "a bust of beethoven" is a bust.
            named = noun if head in LEXICON.of_nouns and judge(inner, noun).physical else head
            return named, ["of", *inner, *_with(after[stop:])]
    return head, _with(rest)


def _with(rest: Sequence[str]) -> list[str]:
    """What follows the core: features ("with ...") stay, uses ("for ...", "to ...") go."""
    if rest[:1] not in (["with"], ["without"], ["and"], ["plus"], ["having"]):
        return []
    if rest[1:2] and rest[1] in _COMPANY:
        return []  # "a fort with me"
    stops = (LEXICON.enders | LEXICON.finite | {"make"}) - {"with", "without", "and", "no", "plus"}
    end = next((i for i, word in enumerate(rest) if i and word in stops), len(rest))
    kept = list(rest[:end])
    if rest[end : end + 1] and rest[end] in ("it", "them") and _verb(kept[-1]):
        kept.pop()  # "and paint it green"
    while kept and kept[-1] in ("and", "plus", "with", "having"):
        kept.pop()
    return kept


def _verb(word: str) -> bool:
    entry = look_up(word)
    return entry is not None and "v" in entry.parts


def _others(tail: list[str], rest: Sequence[str]) -> tuple[tuple[str, ...], int, list[str], bool]:
    """Further objects of "a shelf and a stool", and how many; whether one of them is wanted."""
    if rest[:1] == ("or",):
        after = [word for word in rest[1:] if word not in LEXICON.fillers]
        if after[:1] and after[0] in LEXICON.determiners and len(after) > 1:
            noun = singular(after[-1])
            if LEXICON.is_physical(noun):
                return (noun,), 0, [], True
        return (), 0, tail, False
    if tail[:1] not in (["and"], ["plus"]) or len(tail) < 2:
        return (), 0, tail, False
    noun = singular(tail[-1])
    number = read_number(tail, 1)
    counted = tail[1] in LEXICON.determiners or number is not None
    if counted and judge(tail[2:], noun).physical:
        return (noun,), int(number[0]) if number else 1, tail, False
    return (), 0, [], False
