"""Collisions: the gripper's body and the part it holds, swept against everything solid.

All of it happens in the workspace frame. Bodies are shrunk by ``CONTACT_TOLERANCE_M`` on every
side, so that faces may touch and parts may be placed between neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.sim.plant import Floats
from cellctl.sim.world_belt import BeltRow
from cellctl.sim.world_geometry import Box, Triple, apart, between, inverse, pose_matrix, rotation

CONTACT_TOLERANCE_M = 0.002
"""How deep two things may overlap before it counts as a collision."""
SWEEP_STEP_M = 0.002
"""Between two poses of the arm, contact is looked for at least this often along the way."""
_GROUND_M = 20.0
"""Extent of the floor that the world knows of."""


class Contact(NamedTuple):
    """Two things that overlap."""

    body: str
    obstacle: str
    part: int | None = None
    cell: Cell | None = None


@dataclass(frozen=True)
class Body:
    """A block that moves with the tool: centred on the TCP's z axis."""

    name: str
    offset_m: float
    """From the TCP to the centre, along the TCP's z axis."""
    half_m: Triple

    def at(self, tcp: Floats) -> Box:
        """Where it is when the TCP is there."""
        pose = tcp.copy()
        pose[:3, 3] += pose[:3, 2] * self.offset_m
        return Box(pose, self.half_m)

    @property
    def arm_m(self) -> float:
        """How far its furthest corner is from the TCP, at most."""
        return abs(self.offset_m) + float(np.linalg.norm(self.half_m))


class Contacts:
    """Everything solid that stands still, and the bodies that move.

    Args:
        config: the cell.
        from_cell: 4x4, cell frame to workspace frame.
    """

    def __init__(self, config: CellConfig, from_cell: Floats) -> None:
        self._pitch_m = config.voxel.pitch_m
        self._grid = config.grid
        width_m, height_m = config.tool.width_m, config.tool.height_m
        self._gripper = _body("gripper", -height_m / 2, (width_m, width_m, height_m))
        edges = (self._pitch_m,) * 3
        self._held = _body("held part", self._pitch_m / 2, edges)
        self._from_feeder = from_cell @ pose_matrix(config.feeder.frame)
        self._to_feeder = inverse(self._from_feeder)
        self._still = [(name, box, *box.bounds()) for name, box in _furniture(config, from_cell)]

    def along(
        self, start: Floats, end: Floats, holding: bool, placed: dict[Cell, int], row: BeltRow
    ) -> set[Contact]:
        """What the tool touches on its way from one TCP pose (left out) to the next."""
        found: set[Contact] = set()
        for body in (self._gripper, self._held) if holding else (self._gripper,):
            first, last = body.at(start).bounds(), body.at(end).bounds()
            # Corners of a turning body leave the hull of its first and last bounds.
            turning = float(np.abs(start[:3, :3] - end[:3, :3]).max()) > 0.02
            low, high = _hull(first, last, body.arm_m if turning else 0.0)
            near = self._near(body.name, low, high, placed)
            near += self._near_on_belt(body, start, end, row)
            if not near:
                continue
            for tcp in between(start, end, SWEEP_STEP_M, body.arm_m):
                box = body.at(tcp)
                found.update(contact for contact, obstacle in near if box.overlaps(obstacle))
        return found

    def _near(
        self, body: str, low: Triple, high: Triple, placed: dict[Cell, int]
    ) -> list[tuple[Contact, Box]]:
        near = [
            (Contact(body, name), box)
            for name, box, box_low, box_high in self._still
            if not apart(low, high, box_low, box_high)
        ]
        if not placed:
            return near
        pitch_m = self._pitch_m
        spans = [
            range(max(0, int(a // pitch_m)), min(count, int(b // pitch_m) + 1))
            for a, b, count in zip(low, high, self._grid, strict=True)
        ]
        for x in spans[0]:
            for y in spans[1]:
                for z in spans[2]:
                    cell = Cell(x, y, z)
                    if cell in placed:
                        contact = Contact(body, "placed part", placed[cell], cell)
                        near.append((contact, self._cell_box(cell)))
        return near

    def _cell_box(self, cell: Cell) -> Box:
        pose = np.eye(4)
        pose[:3, 3] = [(index + 0.5) * self._pitch_m for index in cell]
        half_m = self._pitch_m / 2
        return Box(pose, (half_m, half_m, half_m))

    def _near_on_belt(
        self, body: Body, start: Floats, end: Floats, row: BeltRow
    ) -> list[tuple[Contact, Box]]:
        """Parts of the belt's row whose surrounding sphere comes near the body's."""
        centres = np.stack([body.at(start).pose[:, 3], body.at(end).pose[:, 3]])
        (x0, y0, z0, _), (x1, y1, z1, _) = (centres @ self._to_feeder.T).tolist()
        half_m = self._pitch_m / 2
        radius_m = float(np.linalg.norm(body.half_m))
        if min(z0, z1) - radius_m >= 0.0 or min(abs(y0), abs(y1)) > radius_m + 2 * half_m:
            return []
        low_m, high_m = min(x0, x1) - radius_m, max(x0, x1) + radius_m
        near = []
        for item in row.parts:
            if low_m - 2 * half_m < item.position_m < high_m + 2 * half_m:
                pose = np.eye(4)
                pose[:3, :3] = rotation(np.array([0.0, 0.0, item.yaw_rad]))
                pose[:3, 3] = [item.position_m, 0.0, -half_m]
                box = Box(self._from_feeder @ pose, (half_m, half_m, half_m))
                near.append((Contact(body.name, "part on the belt", item.part), box))
        return near


def _hull(
    first: tuple[Triple, Triple], last: tuple[Triple, Triple], margin_m: float
) -> tuple[Triple, Triple]:
    (ax, ay, az), (bx, by, bz) = first[0], last[0]
    (cx, cy, cz), (dx, dy, dz) = first[1], last[1]
    return (
        (min(ax, bx) - margin_m, min(ay, by) - margin_m, min(az, bz) - margin_m),
        (max(cx, dx) + margin_m, max(cy, dy) + margin_m, max(cz, dz) + margin_m),
    )


def _body(name: str, offset_m: float, edges_m: Triple) -> Body:
    x, y, z = (edge_m / 2 - CONTACT_TOLERANCE_M for edge_m in edges_m)
    return Body(name, offset_m, (x, y, z))


def _furniture(config: CellConfig, from_cell: Floats) -> list[tuple[str, Box]]:
    """Floor, pedestal and belt, in the workspace frame."""

    def block(frame: Floats, centre_m: Triple, edges_m: Triple) -> Box:
        pose = np.eye(4)
        pose[:3, 3] = centre_m
        x, y, z = (edge_m / 2 for edge_m in edges_m)
        return Box(from_cell @ frame @ pose, (x, y, z))

    ground = block(np.eye(4), (0.0, 0.0, -_GROUND_M / 2), (_GROUND_M,) * 3)
    width_m, depth_m, height_m = config.pedestal.size_m
    pedestal = block(
        pose_matrix(config.pedestal.frame),
        (0.0, 0.0, -height_m / 2),
        (width_m, depth_m, height_m),
    )
    furniture = [("floor", ground), ("pedestal", pedestal)]
    # The belt carries the waiting part, so its surface is one part below the feeder's frame; it
    # ends under that part's leading edge.
    pitch_m = config.voxel.pitch_m
    surface_m = config.feeder.frame[2] - pitch_m
    if surface_m > CONTACT_TOLERANCE_M:
        length_m = config.feeder.capacity_parts * pitch_m
        belt = block(
            pose_matrix(config.feeder.frame),
            (pitch_m / 2 - length_m / 2, 0.0, -pitch_m - surface_m / 2),
            (length_m, config.feeder.width_m, surface_m),
        )
        furniture.append(("belt", belt))
    return furniture
