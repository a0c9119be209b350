"""The tables of what does not move by itself: place, tool, parts, and what holds them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator

from cellctl.config.section import NotNegative, Pose, Positive, Section, Vector


class CellSection(Section):
    """What this cell is."""

    name: Annotated[str, Field(min_length=1, max_length=80)]
    """What people call it."""
    kind: Literal["real", "emulated"]
    """``emulated`` lets ``cellctl sim`` and ``cellctl demo`` stand in for the metal."""
    clock_rate: Annotated[float, Field(gt=0.0, le=100.0)] = 1.0
    """Cell seconds per wall second; anything but 1.0 needs ``kind = "emulated"``."""


class WorkspaceSection(Section):
    """Where things are built."""

    frame: Pose
    """Minimum corner of the building space, on the floor."""
    size_m: tuple[Positive, Positive, Positive]
    """Along x, y and z; as many whole cells as fit are used."""


class BaseSection(Section):
    """Where the robot stands."""

    frame: Pose
    """The robot's base frame, as the pendant's *Base* feature has it."""


class PedestalSection(Section):
    """The block that the robot stands on: an obstacle."""

    frame: Pose
    """Centre of its top face."""
    size_m: tuple[Positive, Positive, Positive]
    """Along x, y and z."""


class WallsSection(Section):
    """What else stands around the arm and does not move: walls, fences, cabinets."""

    boxes_m: tuple[tuple[float, float, float, float, float, float], ...] = ()
    """For each the smallest x, y and z and the largest x, y and z that it takes up, in the cell
    frame: an obstacle."""

    @field_validator("boxes_m")
    @classmethod
    def _ordered(cls, boxes: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
        for box in boxes:
            if not all(low < high for low, high in zip(box[:3], box[3:], strict=True)):
                raise ValueError(f"{list(box)}: first the smallest x, y and z, then the largest")
        return boxes


class ToolSection(Section):
    """The latch gripper on the robot's flange."""

    frame: Pose
    """TCP in the flange frame: the centre of the top face of a gripped voxel, z into the voxel."""
    width_m: Positive
    """Edge of the square that the gripper's body needs, seen from above."""
    height_m: Positive
    """From the flange to the gripper's lower face."""
    payload_kg: Annotated[float, Field(gt=0.0, le=12.5)]
    """Gripper and one voxel together."""
    payload_cog_m: Vector
    """Centre of gravity of that payload, in the flange frame."""
    voltage_v: Literal[0, 12, 24] = 0
    """Supply of the tool's connector in the robot's installation; compared, never set: only a
    program of its own could set it."""


class VoxelSection(Section):
    """The reusable part."""

    pitch_m: Annotated[float, Field(ge=0.02, le=0.25)]
    """Edge of a cell: the distance from one part's centre to its neighbour's."""
    mass_kg: Positive
    """Mass of one part."""


class LimitsSection(Section):
    """What can be built, after the paper's section 3.3."""

    inventory_parts: Annotated[int, Field(ge=1, le=1000)]
    """Most parts that one object may have."""
    overhang_cells: Annotated[int, Field(ge=0, le=50)]
    """Most cells that a row may reach out from the last supported one, by the policy ``paper``."""
    stack_cells: Annotated[int, Field(ge=1, le=50)]
    """Most cells on top of each other without a neighbour beside them, by the policy ``paper``."""


class StabilitySection(Section):
    """What holds parts together, and what a placement does to them.

    The paper publishes none of it. With parts of 0.15 kg the defaults fit what it reports: its four
    objects stand at every step of a good order; a row of three over nothing holds while it is built
    and one of four does not; a column of four with a part on top does, and one higher does not.
    """

    magnet_force_n: Positive = 22.0
    """Pull that one joint of two faces holds, straight apart."""
    contact: Literal["diamond", "square"] = "square"
    """Where two faces touch: all over, or in a square that stands on its corner (cuboctahedra).
    With ``diamond`` no magnets fit both the paper's table on one leg and its rows of three."""
    friction: Annotated[float, Field(ge=0.0, le=2.0)] = 0.5
    """Coefficient between two faces, and between a part and the floor."""
    floor: Literal["grips", "bare"] = "grips"
    """``grips``: the floor holds a part like another part does; ``bare``: it only carries it."""
    polarity: Literal["genderless", "directed"] = "genderless"
    """``genderless``: any two side faces attract; ``directed``: only opposite ones, so that all
    parts must be placed with the same yaw."""
    yaw_symmetry_deg: Literal[90, 180, 360] = 90
    """A part turned by this about the vertical is the same part."""
    placement_down_n: NotNegative = 1.5
    """How hard a part is pressed down when it is placed."""
    placement_side_n: NotNegative = 2.9
    """How hard it may be pushed aside meanwhile, at its top face, in any direction."""
    least_margin: Annotated[float, Field(ge=1.0, le=10.0)] = 1.0
    """The joints must bear this many times what every step asks of them."""
