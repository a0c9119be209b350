"""Watches the arm in every state, and shows what it says."""

from __future__ import annotations

import time
from collections.abc import Callable

from cellctl.assembling.arm import Arm, ArmState
from cellctl.clock import Clock
from cellctl.control.controller import Controller
from cellctl.control.states import top_of
from cellctl.errors import CellFault
from cellctl.messages import ArmData, StatusData

_PERIOD_S = 0.05
_LOST_S = 2.0
"""An arm that says nothing for so long while nobody moves it is lost (wall time: so long an arm
process that died is asked for the cause, however fast the cell's clock runs)."""
_PUBLISH_MOVING_S = 0.2
_PUBLISH_RESTING_S = 2.0

_FAULTS = {
    "protective": "protective_stop",
    "safeguard": "safeguard_stop",
    "emergency": "emergency_stop",
    "fault": "protective_stop",
}


def arm_view(state: ArmState | None) -> ArmData:
    """The arm as the bus shows it."""
    if state is None:
        return ArmData(connected=False)
    return ArmData(
        connected=True,
        robot_time_s=state.robot_time_s,
        joints_rad=state.joints_rad,
        tcp_pose=state.tcp_pose,
        tcp_speed_m_s=state.tcp_speed_m_s,
        moving=state.moving,
        safety=state.safety,
        speed_fraction=state.speed_fraction,
    )


class ArmMonitor:
    """Publishes the arm's state and reports stops that strike while nobody moves it."""

    def __init__(
        self,
        arm: Arm,
        clock: Clock,
        controller: Controller,
        publish: Callable[[StatusData], None],
    ) -> None:
        self._arm = arm
        self._clock = clock
        self._controller = controller
        self._publish = publish

    async def run(self) -> None:
        """Watch until cancelled."""
        published_s = -_PUBLISH_RESTING_S
        heard_s = time.monotonic()
        reported = ""
        while True:
            state = self._arm.state()
            watched = top_of(self._controller.state) not in {"starting", "fault"}
            if state is not None or not watched:
                heard_s = time.monotonic()
            trouble = "" if state is None else _FAULTS.get(state.safety, "")
            if time.monotonic() - heard_s > _LOST_S:
                trouble = "robot_lost"
            if not trouble or not watched:
                reported = ""
            elif trouble != reported:
                reported = trouble
                self._controller.post_fault(CellFault(trouble))
            moving = state is not None and state.moving
            period_s = _PUBLISH_MOVING_S if moving else _PUBLISH_RESTING_S
            now_s = self._clock.now_s()
            if now_s - published_s >= period_s:
                published_s = now_s
                self._publish(arm_view(state))
            await self._clock.sleep(_PERIOD_S)
