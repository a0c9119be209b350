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
from cellctl.clock import SystemClock
from cellctl.config import BusSection, load_config
from cellctl.control.about import Present
from cellctl.control.archive import Archive
from cellctl.control.door import Answer
from cellctl.control.job import Job
from cellctl.control.possible import possible
from cellctl.control.recollection import Recollection
from cellctl.control.states import Event, decide
from cellctl.errors import CellctlError, RefusedError, UsageError
from cellctl.feeding.inventory import Counts
from cellctl.messages import (
    AboutData,
    AskCommand,
    BoardData,
    ControlReply,
    ControlRequest,
    ConveyorData,
    EarsData,
    FileCommand,
    FileData,
    FileKind,
    GripperData,
    HistoryCommand,
    HistoryData,
    Inquiry,
    JobCommand,
    JobRecordData,
    LimitsData,
    RefillCommand,
    ReplyData,
    ReplyError,
    SayCommand,
)
from tests.control.journals import CELLS, files, opened, place, record, tower
from tests.control.served import serving, settings
from tests.leaks import REPOSITORY

CONFIG = load_config(REPOSITORY / "config" / "sim.toml")


def archive_of(path: Path, job: Job | None) -> Archive:
    config = CONFIG.model_copy(
        update={"journal": CONFIG.journal.model_copy(update={"path": str(path)})}
    )
    return Archive(config, lambda: job, present, Recollection(SystemClock()))


def present() -> Present:
    return Present(
        identity=None,
        check=None,
        robot_connected=False,
        conveyor=ConveyorData(connected=True, board=BOARD),
        gripper=GripperData(holding="nothing"),
        ears=EarsData(state="off"),
        recogniser="vosk",
        counts=Counts(stock=2, belt=10, structure=3),
        standing=3,
        uptime_s=1.0,
    )


BOARD = BoardData(port="/dev/belt", serial_number="AF", protocol_version=1, firmware_version="1.2")


@asynccontextmanager
async def answering(folder: Path, job: Job | None) -> AsyncIterator[BusSection]:
    """A bus whose archive has a newest job, and whose journal has older ones."""
    path = folder / "journal.sqlite"
    new = not path.exists()
    async with opened(path) as journal:
        if new:
            journal.keep_job(record("oldest"))
            journal.keep_job(record("older"), files())
            await place(journal, CELLS[0], "older")
            await journal.flush()
        archive = archive_of(path, job)

        async def handle(request: ControlRequest, _: bytes | None, role: Role) -> Answer:
            assert isinstance(request.body, Inquiry)
            try:
                data, file = await archive.answer(request.body, role)
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
        archive = archive_of(tmp_path / "none", job)
        parts = []
        for height in (4, 4, 5):
            job.plan = tower(height)
            _, frame = await archive.answer(FileCommand(kind="plan"), Role.VISITOR)
            assert frame is not None
            parts.append(BuildPlan.model_validate_json(frame.bytes).parts)
        return parts

    assert asyncio.run(exercise()) == [4, 4, 5]


def told(folder: Path, question: Inquiry) -> ReplyData:
    async def exercise() -> ControlReply:
        async with answering(folder, None) as own:
            with CellClient(own.operator, own.status) as client:
                return await asyncio.to_thread(client.request, question)

    data = asyncio.run(exercise()).data
    assert data is not None
    return data


def test_history_comes_in_pages(tmp_path: Path) -> None:
    first = told(tmp_path, HistoryCommand(limit=1))
    assert isinstance(first, HistoryData)
    assert first.total == 2
    assert [(job.job_id, job.title, job.steps) for job in first.jobs] == [("older", "tower", 3)]
    second = told(tmp_path, HistoryCommand(limit=1, before=first.next_before))
    assert isinstance(second, HistoryData)
    assert [job.job_id for job in second.jobs] == ["oldest"]
    assert second.next_before is None


def test_a_job_is_told_with_what_a_replay_needs(tmp_path: Path) -> None:
    found = told(tmp_path, JobCommand(job_id="older"))
    assert isinstance(found, JobRecordData)
    assert found.plan == tower(3)
    assert found.has_mesh
    assert [(act.kind, act.outcome, act.moves) for act in found.acts] == [
        ("pick", "done", ("pick",)),
        ("place", "done", ()),
        ("release", "done", ("place",)),
    ]


def test_limits_say_what_is_in_force(tmp_path: Path) -> None:
    found = told(tmp_path, AskCommand(command="limits"))
    assert isinstance(found, LimitsData)
    rows = {row.option: (row.configured, row.in_force) for row in found.limits}
    expected: dict[str, tuple[object, object]] = {
        "limits.inventory_parts": (CONFIG.limits.inventory_parts, 15),
        "policy.confirmation": ("ask", None),
        "tool.payload_kg": (CONFIG.tool.payload_kg, None),
    }
    assert {name: rows[name] for name in expected} == expected


def test_devices_and_versions(tmp_path: Path) -> None:
    found = told(tmp_path, AskCommand(command="about"))
    assert isinstance(found, AboutData)
    devices = {device.name: device for device in found.devices}
    assert not devices["robot"].connected
    assert (devices["conveyor"].serial_number, devices["conveyor"].version) == ("AF", "1.2")
    assert found.packages["pyzmq"]


def test_the_audit_keeps_commands_and_not_what_was_said() -> None:
    recollection = Recollection(SystemClock())
    for body in (
        SayCommand(text="my secret"),
        RefillCommand(parts=3),
        AskCommand(command="log"),
    ):
        recollection.commanded(body, Role.OPERATOR, ok=True, message="Done.")
    kept = [(entry.command, entry.detail) for entry in recollection.audit().entries]
    assert kept == [
        ("say", ""),
        ("refill", "parts=3"),
    ]


def test_visitors_cannot_have_it_forgotten_what_an_operator_did() -> None:
    recollection = Recollection(SystemClock())
    recollection.commanded(RefillCommand(parts=3), Role.OPERATOR, ok=True, message="")
    for _ in range(1000):
        recollection.commanded(SayCommand(text="hello"), Role.VISITOR, ok=True, message="")
    entries = recollection.audit().entries
    assert len(entries) < 1000
    assert entries[0].command == "refill"


@pytest.mark.parametrize(
    "state", ["idle", "feeding_indexing", "paused_resting", "paused_moving", "fault_held"]
)
def test_what_is_possible_is_what_the_machine_takes(state: str) -> None:
    ways = {"reset": Event.RESET, "hand": Event.HAND, "cancel": Event.CANCEL, "own": Event.BOOK}
    for command, event in ways.items():
        assert (command in possible(state)) is (decide(state, event).verdict == "accepted")
    assert "stop" in possible(state)
