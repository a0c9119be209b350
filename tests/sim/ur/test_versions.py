"""A UR10 with a CB3 controller at 125 Hz, and an e-Series in cell time that runs faster."""

from __future__ import annotations

from cellctl.sim.ur.options import PLACE_NOISE_M
from tests.sim.ur.harness import Clients, Emulator, distance_m, wait_until

_WITHIN_NOISE_M = 10 * PLACE_NOISE_M["ur10"]


def test_a_cb3_controller_with_its_cycle_of_8_ms_moves_a_ur10() -> None:
    with (
        Emulator(model="ur10", controller_version="3.15") as emulator,
        Clients(emulator.host) as robot,
    ):
        assert robot.dashboard.polyscopeVersion().startswith("3.15")
        target = robot.lifted(0.1)
        assert robot.control.moveL(target, 0.25, 1.2)
        wait_until(lambda: distance_m(target, robot.receive.getActualTCPPose()) < _WITHIN_NOISE_M)
        wait_until(lambda: robot.control.getStepTime() == 0.008)


def test_a_faster_clock_shortens_the_wait_and_not_the_move() -> None:
    with Emulator(clock_rate=20.0) as emulator, Clients(emulator.host) as robot:
        target = robot.lifted(0.3)
        started_s = robot.receive.getTimestamp()
        assert robot.control.moveL(target, 0.05, 0.5)
        wait_until(lambda: distance_m(target, robot.receive.getActualTCPPose()) < 1e-6)
        took_s = robot.receive.getTimestamp() - started_s
        ideal_s = 0.3 / 0.05 + 0.05 / 0.5
        # Whoever looks a tenth of a second late is two seconds late by this clock.
        assert ideal_s - 0.1 < took_s < 5.0 * ideal_s
