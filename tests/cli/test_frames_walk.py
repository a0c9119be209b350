"""Frames are measured at a cell whose things are not where its configuration says."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

from cellctl.assembling.poses import Matrix, distance, inverse, to_matrix
from cellctl.cli.calibrate_command import Terminal, offer, prepare
from cellctl.cli.frames_walk import FramesWalk, Touch
from cellctl.config import CellConfig, load_config
from cellctl.config.rewriting import rewritten
from cellctl.errors import ConfigError, RefusedError, UsageError
from cellctl.messages import CalibratedCommand
from cellctl.sim.as_built import as_built
from tests.cell.harness import CONFIG, RunningCell, running_cell
from tests.leaks import REPOSITORY

PIN_M = 0.1
SHIFTS: dict[str, tuple[float, ...]] = {
    "shifted_tool": (0.002, -0.003, 0.004, 0.0, 0.0, 0.0),
    "shifted_base": (0.011, -0.007, 0.005, 0.004, -0.006, 0.02),
    "shifted_feeder": (-0.006, 0.009, -0.004, 0.0, 0.0, -0.03),
}
FRAMES = ("tool", "base", "pedestal", "feeder")
CLOSE_M, CLOSE_RAD = 0.0005, 0.002


def shifted() -> CellConfig:
    data = load_config(CONFIG).model_dump(exclude_none=True)
    data["emulation"] |= SHIFTS
    return CellConfig.model_validate(data)


def in_cell(config: CellConfig, frame: str, touch: Touch) -> Matrix:
    """Where the point of a touch really is, and how the tool points there."""
    there = config.workspace.frame if frame == "workspace" else config.feeder.frame
    at = to_matrix(there) @ to_matrix((*touch.at_m, 0.0, 0.0, 0.0))
    at[:3, :3] = to_matrix((0.0, 0.0, 0.0, *touch.tilt_rad, 0.0))[:3, :3] @ np.diag([1, -1, -1])
    return at


class Hand:
    """Touches what it is told, a little beside it.

    Args:
        config: the cell as it really is.
        off_m: how far beside, at most, along each axis.
        slips: the number of the touch that is 5 mm off.
    """

    def __init__(self, config: CellConfig, off_m: float, slips: int = -1) -> None:
        self._config = config
        self._off_m = off_m
        self._slips = slips
        self._chance = random.Random(7)  # noqa: S311 - repeatable
        self._touches = 0

    def tell(self, text: str) -> None:
        assert text

    def touched(self, frame: str, touch: Touch) -> Matrix | None:
        tip = in_cell(self._config, frame, touch)
        tip[:3, 3] += [self._chance.uniform(-self._off_m, self._off_m) for _ in range(3)]
        self._touches += 1
        if self._touches == self._slips:
            tip[0, 3] += 0.005
        pin = to_matrix((0.0, 0.0, PIN_M, 0.0, 0.0, 0.0))
        tool = to_matrix(self._config.tool.frame) @ pin
        return np.asarray(inverse(to_matrix(self._config.base.frame)) @ tip @ inverse(tool))


def assert_close(found: CellConfig, right: CellConfig) -> None:
    for table in FRAMES:
        off_m, off_rad = distance(getattr(found, table).frame, getattr(right, table).frame)
        assert off_m < CLOSE_M, table
        assert off_rad < CLOSE_RAD, table


def test_frames_come_out_within_half_a_millimetre_though_no_touch_is_exact() -> None:
    config = shifted()
    measured = FramesWalk(config, Hand(as_built(config), off_m=0.0002), PIN_M).run()
    text, found = rewritten(CONFIG.read_text(), measured.values, "sim.toml")
    assert_close(found, as_built(config))
    # All else is as it was, comments included.
    old, new = CONFIG.read_text().splitlines(), text.splitlines()
    assert sum(one != two for one, two in zip(old, new, strict=True)) == len(FRAMES)
    assert any("the touches are off by" in line for line in measured.report)


@pytest.mark.parametrize("slips", [2, 8, 12])
def test_a_touch_that_slipped_is_told_and_nothing_comes_of_it(slips: int) -> None:
    config = shifted()
    with pytest.raises(UsageError, match=r"mm off; 1\.5 mm are allowed"):
        FramesWalk(config, Hand(as_built(config), off_m=0.0, slips=slips), PIN_M).run()


def test_another_thing_than_was_meant_is_refused() -> None:
    config = shifted()
    real = as_built(config)
    feeder = real.feeder.model_copy(update={"frame": (-0.2, -0.2, 0.3, 0.0, 0.0, 0.0)})
    elsewhere = real.model_copy(update={"feeder": feeder})
    with pytest.raises(UsageError, match="no matter of measuring"):
        FramesWalk(config, Hand(elsewhere, off_m=0.0), PIN_M).run()


def test_nothing_is_written_without_a_yes_or_over_a_change(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(CONFIG.read_text())
    values = {("base", "frame"): (0.31, -0.45, 0.35, 0.0, 0.0, 0.0)}
    before = file.read_text()
    assert offer(file, values, lambda _: False) is False
    assert file.read_text() == before

    def meddle(_: str) -> bool:
        file.write_text(before + "# mine\n")
        return True

    with pytest.raises(ConfigError, match="changed it meanwhile"):
        offer(file, values, meddle)
    file.write_text(before)
    assert offer(file, values, lambda _: True) is True
    assert load_config(file).base.frame[0] == 0.31
    (kept,) = tmp_path.glob("cell.toml.before-*")
    assert kept.read_text() == before
    with pytest.raises(ConfigError, match="several lines"):
        rewritten("[base]\nframe = [\n0.1,\n]\n", values, "x")
    with pytest.raises(ConfigError, match=r"no table \[base\]"):
        rewritten("[cell]\n", values, "x")


class Guiding(Terminal):
    """A person at an emulated cell: guides the arm, then says yes."""

    def __init__(self, cell: RunningCell) -> None:
        super().__init__(cell.config, cell.client)
        self._running = cell
        self._real = as_built(cell.config)

    def tell(self, text: str) -> None:
        assert text

    def touched(self, frame: str, touch: Touch) -> Matrix | None:
        tip = in_cell(self._real, frame, touch)
        x_m, y_m, z_m = (float(one) for one in tip[:3, 3])
        tilt_x, tilt_y = touch.tilt_rad
        self._running.world.inject(
            "arm_guided",
            x_m=x_m, y_m=y_m, z_m=z_m, pin_m=PIN_M, tilt_x_rad=tilt_x, tilt_y_rad=tilt_y,
        )  # fmt: skip
        wanted = self._running.truth().robot["joints_rad"]
        self._running.wait(
            "the arm's new place",
            lambda now: np.allclose(now.arm.joints_rad, wanted, atol=1e-6),
        )
        return self.flange()


@pytest.mark.wire
def test_an_operator_measures_an_emulated_cell_and_it_is_written_down() -> None:
    with running_cell(speed=5.0, emulation=SHIFTS) as cell:
        with pytest.raises(RefusedError, match="not paused"):
            prepare(CONFIG, cell.config, cell.client)
        cell.client.command("pause")
        cell.wait_state("paused_resting")
        prepare(CONFIG, cell.config, cell.client)
        measured = FramesWalk(cell.config, Guiding(cell), PIN_M).run()
        _, found = rewritten((REPOSITORY / CONFIG).read_text(), measured.values, "sim.toml")
        assert_close(found, as_built(cell.config))
        reply = cell.client.request(CalibratedCommand(what="frames", note=measured.report[0]))
        assert reply.message == "Written down."
        assert cell.truth().violations == ()
