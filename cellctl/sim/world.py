"""The one physical truth of the emulated cell.

Pure: no I/O, no clock of its own, all chance from one seed. The emulators of robot, latch and
conveyor tell it what they do; it keeps every part in exactly one place and holds against the cell
whatever must not happen. It shares no code with the planner.

What it does not know: links of the arm above the gripper, springiness, parts that fall onto other
parts. A fallen part is out of play until somebody clears the workspace.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.sim.physics import Material, collapse, parting
from cellctl.sim.plant import Floats
from cellctl.sim.world_belt import BeltPart, BeltRow
from cellctl.sim.world_contact import Contact, Contacts, Span
from cellctl.sim.world_geometry import (
    farthest_corner_m,
    inverse,
    pose_matrix,
    rotation,
    rotation_vector,
)
from cellctl.sim.world_grip import fits, judge_release
from cellctl.sim.world_support import adrift
from cellctl.sim.world_touch import holding_back_n, pressing_n
from cellctl.sim.world_values import (
    Imperfections,
    PartTruth,
    Violation,
    ViolationKind,
    Where,
)

BOND_LIFT_M = 0.03
"""A part that sticks to its neighbour comes off once it is lifted this far..."""
BOND_SLACK_M = 0.01
"""...and drags the neighbour off the belt if it is moved this far aside before that."""
PARTING_M = 0.001
"""A placed part in the closed latch comes off once a corner of it has moved this far: that is where
its magnets let go, and the way there is how it was taken."""


class World:
    """Where every part is, and what is held against the cell.

    Args:
        config: the cell; an emulated one starts with a full belt and the rest in the stock.
        seed: where all chance comes from; the same calls then give the same world.
        imperfections: how far the belt and its parts are from perfect.
        on_violation: called with each violation as it happens.
    """

    def __init__(
        self,
        config: CellConfig,
        seed: int = 1,
        imperfections: Imperfections | None = None,
        on_violation: Callable[[Violation], None] | None = None,
    ) -> None:
        self.config = config
        self.imperfections = imperfections or Imperfections()
        self.violations: list[Violation] = []
        self.time_s = 0.0
        self._on_violation = on_violation
        self._pitch_m = config.voxel.pitch_m
        from_cell = inverse(pose_matrix(config.workspace.frame))
        self._from_base = from_cell @ pose_matrix(config.base.frame)
        self._from_feeder = from_cell @ pose_matrix(config.feeder.frame)
        self._to_feeder = inverse(self._from_feeder)
        self._tool = pose_matrix(config.tool.frame)
        self._contacts = Contacts(config, from_cell)
        self._material = Material.of(config)
        self._ongoing: set[Contact] = set()
        self._span: Span | None = None
        self._tcp: Floats | None = None
        """TCP in the workspace frame; None until the arm first told where it is."""

        self._stock = list(range(config.limits.inventory_parts))
        self._row = BeltRow(self._pitch_m, random.Random(seed))  # noqa: S311 - repeatable chance
        self._held: int | None = None
        self._placed: dict[Cell, int] = {}
        self._fallen: list[int] = []
        self._handed_over: list[int] = []
        self._everything = frozenset(self._stock)
        self._bond: tuple[int, Floats] | None = None
        """The part that sticks to the held one, and the TCP where that was picked."""
        self._gripped: tuple[Cell, Floats] | None = None
        """The placed part in the closed latch that has not come off yet, and the TCP then, on its
        seat."""
        self.parts_stick = False
        """Parts that are let go at a cell stick to the gripper."""
        self.refill_belt()

    # ---- time and the belt ----

    def advance(self, dt_s: float) -> None:
        """Let cell time pass."""
        self.time_s += dt_s

    def belt_move(self, distance_m: float) -> None:
        """Turn the belt by a distance; positive feeds towards the pick station."""
        self._row.move(distance_m, self.imperfections.belt_slip)

    def part_at_pick(self) -> bool:
        """What the part sensor at the pick station sees: a part on the belt or in the gripper."""
        if self._row.at_stop() is not None:
            return True
        if self._held is None or self._tcp is None:
            return False
        centre = self._to_feeder @ (self._tcp @ np.array([0.0, 0.0, self._pitch_m / 2, 1.0]))
        centre[2] += self._pitch_m / 2
        return bool(np.all(np.abs(centre[:3]) < self._pitch_m / 2))

    @property
    def parts_on_belt(self) -> int:
        """How many parts the belt still carries, the one at the pick station included."""
        return len(self._row)

    # ---- the arm and the latch ----

    def robot_moved(self, flange: Floats, joints_rad: Floats, dt_s: float) -> None:
        """Take the arm's new pose and judge the way to it; see ``Plant.robot_moved``."""
        del joints_rad, dt_s  # only the tool is judged, and time passes in advance()
        tcp = self._from_base @ flange @ self._tool
        if self._tcp is not None and tcp.tobytes() == self._tcp.tobytes():
            return
        self._tcp = tcp
        self._strain_grip(tcp)
        holding = self._held is not None
        before, self._span = self._span, self._contacts.span(tcp, holding)
        if before is None:
            return
        if before.holding != holding:
            before = self._contacts.span(before.tcp, holding)
        self._strain_bond(tcp)
        contacts = self._contacts.along(before, self._span, self._placed, self._row)
        if contacts == self._ongoing:
            return
        for contact in sorted(contacts - self._ongoing, key=str):
            where = f" at cell {tuple(contact.cell)}" if contact.cell else ""
            self._hold_against(
                ViolationKind.COLLISION,
                f"The {contact.body} ran into the {contact.obstacle}{where}.",
                part=contact.part,
                cell=contact.cell,
            )
        self._ongoing = contacts

    def _grip(self, cell: Cell) -> None:
        assert self._tcp is not None, "the arm is somewhere"
        seated = self._tcp.copy()
        seated[2, 3] = (cell.z + 1) * self._pitch_m
        self._gripped = (cell, seated)

    def tcp_force_n(self) -> Floats:
        """What acts on the tool from outside, (3,) in the base frame, in N. Part and gripper do not
        count: the robot knows what it carries."""
        return np.asarray(self._from_base[2, :3] * self._upward_force_n())

    def _upward_force_n(self) -> float:
        if self._tcp is None:
            return 0.0
        if self._gripped is not None:
            cell, seated = self._gripped
            below = cell.below() in self._placed if cell.z else self._material.floor_magnet > 0.0
            magnet_n = self.config.stability.magnet_force_n if below else 0.0
            lifted_m = float(self._tcp[2, 3] - seated[2, 3])
            return -holding_back_n(lifted_m, magnet_n, PARTING_M)
        if self._held is None:
            return 0.0
        return pressing_n(self._tcp, self._placed.keys(), self._from_feeder, self._pitch_m)

    @property
    def tcp_pose(self) -> Floats | None:
        """4x4 pose of the TCP in the workspace frame; None before the arm told where it is."""
        return None if self._tcp is None else self._tcp.copy()

    @property
    def held_part(self) -> int | None:
        """The part in the gripper."""
        return self._held

    def latch_closed(self) -> None:
        """The latch has closed: it holds what lies within its tolerance, and centres it."""
        if self._held is not None or self._gripped is not None or self._tcp is None:
            return
        to_tcp = inverse(self._tcp)
        on_belt = [(item, to_tcp @ self._belt_top(item)) for item in self._row.parts]
        for item, error in on_belt:
            if fits(error):
                _, behind = self._row.take(item.part)
                self._held = item.part
                self._bond = None if behind is None else (behind.part, self._tcp.copy())
                self._settle()
                return
        in_place = [(cell, to_tcp @ self._cell_top(cell)) for cell in self._placed]
        for cell, error in in_place:
            if fits(error):
                self._grip(cell)
                return
        # Closing far from every part, as when the controller boots, is no attempt to pick.
        station = to_tcp @ self._from_feeder
        tops = [station, *(error for _, error in on_belt), *(error for _, error in in_place)]
        if min(float(np.linalg.norm(top[:3, 3])) for top in tops) < self._pitch_m:
            self._hold_against(
                ViolationKind.PICKED_NOTHING,
                "The latch closed, and no part was within its tolerance.",
            )

    def latch_opened(self) -> None:
        """The latch has opened: a held part goes where it goes, a gripped one stands on."""
        self._gripped = None
        if self._held is None or self._tcp is None:
            return
        part, self._held, self._bond = self._held, None, None
        station = inverse(self._tcp) @ self._from_feeder
        if fits(station) and self._row.has_room_at_stop():
            self._row.put_back(part)
        else:
            cell, wrong, message = judge_release(
                self._tcp, self._placed.keys(), self.config.grid, self._pitch_m
            )
            if wrong is None:
                self._placed[cell] = part
                if self.parts_stick:
                    self._grip(cell)
                self._drop_what_cannot_hold(cell)
            else:
                self._fallen.append(part)
                self._hold_against(wrong, message, part=part, cell=cell)
        self._settle()

    # ---- hands: what a person does in the cell ----

    def refill_belt(self, parts: int | None = None) -> int:
        """Lay parts on the belt: from the stock, then those that visitors bring back.

        Args:
            parts: how many; None fills the belt.

        Returns:
            How many places were filled.
        """
        room = self.config.feeder.capacity_parts - len(self._row)
        count = room if parts is None else min(parts, room)
        source = self._stock + self._handed_over
        laid, kept = source[:count], source[count:]
        left_out = self._row.lay(laid, self.imperfections)
        self._stock = [part for part in kept if part not in self._handed_over] + left_out
        self._handed_over = [part for part in self._handed_over if part in kept]
        self._settle()
        return len(laid) - len(left_out)

    def empty_belt(self) -> None:
        """Take every part off the belt, into the stock."""
        self._stock += self._row.empty()
        self._bond = None
        self._settle()

    def hand_over(self) -> int:
        """Give what stands in the workspace to the visitor; returns the number of parts."""
        parts = list(self._placed.values())
        self._gripped = None
        self._handed_over += parts
        self._placed.clear()
        self._settle()
        return len(parts)

    def clear_workspace(self) -> int:
        """Take what stands or lies in the workspace to the stock; returns the number of parts."""
        parts = [*self._placed.values(), *self._fallen]
        self._stock += parts
        self._gripped = None
        self._placed.clear()
        self._fallen.clear()
        self._settle()
        return len(parts)

    # ---- mishaps on demand ----

    def turn_next_part(self, yaw_rad: float) -> None:
        """Turn the first part on the belt about the vertical."""
        if self._row.parts:
            self._row.parts[0].yaw_rad = yaw_rad

    def straighten_parts(self) -> None:
        """Turn every part on the belt square to it, and part those that stick together."""
        for item in self._row.parts:
            item.yaw_rad = 0.0
            item.sticky = False
        self._bond = None

    def stick_next_part(self) -> None:
        """Make the first part on the belt stick to the one behind it."""
        if self._row.parts:
            self._row.parts[0].sticky = True

    def free_parts(self) -> None:
        """Parts no longer stick to the gripper, and none that sticks is held any more."""
        self.parts_stick = False
        self._gripped = None

    def remove_next_part(self) -> None:
        """Take the first part off the belt, into the stock; its place stays empty."""
        if self._row.parts:
            part = self._row.parts[0].part
            self._row.take(part)
            self._stock.append(part)
            self._settle()

    def drop_held_part(self) -> None:
        """Let the part slip out of the closed gripper."""
        if self._held is not None:
            self._fallen.append(self._held)
            self._held = self._bond = None
            self._settle()

    def take_placed_part(self, cell: Cell) -> None:
        """A visitor takes a part off the structure along; what cannot hold without it falls.

        Raises:
            ValueError: there is no part at that cell.
        """
        if cell not in self._placed:
            raise ValueError(f"no part stands at {tuple(cell)}")
        if self._gripped is not None and self._gripped[0] == cell:
            self._gripped = None
        self._handed_over.append(self._placed.pop(cell))
        self._drop_what_cannot_hold(None)
        self._settle()

    # ---- truth ----

    @property
    def built(self) -> frozenset[Cell]:
        """The cells that hold a part."""
        return frozenset(self._placed)

    def parts(self) -> tuple[PartTruth, ...]:
        """Every part and where it is, by part number."""
        at_stop = self._row.at_stop()
        truths = [PartTruth(part=part, where=Where.STOCK) for part in self._stock]
        for item in self._row.parts:
            where = Where.PICK_STATION if item is at_stop else Where.BELT
            belt_m = round(-item.position_m, 6)
            truths.append(PartTruth(part=item.part, where=where, belt_m=belt_m))
        if self._held is not None:
            truths.append(PartTruth(part=self._held, where=Where.GRIPPER))
        for cell, part in self._placed.items():
            truths.append(PartTruth(part=part, where=Where.PLACED, cell=cell))
        truths += [PartTruth(part=part, where=Where.FALLEN) for part in self._fallen]
        truths += [PartTruth(part=part, where=Where.HANDED_OVER) for part in self._handed_over]
        return tuple(sorted(truths, key=lambda truth: truth.part))

    def counts(self) -> dict[Where, int]:
        """How many parts are at each kind of place; the sum never changes."""
        found = Counter(truth.where for truth in self.parts())
        return {where: found[where] for where in Where}

    # ---- how it judges ----

    def _drop_what_cannot_hold(self, newest: Cell | None) -> None:
        """Let fall what does not stay, until all that is left does.

        Args:
            newest: the part that the arm has just pushed into its place.
        """
        while True:
            if loose := adrift(self._placed.keys()):
                self._drop(
                    sorted(loose), ViolationKind.LOST_SUPPORT, "nothing joins it to the floor"
                )
                continue
            found = collapse(frozenset(self._placed), self._material, newest)
            if found is None:
                return
            load = "the push of the placement" if found.pushed else "the weight on it"
            why = f"the joint {found.weakest} does not bear {load}"
            self._drop(found.moving, ViolationKind.COLLAPSED, why)
            newest = None  # the arm has let go of it by now

    def _strain_grip(self, tcp: Floats) -> None:
        """Follow a placed part in the closed latch, until it comes off its neighbours."""
        if self._gripped is None:
            return
        cell, gripped = self._gripped
        moved = tcp @ inverse(gripped)
        half_m = self._pitch_m / 2
        centre = (np.array(cell) + 0.5) * self._pitch_m
        shift_m = moved[:3, :3] @ centre + moved[:3, 3] - centre
        turn_rad = rotation_vector(moved[:3, :3])
        if farthest_corner_m(shift_m, turn_rad, half_m) < PARTING_M:
            return
        self._gripped = None
        found = parting(frozenset(self._placed), cell, shift_m / half_m, turn_rad, self._material)
        self._held = self._placed.pop(cell)
        if found.pressed is not None:
            self._hold_against(
                ViolationKind.COLLISION,
                f"The part of cell {tuple(cell)} was pressed into the one at cell "
                f"{tuple(found.pressed)} when it was taken.",
                part=self._held,
                cell=cell,
            )
        if found.dragged is not None:
            why = (
                f"it came along with the one of cell {tuple(cell)}, for the joint "
                f"{found.dragged.weakest} does not bear how that was taken off"
            )
            self._drop(found.dragged.moving, ViolationKind.DRAGGED_NEIGHBOUR, why)
        self._drop_what_cannot_hold(None)
        self._settle()

    def _drop(self, cells: Sequence[Cell], kind: ViolationKind, why: str) -> None:
        for cell in cells:
            part = self._placed.pop(cell)
            self._fallen.append(part)
            message = f"The part at cell {tuple(cell)} fell: {why}."
            self._hold_against(kind, message, part=part, cell=cell)

    def _strain_bond(self, tcp: Floats) -> None:
        """Follow a part that sticks to the held one, until it comes off or is dragged away."""
        if self._bond is None:
            return
        neighbour, picked = self._bond
        moved = self._to_feeder[:3, :3] @ (tcp[:3, 3] - picked[:3, 3])
        if moved[2] >= BOND_LIFT_M:
            self._bond = None
        elif math.hypot(moved[0], moved[1]) > BOND_SLACK_M:
            self._bond = None
            self._row.take(neighbour)
            self._fallen.append(neighbour)
            self._hold_against(
                ViolationKind.DRAGGED_NEIGHBOUR,
                f"A part stuck to the picked one and was dragged off the belt: it was moved "
                f"aside before it was lifted {BOND_LIFT_M * 1e3:.0f} mm.",
                part=neighbour,
            )
            self._settle()

    def _hold_against(
        self,
        kind: ViolationKind,
        message: str,
        part: int | None = None,
        cell: Cell | None = None,
    ) -> None:
        violation = Violation(
            kind=kind, message=message, cell_time_s=round(self.time_s, 6), part=part, cell=cell
        )
        self.violations.append(violation)
        if self._on_violation is not None:
            self._on_violation(violation)

    def _settle(self) -> None:
        """The law of conservation: every part is in exactly one place, none comes or goes."""
        places = [
            *self._stock,
            *(item.part for item in self._row.parts),
            *([] if self._held is None else [self._held]),
            *self._placed.values(),
            *self._fallen,
            *self._handed_over,
        ]
        assert len(places) == len(self._everything), "a part came, went or is in two places"
        assert set(places) == self._everything, "a part was swapped for another"

    def _belt_top(self, item: BeltPart) -> Floats:
        """Pose of the centre of a belt part's top face, in the workspace frame."""
        pose = np.eye(4)
        pose[:3, :3] = rotation(np.array([0.0, 0.0, item.yaw_rad]))
        pose[0, 3] = item.position_m
        return np.asarray(self._from_feeder @ pose)

    def _cell_top(self, cell: Cell) -> Floats:
        pose = np.eye(4)
        pose[:3, 3] = np.array([cell.x + 0.5, cell.y + 0.5, cell.z + 1.0]) * self._pitch_m
        return pose
