"""Why something is not built, or the cell stands still, for those who only want an object: no
cells, no figures, no settings, no commands.

An operator, and whoever plans by hand, is told all of it.
"""

from __future__ import annotations

from typing import Final

from cellctl.errors import CellctlError, PlanError

BY_RULE: Final = {
    "workspace": "It is too large for the space that I build in.",
    "count": "It takes more parts than I have.",
    "connectivity": "It would be several things that do not touch.",
    "grounded": "It would hang in the air.",
    "access": "My gripper does not get to all of its places.",
    "order": "There is no order in which I could build it.",
    "stability": "My parts would not hold together like that.",
    "overhang": "It reaches out too far.",
    "stack": "It is too high for how thin it is.",
    "reach": "My arm does not reach all of it.",
}
"""By the rule that a shape breaks."""
INSTEAD: Final = "Ask for something smaller or simpler, or for something else."
"""What a visitor can do about all of them."""
_WHERE: Final = {
    "no_parts": ("belt_empty",),
    "belt": ("belt_jam", "belt_lost", "belt_mismatch"),
    "gripper": (
        *("gripper_silent", "gripper_fault", "gripper_reset", "gripper_mismatch"),
        *("gripper_holds", "part_stuck"),
    ),
    "part": ("pick_missed", "not_seated", "part_fell"),
    "in_the_way": ("contact_early", "no_route", "protective_stop"),
    "too_close": ("safeguard_stop",),
    "emergency": ("emergency_stop",),
    "arm": (
        *("arm_moved", "local_control", "robot_lost"),
        *("program_stopped", "motion_timeout", "robot_mismatch"),
    ),
    "inside": ("journal_failed", "journal_damaged", "internal"),
}
"""Codes of faults that are the same to a visitor."""
BY_FAULT: Final = {code: f"waits.{where}" for where, codes in _WHERE.items() for code in codes}
"""Key of what a visitor is told, by the code of the fault."""


def plainly(error: CellctlError) -> str:
    """Why, and what to do about it."""
    if isinstance(error, PlanError) and error.rule in BY_RULE:
        return f"{BY_RULE[error.rule]} {INSTEAD}"
    return str(error)


def reason(error: PlanError) -> str:
    """Why, without what to do."""
    return BY_RULE.get(error.rule, error.message)
