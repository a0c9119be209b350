"""Acts, ledgers and jobs as rows of the journal's tables, and back, with their checksums."""

from __future__ import annotations

import hashlib
import io
import json
import zlib
from dataclasses import dataclass
from datetime import datetime
from typing import Any, TypeVar

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cellctl.assembly import BuildPlan, Change, Value
from cellctl.control.acts import Act, JobFiles, JobRecord
from cellctl.control.ledger import Ledger
from cellctl.mesh import GeneratedMesh

Row = tuple[Any, ...]
T = TypeVar("T", bound=Value)

PLAN, MESH, UPLOAD = "plan", "mesh", "upload"
"""Kinds of files of a job."""

_CHANGES = TypeAdapter(tuple[Change, ...])


class RowError(Exception):
    """A row that was not written so."""


def _crc(*parts: object) -> int:
    return zlib.crc32("\n".join(map(str, parts)).encode())


def _parsed(kind: type[T], body: str, what: str) -> T:
    try:
        return kind.model_validate_json(body)
    except ValidationError as error:
        raise RowError(f"{what} cannot be read ({error.errors()[0]['msg']})") from error


ACT_COLUMNS = "act_id, settled_order, job_id, intended_unix_s, body, crc"


def act_row(act: Act, settled_order: int | None) -> Row:
    """An act as ``ACT_COLUMNS``."""
    assert (act.outcome is None) == (settled_order is None), "what is settled has an order"
    body = act.model_dump_json(exclude_defaults=True)
    unix_s = act.intended_at.timestamp()
    return (act.act_id, settled_order, act.job_id, unix_s, body, _crc(settled_order, body))


def act_of(row: Row) -> tuple[Act, int | None]:
    """An act and its place in the order of outcomes.

    Raises:
        RowError: the row is damaged.
    """
    act_id, settled_order, job_id, _, body, crc = row
    if _crc(settled_order, body) != crc:
        raise RowError(f"the checksum of act {act_id} is wrong")
    act = _parsed(Act, body, f"act {act_id}")
    if (
        act.act_id != act_id
        or act.job_id != job_id
        or (act.outcome is None) != (settled_order is None)
    ):
        raise RowError(f"act {act_id} contradicts itself")
    return act, settled_order


CHECKPOINT_COLUMNS = "settled_order, act_id, made_at, ledger, crc"


def checkpoint_row(settled_order: int, act_id: int, made_at: datetime, ledger: Ledger) -> Row:
    """A ledger as ``CHECKPOINT_COLUMNS``."""
    body = ledger.model_dump_json()
    return (settled_order, act_id, made_at.isoformat(), body, _crc(settled_order, act_id, body))


def checkpoint_of(row: Row) -> tuple[int, int, Ledger]:
    """Order of the newest act that it knows of, the highest act's id, and the ledger.

    Raises:
        RowError: the row is damaged.
    """
    settled_order, act_id, _, body, crc = row
    if _crc(settled_order, act_id, body) != crc:
        raise RowError("the checksum of the inventory is wrong")
    return settled_order, act_id, _parsed(Ledger, body, "the inventory")


JOB_COLUMNS = "job_id, finished_unix_s, body, crc"


def job_row(record: JobRecord) -> Row:
    """A job as ``JOB_COLUMNS``; its plan is a file."""
    body = record.model_dump_json(exclude={"plan"})
    finished_s = record.finished_at.timestamp() if record.finished_at is not None else None
    return (record.job_id, finished_s, body, _crc(body))


def job_of(row: Row) -> JobRecord:
    """A job, without its plan.

    Raises:
        RowError: the row is damaged.
    """
    job_id, finished_s, body, crc = row
    if _crc(body) != crc:
        raise RowError(f"the checksum of job {job_id} is wrong")
    record = _parsed(JobRecord, body, f"job {job_id}")
    if record.job_id != job_id or (record.finished_at is None) != (finished_s is None):
        raise RowError(f"job {job_id} contradicts itself")
    return record


@dataclass(frozen=True)
class StoredFile:
    """One file of a job."""

    kind: str
    content: bytes
    sha256: str

    @classmethod
    def of(cls, kind: str, content: bytes) -> StoredFile:
        """With its checksum."""
        return cls(kind, content, hashlib.sha256(content).hexdigest())

    def checked(self) -> bytes:
        """The content.

        Raises:
            RowError: it is not what was written.
        """
        if hashlib.sha256(self.content).hexdigest() != self.sha256:
            raise RowError(f"the checksum of a {self.kind} is wrong")
        return self.content


def plan_file(plan: BuildPlan) -> StoredFile:
    """A plan as canonical JSON: sorted keys, no spaces."""
    data = plan.model_dump(mode="json")
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return StoredFile.of(PLAN, text.encode())


def plan_of(file: StoredFile) -> BuildPlan:
    """The plan.

    Raises:
        RowError: the file is damaged.
    """
    return _parsed(BuildPlan, file.checked().decode(), "a plan")


def job_files(files: JobFiles) -> tuple[StoredFile, ...]:
    """The large parts of a job."""
    found = []
    if files.mesh is not None:
        found.append(StoredFile.of(MESH, _packed(files.mesh)))
    if files.upload is not None:
        found.append(StoredFile.of(UPLOAD, files.upload))
    return tuple(found)


def files_of(stored: dict[str, StoredFile]) -> JobFiles:
    """The large parts of a job.

    Raises:
        RowError: one of them is damaged.
    """
    mesh, upload = stored.get(MESH), stored.get(UPLOAD)
    return JobFiles(
        mesh=_unpacked(mesh.checked()) if mesh is not None else None,
        upload=upload.checked() if upload is not None else None,
    )


def _packed(mesh: GeneratedMesh) -> bytes:
    words = {
        "metric": mesh.metric,
        "title": mesh.title,
        "provenance": mesh.provenance,
        "stated_dimensions_m": mesh.stated_dimensions_m,
        "changes": _CHANGES.dump_python(mesh.changes, mode="json"),
    }
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        vertices=mesh.vertices,
        faces=mesh.faces,
        words=np.frombuffer(json.dumps(words).encode(), dtype=np.uint8),
    )
    return buffer.getvalue()


def _unpacked(content: bytes) -> GeneratedMesh:
    with np.load(io.BytesIO(content), allow_pickle=False) as data:
        words = json.loads(data["words"].tobytes())
        return GeneratedMesh(
            vertices=data["vertices"],
            faces=data["faces"],
            metric=words["metric"],
            title=words["title"],
            provenance=words["provenance"],
            stated_dimensions_m=words["stated_dimensions_m"],
            changes=_CHANGES.validate_python(words["changes"]),
        )
