"""Stability of every state of a structure, proven by linear programming."""

from cellctl.validating.stability.assess import Verdict, assess
from cellctl.validating.stability.joints import Joint
from cellctl.validating.stability.physics import Physics
from cellctl.validating.stability.prefixes import assess_order, walk_order

__all__ = ["Joint", "Physics", "Verdict", "assess", "assess_order", "walk_order"]
