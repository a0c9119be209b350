"""The demonstration: a spoken wish, built by the emulated cell, judged by its world.

The emulated cell and the daemon run as processes of their own, as they would for anybody else; this
module is their visitor. It speaks, watches the status stream, and at the end compares what the plan
says with what the world says.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from cellctl.assembly import Cell, Role
from cellctl.cli.daemon_process import running_daemon, wait_idle
from cellctl.cli.following import follow_job
from cellctl.cli.kiosk_process import running_kiosk, with_own_page
from cellctl.client import CellClient
from cellctl.config import CellConfig
from cellctl.errors import CellctlError, ExitStatus
from cellctl.messages import Snapshot
from cellctl.sim.isolation import isolated
from cellctl.sim.messages import CellTruth
from cellctl.sim.spawn import emulated_cell
from cellctl.sim.world_values import Where

_REST_PATIENCE_S = 30.0
_LOOK_S = 0.05
_TIMES_HEARD_LATE = 5
"""So often the demonstration goes on where a busy computer lets the robot stop."""


@dataclass(frozen=True)
class Wish:
    """What the demonstration's visitor gives to the cell."""

    text: str | None
    """Typed or to be spoken; None when there is a recording."""
    wav: Path | None


def demonstrate(
    config: CellConfig, wish: Wish, console: Console, *, page: bool = False
) -> tuple[ExitStatus, dict[str, Any], CellTruth]:
    """Run the demonstration.

    Args:
        config: an emulated cell whose policy waives the confirmation.
        wish: what to ask for.
        console: where to show it.
        page: serve the page meanwhile, and wait with the wish until somebody has opened it.

    Returns:
        How it ended, the report, and the world's truth.
    """
    began_s = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        own = with_own_page(isolated(config, folder))
        wav = wish.wav if wish.wav is not None else _spoken(wish.text or "", folder, console)
        with (
            emulated_cell(own, own.cell.clock_rate) as world,
            running_daemon(own, folder) as daemon,
            CellClient.for_role(own, Role.VISITOR) as cell,
            CellClient.for_role(own) as operator,
            running_kiosk(own, folder) if page else nullcontext() as kiosk,
        ):
            try:
                wait_idle(cell, daemon)
                if kiosk is not None:
                    console.print(f"[green]{'page':<26}[/] {kiosk.url}")
                    console.input("Open it, then press Enter. ")
                cell.subscribe()
                reply = cell.hear(wav.name, wav.read_bytes())
                status = _see_through(cell, operator, reply.job_id, console)
                snapshot = cell.snapshot()
            except CellctlError:
                console.print(daemon.log_tail(), markup=False)
                raise
            truth = world.truth()
    report = make_report(snapshot, truth)
    report["wall_seconds"] = round(time.monotonic() - began_s, 1)
    report["speed"] = config.cell.clock_rate
    if status is ExitStatus.DONE and not (report["matches_plan"] and not report["violations"]):
        status = ExitStatus.DIFFERS
    report["exit_status"] = int(status)
    return status, report, truth


def _see_through(
    cell: CellClient, operator: CellClient, job_id: str, console: Console
) -> ExitStatus:
    """Show the job to its end; go on where the computer had no time for the arm."""
    status = follow_job(cell, job_id, console)
    for _ in range(_TIMES_HEARD_LATE):
        if not _was_heard_late(cell.snapshot()):
            break
        console.print(
            "[yellow]This computer was too busy: the robot did not hear it in time, and stopped. "
            "Going on, as an operator would.[/]"
        )
        _go_on(operator)
        while any(True for _ in cell.messages(0.0)):
            continue  # what was told before
        status = follow_job(cell, job_id, console)
    return status


def _was_heard_late(snapshot: Snapshot) -> bool:
    """Whether the emulated robot stopped because the arm process had no time to be heard."""
    entry = snapshot.fault.entry
    return entry is not None and entry.code == "program_stopped"


def _go_on(operator: CellClient) -> None:
    """Reset and resume.

    Raises:
        CellctlError: the cell does not, and says why.
    """
    operator.command("reset")
    deadline_s = time.monotonic() + _REST_PATIENCE_S
    while operator.snapshot().state.state != "paused_resting":
        if time.monotonic() > deadline_s:
            raise CellctlError("The cell does not come to rest after a reset.")
        time.sleep(_LOOK_S)
    operator.command("resume")


def make_report(snapshot: Snapshot, truth: CellTruth) -> dict[str, Any]:
    """What was asked, what was planned and what stands, for people and programs."""
    job, plan = snapshot.job, snapshot.plan
    planned = set(plan.assembly.cells) if plan is not None else set()
    fallen = truth.counts.get(Where.FALLEN, 0)
    seconds = [part.seconds for part in snapshot.parts]
    return {
        "heard": job.utterance.text if job is not None and job.utterance is not None else "",
        "recogniser": (
            job.utterance.recogniser if job is not None and job.utterance is not None else ""
        ),
        "understood": (
            job.request.model_dump(mode="json")
            if job is not None and job.request is not None
            else None
        ),
        "plan": plan.model_dump(mode="json") if plan is not None else None,
        "built": [list(cell) for cell in truth.built],
        "fallen": fallen,
        "matches_plan": plan is not None and set(truth.built) == planned and not fallen,
        "violations": [violation.model_dump(mode="json") for violation in truth.violations],
        "parts": len(truth.built),
        "seconds_per_part": round(sum(seconds) / len(seconds), 2) if seconds else None,
        "seconds_to_first_motion": _difference(job, "first_motion_s"),
        "seconds_total": _difference(job, "finished_s"),
        "state": snapshot.state.state,
        "outcome": job.outcome if job is not None else "",
        "message": job.message if job is not None else "",
        "fault": snapshot.fault.model_dump(mode="json") if snapshot.fault.entry else None,
    }


def _difference(job: Any, name: str) -> float | None:
    """Cell time from the end of speech to a moment of the job."""
    moment = getattr(job, name, None)
    if job is None or moment is None or job.end_of_speech_s is None:
        return None
    return round(float(moment) - float(job.end_of_speech_s), 2)


def _spoken(text: str, folder: Path, console: Console) -> Path:
    from cellctl.speaking.voices import speak_to_wav  # noqa: PLC0415 - optional part

    path = folder / "wish.wav"
    voice = speak_to_wav(text, path)
    console.print(f"[green]{'spoken':<26}[/] {text!r} by {voice}")
    return path


def write_report(report: dict[str, Any], path: Path) -> None:
    """Write the report as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


def draw(report: dict[str, Any], truth: CellTruth, config: CellConfig, path: Path) -> None:
    """Draw what stands in the world; parts that the plan does not know are red."""
    from cellctl.cli.picture import draw_assembly  # noqa: PLC0415 - optional part

    plan = report["plan"]
    planned = {Cell(*cell) for cell in plan["assembly"]["cells"]} if plan is not None else set()
    path.parent.mkdir(parents=True, exist_ok=True)
    seconds = report["seconds_per_part"]
    caption = f"{len(truth.built)} parts" + (f", {seconds:.1f} s a part" if seconds else "")
    draw_assembly(
        truth.built,
        config.grid,
        path,
        title=f"“{report['heard']}”",
        caption=caption,
        pitch_m=config.voxel.pitch_m,
        wrong=[cell for cell in truth.built if cell not in planned],
        missing=[cell for cell in planned if cell not in truth.built],
    )


def summarise(
    console: Console, report: dict[str, Any], picture: Path | None, file: Path | None
) -> None:
    """Say at the end what was asked, what was built, and whether it is right."""
    table = Table.grid(padding=(0, 2))
    plan, phrase = report["plan"], (report["understood"] or {}).get("phrase", "")
    table.add_row("[bold]asked[/]", repr(report["heard"]), f"understood: {phrase}")
    if plan is not None:
        edges = " x ".join(f"{n}" for n in _extent(plan["assembly"]["cells"]))
        table.add_row("[bold]planned[/]", f"{plan['title']}, {edges} cells")
        for change in plan["changes"]:
            table.add_row("", f"changed: {change['what']}", change["why"])
    if report["parts"]:
        table.add_row("[bold]built[/]", f"{report['parts']} parts")
        match = "is what was planned" if report["matches_plan"] else "[red]differs from the plan[/]"
        table.add_row("[bold]world[/]", f"what stands {match}")
    for violation in report["violations"]:
        table.add_row("[bold red]held against it[/]", violation["kind"], violation["message"])
    total = report["seconds_total"]
    if report["seconds_per_part"] is not None:
        table.add_row(
            "[bold]time[/]",
            f"{report['seconds_per_part']:.1f} s a part"
            + (f", {total:.0f} s in all" if total else ""),
            f"cell time; {report['wall_seconds']:.0f} s of yours",
        )
    fault = report["fault"]
    if fault is not None:
        table.add_row("[bold red]fault[/]", fault["entry"]["title"], fault["detail"])
    if report["message"]:
        table.add_row("[bold]says[/]", report["message"])
    if picture is not None:
        table.add_row("[bold]picture[/]", str(picture))
    if file is not None:
        table.add_row("[bold]report[/]", str(file))
    console.print()
    console.print(table)


def _extent(cells: Sequence[Sequence[int]]) -> list[int]:
    return [max(axis) - min(axis) + 1 for axis in zip(*cells, strict=True)] if cells else [0, 0, 0]
