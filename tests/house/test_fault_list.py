"""Every fault of the catalogue is provoked at the wire, and left by its documented way."""

from __future__ import annotations

import inspect
from importlib import import_module

import pytest

from cellctl.errors import CATALOGUE

FAULTS = "tests.cell.test_faults"
WAYS = "tests.cell.test_fault_ways"
JOURNAL = "tests.cell.test_journal_faults"

PROVOKED: dict[str, tuple[str, str]] = {
    "belt_empty": (WAYS, "test_nobody_refills_the_belt"),
    "belt_jam": (FAULTS, "test_a_jammed_belt"),
    "belt_lost": (FAULTS, "test_a_silent_conveyor_board"),
    "belt_mismatch": (WAYS, "test_another_board_is_on_the_conveyors_port"),
    "gripper_silent": (FAULTS, "test_a_gripper_that_reports_nothing"),
    "gripper_fault": (FAULTS, "test_a_gripper_that_reports_a_fault"),
    "gripper_reset": (WAYS, "test_the_grippers_board_is_reset_with_a_part_in_it"),
    "gripper_mismatch": (WAYS, "test_another_board_is_on_the_grippers_port"),
    "pick_missed": (FAULTS, "test_a_part_that_lies_turned_is_missed_twice_and_then_a_fault"),
    "not_seated": (WAYS, "test_nothing_is_under_the_part_that_is_to_be_let_go"),
    "contact_early": (WAYS, "test_a_part_below_stands_too_high"),
    "part_stuck": (WAYS, "test_a_part_that_sticks_to_the_gripper_is_not_torn_off"),
    "part_fell": (WAYS, "test_a_part_is_set_down_too_hard_in_a_trial_of_speed"),
    "gripper_holds": (WAYS, "test_the_latch_holds_something_that_nobody_knows_of"),
    "arm_moved": (WAYS, "test_the_arm_is_moved_while_the_latch_is_not_confirmed"),
    "no_route": (WAYS, "test_a_part_stands_over_the_cell_where_another_must_go"),
    "protective_stop": (FAULTS, "test_a_protective_stop_in_mid_place"),
    "safeguard_stop": (FAULTS, "test_a_safeguard_stop_in_mid_place"),
    "emergency_stop": (FAULTS, "test_an_emergency_stop_in_mid_place"),
    "local_control": (WAYS, "test_the_pendant_is_switched_to_local"),
    "robot_lost": (FAULTS, "test_a_lost_connection_in_mid_place"),
    "program_stopped": (FAULTS, "test_a_killed_program_in_mid_place"),
    "motion_timeout": (WAYS, "test_the_speed_slider_is_down"),
    "robot_mismatch": (WAYS, "test_the_robots_settings_were_changed_on_the_pendant"),
    "journal_failed": (JOURNAL, "test_a_full_disk_in_mid_build"),
    "journal_damaged": (JOURNAL, "test_a_damaged_journal"),
    "internal": (WAYS, "test_the_inventory_rules_out_what_the_arm_has_done"),
}
"""Code -> module and function of the test."""


def test_every_fault_has_a_test_and_every_test_its_fault() -> None:
    assert set(PROVOKED) == set(CATALOGUE)
    assert len(set(PROVOKED.values())) == len(PROVOKED)


@pytest.mark.parametrize("code", PROVOKED)
def test_the_test_provokes_it_and_leaves_it_by_a_reset(code: str) -> None:
    module, name = PROVOKED[code]
    body = inspect.getsource(getattr(import_module(module), name))
    assert f'expect_fault(idle, "{code}")' in body or f'expect_fault(cell, "{code}")' in body
    after = body.rpartition(f'"{code}")')[2]
    assert "reset" in after, f"{name} does not leave {code}"


@pytest.mark.parametrize("module", [FAULTS, WAYS, JOURNAL])
def test_those_tests_are_run_at_the_wire(module: str) -> None:
    marks = import_module(module).pytestmark
    assert "wire" in {mark.name for mark in marks}
    assert "soak" not in {mark.name for mark in marks}
