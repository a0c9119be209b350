"""What a state of the controller says of the speed slider."""

from __future__ import annotations

import pytest

from cellctl.assembling.arm_receiver import PLAYING, RUNNING, Sample
from cellctl.control.monitor import arm_view


@pytest.mark.parametrize(
    ("slider", "shown"), [(1.0, 1.0), (0.5, 0.5), (0.01, 0.01), (0.0, 0.8), (0.005, 0.8)]
)
def test_a_slider_that_the_cell_holds_at_0_is_shown_where_somebody_put_it(
    slider: float, shown: float
) -> None:
    sample = Sample(
        robot_time_s=1.0,
        joints_rad=(0.0,) * 6,
        joint_speed_rad_s=0.0,
        tcp_pose=(0.0,) * 6,
        tcp_speed_m_s=0.0,
        tcp_force_n=(0.0,) * 3,
        told_pose=(0.0,) * 6,
        inputs=0,
        outputs=0,
        robot_mode=RUNNING,
        runtime_state=PLAYING,
        safety_bits=0,
        speed_fraction=slider,
    )
    assert arm_view(sample.state(chosen_fraction=0.8)).speed_fraction == shown
