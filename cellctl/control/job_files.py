"""The files of a job, as they are given away: GLB to look at, JSON to build again."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import PurePath
from typing import TYPE_CHECKING, Final

from cellctl.drawing.glb import MEDIA_TYPE, mesh_glb
from cellctl.drawing.plan_glb import steps_glb
from cellctl.errors import UsageError
from cellctl.messages import MAX_ATTACHMENT, FileData, FileKind

if TYPE_CHECKING:
    from cellctl.assembly import BuildPlan
    from cellctl.mesh import GeneratedMesh

_MISSING: Final[dict[FileKind, str]] = {
    "mesh": "has no mesh: it was not designed yet, or began with a file.",
    "plan": "has no plan.",
    "steps": "has no plan.",
    "upload": "did not begin with a file.",
}


@dataclass(frozen=True, eq=False)
class Source:
    """What the files of a job are made from."""

    job_id: str
    mesh: GeneratedMesh | None
    plan: BuildPlan | None
    upload_name: str
    upload: bytes | None

    def of(self, kind: FileKind) -> object:
        """What a kind of file is made from; None where there is no such file."""
        return {"mesh": self.mesh, "upload": self.upload}.get(kind, self.plan)


def packed(source: Source, kind: FileKind) -> tuple[FileData, bytes]:
    """One file of a job.

    Raises:
        UsageError: it has no such file, or one that is too large to be sent.
    """
    if source.of(kind) is None:
        raise UsageError(f"Job {source.job_id} {_MISSING[kind]}")
    content = _content(source, kind)
    if len(content) > MAX_ATTACHMENT:
        raise UsageError(
            f"The {kind} of job {source.job_id} has {len(content) / 1e6:.0f} MB; "
            f"{MAX_ATTACHMENT / 1e6:.0f} MB are sent at most.",
            "`cellctl history` reads it from the journal's file.",
        )
    name, media_type = _name(source, kind)
    data = FileData(
        job_id=source.job_id,
        kind=kind,
        name=name,
        media_type=media_type,
        size_bytes=len(content),
        sha256=hashlib.sha256(content).hexdigest(),
    )
    return data, content


def _content(source: Source, kind: FileKind) -> bytes:
    match kind:
        case "mesh":
            assert source.mesh is not None
            return mesh_glb(source.mesh)
        case "upload":
            assert source.upload is not None
            return source.upload
        case "steps":
            assert source.plan is not None
            return steps_glb(source.plan)
        case "plan":
            assert source.plan is not None
            return source.plan.model_dump_json().encode()


def _name(source: Source, kind: FileKind) -> tuple[str, str]:
    """A file's name and media type."""
    if kind == "upload":
        # Whoever sent it chose the name; where it is saved, it must not lead elsewhere.
        return PurePath(source.upload_name).name or "upload", "application/octet-stream"
    title = source.plan.title if source.plan is not None else ""
    if not title and source.mesh is not None:
        title = source.mesh.title
    stem = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")[:60] or "object"
    if kind == "plan":
        return f"{stem}-{source.job_id}.json", "application/json"
    return f"{stem}-{kind}-{source.job_id}.glb", MEDIA_TYPE
