"""The compiled programs by themselves: times, memory, and what becomes of them in trouble."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from cellctl.boards.constants import (
    LATCH_PULSE_US,
    PROTOCOL_VERSION,
    TRAVEL_MS,
    UNLATCH_PULSE_US,
    BoardRole,
    Command,
    ConveyorFlag,
    Register,
    ReplyKind,
    ResetCause,
)
from cellctl.boards.line import Banner
from cellctl.config import CellConfig
from cellctl.errors import UsageError
from cellctl.sim.avr.simulator import BoardCrashedError, PinChange, Simulator
from cellctl.sim.boards import FIRMWARE_RATE_MAX, check_boards
from cellctl.sim.world_values import Imperfections, Where
from tests.firmware.image import toolchain
from tests.firmware.loop.bench import STEP_S, conveyor, gripper
from tests.sim.world.hand import emulated_config

LATCH_TOLD = {"PA1": "L", "PA7": "Z"}
OPEN_TOLD = {"PA1": "H", "PA7": "Z"}
WATCHDOG_S = 0.256
"""Of the fuse; its oscillator is good for some per cent."""


@pytest.fixture
def chip() -> Simulator:
    """A gripper's chip whose program has started, told to be latched."""
    return Simulator(BoardRole.GRIPPER)


def servo_pulses_us(changes: tuple[PinChange, ...]) -> list[float]:
    """The length of each pulse on the servo's pin."""
    edges = [change for change in changes if change.pin == "PA3"]
    assert [edge.high for edge in edges] == [True, False] * (len(edges) // 2)
    return [
        (fall.time_s - rise.time_s) * 1e6
        for rise, fall in zip(edges[::2], edges[1::2], strict=True)
    ]


def test_servo_pulses_and_the_time_to_a_confirmed_latch(chip: Simulator) -> None:
    chip.start()
    try:
        assert chip.advance(0.5, LATCH_TOLD).changes == ()
        opening = chip.advance(0.5, OPEN_TOLD).changes
        told_s = chip.time_s
        closing = chip.advance(0.5, LATCH_TOLD).changes
    finally:
        chip.stop()
    for changes, wanted_us in ((opening, UNLATCH_PULSE_US), (closing, LATCH_PULSE_US)):
        pulses = servo_pulses_us(changes)
        assert len(pulses) == pytest.approx(TRAVEL_MS / 20, abs=1)
        assert all(abs(pulse - wanted_us) <= 5.0 for pulse in pulses), pulses
    (confirmed,) = (change for change in closing if change.pin == "PA2")
    assert confirmed.high
    assert confirmed.time_s - told_s == pytest.approx(0.356, abs=0.002)


def test_a_glitch_of_4_ms_moves_nothing_and_one_of_8_ms_does(chip: Simulator) -> None:
    chip.start()
    try:
        chip.advance(0.5, LATCH_TOLD)
        for offset_s in (0.0, 0.0003, 0.0007):
            chip.advance(0.1 + offset_s, LATCH_TOLD)
            chip.advance(0.004, OPEN_TOLD)
            assert chip.advance(0.5, LATCH_TOLD).changes == ()
        chip.advance(0.008, OPEN_TOLD)
        assert servo_pulses_us(chip.advance(0.5, LATCH_TOLD).changes)
    finally:
        chip.stop()


@pytest.mark.parametrize("interrupts", [True, False])
def test_a_hang_ends_by_the_watchdog_with_the_part_kept_and_the_host_told(
    interrupts: bool,
) -> None:
    with gripper("elf") as bench:
        bench.hand.pick()
        bench.host.identify()
        bench.host.heard()
        hung_s = bench.time_s
        bench.gripper.inject("hang", interrupts=interrupts)
        while not (heard := bench.host.heard()):
            assert bench.time_s - hung_s < 1.0
            bench.advance(STEP_S)
        assert heard == [Banner(BoardRole.GRIPPER, PROTOCOL_VERSION, ResetCause.WATCHDOG)]
        assert bench.time_s - hung_s == pytest.approx(WATCHDOG_S, abs=0.02)
        assert not bench.status
        assert bench.world.held_part is not None
        bench.host.identify()
        resets = bench.host.ask(1, Command.READ, Register.WATCHDOG_RESETS).status
        assert resets is not None
        assert resets.value == 1


def index_and_measure(indexes: int, seed: int) -> tuple[int, float]:
    """Bring parts one after another over a belt that slips and drifts.

    Returns:
        The board's count of indexes, and how far off the stop a part ever came to lie, in metres.
    """
    imperfect = Imperfections(belt_slip=0.05, pitch_drift_m=0.004)
    worst_m = 0.0
    counted = 0
    with conveyor("elf", imperfect, seed) as bench:
        for number in range(1, indexes + 1):
            outcome = bench.host.finish(number % 256)
            assert outcome.kind is ReplyKind.OK, (number, outcome)
            assert outcome.status is not None
            assert outcome.status.flags == ConveyorFlag.PART
            counted = outcome.status.value
            (part,) = (p for p in bench.world.parts() if p.where is Where.PICK_STATION)
            assert part.belt_m is not None
            worst_m = max(worst_m, abs(part.belt_m))
            bench.world.remove_next_part()
            if bench.world.parts_on_belt <= 2:
                bench.world.refill_belt()
            bench.advance(0.02)
        assert bench.world.violations == []
    return counted, worst_m


def test_parts_come_to_lie_at_the_stop_over_a_belt_that_slips_and_drifts() -> None:
    count, worst_m = index_and_measure(6, seed=3)
    assert count == 6
    assert worst_m <= 1e-6


@pytest.mark.soak
def test_a_thousand_indexes_are_exact() -> None:
    count, worst_m = index_and_measure(1000, seed=7)
    assert count == 1000
    assert worst_m <= 1e-6


def test_a_program_that_crashes_ends_the_cell_with_where(tmp_path: Path) -> None:
    source = tmp_path / "crash.c"
    source.write_text(CRASHING)
    elf = tmp_path / "gripper.elf"
    compiler = toolchain() / "avr-gcc"
    subprocess.run([compiler, "-mmcu=attiny412", "-Os", "-o", elf, source], check=True, timeout=60)
    chip = Simulator(BoardRole.GRIPPER, tmp_path)
    chip.start()
    try:
        with pytest.raises(
            BoardCrashedError, match=r"crashed at 0\.\d+ s.*\n.*invalid data address: 0x2000"
        ):
            chip.advance(0.5, LATCH_TOLD)
    finally:
        chip.stop()


CRASHING = """
#include <avr/io.h>
FUSES = {.OSCCFG = 2};
int main(void) {
    _PROTECTED_WRITE(CLKCTRL.MCLKCTRLB, 1);
    for (volatile uint16_t wait = 0; wait < 30000; wait++) {
    }
    *(volatile uint8_t *)0x2000 = 1; /* where the chip has nothing */
    for (;;) {
    }
}
"""


def cell(**changes: object) -> CellConfig:
    """The emulated cell with compiled boards."""
    config = emulated_config()
    assert config.emulation is not None
    emulation = config.emulation.model_copy(update={"firmware": "elf", **changes})
    return config.model_copy(update={"emulation": emulation})


def test_a_program_that_is_not_there_is_refused_with_what_to_run(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"conveyor's program is not there") as caught:
        check_boards(cell(firmware_folder=str(tmp_path)))
    assert "make firmware" in caught.value.hint


def test_too_fast_a_clock_is_refused_with_the_reason() -> None:
    config = cell()
    fast = config.cell.model_copy(update={"clock_rate": FIRMWARE_RATE_MAX + 1})
    with pytest.raises(UsageError, match=r"4 times as fast.*silent for 0\.2 s"):
        check_boards(config.model_copy(update={"cell": fast}))
    check_boards(config)
