"""``cellctl plan`` as a person types it, in this process; no cell runs."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

from cellctl.assembly import BuildPlan
from cellctl.cli.app import main
from cellctl.cli.plan_command import make_plan
from cellctl.cli.plan_files import robot_side
from cellctl.cli.plan_options import adjusted, input_kind
from cellctl.cli.plan_report import PlanReport
from cellctl.config import load_config
from cellctl.errors import UsageError
from tests.cell.harness import CONFIG

SETTINGS = load_config(CONFIG)

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs the command; returns its status, its output and its errors."""

    def plan(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["cellctl", "plan", "--config", str(CONFIG), *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return int(ended.value.code or 0), out, err

    return plan


@pytest.fixture
def column_stl(tmp_path: Path) -> Path:
    """A column of 10 x 10 x 30 mm, its long axis along the file's y."""
    path = tmp_path / "a_column.stl"
    trimesh.creation.box((10.0, 30.0, 10.0)).export(path)
    return path


def reported(path: Path) -> PlanReport:
    return PlanReport.model_validate_json(path.read_text(encoding="utf-8"))


def test_a_sentence_gives_every_file(run: Run, tmp_path: Path) -> None:
    files = {name: tmp_path / name for name in ("t.json", "t.png", "t.glb", "plan.json")}
    status, out, err = run(
        *("the letter T", "--json", str(files["t.json"]), "--plan", str(files["plan.json"])),
        *("--picture", str(files["t.png"]), "--steps", str(files["t.glb"])),
    )
    assert (status, err) == (0, "")
    assert "letter T: 7 parts, 30 x 10 x 50 cm" in out
    assert all(str(path) in out for path in files.values())
    assert max(map(len, out.splitlines())) <= 100 + len(str(tmp_path))
    report = reported(files["t.json"])
    assert report.refused is None
    assert report.input.kind == "sentence"
    assert report.parts == len(report.placements) == 7
    assert all(check.passed for check in report.checks)
    plan = BuildPlan.model_validate_json(files["plan.json"].read_text())
    assert [step.cell for step in plan.steps] == [step.cell for step in report.placements]
    assert files["t.png"].read_bytes().startswith(b"\x89PNG")
    assert len(trimesh.load_scene(files["t.glb"]).graph.nodes_geometry) >= 7


def test_json_on_standard_output_is_alone_there(run: Run) -> None:
    status, out, err = run("the letter T", "--json", "-")
    assert (status, err) == (0, "")
    assert PlanReport.model_validate(json.loads(out), strict=False).title == "letter T"


def test_a_plan_that_was_written_can_be_planned_again(run: Run, tmp_path: Path) -> None:
    file, again = tmp_path / "plan.json", tmp_path / "again.json"
    assert run("the letter T", "--plan", str(file))[0] == 0
    assert run(str(file), "--json", str(again))[0] == 0
    report = reported(again)
    assert report.input.kind == "cells"
    assert report.plan_id == BuildPlan.model_validate_json(file.read_text()).plan_id


def test_cells_are_built_as_they_are(run: Run, tmp_path: Path) -> None:
    file, out = tmp_path / "cells.json", tmp_path / "report.json"
    file.write_text('{"cells": [[0, 0, 0], [0, 0, 1], [1, 0, 1]], "pitch_m": 0.1}')
    assert run(str(file), "--json", str(out))[0] == 0
    assert reported(out).size_m == (0.2, 0.1, 0.2)


def test_height_and_up_of_a_mesh(column_stl: Path) -> None:
    # As it lies in the file, z being up for STL, its 30 mm are its depth.
    lying = make_plan(str(column_stl), SETTINGS, height_m=0.1)
    assert lying.assembly.size == (1, 3, 1)
    upright = make_plan(str(column_stl), SETTINGS, height_m=0.3, up="y")
    assert upright.assembly.size == (1, 1, 3)


def test_height_of_a_sentence_is_as_if_it_had_been_said() -> None:
    given = make_plan("a stool", SETTINGS, height_m=0.4)
    said = make_plan("a stool 40 cm high", SETTINGS)
    assert given.assembly == said.assembly
    assert given.assembly.size[2] == 4


@pytest.mark.parametrize(
    ("wish", "told"),
    [
        ("create beauty", (3, "request", "beauty")),
        ("a dragon", (4, "design", "cannot design a dragon yet")),
        ("missing.stl", (2, "input", "there is no such file")),
    ],
)
def test_a_refusal_is_told_and_reported(
    run: Run, tmp_path: Path, wish: str, told: tuple[int, str, str]
) -> None:
    status, rule, says = told
    path = tmp_path / "report.json"
    ended, _, err = run(wish, "--json", str(path))
    assert ended == status
    assert says in err
    refused = reported(path).refused
    assert refused is not None
    assert (refused.rule, refused.exit_status) == (rule, status)
    assert says in refused.message


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("empty.stl", b"", "the file is empty"),
        ("noise.glb", b"noise", "cannot be read as GLB"),
        ("noise.json", b"{", "is not valid JSON"),
        ("chair.fbx", b"chair", "not a kind of file that can be planned"),
    ],
)
def test_a_file_that_cannot_be_used_is_reported(
    run: Run, tmp_path: Path, name: str, content: bytes, says: str
) -> None:
    file, path = tmp_path / name, tmp_path / "report.json"
    file.write_bytes(content)
    status, _, err = run(str(file), "--json", str(path))
    assert status == 2
    assert says in err
    refused = reported(path).refused
    assert refused is not None
    assert (refused.rule, refused.exit_status) == ("input", 2)


def test_a_long_sentence_is_no_file_name(run: Run) -> None:
    status, _, err = run("please " * 60 + "build me a dragon")
    assert status == 4
    assert "dragon" in err


def test_a_shape_that_breaks_a_rule_is_reported(run: Run, tmp_path: Path) -> None:
    file, path = tmp_path / "cells.json", tmp_path / "report.json"
    file.write_text('{"cells": [[0, 0, 0], [2, 0, 0]], "pitch_m": 0.1}')
    status, _, err = run(str(file), "--json", str(path))
    assert status == 4
    assert "connectivity" in err
    report = reported(path)
    assert report.refused is not None
    assert "connectivity" in report.refused.message
    assert report.placements == ()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("a stool", "--height-m", "nan"), "--height-m nan: no height"),
        (("a stool", "--height-m", "-1"), "--height-m -1: no height"),
        (("a stool", "--up", "y"), "only a mesh can be turned"),
        (("x.json", "--height-m", "1"), "cells have their size already"),
        (("a stool", "--budget-s", "0"), "--budget-s 0: no budget"),
        (("x.json", "--budget-s", "5"), "never improved"),
        (("a stool", "--budget-s", "5", "--policy", "paper"), "improves nothing"),
        (("x.json", "--take-apart", "--policy", "paper"), "the policy cellctl only"),
        (("a stool", "--standing", "x.json", "--policy", "paper"), "the policy cellctl only"),
        (("a stool", "--up", "x"), "--up"),
        (("a stool", "--policy", "luck"), "--policy"),
        (("a stool", "--picture", "x.jpg"), "writes PNG files only"),
        (("a stool", "--steps", "x.obj"), "writes GLB files only"),
        (("a stool", "--json", "/no/such/folder/x.json"), "there is no folder /no/such/folder"),
        (("a stool", "--plan", "/"), "/: is a folder"),
    ],
)
def test_options_that_make_no_sense_are_refused(
    run: Run, arguments: tuple[str, ...], says: str
) -> None:
    status, out, err = run(*arguments)
    assert status == 2
    assert says in " ".join(err.split())
    assert out == ""


def test_without_matplotlib_a_picture_is_refused_before_anything_is_planned(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    report = tmp_path / "t.json"
    status, out, err = run(
        "the letter T", "--picture", str(tmp_path / "t.png"), "--json", str(report)
    )
    assert status == 2
    assert "matplotlib, which is not installed" in err
    assert "cellctl[picture]" in err
    assert out == ""
    assert not report.exists()


def test_what_an_input_is_goes_by_its_suffix() -> None:
    assert input_kind("Chair.GLB") == "mesh"
    assert input_kind("a/b.json") == "cells"
    assert input_kind("a table 0.7 m high") == "sentence"


def test_budget_and_policy_are_those_of_the_configuration_unless_given() -> None:
    assert adjusted(SETTINGS, None, None) == SETTINGS
    changed = adjusted(SETTINGS, 3.0, "paper").planning
    assert (changed.budget_s, changed.policy) == (3.0, "paper")
    with pytest.raises(UsageError):
        adjusted(SETTINGS, float("nan"), None)


@pytest.mark.parametrize(
    ("base", "side"),
    [
        ((0.3, -0.45, 0.35), "-y"),
        ((0.3, 0.95, 0.35), "+y"),
        ((-0.4, 0.2, 0.35), "-x"),
        ((1.1, 0.3, 0.35), "+x"),
    ],
)
def test_the_robot_is_drawn_where_it_stands(base: tuple[float, float, float], side: str) -> None:
    moved = SETTINGS.base.model_copy(update={"frame": (*base, 0.0, 0.0, 0.0)})
    assert robot_side(SETTINGS.model_copy(update={"base": moved})) == side


@pytest.mark.soak
def test_every_shared_mesh_is_planned(test_data: Path) -> None:
    for entry in json.loads((test_data / "meshes" / "manifest.json").read_text()):
        path = test_data / "meshes" / entry["file"]
        height_cm = entry.get("suggested_height_cm")
        height_m = None if height_cm is None else height_cm / 100.0
        plan = make_plan(str(path), SETTINGS, height_m=height_m, up=entry["up"])
        assert 0 < plan.parts <= SETTINGS.limits.inventory_parts


def cells_file(path: Path, *cells: tuple[int, int, int]) -> str:
    path.write_text(json.dumps({"cells": cells, "pitch_m": 0.1}))
    return str(path)


def test_what_stands_is_taken_apart_or_becomes_something_else(run: Run, tmp_path: Path) -> None:
    post = cells_file(tmp_path / "post.json", (2, 2, 0), (2, 2, 1))
    bench = cells_file(tmp_path / "bench.json", (0, 0, 0), (1, 0, 0))
    report = tmp_path / "report.json"
    status, out, err = run(post, "--take-apart", "--json", str(report))
    assert (status, err) == (0, "")
    assert "taken apart in 2 steps" in out
    taken = reported(report)
    assert [(step.kind, step.cell) for step in taken.placements] == [
        ("remove", (2, 2, 1)),
        ("remove", (2, 2, 0)),
    ]
    assert taken.cells == ()

    status, out, err = run(bench, "--standing", post, "--json", str(report))
    assert (status, err) == (0, "")
    assert "1 of 2 parts stays; 2 moves instead of 4" in out
    assert "2 parts, 20 x 10 x 10 cm" in out
    changed = reported(report)
    assert [step.kind for step in changed.placements] == ["remove", "place"]
    assert (2, 2, 0) in changed.cells
    assert len(changed.cells) == 2


def test_a_configured_policy_that_knows_no_taking_apart_is_told(run: Run, tmp_path: Path) -> None:
    cells = cells_file(tmp_path / "post.json", (2, 2, 0), (2, 2, 1))
    paper = tmp_path / "cell.toml"
    paper.write_text(f'{CONFIG.read_text()}\n[planning]\npolicy = "paper"\n')
    for more in (("--take-apart",), ("--standing", cells)):
        status, out, _ = run(cells, *more, "--config", str(paper))
        assert status == 0
        assert "planning.policy is 'paper', which knows no taking apart" in " ".join(out.split())
        assert "by the policy 'cellctl'" in out
    assert "planning.policy" not in run(cells, "--take-apart")[1]


def test_what_stands_already_is_drawn_and_told(run: Run, tmp_path: Path) -> None:
    post = cells_file(tmp_path / "post.json", (2, 2, 0), (2, 2, 1))
    picture, steps = tmp_path / "x.png", tmp_path / "x.glb"
    status, out, err = run(
        *(post, "--standing", post, "--steps", str(steps), "--picture", str(picture))
    )
    assert (status, err) == (0, "")
    assert "post: 2 parts, 10 x 10 x 20 cm, standing already" in out
    assert "It stands already; nothing is moved." in out
    assert "moves instead" not in out
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert len(trimesh.load_scene(steps).graph.nodes_geometry) == 2


def test_a_single_part_is_told_in_the_singular(run: Run, tmp_path: Path) -> None:
    one = cells_file(tmp_path / "one.json", (2, 2, 0))
    status, out, _ = run(one)
    assert status == 0
    assert "count: 1 part;" in out
    assert "1 part stands on the floor." in out
    assert "1 parts" not in out
    status, out, _ = run(one, "--policy", "paper")
    assert status == 0
    assert "1 parts" not in out
    status, out, _ = run(one, "--take-apart")
    assert status == 0
    assert "taken apart in 1 step\n" in out
    assert "1 part is p" in out
    assert " 0 " not in out.split("removal:")[1].split(";")[0]


def test_a_plan_is_not_planned_by_another_policy(run: Run, tmp_path: Path) -> None:
    cells = cells_file(tmp_path / "post.json", (2, 2, 0), (2, 2, 1))
    plan = tmp_path / "plan.json"
    status, out, _ = run(cells, "--policy", "paper", "--plan", str(plan))
    assert status == 0
    assert "by the policy 'paper'" in out
    for more in ((), ("--standing", cells)):
        status, out, err = run(str(plan), "--policy", "cellctl", *more)
        assert (status, out) == (2, "")
        assert "the policy that the cell is configured for" in " ".join(err.split())


def test_a_refusal_is_told_once_and_says_what_to_do(run: Run, tmp_path: Path) -> None:
    apart = cells_file(tmp_path / "apart.json", (0, 0, 0), (2, 0, 0))
    status, out, err = run(apart)
    assert (status, out) == (4, "")
    assert "It breaks the rule of connectivity" in err
    assert "what to do:" in err
    assert "touch face to face" in err


def test_what_stands_is_told_by_its_cells(run: Run, tmp_path: Path) -> None:
    far = cells_file(tmp_path / "far.json", (9, 0, 0))
    for arguments, said in (
        (("a stool", "--take-apart"), "the cells that stand"),
        ((far, "--take-apart"), "outside the workspace"),
        (("a stool", "--standing", far), "outside the workspace"),
        (("a stool", "--standing", str(tmp_path / "none.json")), "none.json"),
        ((far, "--take-apart", "--standing", far), "without --standing"),
    ):
        status, _, err = run(*arguments)
        assert status != 0
        assert said in " ".join(err.split()), err
