"""The many ways to ask for a change, put into the few that ``edits`` reads."""

from __future__ import annotations

import re

_IT = r"(?P<it>it|that|this|them|the \w+(?: \w+)?)"
_BETTER = r"(?:better|nicer|nice|great|good|cool|best)"
_WOULD_BE = r"(?:it (?:would|might|could) be|it'd be)"
_WANT = r"(?:i want|i need|i'd like|i'd prefer|i would like|i would prefer)"
_MAKE = rf"(?:make|try|do|build|have|design|{_WANT})"
_REWRITES = tuple(
    (re.compile(pattern), plain)
    for pattern, plain in (
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
            r"(?:make (?:it|that|this) )?as (?P<rest>\w+) as (?:possible|you can|it gets|it goes)",
            "make it more {rest}",
        ),
        (
            r"(?:change|set|reduce|increase) the (?P<part>\w+) to (?P<rest>\w+)",
            "with {rest} {part}",
        ),
        (r"(?P<part>\w+) (?P<rest>(?:a bit |a little |much )?\w+er)", "make the {part} {rest}"),
        (r"(?:give it|with) (?P<rest>(?:an? )?(?:bit |little |much )?\w+er \w+)", "{rest}"),
        (r"(?:make|build) (?P<rest>\w+) of (?:them|these|those|it)", "make that {rest}"),
        (r"i (?:want|need) (?P<rest>\w+) of (?:them|these|those)", "make that {rest}"),
        (
            r"(?:i said|i meant|i asked for|i wanted|i ordered|it should be|not an? \w+(?: but)?) "
            r"(?P<rest>an? .+)",
            "make it {rest}",
        ),
    )
)
"""Each pattern for a whole sentence, and what it comes to."""


def phrasings(text: str) -> list[str]:
    """A sentence, and what else it may be put as, the nearest first."""
    found = [text]
    for pattern, plain in _REWRITES:
        if (match := pattern.fullmatch(text)) is not None:
            found.append(plain.format(**match.groupdict()))
    return found
