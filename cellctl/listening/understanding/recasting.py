"""Sentences that put a wish in another order, put into the order in which wishes are read.

The order tells who wants what, not the words: ``with two drawers, a desk`` has its features in
front, ``a bench would fit nicely`` has the thing for its subject, ``i take a stool`` and ``i search
a shelf`` have a verb of choosing or seeking where English has "want".
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from cellctl.listening.frames import MAKES
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.understanding.judging import judge
from cellctl.listening.understanding.mentioned import speaks_against
from cellctl.listening.understanding.talk import FURNISHING
from cellctl.listening.understanding.words import look_up

_ARTICLES = frozenset({"a", "an", "one", "some", "two", "three", "four"})
_FRONTED = frozenset({"with", "without", "in", "for", "about", "having"})
_PRONOUNS = frozenset({"i", "we", "you", "he", "she", "they", "it", "there", "this", "that"})
_MOST_IN_FRONT = 8
_AS_SUBJECT = re.compile(
    r"(?P<wish>(?:an?|some|two|three|four) (?:[\w']+ ){1,5}?)(?:"
    r"(?:would|could|might|'d|should) (?:(?:really|just|also|probably|certainly|surely|perhaps) )*"
    r"(?:be (?!an?\b|in\b|at\b)|fit|look|go\b|work|match|brighten|complete|finish|please|solve|"
    r"save|"
    r"cheer|serve|help|do\b|make (?:me|us|him|her|them|my|our|the|a (?:nice|good|great|lovely))|"
    r"come in|suit)"
    r"|(?:is|are) (?:what (?:i|we|he|she|they|my \w+)|(?:needed|wanted|required|missing|desired)|"
    r"my (?:choice|wish|pick)|all (?:i|we))).*"
)
_NEEDED = re.compile(
    r"(?:(?:it|there|here|what)(?:'s| is| would be)?|is)(?: \w+)? (?:needed|wanted|required|"
    r"missing|needs|wants|lacks|lacking)(?: (?:here|now|is))? (?P<wish>(?:an?|some|two|three) .+)"
)
_BECOMES = re.compile(
    r"(?:it|that|this|he|she|they)(?:'ll| will| should| must| has to| needs to| ought to| shall|"
    r" is to| is going to| could)?(?: \w+){0,6}? (?:be|become|being) (?P<wish>(?:an?|the "
    r"(?:letter|number)) .+)"
)
_CHOOSES = re.compile(
    r"(?:i|we|me|my \w+|for me|(?:the|this|my|our) \w+ \w+)(?: (?:will|would|'d|'ll|do|gladly|"
    r"now|also|please|then|just|really|keeps?|is|am|are|'m))*"
    r" (?P<verb>\w+)(?: (?:on|for|of|to|gladly|please|now|me|us|out|that it is|myself))* "
    r"(?P<wish>(?:an?|one|two|three) .+)"
)
_CHOOSING = frozenset(
    {"take", "choose", "pick", "select", "order", "seek", "search", "request", "vote", "opt",
     "become", "get", "go", "wish", "ask", "asking", "beg", "begging", "long", "dream",
     "imagine", "require", "demand", "command", "desire", "hope", "need", "want", "prefer",
     "says", "say", "suggest", "propose", "settle", "plump", "await", "expect", "crave", "call",
     "insists", "insist", "asks", "wants", "needs", "takes", "chooses", "wishes", "picks",
     "votes", "shouts", "shouting", "calling", "crying", "suggests", "demands", "begs"}
)  # fmt: skip
"""What a speaker does to a thing that is to be; in the past it was."""
_WEAK = frozenset({"take", "get", "call", "becomes", "become", "go", "say",
                   "says", "see", "search", "order", "takes"})  # fmt: skip
"""Of these, what is also said of things that are there: only furniture is meant to be built."""
_JOY = re.compile(
    r"(?:i|we|he|she|they|my \w+)(?: would|'d|'ll| will) (?:be|make do|do|go) "
    r"(?:[\w']+ ){0,4}?with (?P<wish>an? .+)"
)
_ONE = re.compile(
    r"(?P<before>.+?) (?P<ask>(?:(?:can|could|would|will) you |please |so |then )*"
    rf"(?:{MAKES}|(?:i|we) (?:want|need|would like|'d like)|(?:can|could|may) (?:i|we) (?:have|"
    rf"get)))"
    r"(?: me| us)? (?:a |an |another )?(?P<new>(?:\w+ )?)(?:one|some|it|that)(?: for .+| please)?"
)
_DECIDED = re.compile(
    r".*\b(?:(?:settled|decided|agreed|voted|opted|settling|deciding|voting|set|fixed|hooked|"
    r"dead set|keen|asking|asked|begging|pining|longing|crying|heart|mind|sights)(?: myself|"
    r" ourselves)? (?:on|for|upon)|(?:lines|thinking|dreaming|fond|fans?) of) (?P<wish>an? .+)"
)
_SUGGESTED = re.compile(
    r"(?:wouldn't|won't|would|isn't|shouldn't|might|could|couldn't) (?P<wish>an? (?:\w+ ){1,4}?)"
    r"(?:be|look|fit|help|work|do|suit|go|make)\b.*|(?:is|would|are) (?P<asked>an? (?:\w+ ){1,4}?)"
    r"(?:be )?(?:okay|ok|alright|all right|fine|allowed|doable|possible|feasible|"
    r"available|an option|on the menu|too (?:hard|difficult|"
    r"much))(?: .*)?"
)
_CLEFT = re.compile(
    r"(?:what|the (?:\w+ )?thing)(?: that)? (?:i|we|he|she|they|(?:my|our|the) \w+)(?!.*\b(?:saw|"
    r"bought|had|broke|found|lost|sold|got|ate|"
    r"heard|hate|own|have|made|built|see)\b) .+? (?:is|was|would be) (?P<wish>an? .+)"
)
_IF_YOU = re.compile(
    r"(?:it'd|it would|i'd|i would|we'd|we would|how|what|would) .*\bif you (?:could |would |"
    r"please )*"
    rf"(?:built|made|created|designed|assembled|{MAKES})(?: me| us)? (?P<wish>an? .+)"
)
_SUCH_AS = re.compile(
    r"(?:something|anything)(?: \w+){1,6} (?:like|such as|for example|say) (?P<wish>an? .+)"
)
_REPORTED = re.compile(
    r".*\b(?:says?|said|thinks?|thought|told (?:me|us)|suggests?|suggested|meant)(?: that)? "
    r"(?:i|we|you|it|he|she) (?:should|must|could|can|might|ought to|have to|has to|shall) "
    rf"(?:please )?(?:{MAKES}|do|have|try|get|ask for|go for|order) (?P<wish>an? .+)"
)
_VOTE = re.compile(
    r"(?:my|our|his|her) (?:\w+ )?(?:vote|choice|pick|wish|favou?rite|idea|suggestion|guess|order)"
    r"(?:'s| is| goes| would be| was)(?: (?:for|to|on))? (?:the|an?) (?P<wish>.+)"
)
_NOT_THIS = re.compile(
    r"(?:no )*(?:not|i don't want|i didn't (?:want|say|mean)) (?:the|an?|that) \w+ "
    r"(?:(?:but|rather|instead|i (?:said|meant|wanted|want)) )*(?P<wish>an? .+)"
)
_MADE_ONE = re.compile(rf"{MAKES}$")
_VAGUE = re.compile(
    rf"(?:(?:.* )?(?:{MAKES}|want|need|like|love|give me|think of|try) )?(?:something|anything|"
    r"(?:any|some)(?= \w+s ))(?: (?:.* )?(?P<last>\w+))? (?P<wish>an? (?:\w+ ){0,3}?\w+)"
    r"(?: maybe| perhaps)?(?: or (?:something|anything|so))?"
)
_IF_FIRST = re.compile(
    rf"if you (?:can|could|would|will|were to|are able to|manage) (?:to )?(?:{MAKES}|do) "
    r"(?P<wish>an? .+?) (?:then )?(?:i|we|it|that|he|she|they|my \w+|our \w+|everyone|everybody)"
    r"(?:'d|'ll| would| will| might)(?: .*)?"
)
_LACKS = re.compile(
    r"\b(?:no|not|don't|doesn't|haven't|without|lack|lost|broke|broken|need|needs|want|wants|like|"
    r"likes|love|loves|never|dream|thing as|called|heard of)\b"
)


def recast(text: str) -> Iterator[str]:
    """The wish that a sentence comes to, as "i want ..."; none where it wishes for nothing.

    Args:
        text: lower-case words, without what is said around a wish.
    """
    if (one := _named_earlier(text)) is not None:
        yield f"make {one}"
    yield from _wished(text, (_VOTE, _NOT_THIS, _NEEDED, _CLEFT, _IF_YOU, _IF_FIRST, _REPORTED))
    if speaks_against(text):
        return
    yield from (f"i want {wish}" for wish in _fronted(text.split()))
    yield from _wished(text, (_AS_SUBJECT, _SUGGESTED, _BECOMES, _JOY, _DECIDED, _SUCH_AS))
    match = _VAGUE.fullmatch(text)
    if match is not None and _may_end(match["last"] or "") and _is_thing(match["wish"]):
        yield f"i want {match['wish']}"
    match = _CHOOSES.fullmatch(text)
    if match is not None and match["verb"] in _CHOOSING:
        head = _head_of(match["wish"])
        if match["verb"] not in _WEAK or head in LEXICON.families | FURNISHING:
            yield f"i want {match['wish']}"


def _may_end(word: str) -> bool:
    """Whether a phrase may end in a word: no preposition and no verb governs what follows it."""
    entry = look_up(word)
    return word not in LEXICON.enders | LEXICON.finite and not (entry and entry.parts[:1] == "v")


def _wished(text: str, patterns: Sequence[re.Pattern[str]]) -> Iterator[str]:
    """What stands in the patterns' groups, where that is a thing."""
    for pattern in patterns:
        match = pattern.fullmatch(text)
        wish = next((group for group in match.groups() if group), "").strip() if match else ""
        if wish and _is_thing(wish):
            yield f"i want {wish}" if wish.split()[0] in _ARTICLES else f"i want a {wish}"


def _fronted(words: Sequence[str]) -> Iterator[str]:
    """``with two drawers a desk`` is a desk with two drawers."""
    if not words or words[0] not in _FRONTED:
        return
    for index in range(2, min(len(words) - 1, _MOST_IN_FRONT)):
        front, wish = words[:index], words[index:]
        if wish[0] not in ("a", "an") or _tells(front) or _tells(wish[:2]):
            continue
        if _is_thing(" ".join(wish)):
            yield " ".join([*wish, *front])


def _tells(words: Sequence[str]) -> bool:
    return bool(set(words) & (_PRONOUNS | LEXICON.finite))


def _head_of(wish: str) -> str:
    words = wish.split()
    stops = LEXICON.enders | LEXICON.finite
    end = next((i for i, word in enumerate(words) if i and word in stops), len(words))
    while end > 2 and words[end - 1] in LEXICON.comparatives:
        end -= 1  # "a table small"
    return singular(words[end - 1])


def _is_thing(wish: str) -> bool:
    """Whether its first noun phrase names a thing."""
    words = [word for word in wish.split() if word not in _ARTICLES]
    head = _head_of(wish)
    core = words[: words.index(head) + 1] if head in words else [head]
    return bool(words) and judge(core, head).physical is True


def _named_earlier(text: str) -> str | None:
    """``i don't have a desk so please make one``: a desk; ``my stool broke, build a new one``."""
    match = _ONE.fullmatch(text)
    if match is None:
        return None
    made = _MADE_ONE.search(match["ask"]) and text.rsplit(maxsplit=1)[-1] == "one"
    if not made and not _LACKS.search(match["before"]):
        return None
    words = match["before"].split()
    for index in reversed(range(len(words))):
        noun = singular(words[index])
        entry = look_up(noun)
        if words[index] in LEXICON.enders or not judge((noun,), noun).physical:
            continue
        if LEXICON.is_physical(noun) is not True and (entry is None or entry.parts[:1] != "n"):
            continue
        before = words[index - 1] if index else ""
        kind = look_up(before)
        named = f"{before} {noun}" if kind and kind.parts[:1] == "n" and before not in (
            *LEXICON.determiners, *LEXICON.enders, "no", "any") else noun  # fmt: skip
        return f"a {match['new']}{named}"
    return None
