"""The command line as a person types it: what it prints, and the status it ends with."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest
import tomli_w

from cellctl.assembly import BuildPlan
from cellctl.cli.plan_report import PlanReport
from cellctl.config import CellConfig, load_config
from tests.cell.harness import CONFIG, running_cell
from tests.firmware.loop.bench import compile_programs

TIMEOUT_S = 240.0


def cellctl(*arguments: str, config: Path | None = CONFIG) -> subprocess.CompletedProcess[str]:
    """Run the command with a configuration in its environment."""
    environment = {k: v for k, v in os.environ.items() if k != "CELLCTL_CONFIG"}
    if config is not None:
        environment["CELLCTL_CONFIG"] = str(config)
    return subprocess.run(
        [sys.executable, "-m", "cellctl", *arguments],
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        env=environment,
        check=False,
    )


def changed_config(folder: Path, **sections: dict[str, Any]) -> Path:
    """The emulated cell's configuration with some settings changed, as a file."""
    base = load_config(CONFIG)
    updates = {
        name: getattr(base, name).model_copy(update=values) for name, values in sections.items()
    }
    path = folder / "cell.toml"
    data = base.model_copy(update=updates).model_dump(exclude_none=True)
    path.write_text(tomli_w.dumps(CellConfig.model_validate(data).model_dump(exclude_none=True)))
    return path


def test_help_names_every_command() -> None:
    done = cellctl("--help")
    assert done.returncode == 0
    for command in (
        *("run", "sim", "demo", "plan", "say", "build", "status", "watch"),
        *("pause", "resume", "stop", "cancel", "reset", "config"),
    ):
        assert f" {command} " in done.stdout


def test_a_wrong_option_is_a_usage_error() -> None:
    done = cellctl("status", "--confog", "x")
    assert done.returncode == 2
    assert "--confog" in done.stderr


def test_config_check_says_right_or_what_is_wrong(tmp_path: Path) -> None:
    done = cellctl("config", "check", str(CONFIG))
    assert done.returncode == 0
    assert "right" in done.stdout
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(CONFIG.read_text().replace("pitch_m", "pich_m"))
    done = cellctl("config", "check", str(wrong))
    assert done.returncode == 2
    assert "voxel.pich_m: unknown key; did you mean voxel.pitch_m?" in done.stderr
    assert str(wrong) in done.stderr


def test_without_a_configuration_nothing_is_assumed() -> None:
    done = cellctl("run", config=None)
    assert done.returncode == 2
    assert "$CELLCTL_CONFIG is not set" in done.stderr


def test_plan_prints_a_plan_that_can_be_read_back(tmp_path: Path) -> None:
    file = tmp_path / "plan.json"
    done = cellctl("plan", "the letter T", "--plan", str(file))
    assert done.returncode == 0
    assert "letter T: 7 parts" in done.stdout
    done = cellctl("plan", str(file), "--json", "-")
    assert done.returncode == 0
    report = PlanReport.model_validate_json(done.stdout)
    plan = BuildPlan.model_validate_json(file.read_text())
    assert [step.cell for step in report.placements] == [step.cell for step in plan.steps]


@pytest.mark.parametrize(
    ("wish", "status", "says"),
    [
        ("create beauty", 3, "beauty"),
        ("a dragon", 4, "cannot design a dragon yet"),
        ("missing.stl", 2, "no such file"),
    ],
)
def test_plan_says_why_not(wish: str, status: int, says: str) -> None:
    done = cellctl("plan", wish)
    assert done.returncode == status
    assert says in done.stderr
    assert "Traceback" not in done.stderr


def test_a_command_without_a_daemon_says_what_to_do(tmp_path: Path) -> None:
    bus = {name: f"ipc://{tmp_path}/{name}" for name in ("status", "visitor", "operator")}
    done = cellctl("stop", config=changed_config(tmp_path, bus=bus))
    assert done.returncode == 1
    assert "No cell answers" in done.stderr
    assert "cellctl run" in done.stderr


def demo(*arguments: str, config: Path = CONFIG) -> tuple[int, dict[str, Any], str]:
    """Run the demonstration; its status, its report and what it printed."""
    report = config.parent / "report.json" if config != CONFIG else None
    if report is None:
        raise AssertionError("give the demonstration a folder of its own")
    done = cellctl("demo", "--speed", "10", "--report", str(report), *arguments, config=config)
    assert "Traceback" not in done.stderr
    return done.returncode, json.loads(report.read_text()), done.stdout


@pytest.mark.wire
def test_a_demonstration_tells_what_was_heard_planned_and_built(tmp_path: Path) -> None:
    picture = tmp_path / "t.png"
    status, report, said = demo(
        "--say", "the letter T", "--picture", str(picture), config=changed_config(tmp_path)
    )
    assert status == 0, said
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert report["heard"].lower().startswith("the letter t")
    assert report["understood"]["attributes"]["glyph"] == "T"
    assert sorted(report["built"]) == sorted(report["plan"]["assembly"]["cells"])
    assert report["matches_plan"] is True
    assert report["violations"] == []
    assert report["seconds_per_part"] > 0
    assert report["state"] == "idle"
    assert "waived" in said
    assert "part   7 of 7" in said


@pytest.mark.soak
@pytest.mark.wire
def test_a_demonstration_goes_on_where_the_robot_did_not_hear_it_in_time(tmp_path: Path) -> None:
    config = changed_config(tmp_path)
    with begun(config, "demo", "--speed", "5", "--say", "the letter T") as running:
        assert running.stdout is not None
        said = ""
        while "part   2 of 7" not in said:
            line = running.stdout.readline()
            assert line, said
            said += line
        (arm,) = (
            process
            for process in psutil.Process(running.pid).children(recursive=True)
            if "cellctl.assembling.arm_worker" in process.cmdline()
        )
        arm.suspend()
        time.sleep(0.5)  # longer than the robot's watchdog waits: what is tested
        arm.resume()
        said += running.communicate(timeout=TIMEOUT_S)[0]
    assert running.returncode == 0, said
    assert "too busy" in said
    assert "what stands is what was planned" in said


@pytest.mark.soak
@pytest.mark.wire
def test_a_demonstration_of_what_cannot_be_built(tmp_path: Path) -> None:
    ended, report, _ = demo("--say", "a dragon", config=changed_config(tmp_path))
    assert (ended, report["built"], report["state"]) == (4, [], "idle")


@pytest.mark.soak
@pytest.mark.wire
def test_a_demonstration_that_runs_out_of_parts_ends_in_a_fault(tmp_path: Path) -> None:
    config = changed_config(
        tmp_path, feeder={"capacity_parts": 2}, policy={"refill_timeout_s": 10.0}
    )
    status, report, said = demo("--say", "the letter T", config=config)
    assert status == 5
    assert report["state"].startswith("fault")
    assert report["fault"]["entry"]["code"] == "belt_empty"
    assert len(report["built"]) == 2
    assert report["fault"]["entry"]["remedy"][:20] in said


def begun(config: Path, *arguments: str) -> subprocess.Popen[str]:
    """A command that runs on, and what it prints."""
    return subprocess.Popen(
        [sys.executable, "-m", "cellctl", *arguments],
        env={**os.environ, "CELLCTL_CONFIG": str(config)},
        stdout=subprocess.PIPE,
        text=True,
    )


@pytest.mark.wire
def test_a_wish_is_said_asked_about_built_cancelled_and_taken_apart(tmp_path: Path) -> None:
    with running_cell(policy={"confirmation": "ask"}) as cell:
        path = changed_config(tmp_path, bus=cell.config.bus.model_dump())
        asked = cellctl("say", "the letter T", config=path)
        assert asked.returncode == 0
        assert "Shall I build it?" in asked.stdout
        assert cellctl("no", config=path).returncode == 0
        cell.wait_state("idle")
        beauty = cellctl("say", "create beauty", config=path)
        assert beauty.returncode == 3
        assert "beauty" in beauty.stdout
        for nothing in ("", "stool " * 200):
            refused = cellctl("say", nothing, config=path)
            assert refused.returncode == 2
            assert "one sentence" in refused.stderr
            assert "Traceback" not in refused.stderr

        with begun(path, "say", "the letter T", "--wait") as waiting:
            cell.wait_state("validating_confirming")
            assert cellctl("yes", config=path).returncode == 0
            cell.wait_state("assembling_placing")
            cell.visitor.command("cancel")
            assert waiting.wait(TIMEOUT_S) == 6
        shown = cellctl("status", config=path)
        assert shown.returncode == 0
        assert "idle" in shown.stdout
        # How many were placed before it was cancelled depends on how quickly a command starts.
        standing = len(json.loads(cellctl("status", "--json", config=path).stdout)["standing"])
        assert standing >= 1
        with begun(path, "take-apart", "--wait") as waiting:
            cell.wait_state("validating_confirming")
            assert cellctl("yes", config=path).returncode == 0
            told, _ = waiting.communicate(timeout=TIMEOUT_S)
        assert waiting.returncode == 0
        assert f"part {standing:>3} of {standing}" in told
        assert not json.loads(cellctl("status", "--json", config=path).stdout)["standing"]


@pytest.mark.parametrize("command", [("sim",), ("demo", "--say", "a stool")])
def test_compiled_boards_that_cannot_run_are_refused_at_once(
    command: tuple[str, ...], tmp_path: Path
) -> None:
    missing = cellctl(*command, "--firmware", "elf", "--firmware-folder", str(tmp_path))
    assert missing.returncode == 2
    assert "make firmware" in missing.stderr
    compile_programs()
    fast = cellctl(*command, "--firmware", "elf", "--speed", "10")
    assert fast.returncode == 2
    assert "--firmware plain" in fast.stderr
