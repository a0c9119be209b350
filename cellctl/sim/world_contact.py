"""Collisions: the gripper's body and the part it holds, swept against everything solid.

All of it happens in the workspace frame. Bodies are shrunk by ``CONTACT_TOLERANCE_M`` on every
side, so that faces may touch and parts may be placed between neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass
from operator import mul
from typing import NamedTuple

import numpy as np

from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.sim.plant import Floats
from cellctl.sim.world_belt import BeltRow
from cellctl.sim.world_geometry import Box, Triple, apart, between, pose_matrix, rotation

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


class Span(NamedTuple):
    """One pose of the tool, and the axis-parallel box around all of its bodies."""

    tcp: Floats
    turn: tuple[float, ...]
    """The nine elements of the rotation."""
    low: Triple
    high: Triple
    holding: bool


class Contacts:
    """Everything solid that stands still, and the bodies that move.

    Args:
        config: the cell.
        from_cell: 4x4, cell frame to workspace frame.
    """

    def __init__(self, config: CellConfig, from_cell: Floats) -> None:
        pitch_m = self._pitch_m = config.voxel.pitch_m
        self._grid = config.grid
        width_m, height_m = config.tool.width_m, config.tool.height_m
        self._gripper = _body("gripper", -height_m, 0.0, width_m)
        self._held = _body("held part", 0.0, pitch_m, pitch_m)
        # Gripper and held part in one block: almost always it touches nothing, and that is that.
        self._both = _body("both", -height_m, pitch_m, max(width_m, pitch_m))
        self._from_feeder = from_cell @ pose_matrix(config.feeder.frame)
        self._still = [(name, box, *box.bounds()) for name, box in _furniture(config, from_cell)]
        waiting = self._from_feeder @ np.array([0.0, 0.0, -pitch_m / 2, 1.0])
        self._row_line = (waiting[:3].tolist(), self._from_feeder[:3, 0].tolist())
        """Centre of the part that waits at the stop, and the direction of the feed."""
        self._row_zone = _row_zone(config, self._from_feeder).bounds()

    def near(
        self, low: Triple, high: Triple, placed: dict[Cell, int], row: BeltRow
    ) -> list[tuple[Contact, Box]]:
        """What is solid within an axis-parallel box; the contacts name no body yet."""
        return self._near("", low, high, placed, row)

    def span(self, tcp: Floats, holding: bool) -> Span:
        """The tool at one pose."""
        body = self._both if holding else self._gripper
        (xx, xy, xz, x), (yx, yy, yz, y), (zx, zy, zz, z), _ = tcp.tolist()
        # Written out, because this runs for every step of the arm.
        half_m, _, along_m = body.half_m
        x, y, z = x + xz * body.offset_m, y + yz * body.offset_m, z + zz * body.offset_m
        ex = (abs(xx) + abs(xy)) * half_m + abs(xz) * along_m
        ey = (abs(yx) + abs(yy)) * half_m + abs(yz) * along_m
        ez = (abs(zx) + abs(zy)) * half_m + abs(zz) * along_m
        low, high = (x - ex, y - ey, z - ez), (x + ex, y + ey, z + ez)
        return Span(tcp, (xx, xy, xz, yx, yy, yz, zx, zy, zz), low, high, holding)

    def along(self, start: Span, end: Span, placed: dict[Cell, int], row: BeltRow) -> set[Contact]:
        """What the tool touches on its way from one pose (left out) to the next."""
        if not self._near("", *_hull(start, end, self._both.arm_m), placed, row):
            return set()
        found: set[Contact] = set()
        for body in (self._gripper, self._held) if end.holding else (self._gripper,):
            low, high = _hull(_alone(start, body), _alone(end, body), body.arm_m)
            near = self._near(body.name, low, high, placed, row)
            if not near:
                continue
            for tcp in between(start.tcp, end.tcp, SWEEP_STEP_M, body.arm_m):
                box = body.at(tcp)
                found.update(contact for contact, obstacle in near if box.overlaps(obstacle))
        return found

    def _near(
        self, body: str, low: Triple, high: Triple, placed: dict[Cell, int], row: BeltRow
    ) -> list[tuple[Contact, Box]]:
        """What is solid within an axis-parallel box."""
        near = [
            (Contact(body, name), box)
            for name, box, box_low, box_high in self._still
            if not apart(low, high, box_low, box_high)
        ]
        if not apart(low, high, *self._row_zone):
            near += self._belt_near(body, low, high, row)
        pitch_m = self._pitch_m
        nx, ny, nz = self._grid
        bottom = max(0, int(low[2] // pitch_m))
        if not placed or bottom >= nz:
            return near
        for x in range(max(0, int(low[0] // pitch_m)), min(nx, int(high[0] // pitch_m) + 1)):
            for y in range(max(0, int(low[1] // pitch_m)), min(ny, int(high[1] // pitch_m) + 1)):
                for z in range(bottom, min(nz, int(high[2] // pitch_m) + 1)):
                    # A plain tuple finds a Cell, and is made faster.
                    part = placed.get((x, y, z))  # type: ignore[call-overload]
                    if part is not None:
                        contact = Contact(body, "placed part", part, Cell(x, y, z))
                        near.append((contact, self._cell_box(Cell(x, y, z))))
        return near

    def _cell_box(self, cell: Cell) -> Box:
        pose = np.eye(4)
        pose[:3, 3] = [(index + 0.5) * self._pitch_m for index in cell]
        half_m = self._pitch_m / 2
        return Box(pose, (half_m, half_m, half_m))

    def _belt_near(
        self, body: str, low: Triple, high: Triple, row: BeltRow
    ) -> list[tuple[Contact, Box]]:
        half_m = self._pitch_m / 2
        # Within this of a part's centre is all of it, however it is turned.
        reach_m = 1.8 * half_m
        (x, y, z), (dx, dy, dz) = self._row_line
        near = []
        for item in row.parts:
            along_m = item.position_m
            cx, cy, cz = x + dx * along_m, y + dy * along_m, z + dz * along_m
            if not (
                low[0] - reach_m < cx < high[0] + reach_m
                and low[1] - reach_m < cy < high[1] + reach_m
                and low[2] - reach_m < cz < high[2] + reach_m
            ):
                continue
            pose = np.eye(4)
            pose[:3, :3] = rotation(np.array([0.0, 0.0, item.yaw_rad]))
            pose[:3, 3] = [item.position_m, 0.0, -half_m]
            box = Box(self._from_feeder @ pose, (half_m, half_m, half_m))
            if not apart(low, high, *box.bounds()):
                near.append((Contact(body, "part on the belt", item.part), box))
        return near


def _alone(span: Span, body: Body) -> Span:
    """The same pose with the box around one body only."""
    low, high = body.at(span.tcp).bounds()
    return span._replace(low=low, high=high)


def _hull(start: Span, end: Span, arm_m: float) -> tuple[Triple, Triple]:
    """The axis-parallel box around the way between two poses."""
    # Corners that turn leave the hull of both ends; within a step of the arm that is nothing.
    cosine = (sum(map(mul, start.turn, end.turn)) - 1.0) / 2.0
    margin_m = arm_m if cosine < 0.999 else 0.0
    (ax, ay, az), (bx, by, bz) = start.low, end.low
    (cx, cy, cz), (dx, dy, dz) = start.high, end.high
    return (
        (min(ax, bx) - margin_m, min(ay, by) - margin_m, min(az, bz) - margin_m),
        (max(cx, dx) + margin_m, max(cy, dy) + margin_m, max(cz, dz) + margin_m),
    )


def _body(name: str, from_m: float, to_m: float, width_m: float) -> Body:
    """A square block along the TCP's z axis, shrunk by the tolerance."""
    half_m = width_m / 2 - CONTACT_TOLERANCE_M
    along_m = (to_m - from_m) / 2 - CONTACT_TOLERANCE_M
    return Body(name, (from_m + to_m) / 2, (half_m, half_m, along_m))


def _row_zone(config: CellConfig, from_feeder: Floats) -> Box:
    """Where parts on the belt can be, gaps and yawed parts included."""
    pitch_m = config.voxel.pitch_m
    length_m = 2.0 * (config.feeder.capacity_parts + 1) * pitch_m
    pose = np.eye(4)
    pose[:3, 3] = [pitch_m - length_m / 2, 0.0, -pitch_m / 2]
    return Box(from_feeder @ pose, (length_m / 2, 0.75 * pitch_m, pitch_m / 2))


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
    for low, high in ((box[:3], box[3:]) for box in config.walls.boxes_m):
        centre = tuple((a + b) / 2 for a, b in zip(low, high, strict=True))
        edges = tuple(b - a for a, b in zip(low, high, strict=True))
        furniture.append(("wall", block(np.eye(4), _triple(centre), _triple(edges))))
    return furniture


def _triple(values: tuple[float, ...]) -> Triple:
    x, y, z = values
    return (x, y, z)
