"""The embedded back end: rules and tables, without a network, a GPU or a model to load."""

from __future__ import annotations

from cellctl.assembly import Request
from cellctl.listening.request import read_request
from cellctl.listening.understanding.interpreter import Setting


class EmbeddedInterpreter:
    """Understands English by rules, in about a millisecond."""

    name = "rules"

    def interpret(self, text: str, setting: Setting) -> Request:
        """Understand one sentence; see ``Interpreter``."""
        return read_request(text, setting)
