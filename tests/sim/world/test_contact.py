"""The quick way to find contacts against looking at everything."""

from __future__ import annotations

import math
import random

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.sim.plant import Floats
from cellctl.sim.world_belt import BeltRow
from cellctl.sim.world_contact import CONTACT_TOLERANCE_M, Contacts
from cellctl.sim.world_geometry import Box, inverse, pose_matrix
from cellctl.sim.world_values import Imperfections
from tests.sim.world.hand import emulated_config

CONFIG = emulated_config()
PITCH_M = CONFIG.voxel.pitch_m
FEEDER = inverse(pose_matrix(CONFIG.workspace.frame)) @ pose_matrix(CONFIG.feeder.frame)


def cube(centre: Floats) -> Box:
    half_m = PITCH_M / 2
    return Box(centre, (half_m, half_m, half_m))


def at(offset_m: tuple[float, float, float], yaw_rad: float = 0.0) -> Floats:
    return pose_matrix((*offset_m, 0.0, 0.0, yaw_rad))


cell = st.builds(Cell, st.integers(0, 5), st.integers(0, 4), st.integers(0, 2))
near = st.tuples(*[st.floats(-0.11, 0.11)] * 3)
step = st.tuples(*[st.floats(-0.005, 0.005)] * 3)
tilt = st.tuples(st.floats(math.pi - 0.8, math.pi + 0.8), *[st.floats(-0.4, 0.4)] * 2)
top = st.one_of(
    cell.map(lambda c: ((c.x + 0.5) * PITCH_M, (c.y + 0.5) * PITCH_M, (c.z + 1) * PITCH_M)),
    st.floats(-0.6, 0.0).map(lambda x_m: tuple((FEEDER @ at((x_m, 0.0, 0.0)))[:3, 3].tolist())),
)
# A tool that points down more or less, near the top of a cell or of the belt's row.
pose = st.tuples(top, near, tilt).map(
    lambda drawn: (*(a + b for a, b in zip(drawn[0], drawn[1], strict=True)), *drawn[2])
)


@settings(deadline=None, max_examples=200)
@given(pose, step, st.sets(cell, min_size=10, max_size=40), st.floats(0.0, 0.3))
def test_no_contact_at_the_end_of_a_way_is_overlooked(
    last: tuple[float, ...], back_m: tuple[float, ...], cells: set[Cell], belt_m: float
) -> None:
    row = BeltRow(PITCH_M, random.Random(1))  # noqa: S311 - repeatable
    row.lay(list(range(20)), Imperfections(yawed_share=0.5, yaw_rad=0.3))
    row.move(belt_m, slip=0.0)
    placed = {cell: 100 + index for index, cell in enumerate(sorted(cells))}
    contacts = Contacts(CONFIG, inverse(pose_matrix(CONFIG.workspace.frame)))
    first = (*(a + b for a, b in zip(last[:3], back_m, strict=True)), *last[3:])
    start, end = (contacts.span(pose_matrix(values), holding=True) for values in (first, last))
    found = contacts.along(start, end, placed, row)

    height_m, width_m = CONFIG.tool.height_m, CONFIG.tool.width_m
    bodies = [
        ("gripper", -height_m / 2, np.array([width_m, width_m, height_m]) / 2),
        ("held part", PITCH_M / 2, np.full(3, PITCH_M / 2)),
    ]
    solid = [(item.part, _on_belt(item.position_m, item.yaw_rad)) for item in row.parts]
    solid += [
        (part, cube(at(((c.x + 0.5) * PITCH_M, (c.y + 0.5) * PITCH_M, (c.z + 0.5) * PITCH_M))))
        for c, part in placed.items()
    ]
    told = {(contact.body, contact.part) for contact in found}
    for name, offset_m, half in bodies:
        x, y, z = (half - CONTACT_TOLERANCE_M).tolist()
        body = Box(pose_matrix(last) @ at((0.0, 0.0, offset_m)), (x, y, z))
        for part, box in solid:
            if body.overlaps(box):
                assert (name, part) in told


def _on_belt(position_m: float, yaw_rad: float) -> Box:
    return cube(FEEDER @ at((position_m, 0.0, -PITCH_M / 2), yaw_rad))
