"""A cell of one's own: end points that no other emulated cell on this machine uses."""

from __future__ import annotations

import random
import socket
from contextlib import ExitStack
from pathlib import Path

import tomli_w

from cellctl.config import CellConfig
from cellctl.errors import UsageError

UR_PORTS = (29999, 30003, 30004)
"""The robot's ports are fixed in its client library, so each emulated robot needs an address."""
_ATTEMPTS = 50


def free_robot_host() -> str:
    """A loopback address on which all of the robot's ports are free.

    Raises:
        UsageError: none was found.
    """
    chance = random.SystemRandom()
    for _ in range(_ATTEMPTS):
        host = f"127.{chance.randint(2, 250)}.{chance.randint(0, 250)}.{chance.randint(1, 250)}"
        try:
            with ExitStack() as stack:
                for port in UR_PORTS:
                    probe = stack.enter_context(socket.socket())
                    probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                    probe.bind((host, port))
        except OSError:
            continue
        return host
    raise UsageError(
        f"No loopback address has the ports {', '.join(map(str, UR_PORTS))} free.",
        "Stop emulated cells that are still running.",
    )


def isolated(config: CellConfig, folder: Path, speed: float | None = None) -> CellConfig:
    """The same cell with end points of its own, in a folder of its own.

    Args:
        config: an emulated cell.
        folder: exists, private, and short enough for a socket's path (100 characters).
        speed: cell seconds per wall second; the configuration's by default.

    Raises:
        UsageError: the configuration is of a real cell.
    """
    if config.emulation is None:
        raise UsageError(
            f"{config.cell.name} is a real cell; this command drives an emulated one only.",
            "Name another configuration, for example --config config/sim.toml.",
        )
    cell = {"clock_rate": speed} if speed is not None else {}
    return config.model_copy(
        update={
            "cell": config.cell.model_copy(update=cell),
            "robot": config.robot.model_copy(update={"host": free_robot_host()}),
            "gripper": config.gripper.model_copy(
                update={"port": str(folder / "gripper") if config.gripper.port else None}
            ),
            "feeder": config.feeder.model_copy(update={"port": str(folder / "conveyor")}),
            "bus": config.bus.model_copy(
                update={
                    "status": f"ipc://{folder}/status",
                    "visitor": f"ipc://{folder}/visitor",
                    "operator": f"ipc://{folder}/operator",
                }
            ),
            "journal": config.journal.model_copy(update={"path": str(folder / "journal.db")}),
            "emulation": config.emulation.model_copy(update={"control": f"ipc://{folder}/cell"}),
        }
    )


def write_config(config: CellConfig, path: Path) -> None:
    """Write a configuration to a file that ``load_config`` reads back as the same."""
    path.write_text(tomli_w.dumps(config.model_dump(exclude_none=True)), encoding="utf-8")
