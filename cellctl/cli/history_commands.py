"""``cellctl history``: what was built, act by act, and plans and meshes to build again.

It reads the journal's file, beside a running daemon or without one.
"""

from __future__ import annotations

import json as json_module
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from cellctl.cli.options import ConfigOption, JsonOption, configuration
from cellctl.errors import UsageError

if TYPE_CHECKING:
    from cellctl.control.acts import Act
    from cellctl.control.journal_reader import StoredJob

MESH_SUFFIXES = (".glb", ".obj", ".ply", ".stl")


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def history(
        job: Annotated[
            str | None, typer.Argument(help="Show this job, with its acts; else all jobs.")
        ] = None,
        limit: Annotated[int, typer.Option(min=1, help="So many jobs at most.")] = 20,
        save_plan: Annotated[
            Path | None, typer.Option(help="Write the job's plan (JSON) for `cellctl build`.")
        ] = None,
        save_mesh: Annotated[
            Path | None, typer.Option(help="Write its mesh (glb, obj, ply, stl) likewise.")
        ] = None,
        config: ConfigOption = None,
        json: JsonOption = False,
    ) -> None:
        """Show the jobs, newest first, or one job with all that the cell did for it."""
        from cellctl.control.journal_reader import JournalReader  # noqa: PLC0415 - heavy

        if job is None and (save_plan is not None or save_mesh is not None):
            raise UsageError("Name the job whose plan or mesh shall be written.")
        with JournalReader(Path(configuration(config).journal.path)) as journal:
            if job is None:
                jobs = journal.jobs(limit)
                if json:
                    typer.echo(json_module.dumps([_summary(stored) for stored in jobs], indent=2))
                else:
                    _show_jobs(jobs)
                return
            stored, acts = journal.job(job), journal.acts(job)
        if save_plan is not None:
            _save_plan(stored, save_plan)
        if save_mesh is not None:
            _save_mesh(stored, save_mesh)
        if json:
            listed = [act.model_dump(mode="json") for act in acts]
            typer.echo(json_module.dumps({**_summary(stored), "acts": listed}, indent=2))
        else:
            _show_job(stored, acts)


def _what(stored: StoredJob) -> str:
    record = stored.record
    if record.utterance is not None:
        return f'"{record.utterance.text}"'
    return record.upload_name or "(no words were heard)"


def _summary(stored: StoredJob) -> dict[str, Any]:
    record = stored.record
    return {
        **record.model_dump(mode="json", exclude={"plan"}),
        "what": _what(stored),
        "title": record.plan.title if record.plan is not None else "",
        "plan_id": record.plan.plan_id if record.plan is not None else "",
        "parts_placed": len(record.parts),
        "parts_total": record.plan.parts if record.plan is not None else 0,
        "seconds": round(sum(part.seconds for part in record.parts), 3),
        "cellctl_version": stored.cellctl_version,
        "config_sha256": stored.config_sha256,
    }


def _outcome(stored: StoredJob) -> str:
    return stored.record.outcome or f"open ({stored.record.phase})"


def _parts(stored: StoredJob) -> str:
    plan = stored.record.plan
    return f"{len(stored.record.parts)} of {plan.parts}" if plan is not None else ""


def _time(stored: StoredJob) -> str:
    seconds = sum(part.seconds for part in stored.record.parts)
    return f"{seconds:.0f} s" if seconds else ""


def _when(time: datetime) -> str:
    return f"{time.astimezone():%Y-%m-%d %H:%M:%S}"


def _show_jobs(jobs: tuple[StoredJob, ...]) -> None:
    if not jobs:
        typer.echo("Nothing was built yet.")
        return
    table = Table("job", "when", "what", "outcome", "parts", "time", box=None, pad_edge=False)
    for stored in jobs:
        record = stored.record
        table.add_row(
            *(record.job_id, _when(record.began_at), _what(stored)),
            *(_outcome(stored), _parts(stored), _time(stored)),
        )
    Console(highlight=False, markup=False).print(table)


def _show_job(stored: StoredJob, acts: tuple[Act, ...]) -> None:
    record = stored.record
    console = Console(highlight=False, markup=False, soft_wrap=True)
    console.print(f"{_what(stored)} by the {record.role.value}: {_outcome(stored)}")
    if record.message:
        console.print(record.message)
    ended = _when(record.finished_at) if record.finished_at is not None else "now"
    console.print(f"from {_when(record.began_at)} to {ended}, {_parts(stored) or 'no'} parts")
    if record.plan is not None:
        console.print(f"plan {record.plan.plan_id}: {record.plan.title}")
    if stored.config_sha256:
        settings = f"settings {stored.config_sha256[:12]}"
        console.print(f"by cellctl {stored.cellctl_version} with {settings}")
    for act in acts:
        console.print(_act_line(act))


def _act_line(act: Act) -> str:
    where = f" part {act.step + 1}" if act.step is not None else ""
    where += f" at {list(act.cell)}" if act.cell is not None else ""
    parts = f" ({', '.join(move.value for move in act.moves)})" if act.moves else ""
    took = ""
    if act.settled_at is not None:
        seconds = (act.settled_at - act.intended_at).total_seconds()
        took = f" in {seconds:.1f} s" if seconds > 0 else ""  # calendar time may jump
    outcome = act.outcome or "no outcome is known"
    detail = f": {act.detail}" if act.detail else ""
    line = f"{_when(act.intended_at)} {act.act_id:>6} {act.kind.value}{where}"
    return f"  {line}: {outcome}{took}{parts}{detail}"


def _save_plan(stored: StoredJob, path: Path) -> None:
    plan = stored.record.plan
    if plan is None:
        raise UsageError(f"Job {stored.record.job_id} has no plan.")
    _write(path, plan.model_dump_json(indent=2).encode() + b"\n")


def _save_mesh(stored: StoredJob, path: Path) -> None:
    record, files = stored.record, stored.files
    suffix = path.suffix.lower()
    if files.upload is not None and Path(record.upload_name).suffix.lower() == suffix:
        _write(path, files.upload)
        return
    if files.mesh is None:
        raise UsageError(f"Job {record.job_id} has no mesh.")
    if suffix not in MESH_SUFFIXES:
        raise UsageError(
            f"{path}: not a kind of mesh file.", f"Use one of {', '.join(MESH_SUFFIXES)}."
        )
    mesh = files.mesh.mesh
    if suffix == ".glb":  # its y points up
        mesh.vertices = mesh.vertices[:, [0, 2, 1]] * np.array([1.0, 1.0, -1.0])
    content = mesh.export(file_type=suffix[1:])
    assert isinstance(content, str | bytes), "one file, not a bundle"
    _write(path, content.encode() if isinstance(content, str) else content)


def _write(path: Path, content: bytes) -> None:
    try:
        path.write_bytes(content)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}.") from error
