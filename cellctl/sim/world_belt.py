"""The row of parts on the belt: one dimension, an end stop, friction that may fail.

Positions are distances of a part's centre from its place at the pick station, in metres along the
feed: 0 at the stop, negative while the part is on its way. The belt drives every part; at the stop
it slips under the waiting part, and the parts behind queue up face to face.
"""

from __future__ import annotations

import random
from dataclasses import dataclass

from cellctl.sim.world_values import Imperfections

SENSOR_TOLERANCE_M = 0.004
"""The sensor sees a part whose leading edge is this close to the stop."""


@dataclass
class BeltPart:
    """One part on the belt."""

    part: int
    position_m: float
    yaw_rad: float = 0.0
    sticky: bool = False
    """Sticks to the part behind it."""


class BeltRow:
    """The parts on the belt, the one nearest to the stop first.

    Args:
        pitch_m: edge of a part, and the distance from part to part where nothing is amiss.
        rng: where every imperfection is drawn from.
    """

    def __init__(self, pitch_m: float, rng: random.Random) -> None:
        self.pitch_m = pitch_m
        self.parts: list[BeltPart] = []
        self._rng = rng

    def __len__(self) -> int:
        return len(self.parts)

    def lay(self, parts: list[int], imperfections: Imperfections) -> list[int]:
        """Lay parts on the belt behind those that are there.

        Returns:
            The parts whose place stayed empty; they are not on the belt.
        """
        left_out = []
        place_m = self.parts[-1].position_m if self.parts else 0.0
        for part in parts:
            place_m -= self.pitch_m + self._rng.uniform(0.0, imperfections.pitch_drift_m)
            if self._rng.random() < imperfections.missing_share:
                left_out.append(part)
                continue
            yawed = self._rng.random() < imperfections.yawed_share
            yaw_rad = self._rng.choice((-1.0, 1.0)) * imperfections.yaw_rad if yawed else 0.0
            sticky = self._rng.random() < imperfections.sticky_share
            self.parts.append(BeltPart(part, place_m, yaw_rad, sticky))
        return left_out

    def move(self, distance_m: float, slip: float) -> None:
        """Turn the belt; positive feeds towards the stop.

        Args:
            distance_m: how far the belt's surface moves.
            slip: largest share of it that the parts may not follow.
        """
        if slip:
            distance_m *= 1.0 - self._rng.uniform(0.0, slip)
        limit_m = 0.0
        for part in self.parts:
            # A part beyond its limit (put back by hand, say) is not pushed back by the stop.
            allowed_m = max(limit_m, part.position_m)
            part.position_m = min(part.position_m + distance_m, allowed_m)
            limit_m = part.position_m - self.pitch_m

    def at_stop(self) -> BeltPart | None:
        """The part at the pick station, if one is there."""
        if self.parts and abs(self.parts[0].position_m) <= SENSOR_TOLERANCE_M:
            return self.parts[0]
        return None

    def take(self, part: int) -> tuple[BeltPart, BeltPart | None]:
        """Take a part off the belt.

        Returns:
            The part, and the one behind it if the two stick together.

        Raises:
            KeyError: the part is not on the belt.
        """
        for index, item in enumerate(self.parts):
            if item.part == part:
                del self.parts[index]
                behind = self.parts[index] if index < len(self.parts) else None
                touching = (
                    behind is not None
                    and item.position_m - behind.position_m <= self.pitch_m + SENSOR_TOLERANCE_M
                )
                return item, behind if item.sticky and touching else None
        raise KeyError(part)

    def has_room_at_stop(self) -> bool:
        """Whether a part can be put back at the pick station."""
        return not self.parts or self.parts[0].position_m <= SENSOR_TOLERANCE_M - self.pitch_m

    def put_back(self, part: int) -> None:
        """Put a part at the pick station, which must have room."""
        assert self.has_room_at_stop(), "the pick station is taken"
        self.parts.insert(0, BeltPart(part, 0.0))

    def empty(self) -> list[int]:
        """Take everything off the belt."""
        parts = [item.part for item in self.parts]
        self.parts.clear()
        return parts
