"""A machine of one's own with a GPU: POST a prompt, get a GLB.

``POST {url}`` with ``{"prompt": "a dog"}`` answers, as soon as it is done, with the model's bytes
(``model/gltf-binary``), or with an error status and ``{"message": ...}``.
"""

from __future__ import annotations

from cellctl.generating.remote.glb import check_glb
from cellctl.generating.remote.http import Service
from cellctl.generating.remote.tasks import Progress

KEY = "server-key"


async def ask_server(
    service: Service, prompt: str, progress: Progress, *, timeout_s: float, most_bytes: int
) -> bytes:
    """Have a model made.

    Raises:
        ServiceError: it refuses, fails, or takes too long.
        DesignError: what it sent is no GLB.
    """
    progress(f"{service.name} works on it.")
    answer = await service.send(
        "POST", "", {"prompt": prompt}, timeout_s=timeout_s, most_bytes=most_bytes
    )
    check_glb(answer.content, service.name)
    return answer.content
