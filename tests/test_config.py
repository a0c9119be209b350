"""The configuration: what is accepted, and how everything else is refused."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest

from cellctl import config
from cellctl.config import CellConfig, find_config, load_config, parse_config, unit_of
from cellctl.errors import ConfigError, ExitStatus

FOLDER = Path(__file__).resolve().parent.parent / "config"
FILES = sorted(FOLDER.glob("*.toml"))
SIM = tomllib.loads((FOLDER / "sim.toml").read_text(encoding="utf-8"))


def changed(key: str, value: Any) -> dict[str, Any]:
    """The emulated cell's settings with one of them, ``table.name`` or ``table``, replaced."""
    data = copy.deepcopy(SIM)
    table, _, name = key.partition(".")
    if name:
        data.setdefault(table, {})[name] = value
    else:
        data[table] = value
    return data


def without(key: str) -> dict[str, Any]:
    data = copy.deepcopy(SIM)
    table, _, name = key.partition(".")
    if name:
        del data[table][name]
    else:
        del data[table]
    return data


def refusal(data: dict[str, Any]) -> str:
    with pytest.raises(ConfigError) as caught:
        parse_config(data, "cell.toml")
    assert caught.value.exit_status is ExitStatus.USAGE
    return caught.value.message


# What ships.


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_every_file_that_ships_loads(path: Path) -> None:
    settings = load_config(path)
    assert min(settings.grid) >= 1
    assert (settings.cell.kind == "emulated") == (path.name.startswith("sim"))


def test_the_emulated_cell_is_the_papers_size() -> None:
    settings = load_config(FOLDER / "sim.toml")
    assert settings.grid == (6, 5, 6)
    assert settings.limits.inventory_parts == 40


def test_settings_survive_json_and_cannot_be_changed() -> None:
    settings = parse_config(SIM, "cell.toml")
    assert CellConfig.model_validate_json(settings.model_dump_json()) == settings
    assert CellConfig.model_validate(settings.model_dump()) == settings
    with pytest.raises(ValueError, match="frozen"):
        settings.voxel.pitch_m = 0.2


@pytest.mark.parametrize(
    ("size_m", "grid"),
    [
        ((0.6, 0.5, 0.6), (6, 5, 6)),
        ((0.3, 0.3, 0.3), (3, 3, 3)),  # 0.3 / 0.1 is 2.9999999999999996
        ((0.69, 0.1, 0.7), (6, 1, 7)),
    ],
)
def test_the_grid_is_what_fits_whole(
    size_m: tuple[float, float, float], grid: tuple[int, int, int]
) -> None:
    assert parse_config(changed("workspace.size_m", list(size_m)), "cell.toml").grid == grid


# What is refused, and how.


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        # Unknown names: the nearest valid one.
        ("robt", {}, "robt: unknown key; did you mean robot?"),
        ("voxel.pitch_mm", 100, "voxel.pitch_mm: unknown key; did you mean voxel.pitch_m?"),
        ("robot.speed_m_s", 1.0, "did you mean robot.travel_speed_m_s?"),
        ("workspace.pitch_m", 0.1, "did you mean voxel.pitch_m?"),
        ("robot.mass_kg", 1.0, "did you mean voxel.mass_kg?"),
        ("limits.retries", 1, "did you mean gripper.retries or feeder.retries?"),
        ("emulation.seeds", 1, "emulation.seeds: unknown key; did you mean emulation.seed?"),
        ("base.zzz", 1, "base.zzz: unknown key; known here: frame."),
        # Ranges, with the unit that the name promises.
        ("voxel.pitch_m", 100, "voxel.pitch_m = 100: must be less than or equal to 0.25 (in met"),
        ("voxel.mass_kg", 0, "voxel.mass_kg = 0: must be greater than 0 (in kilograms)."),
        ("robot.travel_speed_m_s", 9.0, "less than or equal to 3 (in metres per second)."),
        ("robot.travel_acceleration_m_s2", 0, "(in metres per second squared)."),
        ("gripper.travel_timeout_s", -1.0, "must be greater than 0 (in seconds)."),
        ("robot.watchdog_hz", 500.0, "must be less than or equal to 50 (in hertz)."),
        ("robot.dashboard_port", 70000, "must be less than or equal to 65535."),
        ("gripper.command_output", 8, "must be less than or equal to 7."),
        ("workspace.size_m", [0.6, -1.0, 0.6], "workspace.size_m[1] = -1.0: must be greater"),
        ("voxel.mass_kg", float("nan"), "must be a finite number"),
        ("feeder.width_m", float("inf"), "must be a finite number"),
        ("planning.budget_s", 60.0, "planning: budget_s must be less than timeout_s (60 and 60)"),
        # Types: TOML has numbers, so text is not taken for one.
        ("voxel.pitch_m", "0.1", "voxel.pitch_m = '0.1': must be a valid number (in metres)."),
        ("voxel.pitch_m", True, "must be a valid number"),
        ("limits.stack_cells", 4.5, "limits.stack_cells = 4.5: must be a valid integer."),
        ("limits.stack_cells", True, "must be a valid integer"),
        ("robot.host", 5, "robot.host = 5: must be a valid string."),
        ("robot.host", "", "robot.host = '': string must have at least 1 character."),
        ("hearing.allow_download", "yes", "must be a valid boolean"),
        ("workspace.frame", [0, 0, 0, 0, 0, "a"], "workspace.frame[5] = 'a': must be a valid numb"),
        ("workspace.frame", [0, 0, 0], "workspace.frame[3]: is missing."),
        ("workspace.frame", [0] * 7, "workspace.frame = (0, 0, 0, 0, 0, 0, 0): "),
        ("workspace.size_m", 0.6, "workspace.size_m = 0.6: must be a valid array"),
        ("voxel", 0.1, "voxel = 0.1: must be a table, [voxel]."),
        # Choices.
        ("robot.model", "ur5", "robot.model = 'ur5': must be 'ur10' or 'ur10e'."),
        ("robot.rtde_frequency_hz", 250, "must be 125 or 500 (in hertz)."),
        ("policy.confirmation", "never", "must be 'ask' or 'waived'."),
        ("cell.kind", "simulated", "must be 'real' or 'emulated'."),
        # What must fit together.
        ("robot.model", "ur10", "robot.rtde_frequency_hz must be 125 for a ur10"),
        ("workspace.size_m", [0.6, 0.5, 0.05], "must hold at least one voxel on every axis"),
        ("bus.status", "udp://127.0.0.1:5571", "status must be ipc:///PATH or tcp://ADDRESS:PORT"),
        ("bus.visitor", "tcp://127.0.0.1", "visitor must be ipc:///PATH or tcp://ADDRESS:PORT"),
        ("bus.visitor", "tcp://127.0.0.1:70000", "visitor must be ipc:///PATH or tcp://"),
        ("bus.operator", "ipc://@cell", "operator must be ipc:// and an absolute path"),
        ("bus.status", "tcp://127.0.0.1:5572", "status and visitor must differ"),
        ("bus.control", "tcp://127.0.0.1:5572", "bus.control: unknown key; did you mean"),
    ],
)
def test_what_is_wrong_is_named(key: str, value: Any, message: str) -> None:
    text = refusal(changed(key, value))
    assert message in text
    assert all(line.startswith("cell.toml: ") for line in text.splitlines())


def test_a_ur10_carries_less_than_a_ur10e() -> None:
    data = changed("tool.payload_kg", 12.0)
    assert parse_config(data, "cell.toml").tool.payload_kg == 12.0
    data["robot"] |= {"model": "ur10", "rtde_frequency_hz": 125}
    assert "tool.payload_kg must be at most 10.0 for a ur10" in refusal(data)


@pytest.mark.parametrize("key", ["robot", "robot.host", "workspace.size_m", "cell.kind"])
def test_what_is_missing_is_named(key: str) -> None:
    assert refusal(without(key)) == f"cell.toml: {key}: is missing."


def test_everything_that_is_wrong_is_told_at_once() -> None:
    data = changed("voxel.pitch_m", 5.0)
    data["robot"]["modell"] = data["robot"].pop("model")
    lines = refusal(data).splitlines()
    assert len(lines) == 3
    assert "cell.toml: robot.model: is missing." in lines
    assert "cell.toml: robot.modell: unknown key; did you mean robot.model?" in lines


# A real cell is never emulated by accident.


def test_a_real_cell_has_nothing_emulated() -> None:
    data = changed("cell.kind", "real")
    assert "a real cell has no [emulation] table" in refusal(data)
    del data["emulation"]
    data["cell"]["clock_rate"] = 20.0
    assert "cell.clock_rate must be 1.0 for a real cell" in refusal(data)
    data["cell"]["clock_rate"] = 1.0
    assert parse_config(data, "cell.toml").emulation is None


def test_an_emulated_cell_says_how() -> None:
    assert "an emulated cell needs an [emulation] table" in refusal(without("emulation"))


# Files.


def test_a_file_is_named_in_what_is_wrong_with_it(tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    text = (FOLDER / "sim.toml").read_text(encoding="utf-8")
    path.write_text(text.replace("[robot]", "[robott]"), encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_config(path)
    assert f"{path}: robott: unknown key; did you mean robot?" in caught.value.message


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[cell\n", "is not valid TOML"),
        (b"a = 1\na = 2\n", "is not valid TOML"),
        (b"\xff\xfe", "is not UTF-8 text"),
        (b"", "cell: is missing."),
    ],
)
def test_a_file_that_cannot_be_understood(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "cell.toml"
    path.write_bytes(content)
    with pytest.raises(ConfigError) as caught:
        load_config(path)
    assert message in caught.value.message
    assert str(path) in caught.value.message


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.toml: cannot be read: No such file"):
        load_config(tmp_path / "none.toml")
    with pytest.raises(ConfigError, match="cannot be read: Is a directory"):
        load_config(tmp_path)


# Where it is looked for.


@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Path]:
    """The three places, none of which has a file yet; the environment names the second."""
    found = {name: tmp_path / f"{name}.toml" for name in ("option", "environment", "etc")}
    monkeypatch.setattr(config.loading, "DEFAULT_PATH", found["etc"])
    monkeypatch.setenv(config.ENVIRONMENT_VARIABLE, str(found["environment"]))
    return found


def test_the_option_comes_first(places: dict[str, Path]) -> None:
    places["etc"].touch()
    assert find_config(places["option"]) == places["option"]


def test_then_the_environment_even_if_its_file_is_missing(places: dict[str, Path]) -> None:
    places["etc"].touch()
    assert find_config(None) == places["environment"]


@pytest.mark.parametrize("value", [None, ""])
def test_then_etc(
    places: dict[str, Path], monkeypatch: pytest.MonkeyPatch, value: str | None
) -> None:
    if value is None:
        monkeypatch.delenv(config.ENVIRONMENT_VARIABLE)
    else:
        monkeypatch.setenv(config.ENVIRONMENT_VARIABLE, value)
    places["etc"].touch()
    assert find_config(None) == places["etc"]


def test_and_never_the_emulated_cell(
    places: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(config.ENVIRONMENT_VARIABLE)
    monkeypatch.chdir(FOLDER.parent)  # where config/sim.toml lies at hand
    with pytest.raises(ConfigError) as caught:
        find_config(None)
    assert str(places["etc"]) in caught.value.message
    assert "--config config/sim.toml" in caught.value.hint


# Names and their units.


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("pitch_m", "metres"),
        ("travel_speed_m_s", "metres per second"),
        ("travel_acceleration_m_s2", "metres per second squared"),
        ("timeout_s", "seconds"),
        ("home_rad", "radians"),
        ("retries", ""),
    ],
)
def test_the_unit_stands_in_the_name(name: str, unit: str) -> None:
    assert unit_of(name) == unit
