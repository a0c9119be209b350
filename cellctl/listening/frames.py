"""The ways people ask: which part of a sentence is the wish, and whether it is one at all."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import read_number

_UP = (
    "put together|come up with|put up|(?:whip|knock|rustle) up|(?:throw|knock|bang) together|"
    "(?:put|throw|knock|bang|whip|rustle) (?:me|us|him|her|them) (?:together|up)|"
    "(?:try your hand|have a go) at"
)
_MAKE = f"(?:{'|'.join(sorted(LEXICON.verbs))}|{_UP}|three d print|3 d print)"
_MAKING = f"(?:{'|'.join(sorted(LEXICON.gerunds))}|putting together|starting|beginning)"
_FOR_ME = (
    r"(?: for (?:me|us|him|her|them|my \w+|our \w+))?(?: please)?"
    r"(?: (?:me|us|him|her|them|yourself|up))?"
)
MAKES = rf"{_MAKE}(?: (?:and|or) {_MAKE})*{_FOR_ME}"
_NOUN = r"(?!(?:i|we|you|he|she|they)\b)\w+"
WHO = (
    r"(?:i|we|you(?! ?(?:'d|would|need|want|might)\b)|they|he|she|me(?= wants?\b)|"
    rf"one(?= (?:needs|wants)\b)|(?:my|our|the|this|his|her) (?:{_NOUN} )?{_NOUN}|"
    r"(?:everyone|everybody)(?: here| else)?|people|"
    r"mommy|daddy|mum|mom|dad|grandma|grandpa|granddad|granny|somebody|someone)"
)
_MUCH = (
    r"(?:(?:really|just|quite|rather|so|very|much|ever|still|also|actually|certainly|only|most|"
    r"always|simply|\w+ly) )*"
)
WANT = (
    rf"(?:(?:would|should) {_MUCH}(?:like|love|prefer|enjoy)|would {_MUCH}(?:want|need)|"
    rf"would(?= to (?:have|get|order) )|'d {_MUCH}(?:like|love|prefer|enjoy|want|need|better "
    rf"(?:have|get))|"
    rf"(?:am|are|is|'m|'re|'s) {_MUCH}(?:needing|wanting|wishing(?: for)?|requiring)|"
    rf"like(?= to (?:have|get|order|own) )|{_MUCH}(?:want|wants|wanted|need|needs|needed)|"
    rf"wish for|"
    r"could (?:really )?(?:use|do with)|demand|demands|"
    r"request|requests|require|requires|desire|fancy|prefer|am after|am looking for)"
)
_CRAFTS = (
    "(?:carve|forge|weld|prototype|engineer|materiali[sz]e|conjure(?: up)?|3d print|mould|mold)"
)
"""Verbs of making that are rarer, and told from others by "a" after them."""
_FAMILY = "|".join(sorted(LEXICON.families))
_GET = r"(?:get|give to|give|bring|fetch|hand|lend|show|grant)"
POLITE = (
    r"(?:can|could|would|will|won't|can't|couldn't) (?:you|(?:the|your|this|that) (?:robot|"
    r"machine|thing)(?: arm)?)(?: please)?(?: just| maybe| possibly)?"
)
_NICE = (
    "(?:great|nice|lovely|good|cool|awesome|perfect|handy|useful|fun|better|amazing|welcome|ideal|"
    "fine|brilliant|fantastic|wonderful|super|helpful|appreciated)"
)
WOULD_DO = (
    rf"(?:would|will|might) (?:(?:be|look|make)(?: \w+)?? {_NICE}|do|help|suffice|suit|come in|"
    r"go down|hit the spot)|it (?:is|shall be|will be)|it'll be"
)
_STOCKED = (
    r"(?= an? (?:\w+ ){0,3}?(?:stool|chair|armchair|bench|sofa|desk|shelf|bookshelf|bookcase|"
    r"cabinet|"
    r"cupboard|rack|dresser|wardrobe|throne|nightstand|(?:\w+ )(?:table|stand|bed)|footstool)\b|"
    r" (?<!sell )(?:any )?(?:stools|chairs|armchairs|benches|sofas|desks|tables|beds|shelves|"
    r"bookcases|cupboards|ladders|boxes)\b(?: please)?$)"
)
"""What a shop may be asked whether it has; a dog or a minute is not meant to be built."""
_LEADS = re.compile(
    rf"(?:(?:you know what (?:would|could) be (?:really |so )?{_NICE}|let me think|not sure|"
    r"right(?= (?:an?|the|so|let|i|we|can|could)\b)|"
    r"i think|i guess|i suppose|i reckon|i mean|you know what|you know|guess what|"
    r"nothing (?:fancy|special)|do (?:me|us) a favou?r and|"
    r"how (?:hard|difficult) (?:would it be|is it)(?= to\b)|"
    r"now|then|and|so|but|next|first|also|today|"
    r"this time|for now|alright|all right|yeah|yes|great|cool|listen|look|"
    r"attention|dear \w+|(?:number|option|choice) (?:one|two|three|four|five|six)(?= the \w)|"
    r"no(?= (?:an?|the|i|make|build|give)\b)|"
    r"if you (?:can|could|would|don't mind)(?: please)?|if possible|if it's possible|"
    r"i (?:was|am|'m) (?:hoping(?! for\b)|wondering|thinking)(?: of| about| if| whether| that)?|"
    r"i'm (?:hoping(?! for\b)|wondering|thinking)(?: of| about| if| whether| that)?|"
    r"i wonder (?:if|whether)|i hope|"
    r"i (?:would|'d) (?:be happy|be glad|appreciate it|love it) if|i'd (?:be happy|be glad|"
    r"appreciate it|love it) if|it would be (?:great|nice|lovely|good|cool|awesome) if"
    r"(?= i\b| we\b)|(?:\w+|(?:my|our|the|his|her) \w+) says (?=(?:he|she|they)\b)|"
    r"i bet (?:that )?you (?:can't|couldn't|cannot|could never)(?= )|do you know how to|"
    r"do you think|(?:(?:would|is) it|it is) (?:be )?possible(?: for you)?(?= to\b)|"
    r"is there (?:any|a) way(?:(?: that)? you (?:could|can)|"
    r"(?= to\b))|are you able(?= to\b)|do you mind|go ahead and|try (?:to|and)|start by|"
    r"i (?:want|need|would like|'d like) you to (?:try to|please|go ahead and)(?= )|just|to) )+"
)
Kind = Literal["making", "having", "bare"]


def _frames(*rows: tuple[Kind, str]) -> tuple[tuple[Kind, re.Pattern[str]], ...]:
    return tuple((kind, re.compile(rf"{pattern}(?= |$)")) for kind, pattern in rows)


_FRAMES = _frames(
    # "I want you to build", "my daughter wants", "we would like to have".
    (
        "making",
        rf"{WHO} ?{WANT}(?: you| the robot| the machine)?(?: please)? to (?:please |just )?{MAKES}",
    ),
    ("making", rf"{WHO} ?{WANT} that you {MAKES}"),
    ("having", rf"{WHO} ?{WANT}(?: to)? (?:have|order|get|own)"),
    ("having", rf"{WHO} ?{WANT} (?:it|that|this) to be(?= an? )"),
    ("having", rf"{WHO} ?{WANT} (?:us|me|you) to (?:ask for|have|get)(?= an? | the )"),
    (
        "making",
        rf"{WHO} ?{WANT} to see (?:(?:how|if) )?(?:it|you|him|he|(?:the|this) \w+)(?: can)? "
        rf"(?:{MAKES}|builds|makes|does|do|{_MAKING})",
    ),
    (
        "making",
        rf"(?:(?:can|could) (?:i|we)|let's|let us|let me) see (?:if|whether|how) "
        rf"(?:it|you|he|she|the \w+) (?:can |could )?(?:{MAKES}|builds|makes|does|do)",
    ),
    ("making", rf"(?:let|have) (?:it|him|the \w+) {MAKES}"),
    ("making", rf"you {MAKES}(?= (?:\w+ )?(?:{_FAMILY})\b)"),
    ("having", r"go for(?= an? )"),
    ("having", r"it (?:really )?(?:needs|could use|could do with)(?= an? )"),
    ("having", r"(?:i|we) ?(?:will|'ll|would|'d) go (?:for|with)(?= the )"),
    (
        "having",
        r"(?:i|we) ?(?:shall|will|'ll|would like to|'d like to|want to) (?:have|choose|pick)"
        r"(?= the )",
    ),
    (
        "having",
        r"(?:i|we) ?(?:shall|will|'ll|would|'d)? ?take"
        rf"(?= the (?!stairs)(?:\w+ )?(?:{_FAMILY})\b)",
    ),
    ("having", rf"{WHO} ?(?:would like|would love|'d like|'d love|wants?) to see(?= an? )"),
    ("having", rf"{WHO} ?(?:asks|asked|(?:was|were) (?:asking|hoping|longing)) for(?= an? )"),
    ("having", rf"{WHO} ?(?:would|'d) be (?:happy|glad|pleased|delighted) with"),
    ("having", r"surprise (?:me|us|my \w+|our \w+|them) with"),
    ("having", r"(?:it's |it is )?(?:high )?time for(?= an? )"),
    ("having", rf"{WHO} ?{WANT}(?! to\b| you\b| it\b| that\b| this\b)"),
    ("having", r"i feel like(?: having)?"),
    ("having", rf"{WHO} ?{WANT} to (?:place|make) an order for"),
    ("having", r"(?:can|could|may|might) (?:i|we) (?:trouble|bother) you for"),
    ("having", r"(?:i am|i'm|we are|we're) in (?:\w+ )?need of"),
    ("having", r"(?:i|we) wish (?:i|we) had"),
    ("making", rf"would you be (?:so )?(?:kind|good|nice)(?: enough)?(?: as)? to {MAKES}"),
    ("having", r"(?:all|what) (?:i|we)(?: really)?(?: want| need| would like|'d like) is"),
    ("having", r"what (?:i'm|i am|we're|we are)(?: really)? (?:after|looking for) is"),
    ("having", r"(?:gimme|show (?:me|us) what you can do with)"),
    ("having", r"(?:(?:can|could|might) you|you (?:can|could|might)) manage(?= an? )"),
    ("making", rf"(?:(?:is|would) it (?:be )?possible(?: that)? )you (?:could |can )?{MAKES}"),
    ("making", rf"(?:can|could|will|would) you to {MAKES}"),
    ("making", rf"(?:can|could|will|would) (?:it|this|that|this thing|he|she) (?:do|"
               rf"{MAKES})(?= an? )"),
    ("making", rf"you (?:please )?(?:{MAKES}|do (?:me|us))(?= (?:an?|one|the) )"),
    ("having", rf"(?:(?:do )?you (?:have|do|make|sell)|(?:have )?you(?: got)?|got)(?: any(?:thing "
               rf"like)?)?{_STOCKED}"),
    ("having", r"(?:can|could|may|might) (?:i|we) (?:please )?(?:see|try)(?= an? | the "
               r"(?:letter|number))"),
    ("having", r"(?:i|we|you) (?:could|can|might) (?:try|do)(?: like)?(?= an? )"),
    ("having", r"(?:what )?if (?:i|we) (?:asked|wanted|said)(?: you)?(?: for)?(?= an? )"),
    ("having", r"(?:i|we)(?:'ve| have)? came?(?: here)? (?:for|to (?:see|get))(?= an? )"),
    ("having", r"put (?:me|us|him|her) down for"),
    ("having", rf"i (?:said|meant|asked for)(?= an? | the letter | (?:{_FAMILY})$)"),
    ("having", r"(?:i'm|i am|we're|we are|let's|let us) (?:going|opting|settling) for(?= an? )"),
    (
        "having",
        rf"{WHO}(?: all)?(?: have|'ve| has)? (?:voted for|decided on|settled on|opted for|"
        rf"agreed on|"
        r"went for)(?= an? | the )",
    ),
    ("having", r"(?:let's |let us )?ask (?:(?:it|him|her|them|the \w+) )?for(?= an? | the "
               r"(?:letter|number))"),
    ("making", rf"(?:ask|tell|get) (?:it|him|her|the (?:robot|machine)) to {MAKES}"),
    ("having", r"show (?:me|us|them|him|her|(?:the|my|our) \w+) what(?= an? .+ looks? like$)"),
    ("making", r"do(?: (?:me|us))?(?= an? (?!favou?r))"),
    (
        "making",
        rf"{WHO} (?:am|are|is|was|were) (?:asking|wondering) (?:if|whether) you"
        rf"(?:'d| would| could| can) {MAKES}",
    ),
    ("making", rf"{POLITE} {MAKES}"),
    ("making", rf"(?:you (?:could|can|should|must|may)|(?:could|can) we) {MAKES}"),
    (
        "having",
        rf"{POLITE} show (?:me|us|them|him|her|(?:the|my|our) \w+) what(?= an? .+ looks? like$)",
    ),
    ("having", rf"{POLITE} {_GET}(?: me| us)?"),
    ("having", r"(?:would|is) it (?:be )?possible(?: for (?:me|us))? to (?:have|get)"),
    ("making", rf"{POLITE} do(?: (?:me|us|him|her))?(?= an? | the (?:letter|number))"),
    ("making", rf"(?:can|could|may|might) (?:i|we) (?:have|get|ask) you to {MAKES}"),
    ("having", r"(?:can|could|may|might) (?:i|we) (?:please )?(?:have|get|request|order|ask for)"),
    ("making", rf"(?:would|do) you mind {_MAKING}{_FOR_ME}"),
    ("making", rf"(?:start|begin|try|consider|get(?: on with)?) {_MAKING}{_FOR_ME}"),
    ("making", r"(?:get on|crack on|carry on|go ahead) with(?= an? )"),
    ("making", rf"{_MAKING}{_FOR_ME}"),
    (
        "having",
        r"(?:let me|let us|let's) (?:(?:have|take)(?: a (?:go|look|try) at)?|get|see|try|do|"
        r"go (?:with|for))"
        r"(?= an? | the (?:letter|number))",
    ),
    ("making", rf"(?:let me|let us|let's) (?:try to )?{MAKES}"),
    ("making", rf"(?:let me|let us|let's) (?:have|get) you to {MAKES}"),
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
    ("having", rf"{WHO} (?:have|has|'ve) (?:always |been )?(?:wanted|wanting|needing)"),
    ("having", r"(?:i've|we've) (?:always |been )?(?:wanted|wanting|needing|dreaming of)"),
    ("having", rf"{WHO} (?:am|are|is) (?:begging|asking|longing|hoping|wishing|missing)(?: for)?"),
    ("having", r"(?:we're|i'm) (?:begging for|asking for|longing for|missing)"),
    ("having", r"(?:let's |let us )?(?:start|begin) with(?= an? | the )"),
    ("having", r"(?:i am|i'm) (?:in need of|in the mood for|craving|dying for)"),
    ("having", r"(?:i|we) ?(?:will|'ll|would|'d) (?:have|take|go (?:with|for))(?= an? )"),
    ("having", r"show (?:me|us)(?= an? )"),
    ("having", r"(?:get|give to|give|bring|fetch|make it|grant) (?:me|us|him|her|them|my "
               r"\w+)(?: please)?"),
    ("having", r"(?:give|bring)(?= an? | two| three| four| some )"),
    ("making", r"(?:write|spell)(?: out)?(?= the (?:word|letters) \w+)"),
    ("making", r"(?:write|draw|show|display|form|spell)(?: (?:me|us))?"
               r"(?= (?:the|an?) (?:capital |big |small )?(?:letter|number|digit) \w+$)"),
    ("having", r"(?:show|give) (?:me|us) your (?:very )?(?=best|biggest|finest|nicest|greatest)"
               r"\w+"),
    ("making", rf"why (?:not|don't (?:you|we)|doesn't (?:it|he|she)) {MAKES}"),
    ("having", r"why (?:not|don't (?:we|i))(?: (?:have|get|try|go for))?(?= an? )"),
    ("having", r"(?:need|want|would like|would love|require|looking for|searching for)"
               r"(?! to\b| you\b| it\b| that\b| this\b| me\b)"),
    ("having", r"(?:draw|deliver|sell|offer|provide|supply|serve)(?: for)? (?:me|us)"
               r"(?: with)?(?= an? )"),
    ("making", rf"{_CRAFTS}(?: (?:me|us))?(?= an? )"),
    (
        "making",
        rf"(?:does|do|can|could|would|will|did) (?:it|he|she|you|they|the \w+)(?: even| also)? "
        rf"(?:know how to|manage to|be able to|(?:ever )?(?:try|learn) to) {MAKES}(?= an? )",
    ),
    ("making", rf"{MAKES}"),
)  # fmt: skip
_QUESTION_FRAMES = re.compile(
    r"(?:is|are|am|do|does|did|was|were|have|has|had|should|shall|isn't|aren't|don't|doesn't|"
    r"didn't|can|could|may|will|would|won't|might) "
    r"(?:you|it|there|this|that|these|those|i|we|he|she|they|the|a|an|my|your|his|her|our|kids|"
    r"anyone|anybody|somebody|someone)\b"
)
_RETELLS = re.compile(
    r"(?:i|we|you|he|she|they|it|nobody|everybody|somebody|there)"
    r"(?:'m|'re|'s|'ve|'d|'ll)? (?!want|need|like|love|would|'d|could|wish|demand|prefer|fancy|"
    r"feel)\w+"
)
_NICE_TO_HAVE = re.compile(
    rf"(?P<wish>(?:an?|some|two|three|any(?: old)?) .+?) (?:{WOULD_DO})(?: .+)?"
)
_KIND_OF = re.compile(r"^(?:some|an?|any) (?:kind|sort|type) of (?:an? )?(?!\w+ (?:thing|place)\b)")
_SORT_OF_THING = re.compile(
    r"^(?:some|an?) (?:kind|sort|type) of (?:an? )?(?P<noun>\w+) (?:thing|thingy|affair)$"
)
_IN_3D = re.compile(r"\b(?:3|three) d (?=model|figure|object|shape|version|copy)")
_OF_A_MENU = ("go for", "go with", "have", "choose", "pick", "take")
_FURTHER = re.compile(r"^(?:(?:one|an?) )?(?:more|additional|extra|further) (?=[\w ]+$)")
_OF_THOSE = re.compile(r"^(?P<number>\w+) of (?:those|these|the|your) (?=\w+s\b)")
_BUT_WITH = re.compile(
    r" (?:but|you know|i mean|say)(?: (?:like|you know|also))* (?=with(?:out)? )"
)
_AS_MANY = re.compile(r"^as many (?=.+s\b)")
_THE = re.compile(r"^the (?!letter|number)")
_LOOKS_LIKE = re.compile(r" looks? like$")
_ANY = re.compile(r"^any(?: old)? ")
_ONE_OF = re.compile(r"^(?:like an? |one of (?:those|these|the|your) )")
_AS_CAN_BE = re.compile(
    r"as (?P<size>\w+) (?P<thing>an? .+?) as (?:possible|can be|it gets|(?:you|we|it) .+)"
)
_ASIDE = re.compile(
    r" (?:(?:whichever|whatever|either)(?: of them)? (?:is|suits|works|you|one) .+|don't you think|"
    r"right|for fun|mate|buddy|pal|dude|bro|"
    r"if (?:you can(?: manage)?|you like|possible|(?:that's|that is|it's) "
    r"(?:ok|okay|alright|all right|possible|not too much)))$"
)
"""What is said after a wish, and is no part of it."""
_ONCE_MORE = re.compile(
    r"(?P<wish>(?:.+ )?(?:an?|two|three) .+?) (?:(?:yes|but|only|just|and) )*an? (?:\w+ ){1,3}one"
)
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


_SPELLED = re.compile(
    r"(?:(?:can|could|would|will) you (?:please )?|please |let's )?(?:spell(?: out)?(?: (?:me|us))?"
    r" (?P<spelled>[a-z]{2,8})|write(?: (?:me|us))? (?P<written>[a-z]{2,4}))(?: please| for me)*"
)
_NOT_SPELLED = LEXICON.enders | LEXICON.determiners | LEXICON.vague | {"code", "down", "out"}
_POSSIBLE = re.compile(r"(?:would|is) it (?:be )?possible(?: for (?:me|us))? to (?:have|get) ")


@dataclass(frozen=True)
class Frame:
    """A sentence split into how it asks and what for."""

    kind: Kind
    """How it asks: to make something, to have it, or not at all, standing alone as a phrase."""
    rest: tuple[str, ...]
    """The wish."""
    of_speaker: bool = False
    """Whether it says "make me a ...", which is also said of what one wants to become."""
    of_doing: bool = False
    """Whether it says "do a ...", which is also said of tricks."""

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
    if match := _SPELLED.fullmatch(text):
        word = match["spelled"] or match["written"]
        if word not in _NOT_SPELLED:
            return Frame("making", ("the", "word", word))
    kind: Kind = "bare"
    of_speaker = of_doing = False
    for name, pattern in _FRAMES:
        if match := pattern.match(text):
            kind, text = name, text[match.end() :].strip()
            if match[0].endswith(_OF_A_MENU):
                text = _THE.sub("a ", text)  # of what is on offer
            of_speaker = match[0].endswith("make me")
            of_doing = match[0].split()[-1] == "do"
            break
    if kind == "bare" and (match := _NICE_TO_HAVE.fullmatch(text)):
        kind, text = "having", _ANY.sub("a ", match["wish"])
    text = _plainly(text)
    for inner in (_PICTURE, _LIKENESS) if kind != "having" else (_LIKENESS,):
        if match := inner.match(text):
            text = text[match.end() :].strip()
    return Frame(kind, tuple(text.split()), of_speaker, of_doing)


def _plainly(text: str) -> str:
    """A wish without what is said of how many more, of which kind and how exactly."""
    text = _BUT_WITH.sub(" ", _FURTHER.sub("a ", _IN_3D.sub("", text)))
    if (match := _OF_THOSE.match(text)) and read_number([match["number"]], 0):
        text = f"{match['number']} {text[match.end() :]}"
    if match := _ONE_OF.match(text):
        *before, last = text[match.end() :].split() or [""]
        text = " ".join(["a", *before, singular(last) if "with" not in before else last])
    text = _AS_MANY.sub("some ", text)
    if match := _AS_CAN_BE.fullmatch(text):
        article, _, thing = match["thing"].partition(" ")
        text = f"{article} {match['size']} {thing}"
    vague = _SORT_OF_THING.match(text)
    if vague and LEXICON.is_physical(vague["noun"]):
        text = f"a {vague['noun']}"
    return _KIND_OF.sub("a ", _LOOKS_LIKE.sub("", text))


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
    # A "wishing well" is none of the fillers, nor is the "so" of "so a stool" later on.
    kept = [
        word
        for index, word in enumerate(kept)
        if word not in LEXICON.fillers or (word in ("well", "so") and index > 0)
    ]
    while kept and kept[0] in LEXICON.greetings:
        kept = kept[1:]
    return kept
