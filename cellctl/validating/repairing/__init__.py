"""Repair that keeps the shape, by an exact search over sizes and cells."""

from cellctl.validating.repairing.score import FORMULA, Likeness, Wanted
from cellctl.validating.repairing.shape import LEAST_SCORE, Repaired, repair_shape

__all__ = ["FORMULA", "LEAST_SCORE", "Likeness", "Repaired", "Wanted", "repair_shape"]
