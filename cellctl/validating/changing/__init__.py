"""Taking an object apart, and changing it into the next one: every step proven."""

from cellctl.validating.changing.changeover import ChangeOver, change_over
from cellctl.validating.changing.moves import Belt, Move, removal_order
from cellctl.validating.changing.plans import plan_change_over, plan_removal
from cellctl.validating.changing.removal import Attempt, Removal, assess_removal

__all__ = [
    "Attempt",
    "Belt",
    "ChangeOver",
    "Move",
    "Removal",
    "assess_removal",
    "change_over",
    "plan_change_over",
    "plan_removal",
    "removal_order",
]
