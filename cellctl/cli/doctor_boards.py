"""The doctor's look at the cell's own boards; only where no daemon holds a port, it is asked."""

from __future__ import annotations

import asyncio
import os
import stat
from pathlib import Path

from cellctl.boards.constants import FIRMWARE_VERSION, BoardRole
from cellctl.boards.session import Board, BoardPort
from cellctl.cli.findings import Finding, ok, problem, warning
from cellctl.config import CellConfig, FeederSection, GripperSection
from cellctl.errors import CATALOGUE, CellctlError
from cellctl.messages import BoardData, Snapshot
from cellctl.notices import NOTICES

_BOARD_TIMEOUT_S = 10.0


def conveyor(config: CellConfig, daemon: Snapshot | None) -> list[Finding]:
    """Whether the conveyor's board is there, and of which version."""
    where = _port(BoardRole.CONVEYOR, config.feeder.port, config.feeder)
    found = _reachable(config, where, daemon is not None)
    if any(finding.advice for finding in found) and daemon is None:
        return found
    if daemon is None:
        return asyncio.run(_ask(where, CATALOGUE["belt_lost"].remedy))
    if daemon.conveyor.connected:
        return [*found, *_told(where, daemon.conveyor.board)]
    text = f"{where.port}: the daemon is not connected to its board"
    return [*found, problem("conveyor", text, CATALOGUE["belt_lost"].remedy)]


def gripper(config: CellConfig, daemon: Snapshot | None) -> list[Finding]:
    """Whether the gripper's board is there, and of which version; it need not be."""
    port = config.gripper.port
    if port is None:
        return [ok("gripper", "its board's serial port is not connected; its lines do without")]
    where = _port(BoardRole.GRIPPER, port, config.gripper)
    found = _reachable(config, where, daemon is not None)
    if any(finding.advice for finding in found) and daemon is None:
        return found
    if daemon is None:
        return asyncio.run(_ask(where, NOTICES["gripper_board_lost"].remedy))
    notice = daemon.gripper.notice
    if notice is not None:
        found.append(warning("gripper", f"{port}: {notice.title}", notice.remedy))
    if daemon.gripper.board is None:
        return found
    return [*found, *_told(where, daemon.gripper.board)]


def _port(role: BoardRole, port: str, section: FeederSection | GripperSection) -> BoardPort:
    return BoardPort(
        role=role,
        port=port,
        baud=section.baud,
        reply_timeout_s=section.reply_timeout_s,
        serial_number=section.serial_number,
        table="feeder" if role is BoardRole.CONVEYOR else "gripper",
    )


def _reachable(config: CellConfig, where: BoardPort, daemon_runs: bool) -> list[Finding]:
    """What is wrong with the port itself; empty when nothing is."""
    topic, port, option = where.role.value, Path(where.port), f"{where.table}.port"
    try:
        mode = port.stat().st_mode
    except OSError as error:
        advice = f"Check its USB cable and power, or correct {option}."
        if config.emulation is not None:
            advice = f"Start the emulated cell with `cellctl sim`, or correct {option}."
        return [problem(topic, f"{port}: {error.strerror}", advice)]
    if not stat.S_ISCHR(mode):
        return [problem(topic, f"{port} is no serial port", f"Correct {option}.")]
    if not os.access(port, os.R_OK | os.W_OK):
        group = "Add this user to the group that owns it, mostly dialout."
        text = f"{port} may not be read and written by this user"
        return [(warning if daemon_runs else problem)(topic, text, group)]
    return []


def _told(where: BoardPort, board: BoardData | None) -> list[Finding]:
    """What the daemon knows of a board that it is connected to."""
    topic = where.role.value
    if board is None:
        return [ok(topic, f"{where.port}: the daemon is connected to its board")]
    return _version(
        where, board.serial_number, board.firmware_version, board.protocol_version, "the daemon's"
    )


def _version(
    where: BoardPort, serial_number: str, firmware: str, protocol: int, whose: str
) -> list[Finding]:
    topic, belongs = where.role.value, FIRMWARE_VERSION[where.role]
    text = (
        f"{where.port}: {whose} {where.role} {serial_number}, firmware {firmware}, "
        f"protocol {protocol}"
    )
    found = [ok(topic, text)]
    if firmware != belongs:
        advice = f"`make flash-{where.role}` installs it, when there is time for it."
        text = f"its firmware is {firmware}; {belongs} belongs to this cellctl"
        found.append(warning(topic, text, advice))
    return found


async def _ask(where: BoardPort, remedy: str) -> list[Finding]:
    board, topic = Board(where), where.role.value
    try:
        async with asyncio.timeout(_BOARD_TIMEOUT_S):
            found = await board.connect()
    except CellctlError as error:
        return [problem(topic, error.message, error.hint or remedy)]
    except TimeoutError:
        text = f"{where.port}: no answer within {_BOARD_TIMEOUT_S:.0f} s"
        return [problem(topic, text, remedy)]
    finally:
        board.drop()
    return _version(where, found.serial_number, found.firmware_version, found.protocol_version, "a")
