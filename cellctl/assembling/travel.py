"""Going along a checked route, whatever it consists of."""

from __future__ import annotations

from cellctl.assembling.arm import Arm, Switch
from cellctl.assembling.route_check import Route


async def travel(arm: Arm, route: Route, switch: Switch | None = None) -> None:
    """Follow a route's path, then turn the joints where it says so; returns when at rest.

    Args:
        arm: what moves.
        route: where it goes.
        switch: an output that is switched just before the path's end.

    Raises:
        CellFault: whatever keeps the arm from arriving.
        CancelledError: the arm was told to stop.
    """
    if route.path:
        await arm.follow(route.path, route.duration_s, switch)
    if route.joints is not None:
        await arm.move_joints(route.joints, route.joint_speed_rad_s)
