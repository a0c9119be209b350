"""Control words: matched as whole sentences, letter by letter, before any model or rule.

Stop and pause must work when everything else is confused, so nothing here guesses.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from cellctl.listening.command_phrasing import phrased_command
from cellctl.listening.contractions import run_together

_SENTENCES: dict[str, tuple[str, ...]] = {
    "stop": (
        *("stop", "stop it", "stop that", "stop this", "stop everything", "stop moving"),
        *("stop building", "stop working", "stop the robot", "stop the arm", "stop the machine"),
        *("stop right there", "stop what you're doing", "emergency stop", "halt", "freeze"),
        *("don't move", "do not move", "no stop", "whoa stop", "that's enough stop"),
    ),
    "pause": (
        *("pause", "pause it", "pause that", "pause the robot", "pause the build", "wait"),
        *("wait for me", "wait there", "no wait", "hold on", "hold it", "hang on", "one moment"),
        *("one second", "just a moment", "just a second", "just a minute"),
    ),
    "resume": (
        *("resume", "resume building", "continue", "continue building", "go on", "carry on"),
        *("keep going", "keep building", "proceed", "unpause", "you can continue", "you can go on"),
    ),
    "cancel": (
        *("cancel", "cancel it", "cancel that", "cancel this", "cancel everything", "abort"),
        *("cancel the build", "cancel the job", "cancel my request", "cancel my order", "abort it"),
        *("no cancel", "no cancel that", "no cancel it", "abort that", "abort mission"),
        *("abort the build", "abort the job", "forget it", "forget that", "forget about it"),
        *("forget about that", "no forget it", "scrap it", "scrap that", "never mind"),
        *("nevermind", "start over", "start again", "start from scratch", "i changed my mind"),
        *("start again from scratch", "start all over again", "start from the beginning"),
    ),
    "yes": (
        *("yes", "yeah", "yep", "yup", "sure", "okay", "ok", "of course", "correct", "do it"),
        *("go ahead", "go for it", "that's right", "looks good", "sounds good", "build it"),
        *("that's fine", "that's good", "that's perfect", "that's the one", "perfect"),
        *("sounds great", "looks great", "looks perfect", "looks fine", "sounds perfect"),
        *("it looks good", "it looks great", "please do", "sure thing", "confirm", "confirmed"),
        *("affirmative", "let's do it", "make it so", "start building", "build that"),
        *(
            "do that",
            "okay go",
            "yes go",
            "i'm sure",
            "that'll do",
            "that will do",
            "that'll do nicely",
        ),
        *("that'll be fine", "that will be fine", "i like it", "i like that", "that works"),
        *("that's exactly what i wanted", "that's what i wanted", "exactly", "exactly like that"),
        *(
            "let's do that one",
            "let's take that one",
            "i'll take it",
            "we'll take it",
            "go on then",
        ),
        *(
            "sounds lovely",
            "looks lovely",
            "lovely",
            "brilliant",
            "that's lovely",
            "that one please",
            "you can start",
            "you can begin",
            "you may start",
        ),
    ),
    "no": (
        *("no", "nope", "nah", "no thanks", "no thank you", "don't", "do not", "don't do it"),
        *("don't build it", "don't do that", "no don't", "no don't do it", "no don't build it"),
        *("absolutely not", "definitely not", "of course not", "no way", "i'd rather not"),
        *(
            "i don't think so",
            "rather not",
            "let's not",
            "not that",
            "no not that",
            "not that one",
            "that's wrong",
        ),
        *("no that's wrong", "that's not right", "no that's not right", "that's not it"),
        *("that's not what i said", "that's not what i want", "that's not what i meant"),
        *("i don't want that", "negative", "leave it", "no leave it", "nah leave it", "skip it"),
    ),
    "take_apart": (
        *("take it apart", "take it apart again", "take that apart", "take it down"),
        *("take it to pieces", "tear it down", "clear it away", "disassemble it"),
        *("disassemble that", "dismantle it", "dismantle that"),
    ),
    "repeat": (
        *("say that again", "say it again", "repeat", "repeat that", "what did you say", "pardon"),
        *(
            "what was that",
            "what was that again",
            "come again",
            "i didn't hear you",
            "i didn't hear that",
        ),
        *("i didn't catch that", "i didn't understand that"),
    ),
    "again": (
        *("do it again", "do that again", "build it again", "make it again", "build another one"),
        *("make another one", "another one", "one more", "the same again", "once more", "again"),
    ),
    "another": (
        *("show me another", "show me another one", "show another", "show me a different one"),
        *("give me another", "give me another one", "try another", "try another one", "try again"),
        *("try a different one", "try a different design", "give me a different one"),
        *("something different", "something else", "show me something else", "a different one"),
        *("show me something different", "try something else", "try something different"),
        *("not like that", "not like this", "no not like that", "no something else"),
        *("another design", "a different design", "another version", "no another one"),
        *("no something different", "no show me another", "no show me another one"),
        *("show me another design", "show me a different design", "show me another version"),
        *("do you have another one", "do you have another", "have you got another one"),
        *("do you have something else", "do you have anything else", "have you got anything else"),
        *("anything else", "what else do you have", "what else have you got", "next", "next one"),
        *("the next one", "show me the next one", "can i see another", "can i see another one"),
        *("i don't like it", "i don't like that", "i don't like that one", "i don't like this one"),
        *("no i don't like it", "no i don't like that", "i'd prefer another one"),
    ),
    "help": ("help", "help me"),
}
_BY_SENTENCE = {sentence: name for name, group in _SENTENCES.items() for sentence in group}
_NO_STOP = re.compile(r"\b(?:don't|not|never) (?:stop|halt|freeze|pause|wait)\b")
_AGREES = re.compile(
    r"\b(?:yes|yeah|yep|yup|ok|okay|sure|of course|correct|confirm(?:ed)?|affirmative|go|do it|"
    r"do that|please do|build|start|begin|make it so|take it|"
    r"good|great|perfect|fine|right|the one)\b"
)
_POLITE = frozenset(
    {"please", "now", "right", "robot", "hey", "um", "uh", "immediately", "ok", "okay", "oh",
     "just", "well", "then", "yes", "yeah", "yep", "sure", "alright", "actually", "so", "sorry",
     "hmm", "hm", "er", "erm", "mm", "ah", "cool", "great", "nice", "dear",
     "love", "mate", "buddy", "sir", "madam", "dude"}
)  # fmt: skip
"""Words that change nothing when they stand before or after a control word."""
_AGREEING = frozenset({"yes", "yeah", "yep", "sure", "ok", "okay", "alright"})
_REFUSING = frozenset({"no", "nope", "nah"})
_YES = frozenset({"yes", "yeah", "yep", "yup"})
_GO = frozenset(
    {
        "go ahead",
        "go on",
        "go on then",
        "do it please",
        "do it",
        "build it",
        "start building",
        "please do",
    }
)
_WARNING = frozenset({"no", "oh", "hey", "wait", "whoa", "ah"})
_ASKED = re.compile(
    r"^(?:(?:can|could|would|will) you(?: please)?|i said|i want you to|let's|all right|"
    r"you (?:can|should|must|have to|need to))(?= )"
)
_MOST_WORDS_IN_PIECES = 12
_THANKS = frozenset({"thanks", "thank you", "cheers", "thank you very much", "thanks a lot"})
_GOING_ON = frozenset(
    {"please", "it's", "that's", "you're", "there's", "he's", "she's", "they're", "something",
     "somebody", "someone", "watch"}
)  # fmt: skip
"""After a command to halt these tell why."""
_GOING_ON_AFTER_STOP = frozenset({"i", "i'm", "we", "you", "my", "no", "now", "robot", "hey"})
"""After "wait" these may begin a wish."""
_TOGETHER = {
    frozenset({"yes", "resume"}): "yes",
    frozenset({"no", "cancel"}): "cancel",
    frozenset({"no", "another"}): "another",
    frozenset({"cancel", "another"}): "another",
}
"""What commands mean that are said in one breath; others contradict each other."""
_TO_US = re.compile(r"\b(show|give|help) us ")
_BRIEFLY = re.compile(r" for (?:a|one) (?:moment|second|minute|bit|while)$| a (?:moment|second|"
                      r"minute|bit)$")  # fmt: skip


@dataclass(frozen=True)
class Sayings:
    """Control words of one more language, or of one's own; the English ones count always."""

    sentences: Mapping[str, str] = field(default_factory=dict)
    """Command by sentence, as ``plain`` makes it."""
    polite: frozenset[str] = frozenset()
    """Words that change nothing when they stand before or after a control word."""

    @classmethod
    def of(cls, listed: Mapping[str, object]) -> Sayings:
        """From lists of sentences by command; the list ``polite`` holds polite words."""
        lists = {name: group for name, group in listed.items() if isinstance(group, list)}
        polite = frozenset(plain(str(word)) for word in lists.pop("polite", []))
        return cls(
            {plain(str(one)): name for name, group in lists.items() for one in group}, polite
        )


_ENGLISH_ONLY = Sayings()


def plain(text: str) -> str:
    """Lower-case words and nothing else, one space between them."""
    letters = re.sub(r"[^\w' ]|[\d_]", " ", text.lower().replace("’", "'"))  # noqa: RUF001
    return " ".join(letters.split())


def spoken_command(text: str, own: Sayings = _ENGLISH_ONLY) -> str | None:
    """The command that a sentence is, or None.

    Args:
        text: as heard or typed.
        own: sentences that count besides the English ones.

    Returns:
        One of ``stop``, ``pause``, ``resume``, ``cancel``, ``yes``, ``no``, ``take_apart``,
        ``repeat``, ``again``, ``another`` and ``help``, or what else ``own`` knows.
    """
    said, polite = _TO_US.sub(r"\1 me ", plain(text)), _POLITE | own.polite
    return _command(said, own, polite) or _command(run_together(said), own, polite)


def _command(said: str, own: Sayings, polite: frozenset[str]) -> str | None:
    leading = " ".join(itertools.dropwhile(polite.__contains__, said.split()))
    for sentence in (said, _unasked(said), _unasked(leading)):
        words = sentence.split()
        while words and words[0] in polite:
            words = words[1:]
        while words and words[-1] in polite:
            words = words[:-1]
        if len(set(words)) == 1:
            words = words[:1]  # "stop stop stop"
        for one in (sentence, " ".join(words)):
            if (name := own.sentences.get(one) or _english(one)) is not None:
                return name
    return (
        _with_reason(leading.split())
        or _with_more(said.split())
        or _with_more(leading.split())
        or _in_pieces(said.split(), own.sentences, polite)
    )


def is_praise(text: str) -> bool:
    """Whether an English yes only says that something pleases, which people say to each other as
    well: "lovely", "exactly"."""
    return spoken_command(text) == "yes" and _AGREES.search(plain(text)) is None


def _english(sentence: str) -> str | None:
    return _BY_SENTENCE.get(sentence) or phrased_command(sentence)


def _in_pieces(words: list[str], own: Mapping[str, str], polite: frozenset[str]) -> str | None:
    """The command of which a sentence says several ways: "cancel please i changed my mind"."""
    if len(words) > _MOST_WORDS_IN_PIECES or _NO_STOP.search(" ".join(words)):
        return None
    # What the first so many words are; None where they are not all commands and polite words.
    found: list[frozenset[str] | None] = [frozenset()]
    for end in range(1, len(words) + 1):
        found.append(None)
        for start in range(end):
            before, piece = found[start], " ".join(words[start:end])
            name = own.get(piece) or _english(piece)
            if before is not None and (name or piece in polite | _THANKS):
                found[end] = before | ({name} if name else frozenset())
                break
    names = found[-1] or frozenset()
    if waits := names & {"stop", "pause"}:
        return "stop" if "stop" in waits else "pause"  # whatever else was said
    if len(names) > 1:
        return next((meant for group, meant in _TOGETHER.items() if names <= group), None)
    return next(iter(names), None)


def _with_reason(words: list[str]) -> str | None:
    """``stop please it's going to fall``; "wait and see" and "stop laughing" are no commands."""
    if words[:1] == ["wait"]:
        return "pause" if _GOING_ON & set(words[1:2]) else None
    halts = words[:1] in (["stop"], ["halt"])
    return "stop" if halts and (_GOING_ON | _GOING_ON_AFTER_STOP) & set(words[1:2]) else None


def _with_more(words: list[str]) -> str | None:
    """A command with a word before it that only adds to it: "no no stop it", "yes ... go ahead"."""
    if not words:
        return None
    first = words[0]
    if first in _WARNING:
        rest = " ".join(itertools.dropwhile(_WARNING.__contains__, words))
        name = _english(rest)
        if name in ("stop", "pause"):
            return name
    if first in _REFUSING and _english(" ".join(words[1:])) == "no":
        return "no"
    if _BY_SENTENCE.get(" ".join(words[:2])) == "yes" and " ".join(words[2:]) in _GO:
        return "yes"
    if first not in _AGREEING:
        return None
    # "yes please", "sure okay": polite words alone, of which the first agrees.
    agrees = set(words) <= _POLITE or (first in _YES and " ".join(words[-2:]) in _GO)
    return "yes" if agrees else None


def _unasked(sentence: str) -> str:
    """Without what makes a command a question, and "for a moment"."""
    bare = " ".join(word for word in sentence.split() if word not in ("please", "just"))
    bare = _ASKED.sub("", bare).strip()
    return _BRIEFLY.sub("", bare)
