"""What the world tells about itself: where parts are, what went wrong, how imperfect it is."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from cellctl.assembly import Cell, Value


class Where(StrEnum):
    """The places where a part can be; each part is in exactly one of them."""

    STOCK = "stock"
    """In the box beside the belt."""
    BELT = "belt"
    PICK_STATION = "pick_station"
    """On the belt, with its leading edge at the stop."""
    GRIPPER = "gripper"
    PLACED = "placed"
    """At a cell of the workspace."""
    FALLEN = "fallen"
    """On the floor, out of play until somebody clears the workspace."""
    HANDED_OVER = "handed_over"


class PartTruth(Value):
    """One part and where it is."""

    part: int
    where: Where
    cell: Cell | None = None
    """For ``placed``."""
    belt_m: float | None = None
    """For ``belt`` and ``pick_station``: distance to the stop, in metres; 0 at the stop."""


class ViolationKind(StrEnum):
    """What the world holds against those who run the cell."""

    RELEASED_IN_MID_AIR = "released_in_mid_air"
    """Let go too high above the cell; the part falls."""
    RELEASED_MISALIGNED = "released_misaligned"
    """Let go beside a cell, too deep, tilted or yawed; the part falls."""
    RELEASED_OUTSIDE = "released_outside"
    """Let go outside of the workspace; the part falls."""
    RELEASED_UNSUPPORTED = "released_unsupported"
    """Let go at a cell where it neither stands on the floor nor touches a placed part; falls."""
    RELEASED_INTO_PART = "released_into_part"
    """Let go at a cell that another part fills; the part falls."""
    JOLTED = "jolted"
    """Set down too hard: the part does not stay, and falls."""
    COLLAPSED = "collapsed"
    """Joints do not bear the weight on them or the push of a placement; what they held falls."""
    LOST_SUPPORT = "lost_support"
    """Nothing joins a part to the floor any more, and the part falls."""
    COLLISION = "collision"
    """The gripper or its part ran into something."""
    PICKED_NOTHING = "picked_nothing"
    """The latch closed where a part should be, and none was within its tolerance."""
    DRAGGED_NEIGHBOUR = "dragged_neighbour"
    """A part was pulled aside while another still stuck to it, or taken off in a way that the
    joints of its neighbours do not bear; what comes along falls."""


class Violation(Value):
    """One thing that must not happen in a cell, as it happened."""

    kind: ViolationKind
    message: str
    cell_time_s: float
    part: int | None = None
    cell: Cell | None = None


class Imperfections(Value):
    """How far the belt and its parts are from perfect; all zero is a perfect cell.

    ``belt_slip`` acts on every movement; the rest is drawn for each part when it is laid on the
    belt, from the world's seed.
    """

    belt_slip: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """Largest share of a movement that the parts do not follow; drawn evenly from 0 to this."""
    pitch_drift_m: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0
    """Largest extra gap to the part ahead, in metres; drawn evenly from 0 to this."""
    yawed_share: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """Share of parts that are laid on the belt turned."""
    yaw_rad: Annotated[float, Field(ge=0.0, le=0.8)] = 0.26
    """How far those are turned, to either side."""
    missing_share: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """Share of places on the belt that hold no part."""
    sticky_share: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """Share of parts that stick to the part behind them."""
