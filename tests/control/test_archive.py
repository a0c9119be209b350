"""What can be asked of jobs, at both doors, and from memory as from the journal."""

from __future__ import annotations

import asyncio
import io
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest
import trimesh

from cellctl.assembly import BuildPlan, Role
from cellctl.client import CellClient
from cellctl.config import BusSection
from cellctl.control.archive import Archive
from cellctl.control.door import Answer
from cellctl.control.job import Job
from cellctl.errors import CellctlError, RefusedError, UsageError
from cellctl.messages import (
    ControlReply,
    ControlRequest,
    FileCommand,
    FileData,
    FileKind,
    ReplyError,
)
from tests.control.journals import files, opened, record, tower
from tests.control.served import serving, settings


@asynccontextmanager
async def answering(folder: Path, job: Job | None) -> AsyncIterator[BusSection]:
    """A bus whose archive has a newest job, and whose journal has an older one."""
    path = folder / "journal.sqlite"
    async with opened(path) as journal:
        journal.keep_job(record("older"), files())
        await journal.flush()
        archive = Archive(lambda: job, path)

        async def handle(request: ControlRequest, _: bytes | None, role: Role) -> Answer:
            assert isinstance(request.body, FileCommand)
            try:
                data, file = await archive.file(request.body, role)
            except CellctlError as error:
                why = ReplyError.of(error)
                return Answer(ControlReply(id=request.id, ok=False, state="idle", error=why))
            return Answer(ControlReply(id=request.id, ok=True, state="idle", data=data), file)

        own = settings(folder)
        async with serving(own, handle):
            yield own


def newest() -> Job:
    found = files(seed=2)
    job = Job(Role.VISITOR, job_id="newest", generated=found.mesh, plan=tower(4))
    job.upload_name, job.upload = "../../stool.obj", found.upload
    return job


def asked(
    folder: Path, job: Job | None, role: Role, kind: FileKind, job_id: str = ""
) -> tuple[str, str, bytes]:
    """A file's name, media type and content."""

    async def exercise() -> tuple[FileData, bytes]:
        async with answering(folder, job) as own:
            with CellClient(own.door(role), own.status) as client:
                return await asyncio.to_thread(client.file, kind, job_id)

    data, content = asyncio.run(exercise())
    assert data.size_bytes == len(content)
    return data.name, data.media_type, content


def loaded(content: bytes) -> trimesh.Trimesh:
    scene = trimesh.load_scene(io.BytesIO(content), file_type="glb", process=False)
    (mesh,) = scene.geometry.values()
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


@pytest.mark.parametrize("role", list(Role))
def test_everybody_gets_the_files_of_the_newest_job(tmp_path: Path, role: Role) -> None:
    name, media_type, content = asked(tmp_path, newest(), role, "plan")
    assert (name, media_type) == ("tower-newest.json", "application/json")
    assert BuildPlan.model_validate_json(content) == tower(4)

    name, media_type, content = asked(tmp_path, newest(), role, "mesh", "newest")
    assert (name, media_type) == ("tower-mesh-newest.glb", "model/gltf-binary")
    mesh, made = files(seed=2).mesh, loaded(content)
    assert mesh is not None
    assert np.array_equal(made.faces, mesh.faces)
    assert np.allclose(made.vertices[:, [0, 2, 1]] * [1, -1, 1], mesh.vertices, atol=1e-6)

    _, _, content = asked(tmp_path, newest(), role, "steps")
    scene = trimesh.load_scene(io.BytesIO(content), file_type="glb")
    assert len(scene.graph.nodes_geometry) == 4


def test_an_upload_comes_back_as_it_was_and_its_name_leads_nowhere(tmp_path: Path) -> None:
    name, _, content = asked(tmp_path, newest(), Role.OPERATOR, "upload")
    assert name == "stool.obj"
    assert content == files(seed=2).upload


def test_older_jobs_are_the_operators(tmp_path: Path) -> None:
    _, _, content = asked(tmp_path, newest(), Role.OPERATOR, "plan", "older")
    assert BuildPlan.model_validate_json(content) == tower(3)
    with pytest.raises(RefusedError, match="need the operator"):
        asked(tmp_path, newest(), Role.VISITOR, "plan", "older")


@pytest.mark.parametrize(
    ("job", "kind", "job_id", "says"),
    [
        (None, "plan", "", "There was no job"),
        (None, "plan", "nobody's", "There is no job nobody's"),
        (Job(Role.VISITOR), "mesh", "", "has no mesh"),
        (Job(Role.VISITOR), "plan", "", "has no plan"),
        (Job(Role.VISITOR), "upload", "", "did not begin with a file"),
    ],
)
def test_what_is_not_there_is_told(
    tmp_path: Path, job: Job | None, kind: FileKind, job_id: str, says: str
) -> None:
    with pytest.raises(UsageError, match=says):
        asked(tmp_path, job, Role.OPERATOR, kind, job_id)


def test_a_new_plan_of_the_same_job_is_a_new_file(tmp_path: Path) -> None:
    async def exercise() -> list[int]:
        job = newest()
        archive = Archive(lambda: job, tmp_path / "none")
        parts = []
        for height in (4, 4, 5):
            job.plan = tower(height)
            _, frame = await archive.file(FileCommand(kind="plan"), Role.VISITOR)
            parts.append(BuildPlan.model_validate_json(frame.bytes).parts)
        return parts

    assert asyncio.run(exercise()) == [4, 4, 5]
