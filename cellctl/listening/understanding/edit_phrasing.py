"""The many ways to ask for a change, put into the few that ``edits`` reads."""

from __future__ import annotations

import re

from cellctl.listening.lexicon import LEXICON
from cellctl.listening.understanding.edit_words import BASES

_QUALITY = "|".join(sorted(BASES.keys() - {"height", "width", "depth", "length", "size", "little"}))
_ADDED_PARTS = (
    r"(?:back|backrest|lid|arm|armrest|drawer|leg|step|tier|chimney|roof|door|handle|cushion|"
    r"railing)"
)
_IT = r"(?P<it>it|that|this|them|the \w+(?: \w+)?)"
_BETTER = r"(?:better|nicer|nice|great|good|cool|best)"
_WOULD_BE = r"(?:it (?:would|might|could) be|it'd be)"
_WANT = r"(?:i want|i need|i'd like|i'd prefer|i would like|i would prefer)"
_COLOURS = "|".join(sorted(LEXICON.colours))
_NUMBER = r"(?:one|two|three|four|five|six|seven|eight|nine|ten|\d+)"
_HAVING = (
    r"(?:(?:please )?(?:(?:can|could|may|should) (?:it|we|i|you|they) (?:please )?(?:have|get|"
    r"make it|give it)|"
    r"it (?:should|could|must) have|give it|make it|make that|with|only|just|have|i said|i meant|"
    r"(?:i|we)(?: want| wanted|'d like| would like|'d prefer| would prefer|'d rather have)(?: "
    r"it to have)?) )?"
)
_ENOUGH = (
    r"(?:would|will|might|'ll) (?:be (?:better|nicer|nice|enough|fine|great|good|plenty)|do|"
    r"suffice)|(?:is|are) (?:enough|better|plenty|fine)"
)
_UNITS = (
    r"(?:blocks?|voxels?|cubes?|bricks?|cm|mm|m|(?:centi|milli)?met(?:re|er)s?|"
    r"inch(?:es)?|levels?|layers?)"
)
_MORE_THAN_ASKED = r"(?:wanted|want|need|needed|asked(?: for)?|said|thought|meant|expected)"
_DONE_WITH = (
    r"(?:leave|take|drop|skip|lose|get rid of|remove) (?:them|it|those|that)(?: off| out| away)?"
)
_MAKE = rf"(?:make|try|do|build|have|design|{_WANT})"
_REWRITES = tuple(
    (re.compile(pattern), plain)
    for pattern, plain in (
        (
            rf"{_HAVING}(?:only |just )?(?P<rest>{_NUMBER} \w+) (?:instead of|rather than|"
            rf"(?:and |but )?not) {_NUMBER}(?: \w+)?",
            "with {rest}",
        ),
        (rf"(?P<rest>{_NUMBER} \w+) (?:{_ENOUGH})(?: instead| please)?", "with {rest}"),
        (
            rf"(?P<rest>(?:half|twice|double|\w+ times) .+|(?:a (?:bit|little) )?\w+er) "
            rf"(?:{_ENOUGH})",
            "{rest}",
        ),
        (
            rf"(?:make it |at )?(?P<times>half|twice|double|{_NUMBER} times) (?:that|its|this|"
            rf"of that) (?P<rest>\w+)",
            "make it {times} the {rest}",
        ),
        (
            rf"(?:that's|it's|this is|that is|it is) twice as (?P<rest>\w+) as (?:i|we) "
            rf"{_MORE_THAN_ASKED}",
            "make it half as {rest}",
        ),
        (
            rf"(?:that's|it's|this is|that is|it is) half as (?P<rest>\w+) as (?:i|we) "
            rf"{_MORE_THAN_ASKED}",
            "make it twice as {rest}",
        ),
        (
            r"(?:i|we) (?:don't|do not) (?:really )?(?:like|want|need) (?:the|its|those|these|any) "
            rf"(?P<rest>\w+)(?: {_DONE_WITH})?",
            "remove {rest}",
        ),
        (r"(?:i|we) (?:could|can) do without the (?P<rest>\w+)", "remove {rest}"),
        (
            r"(?:let's|let us|can (?:we|i)|could (?:we|i)|i'll|we'll|i'd|may i|i) (?:have|like|"
            r"want|see|prefer) "
            rf"{_IT} (?P<rest>.+)",
            "make {it} {rest}",
        ),
        (
            r"(?:no )?(?:(?:i (?:meant|want|wanted|need|said)|i'd (?:like|prefer|rather(?: have)?)|"
            r"(?:can|could|may) (?:i|we) have|(?:do|would) you have|give (?:me|us)|show (?:me|us)|"
            r"make(?: me| us)?|try|how about|what about|i was thinking of) )?"
            r"(?:an?|something|one that's|one that is) (?P<rest>(?:much |slightly |little |bit "
            r"|a bit |a little )?\w+er)(?: (?:one|version|model|design))?",
            "make it {rest}",
        ),
        (
            r"(?:keep|leave|i like) (?:it|that|this)(?: (?:as it is|like that|like this|the "
            r"same|that way))?(?: but| only| just| and) (?P<rest>.+)",
            "{rest}",
        ),
        (
            r"(?:cut|trim|scale|tone) (?P<it>it|that|this) (?:down|back)(?P<rest>.*)",
            "shrink {it}{rest}",
        ),
        (
            rf"(?:shave|take|knock|cut|chop|trim|lop) (?P<rest>(?:\w+ )*{_UNITS}) off"
            r"(?: (?:it|that|the (?:top|height|bottom|legs)|its (?:top|height)))?",
            "make it {rest} lower",
        ),
        (
            r"(?:shave|take|knock|cut|chop|trim) (?:a (?:bit|little)|some|something) off"
            r"(?: (?:it|that|the (?:top|height|bottom|legs)))?(?P<rest>)",
            "lower it{rest}",
        ),
        (
            rf"(?:put|add|stick) (?P<rest>(?:\w+ )*{_UNITS}) (?:to|on|onto) "
            r"(?:it|that|the (?:top|height)|its (?:top|height)|top)",
            "make it {rest} taller",
        ),
        (rf"{_IT} (?:wants|needs|ought|has) to be (?P<rest>.+)", "make {it} {rest}"),
        (
            r"(?:(?:that's|it's|that is|it is|that looks|it looks|looks) )?(?:quite |very |"
            r"really )?(?:nice|good|great|lovely|fine|okay|ok|pretty|cool|perfect|right|close)"
            r"(?: but| only| just| except) (?P<rest>.+)",
            "{rest}",
        ),
        (rf"(?:put|set|stand|place) {_IT} on (?P<rest>{_NUMBER} \w+)", "with {rest}"),
        (
            r"(?:i'd|i would|we'd) (?:rather|prefer to|like to|love to) have (?:it|that) "
            r"(?P<rest>(?:with|without|in) .+)",
            "{rest}",
        ),
        (
            r"(?:and |plus |with |also )*(?P<rest>an? \w+) "
            r"(?:on top|on it|on top of it|at the back|on the back|in it|to it)",
            "add {rest}",
        ),
        (
            r"(?:i|we)(?:'d like| would like| want| need) "
            r"(?P<rest>(?:\w+ more|another|an extra|an additional) \w+)",
            "add {rest}",
        ),
        (rf"(?:how|what) about (?P<rest>{_NUMBER} \w+)(?: instead| then)?", "{rest}"),
        (r"(?:can|could|should|may) (?:it|that|this) have (?P<rest>.+)", "with {rest}"),
        (r"try (?:it|that) (?P<rest>(?:with|without) .+)", "{rest}"),
        (rf"{_IT} (?:must|should|could|ought to|may) be (?P<rest>{_COLOURS})", "make {it} {rest}"),
        (r"(?:i'd|i would|we'd|maybe) (?P<rest>(?:lose|drop|remove|skip|add) .+)", "{rest}"),
        (rf"(?:needs|wants|lacks|missing) (?P<rest>(?:an? )?{_ADDED_PARTS}s?)", "add {rest}"),
        (
            r"(?:can|could) (?:it|that|this) be (?:done|made|built) (?P<rest>(?:with|without) .+)",
            "{rest}",
        ),
        (
            r"(?:chop|cut|saw|trim|file) the (?P<part>\w+) (?P<rest>(?:a bit |a little )?\w+er)",
            "make the {part} {rest}",
        ),
        (
            r"(?P<rest>(?:one|two|three|an?) (?:more|extra|additional|further) \w+) "
            r"(?:on top|on it|on top of it|at the (?:top|bottom|back)|underneath|below|above)",
            "add {rest}",
        ),
        (
            r"(?:the )?other one was (?P<rest>nicer|better|prettier)",
            "it was {rest}",
        ),
        (r"(?:no )?not (?:like|as) (?:this|that) (?P<rest>\w+er)", "{rest}"),
        (rf"{_IT} could do with being (?P<rest>.+)", "make {it} {rest}"),
        (
            r"(?:could|can|shall|should) (?:we|you|it|i) go (?P<rest>(?:a (?:bit|little) |much "
            r")?\w+er)",
            "make it {rest}",
        ),
        (
            r"(?:go|try it|have it|take it) (?P<rest>(?:a (?:bit|little) |much )?\w+er)",
            "make it {rest}",
        ),
        (
            r"(?:the same|same|that|it|this)(?: thing| one)? (?:but )?in an? (?P<rest>(?:much |"
            r"slightly )?\w+er) (?:size|version)",
            "make it {rest}",
        ),
        (
            r"why (?:not|don't (?:you|we)) (?P<rest>(?:add|make|remove|put|give|take|lower|"
            r"raise) .+)",
            "{rest}",
        ),
        (
            r"(?P<rest>(?:stretch|spread|thin|draw|fill) (?:it|that|this)) out(?P<it>.*)",
            "{rest}{it}",
        ),
        (r"(?P<rest>.+ too \w+) for (?:my|our|the) \w+", "{rest}"),
        (
            r"(?:can|could|should) the \w+ have (?P<rest>(?:an? )?(?:much |slightly )?\w+er \w+)",
            "{rest}",
        ),
        (
            rf"{_IT} (?:had better be|should rather be|would be better|would look better) "
            rf"(?P<rest>.+)",
            "make {it} {rest}",
        ),
        (
            r"(?P<rest>.+) (?:about|around|roughly|approximately|maybe|say|some) (?P<it>.+)",
            "{rest} {it}",
        ),
        (r"(?:about|around|roughly|approximately|maybe|say) (?P<rest>.+)", "{rest}"),
        (
            r"(?P<rest>(?:add|put|give it|attach) .+?) (?:in|(?:in|at|on|to|near) (?:the|its|each) "
            r"(?:top|bottom|side|sides|rear|front|middle|left|right|end))",
            "{rest}",
        ),
        (
            r"(?:i think|i guess|i'd say|i would say|i feel|i suppose|it seems) (?P<rest>.+)",
            "{rest}",
        ),
        (
            rf"{_WOULD_BE} {_BETTER} if {_IT} (?:was|were|is|could be) (?P<rest>.+)",
            "make {it} {rest}",
        ),
        (
            rf"{_WOULD_BE} {_BETTER} (?P<rest>(?:with|without) .+|(?:a (?:bit|little) )?\w+er)",
            "{rest}",
        ),
        (
            rf"what if (?:(?:you|we) (?:made|make) )?{_IT} (?:was |were |is )?(?P<rest>.+)",
            "make {it} {rest}",
        ),
        (r"(?:how|what) about making (?P<rest>.+)", "make {rest}"),
        (r"(?:how|what) about adding (?P<rest>.+)", "add {rest}"),
        (r"(?:how|what) about (?:removing|without) (?P<rest>.+)", "remove {rest}"),
        (r"(?:how|what) about (?P<rest>with .+|(?:a bit |a little )?\w+er)", "{rest}"),
        (rf"{_MAKE} (?:it|that|this) (?P<rest>(?:with|without|in) .+)", "{rest}"),
        (
            r"(?:i'd rather have|i would rather have|use|let it have) "
            r"(?P<rest>(?:only |just )?(?!an?\b)\w+ \w+)",
            "with {rest}",
        ),
        (rf"(?:{_WANT}|there should be|there must be) (?P<rest>.+) on it", "add {rest}"),
        (rf"(?:can|could|should|may|would) {_IT} be (?P<rest>.+)", "make {it} {rest}"),
        (
            rf"(?:i'd|i would) (?:rather|prefer) {_IT} had (?P<rest>.+)",
            "with {rest}",
        ),
        (rf"(?:make|have) {_IT} look (?P<rest>.+)", "make {it} {rest}"),
        (rf"(?:bring|move|put) {_IT} down(?P<rest>.*)", "lower {it}{rest}"),
        (rf"(?:bring|move|put) {_IT} up(?P<rest>.*)", "raise {it}{rest}"),
        (r"scale (?:it|that|this) up(?P<rest>.*)", "enlarge it{rest}"),
        (r"scale (?:it|that|this) down(?P<rest>.*)", "shrink it{rest}"),
        (r"(?P<rest>.+) than (?:that|this|it is|it was|before|now)", "{rest}"),
        (
            r"(?:make (?:it|that|this) )?as (?P<rest>\w+) as (?:possible|you can|it gets|it goes|"
            r"me|you|him|her|(?:an?|my|your|the) \w+)",
            "make it more {rest}",
        ),
        (
            rf"(?:change|set|reduce|increase|adjust|bring|put|raise|lower) (?:the|its) "
            rf"(?P<part>height|width|depth|length)(?: up| down)? (?:to|at) (?P<rest>.+ {_UNITS})",
            "make it {rest} in {part}",
        ),
        (r"(?:with|having) (?:no|without) (?P<rest>.+)", "without {rest}"),
        (
            r"(?:it|that) only (?:needs|wants|should have|has to have|must have) (?P<rest>.+)",
            "only {rest}",
        ),
        (
            rf"(?:i|we) (?:wanted|meant|wish|asked for) {_IT} (?:to be )?(?P<rest>.+)",
            "make {it} {rest}",
        ),
        (
            r"(?:change|set|reduce|increase) the (?P<part>\w+) to (?P<rest>\w+)",
            "with {rest} {part}",
        ),
        (r"(?P<part>\w+) (?P<rest>(?:a bit |a little |much )?\w+er)", "make the {part} {rest}"),
        (r"(?:give it|with) (?P<rest>(?:an? )?(?:bit |little |much )?\w+er \w+)", "{rest}"),
        (
            r"(?:make|build|give me|give us|i'll take|we'll take|i'd like|let's have|let me have) "
            r"(?P<rest>\w+) of (?:them|these|those|it|that)",
            "make that {rest}",
        ),
        (
            rf"(?:make|build|get|keep|want) {_IT} (?:to be )?(?:(?:very|really|super|so|extra|"
            rf"quite|pretty|nice and|all|more|\w+ly) )*(?P<rest>{_QUALITY})",
            "make {it} more {rest}",
        ),
        (
            rf"(?:{_WANT}|we want|we'd like|give me|can i have|let's have|(?:it|that) should have) "
            rf"(?P<rest>(?:an? )?(?:much |slightly )?\w+er \w+|{_NUMBER} \w+)",
            "{rest}",
        ),
        (
            r"(?:change|set|reduce|increase|raise|lower|bring) the number of (?P<part>\w+)(?: up| "
            r"down)? to (?P<rest>\w+)",
            "with {rest} {part}",
        ),
        (
            r"(?:change|set|switch|make) (?:the|its) colou?r (?:to |into )?(?P<rest>\w+)",
            "make it {rest}",
        ),
        (
            rf"(?:cut|saw|trim|get|do) {_IT} (?P<rest>(?:a bit |a little |much )?\w+er)",
            "make {it} {rest}",
        ),
        (
            rf"(?P<rest>an? {_ADDED_PARTS}) (?:would|might|will) (?:be|look) {_BETTER}",
            "add {rest}",
        ),
        (rf"(?:and|plus|also|with) (?:maybe |perhaps )?(?P<rest>an? {_ADDED_PARTS})", "add {rest}"),
        (
            rf"(?:it|that) (?:wants|lacks|is missing|could do with) (?P<rest>an? {_ADDED_PARTS})",
            "add {rest}",
        ),
        (
            r"(?:it's |that's |it is )?(?:too \w+|not \w+ enough) (?:so )?(?P<rest>make (?:it|"
            r"that) .+)",
            "{rest}",
        ),
        (rf"(?P<rest>{_NUMBER}) of (?:them|these|those)", "make that {rest}"),
        (rf"make (?P<rest>{_NUMBER})", "make that {rest}"),
        (
            r"(?:needs to|has to|ought to|wants to|should|must|could|might) be "
            r"(?P<rest>(?!an? (?!bit|little|lot|tad)).+)",
            "make it {rest}",
        ),
        (r"(?:the )?same(?: one| thing)? in (?P<rest>\w+er)", "make it {rest}"),
        (
            r"(?:put|add|stick|place|set) (?P<rest>an? \w+) on (?:top|it|there)(?: of it)?",
            "add {rest}",
        ),
        (
            rf"(?:instead of|rather than) {_NUMBER} (?P<part>\w+) .*?(?P<rest>{_NUMBER})",
            "with {rest} {part}",
        ),
        (
            r"(?:drop|cut|bring down|lessen|decrease|lower|take down) "
            r"(?:the|its) (?P<part>height|width|depth|length|size)(?P<rest>.*)",
            "reduce the {part}{rest}",
        ),
        (
            r"(?:increase|up|boost|bring up|grow|raise) "
            r"(?:the|its) (?P<part>height|width|depth|length|size)(?P<rest>.*)",
            "enlarge the {part}{rest}",
        ),
        (r"i (?:want|need) (?P<rest>\w+) of (?:them|these|those)", "make that {rest}"),
        (
            r"(?:i said|i meant|i asked for|i wanted|i ordered|it should be|let it be|"
            r"have it be|it shall be|i wish it was|i wish it were) (?P<rest>an? .+)",
            "make it {rest}",
        ),
        (
            rf"(?:{_HAVING}|add |put )an? (?:second|third|fourth|fifth|sixth) "
            rf"(?P<rest>{_ADDED_PARTS}|(?<!second )shelf)(?: (?:in|on|to) (?:it|there))?",
            "add another {rest}",
        ),
        (r"(?:a (?:bit|little) |(?:go )?(?=up [ab]))up(?P<rest>.*)", "raise it{rest}"),
        (r"(?:a (?:bit|little) |(?:go )?(?=down [ab]))down(?P<rest>.*)", "lower it{rest}"),
    )
)
"""Each pattern for a whole sentence, and what it comes to."""
_STEPS = 2
"""How often what it comes to may be put differently again."""


def phrasings(text: str) -> list[str]:
    """A sentence, and what else it may be put as, the nearest first."""
    found = [text]
    for _ in range(_STEPS):
        for known in tuple(found):
            for pattern, plain in _REWRITES:
                if (match := pattern.fullmatch(known)) is not None:
                    other = plain.format(**match.groupdict())
                    if other not in found:
                        found.append(other)
    return found
