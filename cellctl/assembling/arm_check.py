"""What the robot has set against what it should have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cellctl.assembling.arm import ArmCheck, ArmIdentity
from cellctl.assembling.poses import distance
from cellctl.config import CellConfig
from cellctl.errors import CellFault

_TOLERANCE = 1e-4
"""TCP (m, rad) and payload (kg, m) may differ by rounding only."""


def refuse_mismatch(
    check: ArmCheck,
    config: CellConfig,
    connected: ArmIdentity | None,
    ordered: Mapping[int, bool],
) -> None:
    """Compare what was read back.

    Args:
        check: what was read back.
        config: what model, TCP, payload and tool voltage should be.
        connected: who it was when the connection was made; None where nobody looked.
        ordered: the level that each digital output was last ordered to have.

    Raises:
        CellFault: ``robot_mismatch``; names everything that differs, each with what it should be.
    """
    problems = mismatches(check, config, connected, ordered)
    if problems:
        raise CellFault("robot_mismatch", " ".join(problems))


def mismatches(
    check: ArmCheck,
    config: CellConfig,
    connected: ArmIdentity | None,
    ordered: Mapping[int, bool],
) -> list[str]:
    """One sentence for each thing that is not as it should be."""
    tool = config.tool
    problems = []
    if connected is not None and check.identity != connected:
        problems.append(f"It is {_who(check.identity)} and was {_who(connected)}.")
    if max(distance(check.tcp, tool.frame)) > _TOLERANCE:
        problems.append(f"The TCP is {_numbers(check.tcp)} and must be {_numbers(tool.frame)}.")
    if abs(check.payload_kg - tool.payload_kg) > _TOLERANCE:
        problems.append(
            f"The payload is {check.payload_kg:g} kg and must be {tool.payload_kg:g} kg."
        )
    off_m = [abs(a - b) for a, b in zip(check.payload_cog_m, tool.payload_cog_m, strict=True)]
    if max(off_m) > _TOLERANCE:
        problems.append(
            f"The payload's centre of gravity is {_numbers(check.payload_cog_m)} m and must be "
            f"{_numbers(tool.payload_cog_m)} m."
        )
    if check.tool_voltage_v != tool.voltage_v:
        problems.append(
            f"The tool's supply is {check.tool_voltage_v} V and must be {tool.voltage_v} V; "
            "set it on the pendant (Installation, Tool I/O)."
        )
    if check.safety_mode != "normal":
        problems.append(f"The safety mode is {check.safety_mode} and must be normal.")
    for line, high in sorted(ordered.items()):
        if bool(check.digital_outputs >> line & 1) != high:
            is_, must = ("low", "high") if high else ("high", "low")
            problems.append(
                f"Digital output {line} is {is_} and was ordered {must}; "
                "somebody switched it elsewhere."
            )
    return problems


def _who(identity: ArmIdentity) -> str:
    serial = f" number {identity.serial_number}" if identity.serial_number else ""
    return f"a {identity.model}{serial} with software {identity.controller_version}"


def _numbers(values: Sequence[float]) -> str:
    return f"[{', '.join(f'{value:.4g}' for value in values)}]"
