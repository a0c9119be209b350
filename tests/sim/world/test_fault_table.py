"""The table of faults: what it accepts, and that the documentation shows it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cellctl.errors import UsageError
from cellctl.sim.cell import EmulatedCell
from cellctl.sim.conveyor_faults import FAULTS as CONVEYOR_FAULTS
from cellctl.sim.faults import FAULTS, Device, Fault, Parameter
from cellctl.sim.gripper_board import FAULTS as GRIPPER_BOARD_FAULTS
from cellctl.sim.latch import LatchFault
from cellctl.sim.messages import Argument
from cellctl.sim.world_values import Imperfections, ViolationKind
from tests.leaks import REPOSITORY
from tests.sim.world.hand import emulated_config

PAGE = (REPOSITORY / "docs" / "emulated-cell.md").read_text(encoding="utf-8")


def row(fault: Fault) -> str:
    """The line of the documentation that shows a fault."""
    arguments = "; ".join(_argument(parameter) for parameter in fault.parameters)
    ends = f"once. {fault.remedy}" if fault.once else "when cleared"
    return f"| `{fault.name}` | {fault.device} | {fault.title} | {arguments} | {ends} |"


def _argument(parameter: Parameter) -> str:
    default = "" if parameter.default is None else f", {str(parameter.default).lower()}"
    needed = ", required" if parameter.required else ""
    return f"`{parameter.name}`: {parameter.meaning}{default}{needed}"


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_the_documentation_shows_the_fault(fault: Fault) -> None:
    assert f"\n{row(fault)}\n" in PAGE


def test_the_documentation_shows_no_other_fault() -> None:
    table = PAGE.partition("\n## Faults\n")[2].partition("\n## ")[0]
    assert table.count("\n| `") == len(FAULTS)


@pytest.mark.parametrize("name", [*ViolationKind, *Imperfections.model_fields])
def test_the_documentation_shows_what_is_judged_and_what_is_imperfect(name: str) -> None:
    assert f"`{name}`" in PAGE


def test_no_fault_of_a_device_is_left_out() -> None:
    effects = {(fault.device, fault.effect) for fault in FAULTS.values()}
    assert {effect for device, effect in effects if device is Device.CONVEYOR} == set(
        CONVEYOR_FAULTS
    )
    assert {effect for device, effect in effects if device is Device.GRIPPER_BOARD} == set(
        GRIPPER_BOARD_FAULTS
    )
    assert {(Device.GRIPPER, fault.value) for fault in LatchFault} <= effects


@pytest.mark.parametrize(
    ("name", "arguments", "message"),
    [
        ("protective_stopp", {}, "protective_stop"),
        ("stuck_input", {}, "needs line"),
        ("stuck_input", {"line": "0"}, "is no int"),
        ("stuck_input", {"line": True}, "is no int"),
        ("stuck_input", {"line": 0, "hihg": True}, "no argument 'hihg'"),
        ("stuck_input", {"line": 99}, "no line 99"),
        ("board_reset", {"cause": "boredom"}, "cause"),
    ],
)
def test_what_cannot_be_injected_is_refused_with_what_could_be(
    name: str, arguments: dict[str, Argument], message: str
) -> None:
    cell = EmulatedCell(emulated_config())
    with pytest.raises(UsageError, match=message):
        cell.inject(name, arguments)
    assert cell.truth(0.0).faults == ()


@given(st.integers(-1000, 1000))
def test_whole_numbers_are_taken_where_fractions_are_asked_for(number: int) -> None:
    assert FAULTS["part_yawed"].complete({"yaw_rad": number}) == {"yaw_rad": number}


def test_the_same_fault_on_two_lines_is_two_faults() -> None:
    cell = EmulatedCell(emulated_config())
    cell.inject("stuck_output", {"line": 0})
    cell.inject("stuck_output", {"line": 1})
    cell.clear("stuck_output", {"line": 0})
    assert cell.truth(0.0).faults == ("stuck_output line=1",)
