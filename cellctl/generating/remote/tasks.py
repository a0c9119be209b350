"""Services that make a model as a task: begun once, watched until it is done, fetched.

Beginning a task may be charged. So it is done once: it is repeated only after a refusal that says
that nothing was begun (429), never after silence. After silence the service is asked whether the
task is there.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import structlog

from cellctl.generating.remote.glb import check_glb
from cellctl.generating.remote.http import BusyError, LateError, Service, ServiceError

log = structlog.get_logger(__name__)

Progress = Callable[[str], None]
"""Receives a line for the visitor."""

_FIRST_LOOK_S = 2.0
_SLOWER = 1.5
_SLOWEST_S = 30.0
_MOST_FAILED_LOOKS = 4
_CANCEL_PATIENCE_S = 5.0
_RATE_LIMIT_TRIES = 3


@dataclass(frozen=True)
class TaskState:
    """What a service says of a task."""

    state: Literal["waiting", "working", "done", "failed", "declined", "used_up", "cancelled"]
    percent: int = 0
    model_url: str = ""
    said: str = ""
    """Why it failed, in the service's words."""
    retry_after_s: float | None = None


class TaskService(Protocol):
    """One service's contract."""

    @property
    def service(self) -> Service:
        """Where it is."""
        ...

    async def begin(self, prompt: str) -> str:
        """Begin a task; returns its id. Called once a wish, but for refusals with 429."""
        ...

    async def find(self, prompt: str) -> str | None:
        """The id of a task that was begun for that prompt just now; None where it cannot tell."""
        ...

    async def look(self, task_id: str) -> TaskState:
        """How far it is."""
        ...

    async def cancel(self, task_id: str) -> None:
        """End it, where the service can."""
        ...


async def make_model(
    tasks: TaskService, prompt: str, progress: Progress, *, timeout_s: float, most_bytes: int
) -> bytes:
    """Have a model made; the task is ended when the caller goes away.

    Args:
        tasks: the service.
        prompt: what to make.
        progress: told how far it is.
        timeout_s: for all of it (wall time).
        most_bytes: of the model.

    Returns:
        A GLB whose header is right.

    Raises:
        ServiceError: it refuses, fails, or takes too long.
        DesignError: what it sent is no GLB.
    """
    service, task_id = tasks.service, ""
    try:
        async with asyncio.timeout(timeout_s):
            task_id = await _begun(tasks, prompt, progress)
            progress(f"{service.name} has begun (task {task_id}).")
            done = await _watched(tasks, task_id, progress)
            progress(f"{service.name} is done; I am fetching the model.")
            content = await service.download(
                done.model_url, most_bytes=most_bytes, timeout_s=timeout_s
            )
    except TimeoutError:
        await _cancel(tasks, task_id)
        raise LateError(
            f"{service.name} was not done within {timeout_s:g} s.",
            "Please ask for something simpler, or again later.",
        ) from None
    except asyncio.CancelledError:
        await _cancel(tasks, task_id)
        raise
    check_glb(content, service.name)
    return content


async def _begun(tasks: TaskService, prompt: str, progress: Progress) -> str:
    tries = 0
    while True:
        try:
            return await tasks.begin(prompt)
        except BusyError as busy:
            tries += not busy.slot
            if tries >= _RATE_LIMIT_TRIES:
                raise
            progress(f"{busy.message} I shall ask again in {busy.retry_after_s:g} s.")
            await asyncio.sleep(busy.retry_after_s)
        except LateError as late:
            with contextlib.suppress(ServiceError):
                if (found := await tasks.find(prompt)) is not None:
                    return found
            raise LateError(
                f"{late.message} It may have begun all the same, so I do not ask twice.",
                "The operator can see in the account whether it was charged.",
            ) from late


async def _watched(tasks: TaskService, task_id: str, progress: Progress) -> TaskState:
    """Look until it is done, ever more seldom; looking is free, and may fail now and then."""
    service, wait_s, failed, told = tasks.service, _FIRST_LOOK_S, 0, -1
    while True:
        try:
            now = await tasks.look(task_id)
        except BusyError as busy:
            await asyncio.sleep(busy.retry_after_s)
            continue
        except ServiceError as error:
            failed += 1
            if failed >= _MOST_FAILED_LOOKS:
                raise ServiceError(
                    f"{service.name} began, and then could not tell how far it is: {error.message}",
                    error.hint,
                ) from error
            await asyncio.sleep(min(wait_s, service.answer_timeout_s))
            continue
        failed = 0
        match now.state:
            case "done" if now.model_url:
                return now
            case "done":
                raise ServiceError(f"{service.name} is done and gave no model.")
            case "declined":
                raise service.declined(now.said)
            case "used_up":
                raise service.used_up(f" It says: {now.said}" if now.said else "")
            case "failed" | "cancelled":
                why = f" It says: {now.said}" if now.said else ""
                ended = "could not make it" if now.state == "failed" else "ended the task"
                raise ServiceError(f"{service.name} {ended}.{why}", "Please put it differently.")
            case _:
                if now.percent != told:
                    told = now.percent
                    progress(f"{service.name} works on it: {now.percent} %.")
        await asyncio.sleep(wait_s if now.retry_after_s is None else now.retry_after_s)
        if now.retry_after_s is None:
            wait_s = min(wait_s * _SLOWER, _SLOWEST_S)


async def _cancel(tasks: TaskService, task_id: str) -> None:
    """Tell the service that nobody waits any more; whether that succeeds changes nothing here."""
    if not task_id:
        return
    try:
        async with asyncio.timeout(_CANCEL_PATIENCE_S):
            await tasks.cancel(task_id)
    except (ServiceError, TimeoutError) as error:
        log.warning("task not ended", service=tasks.service.name, task=task_id, reason=str(error))
