"""What the daemon costs and how quick it is: ``python -m benchmarks.daemon [--speed N]``.

Runs one emulated cell and one daemon as processes of their own, and prints a table: processor and
memory of the idle daemon with its processes, the wall time from the end of speech to the first
motion, how long the control loop was blocked, and the time that a stool of 30 parts takes.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

from cellctl.cli.daemon_process import running_daemon, wait_idle
from cellctl.client import CellClient
from cellctl.config import CellConfig, load_config
from cellctl.messages import Snapshot
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from cellctl.speaking.voices import speak_to_wav

CONFIG = Path(__file__).parents[1] / "config" / "sim.toml"
IDLE_S = 20.0
WISH = "I want a simple stool"
_PATIENCE_S = 1200.0


@contextmanager
def cell(speed: float) -> Iterator[tuple[CellClient, psutil.Process, Path]]:
    """A running cell that builds without asking."""
    base = load_config(CONFIG)
    policy = base.policy.model_copy(update={"confirmation": "waived"})
    config: CellConfig = base.model_copy(update={"policy": policy})
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        own = isolated(config, Path(name), speed)
        with (
            emulated_cell(own, speed),
            running_daemon(own, Path(name)) as daemon,
            CellClient.for_role(own) as client,
        ):
            wait_idle(client, daemon)
            yield client, psutil.Process(daemon.process.pid), Path(name)


def family(process: psutil.Process) -> dict[str, list[psutil.Process]]:
    """The daemon's processes by what they are for."""
    groups: dict[str, list[psutil.Process]] = {"daemon": [process]}
    for child in process.children(recursive=True):
        command = " ".join(child.cmdline())
        kind = "arm process" if "arm_worker" in command else "recogniser and planner"
        groups.setdefault(kind, []).append(child)
    return groups


def idle_rows(process: psutil.Process) -> list[tuple[str, str]]:
    """Processor and memory of an idle daemon."""
    rows = []
    groups = family(process)
    before = {kind: sum(_cpu_s(p) for p in group) for kind, group in groups.items()}
    time.sleep(IDLE_S)
    for kind, group in groups.items():
        percent = (sum(_cpu_s(p) for p in group) - before[kind]) / IDLE_S * 100
        megabytes = sum(p.memory_full_info().pss for p in group) / 1e6
        rows.append((f"idle {kind}", f"{percent:.1f} % of a core, {megabytes:.0f} MB"))
    return rows


def _cpu_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def build(client: CellClient, folder: Path) -> tuple[Snapshot, float]:
    """Speak the wish and wait until it stands; the last snapshot and the wall time."""
    speak_to_wav(WISH, folder / "wish.wav")
    began_s = time.monotonic()
    client.subscribe()
    client.hear("wish.wav", (folder / "wish.wav").read_bytes())
    for message in client.messages(15.0):
        if message.topic in {"job", "fault"}:
            snapshot = client.snapshot()
            if snapshot.job is not None and (snapshot.job.outcome or snapshot.fault.entry):
                return snapshot, time.monotonic() - began_s
        if time.monotonic() - began_s > _PATIENCE_S:
            break
    raise SystemExit("The stool was not finished.")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--speed", type=float, default=10.0, help="cell seconds per second")
    speed = parser.parse_args().speed
    with cell(speed) as (client, process, folder):
        rows = idle_rows(process)
        snapshot, wall_s = build(client, folder)
    job = snapshot.job
    assert job is not None
    if job.outcome != "built":
        fault = snapshot.fault
        reason = f"{fault.entry.code}: {fault.detail}" if fault.entry else job.message
        raise SystemExit(f"Not built: {reason}")
    assert job.first_motion_s is not None
    assert job.end_of_speech_s is not None
    seconds = [part.seconds for part in snapshot.parts]
    first_s = (job.first_motion_s - job.end_of_speech_s) / speed
    blocked = snapshot.health
    rows += [
        ("end of speech to first motion", f"{first_s:.1f} s of wall time"),
        (
            "control loop blocked, p99 of the last minute",
            f"{blocked.loop_blocked_p99_s * 1e3:.1f} ms, "
            f"worst {blocked.loop_blocked_max_s * 1e3:.0f} ms",
        ),
        (f"stool of {len(seconds)} parts at {speed:g}x", f"{wall_s:.0f} s of wall time"),
        ("time a part, mean", f"{sum(seconds) / len(seconds):.2f} s of cell time"),
    ]
    for name, value in rows:
        print(f"{name:<48} {value}")  # noqa: T201 - this is what it is for


if __name__ == "__main__":
    main()
