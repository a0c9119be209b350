"""The doctor's look at the daemon and the robot. It asks; it never moves or sets anything."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from cellctl import __version__
from cellctl.assembling.arm_dashboard import Dashboard, finished
from cellctl.assembling.arm_rtde import TOOL_VOLTAGE, read_integer
from cellctl.cli.commissioning import CommissionRecord
from cellctl.cli.findings import Finding, ok, problem, warning
from cellctl.client import CellClient, NoDaemonError
from cellctl.config import CellConfig
from cellctl.errors import CellctlError, CellFault
from cellctl.messages import Snapshot

_BUS_TIMEOUT_S = 1.5


def daemon(config: CellConfig, key: Path | None = None) -> tuple[list[Finding], Snapshot | None]:
    """What a running daemon says of itself; None where none answers."""
    try:
        with CellClient.for_role(config, timeout_s=_BUS_TIMEOUT_S, key=key) as cell:
            snapshot = cell.snapshot()
    except NoDaemonError:
        return [ok("daemon", "none runs (or none answers at its operator's door)")], None
    except CellctlError as error:
        return [warning("daemon", error.message, error.hint)], None
    found = [ok("daemon", f"runs, state {snapshot.state.state.replace('_', ': ')}")]
    if snapshot.version != __version__:
        found.append(
            warning(
                "daemon",
                f"it is version {snapshot.version}; this command is {__version__}",
                "Restart the daemon while the cell is idle.",
            )
        )
    if snapshot.fault.entry is not None:
        entry = snapshot.fault.entry
        text = f"fault {entry.code}: {entry.title} {snapshot.fault.detail}".strip()
        found.append(problem("fault", text, entry.remedy))
    return found, snapshot


def robot(config: CellConfig, record: CommissionRecord | None) -> list[Finding]:
    """Who the robot is and whether it could move."""
    try:
        with closing(Dashboard(config.robot)) as dashboard:
            found = _identity(dashboard, config, record)
            safety = dashboard.ask("safetymode").partition(":")[2].strip()
            mode = dashboard.ask("robotmode").partition(":")[2].strip()
    except CellFault as fault:
        return [problem("robot", fault.message, fault.entry.remedy)]
    if safety == "NORMAL":
        found.append(ok("robot", f"safety mode {safety}, robot mode {mode}"))
    else:
        advice = "See what stops or limits it, on the pendant and around the cell."
        found.append(problem("robot", f"safety mode {safety}, robot mode {mode}", advice))
    if mode != "RUNNING":
        advice = "Switch the arm on and release its brakes, on the pendant."
        found.append(warning("robot", f"the arm is not ready: {mode}", advice))
    return [*found, *_tool_voltage(config)]


def _identity(
    dashboard: Dashboard, config: CellConfig, record: CommissionRecord | None
) -> list[Finding]:
    try:
        identity = dashboard.identity(config.robot.model)
    except CellFault as fault:
        if fault.code not in {"robot_mismatch", "local_control"}:
            raise
        return [problem("robot", fault.message, fault.entry.remedy)]
    serial = f" {identity.serial_number}" if identity.serial_number else ""
    text = f"{identity.model}{serial}, software {identity.controller_version}, remote control"
    found = [ok("robot", text)]
    if record is not None and record.robot is not None and record.robot != identity:
        was = record.robot
        found.append(
            warning(
                "robot",
                f"the cell was commissioned with {was.model} {was.serial_number}, "
                f"software {was.controller_version}",
                "Commission the cell anew: `cellctl commission`.",
            )
        )
    return found


def _tool_voltage(config: CellConfig) -> list[Finding]:
    try:
        voltage_v = finished(read_integer(config.robot.host, TOOL_VOLTAGE))
    except CellFault as fault:
        return [problem("tool supply", fault.message, fault.entry.remedy)]
    wanted_v = config.tool.voltage_v
    if voltage_v != wanted_v:
        advice = "Set it on the pendant (Installation, Tool I/O), or correct tool.voltage_v."
        text = f"{voltage_v} V, must be {wanted_v} V"
        return [problem("tool supply", text, advice)]
    return [ok("tool supply", f"{voltage_v} V")]
