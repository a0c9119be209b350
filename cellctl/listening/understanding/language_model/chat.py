"""One question to a service that speaks OpenAI's chat completions, within a time.

Contract: ``POST {url}/chat/completions`` with a bearer key where the service wants one; the answer
is JSON with ``choices[0].message.content``. Errors carry ``{"error": {"message", "code"}}``.
"""

from __future__ import annotations

import json
import ssl
import time
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import httpx2

_MOST_BYTES = 256 * 1024
_SHOWN = 160
_LONG_WAIT_S = 300.0
"""Nobody asks again for so long after what a second attempt does not cure."""


class ModelError(Exception):
    """The service gave no answer.

    Args:
        message: what happened, without any secret.
        retry_after_s: when a further attempt may go better; None: not at all.
        rest_s: how long it is useless to ask anything.
    """

    def __init__(self, message: str, *, retry_after_s: float | None, rest_s: float = 0.0) -> None:
        super().__init__(message)
        self.retry_after_s = retry_after_s
        self.rest_s = rest_s


@dataclass(frozen=True)
class Chat:
    """A service, and how to ask it."""

    url: str
    key: str | None = field(default=None, repr=False)

    def ask(self, body: dict[str, Any], timeout_s: float) -> str:
        """Send one request; returns what the model wrote.

        Raises:
            ModelError: there is no answer within the time, or none that could be used.
        """
        deadline_s = time.monotonic() + timeout_s
        headers = {"Authorization": f"Bearer {self.key}"} if self.key else {}
        try:
            # A redirect is not followed: the key is for this address alone. Nor does a proxy get
            # it that an environment variable names.
            with (
                httpx2.Client(
                    verify=_tls(), timeout=timeout_s, follow_redirects=False, trust_env=False
                ) as client,
                client.stream(
                    "POST", f"{self.url.rstrip('/')}/chat/completions", json=body, headers=headers
                ) as response,
            ):
                return _content(response, _read(response, deadline_s))
        except httpx2.TimeoutException as error:
            raise ModelError(f"no answer within {timeout_s:g} s", retry_after_s=0.0) from error
        except httpx2.HTTPError as error:
            raise ModelError(
                f"no connection ({type(error).__name__}: {error})", retry_after_s=0.2
            ) from error


@lru_cache(maxsize=1)
def _tls() -> ssl.SSLContext:
    """The system's certificates; reading them takes longer than many an answer."""
    return ssl.create_default_context()


def _read(response: httpx2.Response, deadline_s: float) -> bytes:
    """The body, which may neither trickle in for ever nor be without end."""
    parts: list[bytes] = []
    size = 0
    for part in response.iter_bytes():
        size += len(part)
        parts.append(part)
        if size > _MOST_BYTES:
            raise ModelError("the answer is too large", retry_after_s=None)
        if time.monotonic() > deadline_s:
            raise ModelError("the answer takes too long", retry_after_s=0.0)
    return b"".join(parts)


def _content(response: httpx2.Response, raw: bytes) -> str:
    try:
        answer = json.loads(raw)
    except (ValueError, RecursionError):
        answer = None
    if response.status_code != 200:
        raise _refusal(response, answer)
    if not isinstance(answer, dict):
        raise ModelError("the answer is no JSON", retry_after_s=0.2)
    try:
        choice = answer["choices"][0]
        message = choice["message"]
        content, declined = message.get("content"), message.get("refusal")
        finished = choice.get("finish_reason")
    except (KeyError, IndexError, TypeError, AttributeError):
        raise ModelError("the answer holds no message", retry_after_s=0.2) from None
    if declined or finished == "content_filter":
        raise ModelError("the model declined to answer", retry_after_s=None)
    if finished == "length":
        raise ModelError("the answer was cut off", retry_after_s=None)
    if not isinstance(content, str) or not content.strip():
        raise ModelError("the answer is empty", retry_after_s=0.2)
    return content


def _refusal(response: httpx2.Response, answer: object) -> ModelError:
    status = response.status_code
    error = answer.get("error") if isinstance(answer, dict) else None
    told = error if isinstance(error, dict) else {}
    code = str(told.get("code") or told.get("type") or "")
    said = " ".join(str(told.get("message") or "").split())[:_SHOWN]
    shown = f": {said}" if said else ""
    if status in (401, 403):
        return ModelError(f"the key is refused ({status})", retry_after_s=None, rest_s=_LONG_WAIT_S)
    if status == 404:
        message = f"there is no such model or address (404){shown}"
        return ModelError(message, retry_after_s=None, rest_s=_LONG_WAIT_S)
    if status == 429 and "quota" in code:
        return ModelError("the quota is used up (429)", retry_after_s=None, rest_s=_LONG_WAIT_S)
    if status == 429:
        wait_s = _retry_after_s(response)
        return ModelError("too many requests (429)", retry_after_s=wait_s, rest_s=wait_s)
    if status >= 500:
        return ModelError(f"the service failed ({status})", retry_after_s=_retry_after_s(response))
    return ModelError(f"the request is refused ({status}){shown}", retry_after_s=None)


def _retry_after_s(response: httpx2.Response) -> float:
    try:
        wait_s = float(response.headers.get("retry-after", "0.5"))
    except ValueError:  # a date
        return 0.5
    return min(max(wait_s, 0.0), _LONG_WAIT_S) if wait_s == wait_s else 0.5  # noqa: PLR0124 - nan
