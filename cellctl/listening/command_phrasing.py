"""How control words are put: a small grammar of whole sentences beside the list in ``commands``.

People vary the verb ("drop it", "call it off"), what it is done to ("the build", "that one"), and
how soon ("now", "at once"), so these are put together here rather than listed. A sentence counts as
a whole or not at all; nothing is guessed from a part of one.
"""

from __future__ import annotations

import re

_THIS = (
    r"(?:it|that|this|(?:that|this) one|the (?:whole )?(?:build|job|thing|construction|process))"
)
_MACHINE = r"(?:the|this|that) (?:robot|arm|machine|motors?|robot arm|movement)"
_SOON = r"(?: (?:now|right now|right away|at once|immediately|already|straight away|this instant))?"
_MAKE = r"(?:build|make|do|assemble|construct|print|produce|create)"
_VERY = r"(?:(?:all|about|just|very|really|quite|pretty|exactly|absolutely|totally|so) )*"
_GOOD = (
    r"(?:good|great|fine|right|perfect|correct|nice|lovely|okay|ok|alright|wonderful|excellent|"
    r"amazing|awesome|fantastic|brilliant|beautiful|splendid|super)"
)
_BACK = r"(?:from (?:scratch|zero|the (?:beginning|start|top)))"
_NOT = r"(?:don't|do not|didn't|did not)"
_GRAMMAR = {
    "stop": (
        rf"(?:stop|halt|cease|quit)(?: (?:{_THIS}|{_MACHINE}|everything|all|moving|building|"
        rf"working))"
        rf"?{_SOON}|enough(?: now)?|that's enough now|stand still|stay still|power off|cut it out|"
        rf"(?:shut|turn|switch) (?:{_THIS}|{_MACHINE}|everything) (?:down|off)|shut down{_SOON}|"
        rf"(?:turn|switch) off {_MACHINE}"
    ),
    "pause": (
        r"(?:(?:wait|hold on|hang on|hold up|just) )?(?:just )?(?:a|one) "
        r"(?:moment|second|sec|minute|tick)|hold up|not so fast|stand by|"
        r"(?:wait|pause|hold on) (?:a bit|a while|a little|here)|take a break"
    ),
    "resume": (
        rf"keep (?:on|going|building|working|at it)|(?:go|carry) on(?: with {_THIS})?|"
        rf"(?:continue|proceed|resume)(?: (?:with )?{_THIS}| building| working| work)?|"
        rf"back to work|"
        r"you (?:may|can) (?:continue|go on|carry on|proceed)|(?:pick up|"
        r"continue) where you left off"
    ),
    "cancel": (
        rf"(?:cancel|abort|scrap|drop|ditch|discard|forget|ignore)(?: about)? "
        rf"(?:{_THIS}|everything|all of (?:it|that)|my (?:wish|order|request|build)|"
        r"what i (?:just )?said)|call (?:it|that|the whole thing) off|"
        r"(?:go )?back to the (?:beginning|"
        rf"start)|(?:start|begin) (?:all )?(?:over(?: again)?|again|anew|afresh)(?: {_BACK})?|"
        rf"(?:start|begin) {_BACK}|go back|restart|reset|exit|(?:i've|i have|i|we've|"
        rf"we) changed (?:my|our) "
        r"minds?|i (?:don't|do not) want (?:it|that|this)(?: one)? (?:anymore|any more|any longer|"
        r"after all)|i take (?:it|that) back"
    ),
    "yes": (
        rf"(?:(?:that|it|this)(?:'s| is| looks| sounds| seems)|looks|sounds) {_VERY}{_GOOD}"
        r"(?: to me| like that)?|(?:sure )?why not|i agree|agreed|absolutely|definitely|certainly|"
        r"indeed|excellent|great|fine(?: (?:by|with|for) me)?|by all means|you (?:bet|got it)|"
        r"(?:i'm |we're |all )?(?:ready|good to go)|spot on|works for me|that'll work|that's it|"
        r"(?:that's )?good enough|(?:i'm |we're )?(?:happy|fine|okay|good) with (?:that|it|this)|"
        r"(?:(?:it|that)'s )?a yes(?: from (?:me|us))?|thumbs up|"
        r"(?:all right|alright|okay|ok|fine|good|very well) then|(?:that's|this is|"
        r"it's) (?:exactly |"
        r"just )?what (?:i|we) (?:want|wanted|asked for|meant|said|like|need|needed|ordered)|"
        r"(?:i|we) (?:really )?(?:like|love) (?:it|that|this)(?: one)?(?: a lot| very much)?|"
        rf"(?:that|it|this)(?: would|'d| will|'ll) be {_VERY}{_GOOD}|"
        r"love it|"
        rf"(?:let's|let us) (?:go(?: for it| ahead)?|start|begin|{_MAKE} {_THIS}|get (?:started|"
        rf"going)|take (?:it|that one|this one))|go|start(?: (?:it|the build|the job))?|begin|"
        rf"(?:{_MAKE}|take) (?:that|this|{_THIS}){_SOON}|"
        rf"(?:go ahead|start|begin|proceed){_SOON}(?: with {_THIS})?|(?:i|we)(?:'ll| will) take "
        r"(?:it|that|this)(?: one)?|i want (?:that|this) one|okey dokey|aye"
    ),
    "no": (
        r"wrong|incorrect|never|not (?:really|quite|now|today|good|right|yet|correct|at all|this|"
        r"this one|that one)|certainly not|no (?:good|more)|maybe (?:later|not)|i said no|"
        r"(?:that's|this is|it's|that is|it is) (?:wrong|incorrect|not (?:it|right|good|correct|"
        r"quite right|what i (?:asked for|meant|said|want|wanted|ordered)))|"
        rf"(?:don't|do not) (?:{_MAKE}|start|begin) (?:{_THIS}|anything)|"
        r"(?:i|we) (?:don't|do not) (?:want|need|fancy) (?:it|that|this)(?: one)?|"
        rf"(?:(?:it|that)'s )?a no(?: from (?:me|us))?|thumbs down|"
        rf"(?:that|it|this)(?:'s| is| looks) {_VERY}(?:rubbish|bad|awful|terrible|horrible|ugly|"
        rf"stupid|silly|no good|useless)"
    ),
    "repeat": (
        r"(?:repeat|say) (?:it|that|this|yourself|the question|what you said)(?: again| once more| "
        rf"one more time)?|i (?:{_NOT}|couldn't|can't) (?:get|hear|catch|understand|follow)"
        r"(?: (?:it|that|you|what you said))?|what did you (?:just )?(?:say|ask)(?: just now)?|"
        r"say again|sorry what|(?:i )?beg your pardon|pardon me|say what|tell me (?:that )?again"
    ),
    "again": (
        rf"redo(?: it| that)?|{_MAKE} (?:it|that|this|the same)(?: one| thing)? (?:again|once more|"
        r"one more time|over)|one more time|once (?:again|more)|same again|(?:the )?same(?: one|"
        r" thing)? again"
    ),
    "take_apart": (
        r"(?:take|break|pull|tear) (?:it|that|this|all of (?:it|that)|everything|the (?:whole )?"
        r"(?:thing|lot|building|object)) (?:all )?(?:apart|down|to (?:pieces|bits))(?: again)?"
    ),
    "another": (
        r"(?:(?:i'd|we'd) (?:rather|prefer to|like to)|i want to|(?:can|could|may) (?:i|we)|let's|"
        r"let me) (?:have|see|get|try) (?:something (?:else|different)|another(?: one)?|"
        r"a different one)|i(?:'d| would) (?:like|prefer)(?: to have)? something (?:else|"
        r"different)|"
        r"show me more|(?:show|give) (?:me )?(?:another|a different|some other|other|more) "
        r"(?:one|ones|option|options|idea|ideas|version|versions|design|designs)|"
        r"(?:something|anything) (?:else|different|new)|"
        rf"(?:i|we) {_NOT} like (?:it|that|this)(?: one)?"
    ),
    "help": "help(?: me)?(?: out)?|can you help me",
}
_PATTERN = re.compile("|".join(f"(?P<{name}>{how})" for name, how in _GRAMMAR.items()))


def phrased_command(sentence: str) -> str | None:
    """The command that a sentence puts in words of its own; None where it is none.

    Args:
        sentence: lower-case words, one space between them, without politeness around them.
    """
    match = _PATTERN.fullmatch(sentence)
    return match.lastgroup if match else None
