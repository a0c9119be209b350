"""Which executor follows a planned route best: ``python -m benchmarks.executors [--load N]``.

The same routes, to the pick station and to a cell, against the emulated controller at its own
speed: as one asynchronous path with speed, acceleration and blend for each corner, through the arm
process with its gate and watchdog; and as set-points streamed with servoJ every 8 ms. Told are how
much longer each took than planned, and how far the arm was from where it should have been at that
time; ``--load`` keeps so many processors busy meanwhile.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import multiprocessing
import statistics
import time
from pathlib import Path

import numpy as np
import rtde_control
import rtde_receive
from rich.console import Console
from rich.table import Table

from cellctl.assembling.arm_process import RemoteArm
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import Kinematics, as_joints
from cellctl.assembling.route import Route, RoutePlanner, Stance
from cellctl.assembly import Cell
from cellctl.config import CellConfig, load_config
from tests.assembling.emulator import Emulator
from tests.assembling.executed import Bench

CONFIG = Path(__file__).parents[1] / "config" / "sim.toml"
CELLS = (Cell(2, 2, 0), Cell(4, 3, 0), Cell(1, 1, 0), Cell(5, 4, 0))
PERIOD_S = 0.008
LOOKAHEAD_S = 0.03
GAIN = 300


def routes(config: CellConfig) -> list[tuple[Stance, Route]]:
    """Every route with where it begins."""
    planner = RoutePlanner(config)
    stance, found = planner.home, []
    for cell in CELLS:
        for plan in (planner.to_pick(stance, ()), planner.to_cell(cell, ())):
            found.append((stance, plan))
            stance = plan.end
    return found


async def by_path(config: CellConfig) -> list[float]:
    """Seconds beyond the plan that each route took, start and end seen from the daemon's side."""
    arm = RemoteArm(config)
    await arm.connect()
    late = []
    try:
        for _, route in routes(config):
            state = arm.state()
            assert state is not None
            await arm.follow(route.path, route.duration_s)
            after = arm.state()
            assert after is not None
            late.append(after.robot_time_s - state.robot_time_s - route.duration_s)
    finally:
        await arm.close()
    return late


def by_stream(config: CellConfig) -> tuple[list[float], list[float], list[float]]:
    """Seconds beyond the plan; metres off the plan at its time; longest pause of the stream."""
    bench = Bench(config)
    control = rtde_control.RTDEControlInterface(config.robot.host, 500.0)
    receive = rtde_receive.RTDEReceiveInterface(config.robot.host)
    late, off, pauses = [], [], []
    frames, kinematics = Frames(config), Kinematics(config.robot.model)
    for _, route in routes(config):
        bench.trace.clear()
        bench.follow(route)
        targets = [*bench.trace[:: round(PERIOD_S / bench.step_s)], list(route.end.joints_rad)]
        begun_s, robot_s = time.monotonic(), receive.getTimestamp()
        worst_m, longest_s, last_s = 0.0, 0.0, begun_s
        for i, target in enumerate(targets):
            control.servoJ(target, 0.0, 0.0, PERIOD_S, LOOKAHEAD_S, GAIN)
            time.sleep(max(0.0, begun_s + (i + 1) * PERIOD_S - time.monotonic()))
            now_s = time.monotonic()
            longest_s, last_s = max(longest_s, now_s - last_s), now_s
            at = receive.getActualTCPPose()[:3]
            wanted = frames.tcp(kinematics.forward(as_joints(np.array(target))))[:3, 3]
            worst_m = max(worst_m, math.dist(at, wanted))
        while np.abs(np.subtract(receive.getActualQ(), targets[-1])).max() > 0.001:
            control.servoJ(targets[-1], 0.0, 0.0, PERIOD_S, LOOKAHEAD_S, GAIN)
            time.sleep(PERIOD_S)
        late.append(receive.getTimestamp() - robot_s - route.duration_s)
        off.append(worst_m)
        pauses.append(longest_s)
        control.servoStop()
    control.disconnect()
    receive.disconnect()
    return late, off, pauses


def _spin() -> None:
    while True:
        pass


def main() -> None:
    """Run both and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--load", type=int, default=0, help="processors kept busy meanwhile")
    arguments = parser.parse_args()
    config = load_config(CONFIG)
    busy = [multiprocessing.Process(target=_spin, daemon=True) for _ in range(arguments.load)]
    for process in busy:
        process.start()
    try:
        with Emulator(config) as emulator:
            paths = asyncio.run(by_path(emulator.config))
        with Emulator(config) as emulator:
            streamed, off, pauses = by_stream(emulator.config)
    finally:
        for process in busy:
            process.kill()
    table = Table("executor", "s beyond the plan, median", "worst", "mm off, worst", "pause, ms")
    table.add_row(
        "path, gate and watchdog", f"{statistics.median(paths):.3f}", f"{max(paths):.3f}", "-", "-"
    )
    table.add_row(
        "servoJ every 8 ms",
        f"{statistics.median(streamed):.3f}",
        f"{max(streamed):.3f}",
        f"{max(off) * 1e3:.1f}",
        f"{max(pauses) * 1e3:.0f}",
    )
    Console().print(table)


if __name__ == "__main__":
    main()
