"""Put recogniser slips right by sound: ``two tears`` -> ``two tiers``, ``stole`` -> ``stool``.

Only where the sentence's build says what kind of word must stand there, and only when the word that
stands there makes no sense in that place. Every correction is kept, so that it can be shown.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from difflib import SequenceMatcher

from cellctl.assembly import Correction
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import read_number
from cellctl.listening.understanding.words import look_up

_NUMBER_SOUNDS = {
    "to": "two", "too": "two", "for": "four", "fore": "four", "won": "one", "sticks": "six",
    "sex": "six", "ate": "eight", "tree": "three", "free": "three", "fife": "five", "know": "no",
}  # fmt: skip
_OWNERS = {
    "steps": ("ladder", "staircase", "stairs"),
    "tiers": ("shelf", "bookshelf", "bookcase"),
    "legs": ("stool", "table", "chair", "bench"),
    "back": ("chair", "bench", "sofa"),
    "arms": ("chair", "sofa"),
    "drawers": ("desk", "table", "cabinet"),
}
"""What has such parts: "a letter with five steps" was a ladder, a "self with two tiers" a shelf."""
_CONFUSED = {
    "school": "stool", "tool": "stool", "stole": "stool", "still": "stool", "steel": "stool",
}  # fmt: skip
"""What recognisers write for a family's noun, where they do; each word is one of its own."""
_RARER = {
    "char": "chair", "chare": "chair", "cheer": "chair", "tabled": "table",
    "tabel": "table", "binch": "bench", "shelve": "shelf", "stoll": "stool",
}  # fmt: skip
"""Words that hardly anybody says, and what was meant."""
_IF_MADE = {"share": "chair", "batch": "bench", "pinch": "bench", "self": "shelf"}
"""What nobody has made."""
_PLAIN = frozenset({"simple", "small", "little", "tall", "short"})
_OPENERS = {"kneed": "need", "knead": "need", "bild": "build", "billed": "build"}
_BUILD_SOUNDS = frozenset({"bill", "built", "bell", "bold", "billed"})
_SPLIT_WORDS = {
    ("back", "rest"): "backrest",
    ("back", "wrist"): "backrest",
    ("bag", "rest"): "backrest",
    ("steps", "tool"): "step stool",
    ("step", "tool"): "step stool",
    ("foot", "still"): "footstool",
    ("bag", "rests"): "backrests",
    ("arm", "rest"): "armrest",
    ("arm", "rests"): "armrests",
    ("book", "case"): "bookcase",
    ("book", "shelf"): "bookshelf",
    ("stair", "case"): "staircase",
    ("dog", "house"): "doghouse",
}
_SILENT_STARTS = (("kn", "n"), ("wr", "r"), ("gn", "n"), ("ps", "s"), ("wh", "w"))
_SOUNDS = (
    *(("tch", "C"), ("ch", "C"), ("sh", "X"), ("ph", "f"), ("th", "0"), ("ck", "k"), ("dg", "j")),
    *(("qu", "kw"), ("x", "ks"), ("ce", "se"), ("ci", "si"), ("cy", "sy"), ("c", "k"), ("z", "s")),
    *(("gh", ""), ("v", "f"), ("mb", "m")),
)
_ALIKE = 0.8
_VOWELS = "aeiouyhw"


@dataclass
class Snapped:
    """Words after correction, and what was changed."""

    words: list[str]
    changes: list[Correction] = field(default_factory=list)

    def replace(self, start: int, end: int, *new: str) -> None:
        """Put ``new`` in the place of ``words[start:end]`` and record it."""
        old = " ".join(self.words[start:end])
        self.words[start:end] = new
        self.changes.append(Correction(heard=old, taken=" ".join(new)))


def sound_of(word: str) -> str:
    """A key that words of similar sound share: consonant sounds in order, without vowels."""
    text = word
    for spelled, sound in _SILENT_STARTS:
        if text.startswith(spelled):
            text = sound + text[len(spelled) :]
    for spelled, sound in _SOUNDS:
        text = text.replace(spelled, sound)
    key = "".join(c for i, c in enumerate(text) if c not in _VOWELS or (i == 0 and c in "hwy"))
    squeezed = "".join(c for i, c in enumerate(key) if i == 0 or c != key[i - 1])
    return squeezed if word[:1] not in "aeiou" else f"a{squeezed}"


_FAMILY_SOUNDS = {sound_of(noun): noun for noun in sorted(LEXICON.families) if len(noun) > 3}
_VOICED = str.maketrans("dgbXjC", "tkpsss")


def unvoiced_sound_of(word: str) -> str:
    """A coarser key: ``legs`` and ``lakes``, ``ladder`` and ``letter`` share theirs."""
    return sound_of(word).translate(_VOICED)


_SHORT_SOUNDS = {
    unvoiced_sound_of(noun): noun for noun in sorted(LEXICON.families) if len(noun) <= 4
}
_OWN = (["my"], ["the"], ["our"], ["a"])
_NEVER_SNAPPED = LEXICON.enders | LEXICON.fillers | LEXICON.of_nouns
_COUNTED_PARTS = ("leg", "tier", "step", "drawer")
_PART_PLURALS = tuple(f"{part}s" for part in _COUNTED_PARTS)


def snap(words: list[str]) -> Snapped:
    """Correct the words of one sentence; the list given is left as it is."""
    snapped = Snapped(list(words))
    _join_split_words(snapped)
    _correct_openers(snapped)
    _correct_articles(snapped)
    _correct_parts(snapped)
    _correct_heads(snapped)
    _correct_letter(snapped)
    return snapped


def _join_split_words(snapped: Snapped) -> None:
    for index in range(len(snapped.words) - 1):
        pair = tuple(snapped.words[index : index + 2])
        if len(pair) == 2 and pair in _SPLIT_WORDS:
            snapped.words[index : index + 2] = _SPLIT_WORDS[pair].split()


def _correct_openers(snapped: Snapped) -> None:
    words = snapped.words
    if words[:3] == ["a", "sample", "me"]:
        snapped.replace(0, 2, "assemble")
    elif words[:2] == ["take", "me"] and words[2:3] in (["a"], ["an"]):
        snapped.replace(0, 1, "make")
    elif len(words) > 2 and words[0] == "and" and words[1:3] == ["you", "make"]:
        snapped.replace(0, 1, "can")
    elif words[:1] == ["i"] and words[2:3] == ["for"] and words[3:4] in _OWN:
        # "I bet for my dog" was "a bed for my dog".
        key = unvoiced_sound_of(words[1])
        if (noun := _SHORT_SOUNDS.get(key)) is not None:
            snapped.replace(0, 2, "a", noun)
    for index, word in enumerate(words[:4]):
        if word in _BUILD_SOUNDS and _is_asked(words, index):
            snapped.replace(index, index + 1, "build")
        if word in _OPENERS:
            snapped.replace(index, index + 1, _OPENERS[word])


def _correct_articles(snapped: Snapped) -> None:
    """``I want to chair``, ``I want it throne``: an article was misheard."""
    words = snapped.words
    for index in range(len(words) - 1):
        opener = words[index] in ("want", "need", "make", "build", "like")
        wrong = words[index + 1] in ("to", "it", "too")
        if not (opener and wrong and index + 2 < len(words)):
            continue
        noun = words[index + 2]
        last = index + 3 == len(words)
        meant = _FAMILY_SOUNDS.get(sound_of(noun)) if last and wrong else None
        quality = (
            words[index] in ("make", "want") and words[index + 1] == "it" and _may_describe(noun)
        )
        several = last and singular(noun) != noun and singular(noun) in LEXICON.families
        if several:
            snapped.replace(index + 1, index + 2, "two")
        elif noun in LEXICON.families or (last and noun in LEXICON.physical and not quality):
            snapped.replace(index + 1, index + 2, "a")
        elif meant is not None and (entry := look_up(noun)) is not None and "p" in entry.parts:
            snapped.replace(index + 1, index + 3, "a", meant)


def _may_describe(word: str) -> bool:
    """Whether "make it stable" may change a thing rather than ask for a stable."""
    entry = look_up(word)
    return entry is not None and "a" in entry.parts


def _is_asked(words: list[str], index: int) -> bool:
    """Whether a verb must stand there: ``bill me a table``, ``could you bill the house``."""
    for_somebody = words[index + 1 : index + 2] in (["me"], ["us"])
    article = words[index + 1 + for_somebody : index + 2 + for_somebody]
    asked = words[max(0, index - 1) : index] in (["you"], ["please"], ["to"])
    return bool(set(article) & {"a", "an", "the"}) and (for_somebody or asked)


def _correct_parts(snapped: Snapped) -> None:
    """After "with" and a number stands a part that can be counted."""
    words = snapped.words
    for index, word in enumerate(words):
        if word not in ("with", "having", "and") or index + 2 >= len(words):
            continue
        if words[index + 1] in _NUMBER_SOUNDS and _part(words[index + 2], plural=True):
            snapped.replace(index + 1, index + 2, _NUMBER_SOUNDS[words[index + 1]])
        number = read_number(words, index + 1)
        if number is None or number[1] >= len(words):
            continue
        noun = words[number[1]]
        part = _part(noun, plural=number[0] != 1.0)
        if part is not None and part != noun and not LEXICON.is_physical(singular(noun)):
            snapped.replace(number[1], number[1] + 1, part)


def _part(word: str, *, plural: bool) -> str | None:
    """The part that a word is or sounds like; None for neither."""
    if singular(word) in LEXICON.parts:
        return word
    parts = _PART_PLURALS if plural else _COUNTED_PARTS
    # "tears" is nearer to tiers than to drawers, so the finer key is tried first.
    for key in (sound_of, unvoiced_sound_of):
        if matches := [part for part in parts if key(part) == key(word)]:
            return matches[0]
    return None


def _correct_heads(snapped: Snapped) -> None:
    """A word between an article and the phrase's end is the object's noun."""
    words = snapped.words
    for index, word in enumerate(words):
        ends = index + 1 == len(words) or words[index + 1] in LEXICON.enders | LEXICON.fillers
        if ends and index and (noun := _of_compound(words[index - 1], word)) is not None:
            snapped.replace(index, index + 1, noun)
            continue
        begins = index > 0 and words[index - 1] in (
            LEXICON.determiners | {"me", "simple", "small", "big", "tall"}
        )
        if not (ends and begins):
            continue
        rest = words[index + 1 :]
        better = _owner(rest, word) or _RARER.get(word) or _confused(rest, words[index - 1], word)
        if better is None and LEXICON.verbs & set(words[:index]):
            better = _IF_MADE.get(word)
        noun = singular(word)
        known = LEXICON.is_physical(noun) is not None or noun in LEXICON.parts
        if better is None and not known and word not in _NEVER_SNAPPED and not _is_noun(word):
            better = _FAMILY_SOUNDS.get(sound_of(word))
        if better is not None and better != word:
            snapped.replace(index, index + 1, better)


def _of_compound(before: str, word: str) -> str | None:
    """What sounds alike and makes a compound of two words: a "bunk bet" is a bunk bed."""
    if look_up(f"{before} {word}") is not None or LEXICON.is_physical(singular(word)):
        return None
    noun = _SHORT_SOUNDS.get(unvoiced_sound_of(word)) or _FAMILY_SOUNDS.get(sound_of(word))
    return noun if noun and look_up(f"{before} {noun}") is not None else None


def _is_noun(word: str) -> bool:
    """Whether a word is a noun in its own right: "a cab" is not meant to be a cube.

    The past of a verb is none after an article: "a stole" is meant to be a stool.
    """
    entry = look_up(singular(word))
    return entry is not None and "n" in entry.parts and "p" not in entry.parts


def _confused(rest: list[str], before: str, word: str) -> str | None:
    """A ``simple school`` and a ``tool with three legs`` are stools; a school alone is one."""
    noun = _CONFUSED.get(word)
    if noun is None:
        return None
    legs = rest[:1] == ["with"] and "legs" in {LEXICON.parts.get(singular(w)) for w in rest[1:4]}
    return noun if legs or (before in _PLAIN and not rest) else None


def _owner(rest: list[str], word: str) -> str | None:
    """What sounds like ``word`` and has the parts that ``rest`` gives it."""
    if rest[:1] not in (["with"], ["without"], ["and"], ["having"]):
        return None
    for noun in rest[1:4]:
        owners = _OWNERS.get(LEXICON.parts.get(singular(noun), ""), ())
        if owners and (word not in LEXICON.families or word == "letter"):
            sound = unvoiced_sound_of(word)
            heard = next((o for o in owners if unvoiced_sound_of(o) == sound), None)
            return heard or next((o for o in owners if _spelled_like(o, word)), None)
    return None


def _spelled_like(noun: str, word: str) -> bool:
    """``shell`` and ``shelf``: one letter apart."""
    return len(noun) > 3 and SequenceMatcher(None, noun, word).ratio() >= _ALIKE


def _correct_letter(snapped: Snapped) -> None:
    words = snapped.words
    for index in range(len(words) - 1):
        name = words[index + 1]
        last = index + 2 == len(words) or words[index + 2] in LEXICON.enders | LEXICON.fillers
        if (
            words[index] in ("latter", "later", "lettuce", "ladder", "litter", "leather")
            and len(name) == 1
            and last
        ):
            snapped.replace(index, index + 1, "letter")
        if words[index] in ("letter", "capital") and name in LEXICON.spelled and last:
            snapped.replace(index + 1, index + 2, LEXICON.spelled[name].lower())
