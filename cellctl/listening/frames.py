"""The ways people ask: which part of a sentence is the wish, and whether it is one at all."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from cellctl.listening.lexicon import LEXICON

_UP = (
    "put together|come up with|put up|(?:whip|knock|rustle) up|throw together|"
    "(?:try your hand|have a go) at"
)
_MAKE = f"(?:{'|'.join(sorted(LEXICON.verbs))}|{_UP}|three d print|3 d print)"
_MAKING = f"(?:{'|'.join(sorted(LEXICON.gerunds))}|putting together|starting|beginning)"
_FOR_ME = (
    r"(?: for (?:me|us|him|her|them|my \w+|our \w+))?(?: please)?"
    r"(?: (?:me|us|him|her|them|yourself|up))?"
)
_MAKES = rf"{_MAKE}(?: (?:and|or) {_MAKE})*{_FOR_ME}"
_WHO = (
    r"(?:i|we|you|they|he|she|(?:my|our|the|this|his|her) (?:\w+ )?\w+|everyone|everybody|people|"
    r"mommy|daddy|mum|mom|dad|grandma|grandpa|granny|somebody|someone)"
)
_WANT = (
    r"(?:would (?:really |just )?(?:like|love|prefer|want|enjoy)|"
    r"'d (?:really )?(?:like|love|prefer|enjoy)|"
    r"want|wants|wanted|need|needs|needed|wish for|"
    r"could (?:really )?(?:use|do with)|demand|demands|"
    r"request|requests|require|requires|desire|fancy|prefer|am after|am looking for)"
)
_GET = r"(?:get|give|bring|fetch|hand|lend|show|grant)"
_POLITE = (
    r"(?:can|could|would|will|won't|can't|couldn't) (?:you|the robot(?: arm)?)(?: please)?"
    r"(?: just| maybe| possibly)?"
)
_NICE = "(?:great|nice|lovely|good|cool|awesome|perfect|handy|useful|fun|better|amazing)"
_LEADS = re.compile(
    rf"(?:(?:you know what (?:would|could) be (?:really |so )?{_NICE}|let me think|not sure|"
    r"right(?= (?:an?|the|so|let|i|we|can|could)\b)|"
    r"i think|i guess|i suppose|i reckon|i mean|you know what|you know|guess what|"
    r"nothing (?:fancy|special)|do (?:me|us) a favou?r and|"
    r"how (?:hard|difficult) (?:would it be|is it)(?= to\b)|"
    r"now|then|and|so|but|next|first|also|today|"
    r"this time|for now|alright|all right|yeah|yes|great|cool|listen|look|"
    r"attention|dear \w+|no(?= (?:an?|the|i|make|build|give)\b)|"
    r"if you (?:can|could|would|don't mind)(?: please)?|if possible|if it's possible|"
    r"i (?:was|am|'m) (?:hoping(?! for\b)|wondering|thinking)(?: of| about| if| whether| that)?|"
    r"i'm (?:hoping(?! for\b)|wondering|thinking)(?: of| about| if| whether| that)?|"
    r"i wonder (?:if|whether)|i hope|"
    r"i (?:would|'d) (?:be happy|be glad|appreciate it|love it) if|i'd (?:be happy|be glad|"
    r"appreciate it|love it) if|it would be (?:great|nice|lovely|good|cool|awesome) if"
    r"(?= i\b| we\b)|"
    r"do you think|(?:would|is) it (?:be )?possible(?: for you)?(?= to\b)|"
    r"is there (?:any|a) way(?: you could|"
    r"(?= to\b))|are you able(?= to\b)|do you mind|go ahead and|try (?:to|and)|start by|"
    r"i (?:want|need|would like|'d like) you to (?:try to|please|go ahead and)(?= )|just|"
    r"to) )+"
)
Kind = Literal["making", "having", "bare"]


def _frames(*rows: tuple[Kind, str]) -> tuple[tuple[Kind, re.Pattern[str]], ...]:
    return tuple((kind, re.compile(rf"{pattern}(?= |$)")) for kind, pattern in rows)


_FRAMES = _frames(
    # "I want you to build", "my daughter wants", "we would like to have".
    (
        "making",
        rf"{_WHO} ?{_WANT}(?: you| the robot| the machine)?(?: please)? to (?:please |just )?"
        rf"{_MAKES}",
    ),
    ("having", rf"{_WHO} ?{_WANT} to (?:have|order|get|own)"),
    ("having", rf"{_WHO} ?(?:would like|would love|'d like|'d love|wants?) to see(?= an? )"),
    ("having", rf"{_WHO} ?(?:asks|asked|(?:was|were) (?:asking|hoping|longing)) for(?= an? )"),
    ("having", rf"{_WHO} ?(?:would|'d) be (?:happy|glad|pleased|delighted) with"),
    ("having", r"surprise (?:me|us|my \w+|our \w+|them) with"),
    ("having", r"(?:it's |it is )?(?:high )?time for(?= an? )"),
    ("having", rf"{_WHO} ?{_WANT}(?! to\b| you\b| it\b| that\b| this\b)"),
    ("having", r"i feel like(?: having)?"),
    ("having", rf"{_WHO} ?{_WANT} to (?:place|make) an order for"),
    ("having", r"(?:can|could|may|might) (?:i|we) (?:trouble|bother) you for"),
    ("having", r"(?:i am|i'm|we are|we're) in (?:\w+ )?need of"),
    ("having", r"(?:i|we) wish (?:i|we) had"),
    ("making", rf"would you be (?:so )?(?:kind|good|nice)(?: enough)?(?: as)? to {_MAKES}"),
    ("having", r"(?:all|what) (?:i|we)(?: really)?(?: want| need| would like|'d like) is"),
    ("having", r"what (?:i'm|i am|we're|we are)(?: really)? (?:after|looking for) is"),
    ("having", r"(?:gimme|show (?:me|us) what you can do with)"),
    ("having", r"(?:(?:can|could) you|you (?:can|could)) manage(?= an? )"),
    (
        "making",
        rf"{_WHO} (?:am|are|is|was|were) (?:asking|wondering) (?:if|whether) you"
        rf"(?:'d| would| could| can) {_MAKES}",
    ),
    ("making", rf"{_POLITE} {_MAKES}"),
    ("making", rf"(?:you (?:could|can|should|must|may)|(?:could|can) we) {_MAKES}"),
    ("having", rf"{_POLITE} {_GET}(?: me| us)?"),
    ("having", r"(?:would|is) it (?:be )?possible(?: for (?:me|us))? to (?:have|get)"),
    ("making", rf"{_POLITE} do(?= an? | the (?:letter|number))"),
    ("making", rf"(?:can|could|may|might) (?:i|we) (?:have|get|ask) you to {_MAKES}"),
    ("having", r"(?:can|could|may|might) (?:i|we) (?:please )?(?:have|get|request|order|ask for)"),
    ("making", rf"(?:would|do) you mind {_MAKING}{_FOR_ME}"),
    ("making", rf"(?:start|begin|try|consider) {_MAKING}{_FOR_ME}"),
    ("making", rf"{_MAKING}{_FOR_ME}"),
    (
        "having",
        r"(?:let me|let us|let's) (?:have(?: a go at)?|get|see|try|do|go (?:with|for))"
        r"(?= an? | the (?:letter|number))",
    ),
    ("making", rf"(?:let me|let us|let's) (?:try to )?{_MAKES}"),
    ("making", rf"(?:let me|let us|let's) (?:have|get) you to {_MAKES}"),
    ("having", r"(?:i am|i'm|we are|we're|we|i) (?:looking for|after)"),
    (
        "having",
        r"(?:is there )?any (?:chance|way) (?:of|to get|for|i could get|i can get)"
        r"(?: getting| having)?",
    ),
    ("having", r"(?:it would|it'd) be (?:great|nice|lovely|good|cool|awesome) to (?:have|get|see)"),
    ("making", rf"(?:how|what) about {_MAKING}{_FOR_ME}"),
    ("having", r"(?:how|what) about"),
    (
        "making",
        rf"(?:it would|it'd) be {_NICE} if you (?:could |would )?(?:made|built|created|{_MAKE})"
        rf"{_FOR_ME}",
    ),
    ("having", rf"{_WHO} (?:have|has|'ve) (?:always |been )?(?:wanted|wanting|needing)"),
    ("having", r"(?:i've|we've) (?:always |been )?(?:wanted|wanting|needing|dreaming of)"),
    ("having", rf"{_WHO} (?:am|are|is) (?:begging|asking|longing|hoping|wishing|missing)(?: for)?"),
    ("having", r"(?:we're|i'm) (?:begging for|asking for|longing for|missing)"),
    ("having", r"(?:let's |let us )?(?:start|begin) with(?= an? | the )"),
    ("having", r"(?:i am|i'm) (?:in need of|in the mood for|craving|dying for)"),
    ("having", r"(?:i|we) ?(?:will|'ll|would|'d) (?:have|take|go (?:with|for))(?= an? )"),
    ("having", r"show (?:me|us)(?= an? )"),
    ("having", r"(?:get|give|bring|fetch|make it|grant) (?:me|us|my \w+)(?: please)?"),
    ("having", r"(?:give|bring)(?= an? | two| three| four| some )"),
    ("making", rf"{_MAKES}"),
)  # fmt: skip
_QUESTION_FRAMES = re.compile(
    r"(?:is|are|am|do|does|did|was|were|have|has|had|should|shall|isn't|aren't|don't|doesn't|didn't|"
    r"can|could|may|will|would|won't|might) "
    r"(?:you|it|there|this|that|these|those|i|we|he|she|they|the|a|an|my|your|his|her|our|kids|"
    r"anyone|anybody|somebody|someone)\b"
)
_RETELLS = re.compile(
    r"(?:i|we|you|he|she|they|it|nobody|everybody|somebody|there)"
    r"(?:'m|'re|'s|'ve|'d|'ll)? (?!want|need|like|love|would|'d|could|wish|demand|prefer|fancy|"
    r"feel)\w+"
)
_NICE_TO_HAVE = re.compile(
    rf"(?P<wish>(?:an?|some|two|three) .+) would (?:be|look) (?:so |really |very )?{_NICE}(?: .+)?"
)
_ONE_OF = re.compile(r"^(?:like an? |one of (?:those|these|the|your) )")
_AS_CAN_BE = re.compile(
    r"as (?P<size>\w+) (?P<thing>an? .+?) as (?:possible|can be|it gets|(?:you|we|it) .+)"
)
_ASIDE = re.compile(
    r" (?:don't you think|right|for fun|mate|buddy|pal|dude|bro|"
    r"if (?:you can(?: manage)?|you like|possible|(?:that's|that is|it's) "
    r"(?:ok|okay|alright|all right|possible|not too much)))$"
)
"""What is said after a wish, and is no part of it."""
_ONCE_MORE = re.compile(r"(?P<wish>(?:.+ )?(?:an?|two|three) .+?) an? (?:\w+ ){1,3}one")
"""``a whale, a really huge one``."""
_PICTURE = re.compile(
    r"(?:an?|the) (?:\w+ ){0,4}(?:photo|photograph|picture|image|render|rendering|drawing|sketch|"
    r"painting) of(?= )"
)
"""Who knows generators of pictures asks for "a photo of a red chair"; the chair is wanted."""
_LIKENESS = re.compile(
    r"(?:something(?: to(?: \w+){1,4}?| \w+)?|whatever|anything|"
    r"an? (?:\w+ )?(?:thing|object|shape|structure|model|one)) "
    r"(?:that |which )?(?:is |looks? |shaped |kind of |a bit |just )*(?:like|similar to|"
    r"resembling|in the (?:shape|form) of)(?= (?:an?|the|my|some) )"
)


_POSSIBLE = re.compile(r"(?:would|is) it (?:be )?possible(?: for (?:me|us))? to (?:have|get) ")
_LATER = re.compile(
    r"\b(?:(?:can|could|would|will) you (?:please )?(?:make|build|create|design|assemble) |"
    r"(?:i|we)(?: really)?(?: want| need|'d like| would like| could (?:really )?(?:use|do with)) "
    r"(?=(?:an?|some|two|three|another) )|"
    r"(?:so |then |and |please )?(?:make|build|create|assemble) (?:me |us )?(?=(?:an?|two|three) ))"
)
_GOVERNS = frozenset(
    {"to", "how", "if", "that", "when", "where", "what", "why", "who", "said", "says", "not", "no",
     "don't", "didn't", "can't", "won't", "never", "you", "i", "we", "they", "he", "she", "it",
     "do", "does", "did", "can", "could", "would", "should", "will", "think", "know", "whether",
     "because", "helped", "watched", "saw", "let", "robots", "people", "a", "an", "the", "or",
     "until", "before", "after", "while", "unless", "things", "thing"}
)  # fmt: skip
"""After these a clause tells or depends, and asks for nothing."""


@dataclass(frozen=True)
class Frame:
    """A sentence split into how it asks and what for."""

    kind: Kind
    """How it asks: to make something, to have it, or not at all, standing alone as a phrase."""
    rest: tuple[str, ...]
    """The wish."""
    of_speaker: bool = False
    """Whether it says "make me a ...", which is also said of what one wants to become."""

    @property
    def asks(self) -> bool:
        """Whether the sentence says that something is wanted."""
        return self.kind != "bare"


def find_frame(words: tuple[str, ...]) -> Frame:
    """Split off greetings, fillers, politeness and the words that ask."""
    text = " ".join(plain_words(words))
    while (match := _LEADS.match(text)) and not _POSSIBLE.match(text):
        text = text[match.end() :]
    while match := _ASIDE.search(text):
        text = text[: match.start()]
    if match := _ONCE_MORE.fullmatch(text):
        text = match["wish"]
    kind: Kind = "bare"
    of_speaker = False
    for name, pattern in _FRAMES:
        if match := pattern.match(text):
            kind, text = name, text[match.end() :].strip()
            of_speaker = match[0].endswith("make me")
            break
    if kind == "bare" and (match := _NICE_TO_HAVE.fullmatch(text)):
        kind, text = "having", match["wish"]
    text = _ONE_OF.sub("a ", text)
    if match := _AS_CAN_BE.fullmatch(text):
        article, _, thing = match["thing"].partition(" ")
        text = f"{article} {match['size']} {thing}"
    for inner in (_PICTURE, _LIKENESS) if kind != "having" else (_LIKENESS,):
        if match := inner.match(text):
            text = text[match.end() :].strip()
    return Frame(kind, tuple(text.split()), of_speaker)


def later_wish(words: tuple[str, ...]) -> tuple[str, ...] | None:
    """The clause that asks, of a sentence that says something else first.

    ``my books are all over the floor i need a shelf``, ``scrap that make a bench``.
    """
    text = " ".join(plain_words(words))
    for match in _LATER.finditer(text):
        before = text[: match.start()].split()
        if len(before) > 1 and before[-1] not in _GOVERNS:
            return tuple(text[match.start() :].split())
    return None


def is_question(words: tuple[str, ...]) -> bool:
    """Whether a sentence asks for an answer."""
    text = " ".join(words)
    return words[:1] != () and (
        words[0] in LEXICON.questions or _QUESTION_FRAMES.match(text) is not None
    )


def is_told(words: tuple[str, ...]) -> bool:
    """Whether a sentence tells what somebody does or did: ``i broke the vase``."""
    text = " ".join(words)
    # "I think he broke it" tells; "I think a duck" does not.
    while match := _LEADS.match(text):
        text = text[match.end() :]
    return _RETELLS.match(text) is not None


def plain_words(words: tuple[str, ...]) -> list[str]:
    """The words without greetings in front and without fillers."""
    kept = list(words)
    while kept and kept[0] in LEXICON.greetings:
        kept = kept[1:]
    # A "wishing well" is none of the fillers.
    kept = [
        word
        for index, word in enumerate(kept)
        if word not in LEXICON.fillers or (word == "well" and index > 0)
    ]
    while kept and kept[0] in LEXICON.greetings:
        kept = kept[1:]
    return kept
