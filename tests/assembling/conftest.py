"""The cell of ``config/sim.toml``, as either arm, and its emulated controller."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from cellctl.config import CellConfig, parse_config
from tests.assembling.emulator import Emulator

CONFIG = Path(__file__).resolve().parents[2] / "config" / "sim.toml"
RTDE_FREQUENCY_HZ = {"ur10": 125, "ur10e": 500}


def cell(model: str) -> CellConfig:
    """The emulated cell with one or the other arm."""
    data = tomllib.loads(CONFIG.read_text(encoding="utf-8"))
    data["robot"]["model"] = model
    data["robot"]["rtde_frequency_hz"] = RTDE_FREQUENCY_HZ[model]
    return parse_config(data, str(CONFIG))


@pytest.fixture(params=["ur10e", "ur10"])
def either_cell(request: pytest.FixtureRequest) -> CellConfig:
    """The emulated cell, once with each arm."""
    return cell(request.param)


@pytest.fixture
def config() -> CellConfig:
    """The emulated cell as its file has it, with a UR10e."""
    return cell("ur10e")


@pytest.fixture
def emulator(config: CellConfig) -> Iterator[Emulator]:
    """An emulated UR10e at the speed of a real one."""
    with Emulator(config) as running:
        yield running


@pytest.fixture
def quick_emulator(config: CellConfig) -> Iterator[Emulator]:
    """An emulated UR10e whose clock runs five times as fast."""
    with Emulator(config, "--clock-rate", "5") as running:
        yield running
