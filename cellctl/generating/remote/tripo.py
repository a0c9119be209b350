"""Tripo's text-to-model, version 3 of its interface, as its published client speaks it.

Answers come in an envelope: ``{"code": 0, "data": ...}``, and a code that is not 0 is a refusal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from urllib.parse import quote

from cellctl.generating.remote.http import Answer, BusyError, Service, ServiceError
from cellctl.generating.remote.tasks import TaskState

KEY = "tripo-key"
MOST_PROMPT = 1024
_BEGIN = "/v3/generation/text-to-model"
_TASKS = "/v3/tasks"
_DECLINED, _USED_UP = 2008, 2010
_BUSY_S = 10.0
_STATES: dict[str, Any] = {
    "queued": "waiting",
    "running": "working",
    "success": "done",
    "failed": "failed",
    "expired": "failed",
    "cancelled": "cancelled",
    "banned": "declined",
    "unknown": "waiting",
}


@dataclass(frozen=True)
class Tripo:
    """Its contract: a task by POST, its state by GET; a task cannot be ended or found again."""

    service: Service

    async def begin(self, prompt: str) -> str:
        """Begin a model without texture."""
        body = {
            "prompt": prompt[:MOST_PROMPT],
            "model": "v2.5-20250123",
            "texture": False,
            "pbr": False,
            "face_limit": 10_000,
        }
        data = self._data(await self.service.send("POST", _BEGIN, body))
        task_id = data.get("task_id") if isinstance(data, dict) else None
        if not isinstance(task_id, str) or not task_id:
            raise ServiceError(f"{self.service.name} began something, and did not say what.")
        return task_id

    async def find(self, prompt: str) -> str | None:  # noqa: ARG002 - the contract has no list
        """It cannot tell."""
        return None

    async def look(self, task_id: str) -> TaskState:
        """How far it is."""
        answer = await self.service.send("GET", f"{_TASKS}/{quote(task_id, safe='')}")
        task = self._data(answer)
        state: Any = _STATES.get(str(task.get("status", ""))) if isinstance(task, dict) else None
        if state is None:
            raise ServiceError(f"{self.service.name} sent no task.")
        output = task.get("output")
        url = output.get("model_url") if isinstance(output, dict) else None
        progress = task.get("progress")
        code = task.get("error_code")
        if state == "failed":
            state = {_DECLINED: "declined", _USED_UP: "used_up"}.get(code, state)
        return TaskState(
            state=state,
            percent=min(100, max(0, int(progress))) if isinstance(progress, int | float) else 0,
            model_url=url if isinstance(url, str) else "",
            said=" ".join(str(task.get("error_msg") or task.get("error_message") or "").split()),
            retry_after_s=answer.retry_after_s,
        )

    async def cancel(self, task_id: str) -> None:
        """Nothing to be done: it goes on, and its model is not fetched."""

    def _data(self, answer: Answer) -> Any:
        body = answer.json(self.service.name)
        if not isinstance(body, dict):
            raise ServiceError(f"{self.service.name} sent no answer that it should.")
        code, said = body.get("code", 0), " ".join(str(body.get("message") or "").split())
        match code:
            case 0:
                return body.get("data", body)
            case 2000:
                raise BusyError(
                    f"{self.service.name} gets too many requests. It says: {said}",
                    "Please ask again in a while.",
                    retry_after_s=_BUSY_S if answer.retry_after_s is None else answer.retry_after_s,
                    slot=False,
                )
            case 2008:
                raise self.service.declined(said)
            case 2010:
                raise self.service.used_up(f" It says: {said}" if said else "")
            case _:
                raise ServiceError(f"{self.service.name} refused the request ({code}): {said}")
