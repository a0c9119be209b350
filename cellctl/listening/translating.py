"""Wishes in another language, word by word into English, for the rules that judge them.

It is no translation of the language: only the words of the domain are known, by the language's
message file. What is not known stays as it is, and the rules then know no such thing.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from cellctl.assembly import Intent, Request
from cellctl.listening.understanding.interpreter import Interpreter, Setting

_WORD = re.compile(r"\d+(?:[.,]\d+)?|\w+(?:'\w+)?")
_SURE = 0.5
"""Below this the rules guess that a word which they do not know is a thing; in a sentence that is
only half English it is more likely a word of the other language."""
_MOST_WORDS = 4
"""Longest phrase that is looked up as a whole."""


class Translator:
    """Puts the words of the domain into English.

    Args:
        words: English by word or phrase, in lower case; an asterisk at its end stands for any
            ending.
    """

    def __init__(self, words: Mapping[str, object]) -> None:
        self._exact = {
            " ".join(_WORD.findall(said.lower())): str(meant)
            for said, meant in words.items()
            if not said.endswith("*")
        }
        beginnings = [said[:-1].lower() for said in words if said.endswith("*")]
        self._beginnings = {
            said: str(words[f"{said}*"]) for said in sorted(beginnings, key=len, reverse=True)
        }

    def __bool__(self) -> bool:
        return bool(self._exact or self._beginnings)

    def english(self, text: str) -> str:
        """The sentence with all known words in English, in lower case."""
        words = _WORD.findall(text.lower())
        meant: list[str] = []
        index = 0
        while index < len(words):
            length, english = self._longest(words[index : index + _MOST_WORDS])
            meant.append(english)
            index += length
        return " ".join(filter(None, meant))

    def _longest(self, words: list[str]) -> tuple[int, str]:
        """How many of these words are known together, and what they mean."""
        for length in range(len(words), 0, -1):
            if (exact := self._exact.get(" ".join(words[:length]))) is not None:
                return length, exact
        for beginning, english in self._beginnings.items():
            if words[0].startswith(beginning):
                return 1, english
        return 1, words[0]


class TranslatingInterpreter:
    """An interpreter of English that is asked in another language.

    Args:
        inner: understands English.
        translator: knows the words.
    """

    def __init__(self, inner: Interpreter, translator: Translator) -> None:
        self.name = inner.name
        self._inner = inner
        self._translator = translator

    def interpret(self, text: str, setting: Setting) -> Request:
        """See ``Interpreter``."""
        request = self._inner.interpret(self._translator.english(text), setting)
        if request.intent is Intent.DESIGN and request.confidence < _SURE:
            why = f"it is half understood; {request.why}"
            return Request(
                text=text,
                intent=Intent.NONE,
                phrase="false",
                back_end=request.back_end,
                why=why,
                cloud=request.cloud,
            )
        return request.model_copy(update={"text": text})
