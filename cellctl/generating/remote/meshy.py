"""Meshy's text-to-3D, by its published contract (docs.meshy.ai): preview tasks, without texture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from urllib.parse import quote

from cellctl.generating.remote.http import Service, ServiceError
from cellctl.generating.remote.tasks import TaskState

KEY = "meshy-key"
MOST_PROMPT = 600
_PATH = "/v2/text-to-3d"
_POLYGONS = 10_000
"""Parts of 10 cm show nothing finer."""
_STATES: dict[str, Any] = {
    "PENDING": "waiting",
    "IN_PROGRESS": "working",
    "SUCCEEDED": "done",
    "FAILED": "failed",
    "CANCELED": "cancelled",
}


@dataclass(frozen=True)
class Meshy:
    """Its contract: a task by POST, its state by GET, its end by DELETE."""

    service: Service

    async def begin(self, prompt: str) -> str:
        """Begin a preview; texture is for nothing here."""
        body = {
            "mode": "preview",
            "prompt": prompt[:MOST_PROMPT],
            "should_remesh": True,
            "target_polycount": _POLYGONS,
            "target_formats": ["glb"],
            "moderation": True,
        }
        found = (await self.service.send("POST", _PATH, body)).json(self.service.name)
        task_id = found.get("result") if isinstance(found, dict) else None
        if not isinstance(task_id, str) or not task_id:
            raise ServiceError(f"{self.service.name} began something, and did not say what.")
        return task_id

    async def find(self, prompt: str) -> str | None:
        """The newest task, if it is for that prompt and not yet over."""
        answer = await self.service.send("GET", f"{_PATH}?page_size=3&sort_by=-created_at")
        tasks = answer.json(self.service.name)
        for task in tasks if isinstance(tasks, list) else ():
            if (
                isinstance(task, dict)
                and task.get("prompt") == prompt[:MOST_PROMPT]
                and task.get("status") in ("PENDING", "IN_PROGRESS")
                and isinstance(task.get("id"), str)
            ):
                return str(task["id"])
        return None

    async def look(self, task_id: str) -> TaskState:
        """How far it is."""
        answer = await self.service.send("GET", f"{_PATH}/{quote(task_id, safe='')}")
        task = answer.json(self.service.name)
        state: Any = _STATES.get(task.get("status", "")) if isinstance(task, dict) else None
        if state is None:
            raise ServiceError(f"{self.service.name} sent no task.")
        error = task.get("task_error")
        said = str(error.get("message", "")) if isinstance(error, dict) else ""
        if state == "failed" and any(w in said.lower() for w in ("moderat", "policy", "harmful")):
            state = "declined"
        urls = task.get("model_urls")
        url = urls.get("glb") if isinstance(urls, dict) else None
        return TaskState(
            state=state,
            percent=_percent(task.get("progress")),
            model_url=url if isinstance(url, str) else "",
            said=" ".join(said.split()),
            retry_after_s=answer.retry_after_s,
        )

    async def cancel(self, task_id: str) -> None:
        """Delete it: Meshy has no other way to end one."""
        await self.service.send("DELETE", f"{_PATH}/{quote(task_id, safe='')}")


def _percent(value: object) -> int:
    return min(100, max(0, int(value))) if isinstance(value, int | float) else 0
