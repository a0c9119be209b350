"""The one physical truth of the emulated cell.

Pure: no I/O, no clock of its own, all chance from one seed. The emulators of robot, latch and
conveyor tell it what they do; it keeps every part in exactly one place and holds against the cell
whatever must not happen. It shares no code with the planner.

What it does not know: springiness, and parts that fall onto other parts. A fallen part is out of
play until somebody clears the workspace.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.sim.physics import Material, collapse, parting
from cellctl.sim.plant import Floats
from cellctl.sim.world_belt import BeltPart
from cellctl.sim.world_contact import Contact, Contacts, Span
from cellctl.sim.world_geometry import (
    farthest_corner_m,
    inverse,
    pose_matrix,
    rotation,
    rotation_vector,
)
from cellctl.sim.world_grip import fits, judge_release
from cellctl.sim.world_impact import Impact
from cellctl.sim.world_links import LinkJudge
from cellctl.sim.world_parts import Parts
from cellctl.sim.world_support import adrift
from cellctl.sim.world_touch import holding_back_n, leaning_n, pressing_n
from cellctl.sim.world_values import (
    Imperfections,
    Violation,
    ViolationKind,
)

COLLISION_N = 300.0
"""How hard a collision is felt, against the movement: more than any arm's safety limit allows."""
BOND_LIFT_M = 0.03
"""A part that sticks to its neighbour comes off once it is lifted this far..."""
BOND_SLACK_M = 0.01
"""...and drags the neighbour off the belt if it is moved this far aside before that."""
PARTING_M = 0.001
"""A placed part in the closed latch comes off once a corner of it has moved this far: that is where
its magnets let go, and the way there is how it was taken."""


class World(Parts):
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
        super().__init__(config, seed, imperfections or Imperfections())
        self.violations: list[Violation] = []
        self.time_s = 0.0
        self._on_violation = on_violation
        from_cell = inverse(pose_matrix(config.workspace.frame))
        self._from_base = from_cell @ pose_matrix(config.base.frame)
        self._from_feeder = from_cell @ pose_matrix(config.feeder.frame)
        self._to_feeder = inverse(self._from_feeder)
        self._tool = pose_matrix(config.tool.frame)
        self._contacts = Contacts(config, from_cell)
        self._material = Material.of(config)
        self._ongoing: set[Contact] = set()
        self._links = LinkJudge(config.robot.model, self._from_base)
        self._links_in: set[Contact] = set()
        self._impact = Impact()
        emulation = config.emulation
        self._jolt_limit_m2_s3 = emulation.jolt_limit_m2_s3 if emulation is not None else math.inf
        self._heading = np.zeros(3)
        """Which way the tool moved last, in the workspace frame, of length 1."""
        self._span: Span | None = None
        self._tcp: Floats | None = None
        """TCP in the workspace frame; None until the arm first told where it is."""
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
        del dt_s  # time passes in advance()
        tcp = self._from_base @ flange @ self._tool
        if self._tcp is not None and tcp.tobytes() == self._tcp.tobytes():
            return
        if self._tcp is not None and (way := tcp[:3, 3] - self._tcp[:3, 3]).any():
            self._heading = way / np.linalg.norm(way)
            self._impact.move(float(way[2]))
        self._judge_links(joints_rad)
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
        self._tell_new(contacts - self._ongoing)
        self._ongoing = contacts

    def _judge_links(self, joints_rad: Floats) -> None:
        if not self._links.due(joints_rad):
            return
        contacts = self._links.judge(
            joints_rad, lambda low, high: self._contacts.near(low, high, self._placed, self._row)
        )
        self._tell_new(contacts - self._links_in)
        self._links_in = contacts

    def _tell_new(self, contacts: set[Contact]) -> None:
        for contact in sorted(contacts, key=str):
            where = f" at cell {tuple(contact.cell)}" if contact.cell else ""
            self._hold_against(
                ViolationKind.COLLISION,
                f"The {contact.body} ran into the {contact.obstacle}{where}.",
                part=contact.part,
                cell=contact.cell,
            )

    def _grip(self, cell: Cell) -> None:
        assert self._tcp is not None, "the arm is somewhere"
        seated = self._tcp.copy()
        seated[2, 3] = (cell.z + 1) * self._pitch_m
        self._gripped = (cell, seated)

    def commanded(self, speed_m_s: float, acceleration_m_s2: float) -> None:
        """What is asked of the movement under way; see ``Plant.commanded``."""
        self._impact.command(speed_m_s, acceleration_m_s2)

    def lose_sight(self) -> None:
        """The arm is somewhere else at once: a person guided it there, and looked out."""
        self._span = None
        self._links.lose_sight()

    def tcp_force_n(self) -> Floats:
        """What acts on the tool from outside, (3,) in the base frame, in N. Part and gripper do not
        count: the robot knows what it carries."""
        force_n = self._from_base[2, :3] * self._upward_force_n()
        touched = self._ongoing | self._links_in
        if any(contact.cell is None or contact.cell in self._placed for contact in touched):
            force_n = force_n - self._from_base[:3, :3].T @ self._heading * COLLISION_N
        return np.asarray(force_n)

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
            return leaning_n(self._tcp, self._placed.keys(), self._pitch_m, self.raised_m)
        return pressing_n(
            self._tcp, self._placed.keys(), self._from_feeder, self._pitch_m, self.raised_m
        )

    @property
    def tcp_pose(self) -> Floats | None:
        """4x4 pose of the TCP in the workspace frame; None before the arm told where it is."""
        return None if self._tcp is None else self._tcp.copy()

    @property
    def held_part(self) -> int | None:
        """The part in the gripper."""
        return self._held

    @property
    def feels_part(self) -> bool:
        """Whether a part, held or standing, is at the gripper's face with the latch on it."""
        return self._held is not None or self._gripped is not None

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
            jolt_m2_s3 = self._impact.jolt_m2_s3
            if wrong is None and jolt_m2_s3 > self._jolt_limit_m2_s3:
                wrong = ViolationKind.JOLTED
                message = (
                    f"The part at cell {tuple(cell)} fell: it was set down with a commanded speed "
                    f"times acceleration of {jolt_m2_s3:.2f} m2/s3."
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
