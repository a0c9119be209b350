"""The back end that asks a language model, and decides itself whenever that fails."""

from __future__ import annotations

import ipaddress
import threading
import time
from collections import deque
from urllib.parse import urlsplit

import structlog

from cellctl.assembly import Intent, Request
from cellctl.config import UnderstandingSection
from cellctl.credentials import Credential, find_credential, variable_of
from cellctl.errors import ConfigError
from cellctl.listening.understanding.interpreter import Interpreter, Setting
from cellctl.listening.understanding.language_model.answers import (
    UselessAnswerError,
    read_phrase_answer,
    read_structured,
)
from cellctl.listening.understanding.language_model.chat import Chat, ModelError
from cellctl.listening.understanding.language_model.prompts import PRESETS

log = structlog.get_logger(__name__)

CREDENTIAL = "llm-key"
_HOUR_S = 3600.0
_TRUSTED = 0.9
_MOST_WORDS = 60


class LanguageModelInterpreter:
    """Asks a language model what a sentence means.

    Words of command never get there: they are matched before, word for word, and no model's answer
    can be one. Nor do sentences that no visitor says to a cell: empty or endless ones.

    Args:
        section: which model, and what it may take.
        embedded: decides when the model does not.
        key: for the service; None for one that wants none.

    Raises:
        ConfigError: the key would be sent unencrypted to another computer.
    """

    def __init__(
        self, section: UnderstandingSection, embedded: Interpreter, key: Credential | None
    ) -> None:
        parts = urlsplit(section.model_url)
        assert parts.hostname is not None, "the configuration has checked that"
        here = is_here(parts.hostname)
        if key is not None and parts.scheme == "http" and not here:
            raise ConfigError(
                f"understanding.model_url: the key would be sent unencrypted to {parts.hostname}.",
                "Use https, or give no key.",
            )
        self.name = f"{section.model_name} at {parts.hostname}"
        self._elsewhere = "" if here else parts.hostname
        self._section = section
        self._preset = PRESETS[section.prompt]
        self._embedded = embedded
        self._chat = Chat(section.model_url, key.secret if key else None)
        self._lock = threading.Lock()
        self._asked_s: deque[float] = deque()
        self._rest_until_s = 0.0
        self._resting_for = ""

    def interpret(self, text: str, setting: Setting) -> Request:
        """Understand one sentence; see ``Interpreter``. Takes at most the configured budget."""
        own = self._embedded.interpret(text, setting)
        if own.intent is Intent.CONTROL or not 0 < len(text.split()) <= _MOST_WORDS:
            return own
        sent_to = ""
        try:
            self._count()
            sent_to = self._elsewhere
            answer = self._ask(text)
            read = read_structured if self._preset.structured else read_phrase_answer
            request = read(answer, text, setting)
        except (ModelError, UselessAnswerError) as error:
            log.warning("language model of no use", model=self.name, reason=str(error))
            why = f"{own.why}; {self.name} was of no use: {error}"
            return own.model_copy(update={"why": why, "cloud": sent_to})
        return request.model_copy(
            update={
                "back_end": self.name,
                "why": f"the model said so, asked with the prompt {self._preset.name!r}",
                "confidence": _TRUSTED if request.phrase == own.phrase else _TRUSTED / 2,
                "cloud": sent_to,
            }
        )

    def _count(self) -> None:
        """Count a request.

        Raises:
            ModelError: there may be none now.
        """
        now_s = time.monotonic()
        with self._lock:
            if now_s < self._rest_until_s:
                raise ModelError(f"{self._resting_for}; not asked again yet", retry_after_s=None)
            while self._asked_s and now_s - self._asked_s[0] > _HOUR_S:
                self._asked_s.popleft()
            if len(self._asked_s) >= self._section.requests_per_hour:
                raise ModelError("the requests of this hour are used up", retry_after_s=None)
            self._asked_s.append(now_s)

    def _ask(self, text: str) -> str:
        """Ask until there is an answer, within the budget.

        Raises:
            ModelError: there is none.
        """
        end_s = time.monotonic() + self._section.budget_s
        body = self._preset.body(self._section.model_name, text)
        for attempt in range(1, self._section.attempts + 1):
            left_s = max(end_s - time.monotonic(), 0.05)
            try:
                return self._chat.ask(body, min(self._section.timeout_s, left_s))
            except ModelError as error:
                wait_s = error.retry_after_s
                last = attempt == self._section.attempts
                if wait_s is None or last or time.monotonic() + wait_s >= end_s:
                    self._rest(error)
                    raise
            time.sleep(wait_s)
            self._count()
        raise AssertionError("the last attempt returns or raises")

    def _rest(self, error: ModelError) -> None:
        """Do not keep visitors waiting for what will fail."""
        with self._lock:
            self._rest_until_s = time.monotonic() + error.rest_s
            self._resting_for = str(error)


def is_here(host: str) -> bool:
    """Whether a host is this computer, by its name or address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def language_model(section: UnderstandingSection, embedded: Interpreter) -> Interpreter:
    """The back end that a configuration describes, with its key.

    Raises:
        ConfigError: the key is none, or would be sent unencrypted.
    """
    key = find_credential(CREDENTIAL)
    if key is None and urlsplit(section.model_url).scheme == "https":
        log.warning(
            "no key for the language model",
            hint=f"Give the credential {CREDENTIAL}, or ${variable_of(CREDENTIAL)}.",
        )
    return LanguageModelInterpreter(section, embedded, key)
