"""The form of the arms that cellctl knows, after Universal Robots: for kinematics and for drawing.

Sideways offsets of the two tubes: the robot's own description files. All nominal.
"""

from __future__ import annotations

from typing import NamedTuple


class LinkLengths(NamedTuple):
    """Universal Robots, "DH Parameters for calculations of kinematics and dynamics"; metres."""

    d1: float
    """Height of the shoulder's axis above the foot."""
    upper_arm: float
    forearm: float
    d4: float
    """Wrist 1, sideways out of the arm's plane."""
    d5: float
    d6: float
    """From the crossing of the last two axes to the flange."""


LINK_LENGTHS = {
    "ur10": LinkLengths(0.1273, 0.612, 0.5723, 0.163941, 0.1157, 0.0922),
    "ur10e": LinkLengths(0.1807, 0.6127, 0.57155, 0.17415, 0.11985, 0.11655),
}
UPPER_ASIDE_M = {"ur10": 0.2209, "ur10e": 0.1762}
"""How far the upper arm's tube is beside the arm's plane."""
FORE_ASIDE_M = {"ur10": 0.0490, "ur10e": 0.0393}
"""The same of the forearm's."""
