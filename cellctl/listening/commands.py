"""Control words: matched as whole sentences, letter by letter, before any model or rule.

Stop and pause must work when everything else is confused, so nothing here guesses.
"""

from __future__ import annotations

import re

_SENTENCES: dict[str, tuple[str, ...]] = {
    "stop": (
        *("stop", "stop it", "stop that", "stop everything", "stop moving", "stop building"),
        *("stop the robot", "stop the arm", "emergency stop", "halt", "freeze"),
    ),
    "pause": (
        *("pause", "wait", "wait a moment", "wait a minute", "wait a second", "hold on"),
        *("hold it", "hang on"),
    ),
    "resume": ("resume", "continue", "go on", "carry on", "keep going", "proceed"),
    "cancel": (
        *("cancel", "cancel it", "cancel that", "cancel the build", "cancel the job", "abort"),
        *("forget it", "forget that", "forget about it", "never mind", "nevermind", "start over"),
    ),
    "yes": (
        *("yes", "yeah", "yep", "yup", "sure", "okay", "ok", "of course", "correct", "do it"),
        *("go ahead", "go for it", "that's right", "looks good", "sounds good", "build it"),
        *("yes please", "that's fine", "that's good", "that's perfect", "perfect", "sounds great"),
        *("yes go ahead", "yes do it", "yes build it", "yes please build it", "yes please do"),
        *("okay go ahead", "okay do it", "okay go"),
    ),
    "no": (
        *("no", "nope", "nah", "no thanks", "no thank you", "don't", "do not", "don't do it"),
        *("no don't",),
    ),
    "take_apart": (
        *("take it apart", "take it apart again", "take it down", "clear it away"),
        *("disassemble it",),
    ),
    "repeat": ("say that again", "repeat", "repeat that", "what did you say", "pardon"),
    "again": (
        *("do it again", "build it again", "build another one", "make another one", "once more"),
        *("again",),
    ),
    "help": ("help", "help me"),
}
_BY_SENTENCE = {sentence: name for name, group in _SENTENCES.items() for sentence in group}
_POLITE = frozenset(
    {
        "please",
        "now",
        "right",
        "robot",
        "hey",
        "um",
        "uh",
        "immediately",
        "ok",
        "okay",
        "oh",
        "just",
    }
)
"""Words that change nothing when they stand before or after a control word."""


def spoken_command(text: str) -> str | None:
    """The command that a sentence is, or None.

    Returns:
        One of ``stop``, ``pause``, ``resume``, ``cancel``, ``yes``, ``no``, ``take_apart``,
        ``repeat``, ``again`` and ``help``.
    """
    words = re.sub(r"[^a-z' ]+", " ", text.lower().replace("’", "'")).split()  # noqa: RUF001
    plain = " ".join(words)
    if plain in _BY_SENTENCE:
        return _BY_SENTENCE[plain]
    while words and words[0] in _POLITE:
        words = words[1:]
    while words and words[-1] in _POLITE:
        words = words[:-1]
    if len(set(words)) == 1:
        words = words[:1]  # "stop stop stop"
    return _BY_SENTENCE.get(" ".join(words))
