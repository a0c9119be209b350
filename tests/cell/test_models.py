"""The other robot: a UR10 on a CB3 controller at 125 Hz."""

from __future__ import annotations

import pytest

from tests.cell.harness import running_cell

pytestmark = pytest.mark.wire


def test_a_ur10_at_125_hz_builds_the_letter_t() -> None:
    with running_cell(
        speed=10.0,
        robot={"model": "ur10", "rtde_frequency_hz": 125},
        emulation={"controller_version": "3.15"},
    ) as cell:
        cell.visitor.say("the letter T")
        assert cell.finish().outcome == "built"
        cell.assert_as_planned()
