"""One HTTP service: its address, its key, and answers within a time and a size.

A key goes to the address that it belongs to and nowhere else: redirects are not followed with it,
proxies named by the environment do not get it, and models are downloaded without it.
"""

from __future__ import annotations

import asyncio
import json
import math
import ssl
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any
from urllib.parse import urljoin, urlsplit

import httpx2

from cellctl.errors import DesignError

MOST_ANSWER_BYTES = 4 * 1024 * 1024
_MOST_REDIRECTS = 3
_SHOWN = 200
_RETRY_AFTER_DEFAULT_S = 5.0
_RETRY_AFTER_MOST_S = 60.0
_RETRY_AFTER_LEAST_S = 0.02


class ServiceError(DesignError):
    """A service refused, failed, or cannot be reached; the message is for the visitor."""


class LateError(ServiceError):
    """No answer came in time, so that nobody knows whether the request arrived."""


class BusyError(ServiceError):
    """The service wants to be asked again later (429); nothing was begun, and nothing charged.

    Args:
        message: what it said.
        retry_after_s: when to ask again.
        slot: True when it waits for another task to end, not for a rate to fall.
    """

    def __init__(self, message: str, hint: str, *, retry_after_s: float, slot: bool) -> None:
        super().__init__(message, hint)
        self.retry_after_s = retry_after_s
        self.slot = slot


@dataclass(frozen=True)
class Answer:
    """The body of a good answer, and when it wants to be asked again."""

    content: bytes
    content_type: str
    retry_after_s: float | None

    def json(self, origin: str) -> Any:
        """The body as JSON.

        Raises:
            ServiceError: it is none.
        """
        try:
            return json.loads(self.content)
        except (ValueError, RecursionError) as error:
            raise ServiceError(f"{origin} sent no JSON.", "Please ask again later.") from error


@dataclass(frozen=True)
class Service:
    """A service by name, where it is, and the key it wants.

    Args:
        name: as people know it.
        url: of its interface.
        key_name: of the credential, for messages.
        key: the secret itself, or None for a service that wants none.
        answer_timeout_s: for one answer (wall time).
    """

    name: str
    url: str
    key_name: str
    key: str | None = field(default=None, repr=False)
    answer_timeout_s: float = 30.0

    async def send(
        self,
        method: str,
        path: str,
        body: object = None,
        *,
        timeout_s: float | None = None,
        most_bytes: int = MOST_ANSWER_BYTES,
    ) -> Answer:
        """One request, once: whoever may repeat it does so itself.

        Raises:
            ServiceError: it is refused, or fails; ``BusyError`` and ``LateError`` say how.
        """
        headers = {"Authorization": f"Bearer {self.key}"} if self.key else {}
        url = self.url.rstrip("/") + path
        content = None
        if body is not None:
            content = json.dumps(body).encode()
            headers["Content-Type"] = "application/json"
        wait_s = timeout_s or self.answer_timeout_s
        status, answer = await self._fetch(
            method, url, headers=headers, content=content, timeout_s=wait_s, most_bytes=most_bytes
        )
        if status in range(300, 400):
            raise ServiceError(
                f"{self.name} sent the request elsewhere ({status}), where the key may not go.",
                "Set the service's current address in [generating].",
            )
        if status >= 400:
            raise self._refusal(status, answer)
        return answer

    async def download(self, url: str, *, most_bytes: int, timeout_s: float) -> bytes:
        """Fetch a model from a link, without the key.

        Raises:
            ServiceError: the link has expired, leads astray, or its answer is too large.
        """
        allowed = {"https", urlsplit(self.url).scheme}
        for _ in range(_MOST_REDIRECTS + 1):
            if urlsplit(url).scheme not in allowed:
                raise ServiceError(f"{self.name} gave a link that is none: {url[:80]!r}.")
            status, answer = await self._fetch(
                "GET", url, headers={}, content=None, timeout_s=timeout_s, most_bytes=most_bytes
            )
            if status in (301, 302, 303, 307, 308):
                url = urljoin(url, answer.content_type)
                continue
            if status in (401, 403, 404, 410):
                raise ServiceError(
                    f"The link to the model that {self.name} made has expired ({status}).",
                    "Please ask again; the model is still in the account of the cell.",
                )
            if status != 200:
                raise ServiceError(
                    f"The model that {self.name} made cannot be fetched ({status}).",
                    "Please ask again later.",
                )
            return answer.content
        raise ServiceError(f"The link that {self.name} gave leads in circles.")

    async def _fetch(
        self,
        method: str,
        url: str,
        *,
        headers: dict[str, str],
        content: bytes | None,
        timeout_s: float,
        most_bytes: int,
    ) -> tuple[int, Answer]:
        """Status and answer; of a redirect the place it leads to instead of a type."""
        try:
            async with (
                # The client's own limit is for each of its reads, this one for all of it.
                asyncio.timeout(timeout_s),
                httpx2.AsyncClient(
                    verify=_tls(), timeout=timeout_s, follow_redirects=False, trust_env=False
                ) as client,
                client.stream(method, url, headers=headers, content=content) as response,
            ):
                body = bytearray()
                async for part in response.aiter_bytes():
                    body += part
                    if len(body) > most_bytes:
                        raise ServiceError(
                            f"{self.name} sent more than {most_bytes / 1e6:.3g} MB.",
                            "Ask for something simpler, or raise generating.max_download_mb.",
                        )
                moved = response.headers.get("location", "")
                kind = response.headers.get("content-type", "")
                return response.status_code, Answer(
                    bytes(body), moved or kind, _retry_after_s(response.headers)
                )
        except (TimeoutError, httpx2.TimeoutException) as error:
            raise LateError(
                f"{self.name} did not answer within {timeout_s:g} s.", "Please ask again later."
            ) from error
        except (httpx2.HTTPError, httpx2.InvalidURL, OSError) as error:
            raise ServiceError(
                f"{self.name} cannot be reached ({type(error).__name__}).",
                "Please ask for something that I can design myself, or again later.",
            ) from error

    def _refusal(  # noqa: PLR0911 - one way out a kind of refusal
        self, status: int, answer: Answer
    ) -> ServiceError:
        said, code = _said(answer.content)
        shown = f" It says: {said}" if said else ""
        wait_s = answer.retry_after_s
        match status:
            case 401:
                return ServiceError(
                    f"{self.name} does not accept the key ({self.key_name}).{shown}",
                    "The operator has to give it another one.",
                )
            case 402:
                return self.used_up(shown)
            case 403 if code == 2010:
                return self.used_up(shown)
            case 403:
                return ServiceError(
                    f"{self.name} does not allow that with this key.{shown}",
                    "The operator should look at what the account may do.",
                )
            case 429:
                slot = "NoMoreConcurrentTasks" in said or "concurrent" in said.lower()
                why = "already works on as much as it may" if slot else "gets too many requests"
                return BusyError(
                    f"{self.name} {why}.{shown}",
                    "Please ask again in a while.",
                    retry_after_s=_RETRY_AFTER_DEFAULT_S if wait_s is None else wait_s,
                    slot=slot,
                )
            case _ if status >= 500:
                return ServiceError(
                    f"{self.name} has failed ({status}).{shown}", "Please ask again later."
                )
            case _ if code == 2008 or _is_moderation(said):
                return self.declined(said)
            case _:
                return ServiceError(f"{self.name} refused the request ({status}).{shown}")

    def used_up(self, shown: str = "") -> ServiceError:
        """That the account has no credit."""
        return ServiceError(
            f"The quota at {self.name} is used up.{shown}",
            "The operator has to buy more; what I can design myself goes on.",
        )

    def declined(self, said: str) -> ServiceError:
        """That the service does not make such things."""
        shown = f" It says: {said}" if said else ""
        return ServiceError(
            f"{self.name} does not make that, by its rules.{shown}",
            "Please ask for something else.",
        )


def _is_moderation(said: str) -> bool:
    lower = said.lower()
    return any(word in lower for word in ("moderat", "policy", "policies", "sensitive", "nsfw"))


def _said(content: bytes) -> tuple[str, int | None]:
    """The message of a refusal on one short line, and its number where it has one."""
    try:
        body = json.loads(content)
    except (ValueError, RecursionError):
        return "", None
    if not isinstance(body, dict):
        return "", None
    found = body.get("message") or body.get("detail") or body.get("error") or ""
    if isinstance(found, dict):
        found = found.get("message", "")
    code = body.get("code")
    return " ".join(str(found).split())[:_SHOWN], code if isinstance(code, int) else None


def _retry_after_s(headers: httpx2.Headers) -> float | None:
    """When to ask again; None where nothing usable is said, or only a date."""
    try:
        wait_s = float(headers.get("retry-after", ""))
    except ValueError:
        return None
    if not math.isfinite(wait_s):
        return None
    return min(max(wait_s, _RETRY_AFTER_LEAST_S), _RETRY_AFTER_MOST_S)


@lru_cache(maxsize=1)
def _tls() -> ssl.SSLContext:
    """The system's certificates; reading them takes longer than many an answer."""
    return ssl.create_default_context()
