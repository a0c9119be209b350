"""Whether a structure stands, by MuJoCo: a judge that shares nothing with planner or world.

Each part is a free rigid body. Where two faces touch, four points of one rest on the other with
friction, and a constant force draws the two parts together until they have come apart. The engine
integrates the motion from rest; a structure stands if no part of it gets away.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell

Contact = Literal["diamond", "square"]
Floats = npt.NDArray[np.float64]

_TIME_STEP_S = 5e-4
_DURATION_S = 0.6
_AWAY = 0.1
"""A part has got away once it is displaced by this share of the pitch."""
_APART = 0.02
"""A magnet has let go once its faces are apart by this share of the pitch."""


class Push(NamedTuple):
    """A force at the centre of a part's top face, as of an arm that places it."""

    cell: Cell
    force_n: tuple[float, float, float]


class _Joint(NamedTuple):
    lower: Cell
    """Its z is -1 where it is the floor."""
    upper: Cell
    axis: int


def stands(
    cells: Iterable[Cell],
    *,
    mass_kg: float,
    pitch_m: float,
    magnet_force_n: float,
    friction: float,
    contact: Contact,
    floor_grips: bool,
    push: Push | None = None,
) -> bool:
    """Let the engine run for a while, and see whether every part is still where it was.

    Args:
        cells: where parts are.
        mass_kg: of one part, a homogeneous cube.
        pitch_m: its edge.
        magnet_force_n: with which each joint of two faces is drawn together.
        friction: coefficient of Coulomb's law, at each point of contact.
        contact: where two faces touch: at the middles of the cell's edges, or at its corners.
        floor_grips: whether the floor draws parts like another part does.
        push: acts all the while.
    """
    parts = tuple(sorted(cells))
    joints = _joints(frozenset(parts))
    xml = _Scene(mass_kg, pitch_m, friction, contact).xml(parts, joints)
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    pulls_n = np.full(len(joints), -magnet_force_n)
    if not floor_grips:
        pulls_n[[joint.lower.z < 0 for joint in joints]] = 0.0
    if push is not None:
        force = np.array(push.force_n)
        body = 1 + parts.index(push.cell)
        data.xfrc_applied[body] = np.concatenate([force, np.cross([0, 0, pitch_m / 2], force)])
    data.ctrl[:] = pulls_n
    start_m = data.qpos.reshape(-1, 7)[:, :3].copy()
    for _ in range(round(_DURATION_S / _TIME_STEP_S)):
        mujoco.mj_step(model, data)
        data.ctrl[data.ten_length > (1.0 + _APART) * pitch_m] = 0.0
        moved_m = np.abs(data.qpos.reshape(-1, 7)[:, :3] - start_m).max()
        if moved_m > _AWAY * pitch_m:
            return False
    return True


def least_force_n(
    cells: Iterable[Cell],
    *,
    mass_kg: float,
    pitch_m: float,
    friction: float,
    contact: Contact,
    floor_grips: bool,
    push: Push | None = None,
    within: float = 0.02,
) -> float:
    """The least pull of the magnets with which it stands, to a relative precision."""
    parts = tuple(cells)
    low_n, high_n = 0.0, mass_kg * 9.81

    def holds(force_n: float) -> bool:
        return stands(
            parts,
            mass_kg=mass_kg,
            pitch_m=pitch_m,
            magnet_force_n=force_n,
            friction=friction,
            contact=contact,
            floor_grips=floor_grips,
            push=push,
        )

    while not holds(high_n):
        low_n, high_n = high_n, 2.0 * high_n
        if high_n > 1e4 * mass_kg:
            return float("inf")
    while high_n - low_n > within * high_n:
        middle_n = (low_n + high_n) / 2
        low_n, high_n = (low_n, middle_n) if holds(middle_n) else (middle_n, high_n)
    return high_n


def _joints(cells: frozenset[Cell]) -> tuple[_Joint, ...]:
    found = []
    for cell in sorted(cells):
        for axis, step in enumerate(((1, 0, 0), (0, 1, 0), (0, 0, 1))):
            lower = Cell(cell.x - step[0], cell.y - step[1], cell.z - step[2])
            if lower in cells or lower.z < 0:
                found.append(_Joint(lower, cell, axis))
    return tuple(found)


class _Scene(NamedTuple):
    """Writes structures in MuJoCo's language."""

    mass_kg: float
    pitch_m: float
    friction: float
    contact: Contact

    def xml(self, parts: tuple[Cell, ...], joints: tuple[_Joint, ...]) -> str:
        """Body 1 is the first part, and so on; actuator 0 the magnets of the first joint."""
        inertia = self.mass_kg * self.pitch_m**2 / 6
        inside: dict[Cell, list[str]] = {cell: [] for cell in parts}
        floor: list[str] = []
        pairs, tendons, pulls = [], [], []
        for number, joint in enumerate(joints):
            pairs += self._contact(number, joint, inside, floor)
            ends = f'<site site="from{number}"/><site site="to{number}"/>'
            tendons.append(f'<spatial name="magnet{number}">{ends}</spatial>')
            pulls.append(f'<general tendon="magnet{number}" gainprm="1"/>')
        bodies = [
            f'<body pos="{_text((np.array(cell) + 0.5) * self.pitch_m)}"><freejoint/>'
            f'<inertial pos="0 0 0" mass="{self.mass_kg}" '
            f'diaginertia="{inertia} {inertia} {inertia}"/>{"".join(inside[cell])}</body>'
            for cell in parts
        ]
        return (
            f'<mujoco><option timestep="{_TIME_STEP_S}" cone="elliptic" impratio="20" '
            'gravity="0 0 -9.80665" integrator="implicitfast"/>'
            f"<worldbody>{''.join(floor)}{''.join(bodies)}</worldbody>"
            f"<contact>{''.join(pairs)}</contact><tendon>{''.join(tendons)}</tendon>"
            f"<actuator>{''.join(pulls)}</actuator></mujoco>"
        )

    def _contact(
        self, number: int, joint: _Joint, inside: dict[Cell, list[str]], floor: list[str]
    ) -> list[str]:
        """Add a joint's shapes to its bodies; returns which of them may touch."""
        half_m, ball_m = self.pitch_m / 2, self.pitch_m / 200
        normal = np.eye(3)[joint.axis]
        if joint.lower in inside:
            below, centre_m = inside[joint.lower], np.zeros(3)
        else:
            below, centre_m = floor, (np.array(joint.lower) + 0.5) * self.pitch_m
        # The lower face is drawn wide, so that points at its rim rest on it squarely.
        plate_m = 0.75 * self.pitch_m * (1 - normal) + ball_m * normal
        below.append(
            _geom(f"plate{number}", "box", centre_m + normal * (half_m - 2 * ball_m), plate_m)
        )
        below.append(f'<site name="from{number}" pos="{_text(centre_m)}"/>')
        inside[joint.upper].append(f'<site name="to{number}"/>')
        pairs = []
        for corner, (u, v) in enumerate(_points(self.contact)):
            ball = f"point{number}_{corner}"
            at_m = half_m * np.roll([-1.0, u, v], joint.axis)
            inside[joint.upper].append(_geom(ball, "sphere", at_m, np.array([ball_m])))
            pairs.append(
                f'<pair geom1="plate{number}" geom2="{ball}" condim="3" '
                f'friction="{self.friction} {self.friction}" '
                f'solref="{2 * _TIME_STEP_S} 1" solimp="0.99 0.999 0.001"/>'
            )
        return pairs


def _points(contact: Contact) -> tuple[tuple[int, int], ...]:
    """Of a face, along its two axes, in half pitches."""
    if contact == "diamond":
        return ((1, 0), (-1, 0), (0, 1), (0, -1))
    return ((1, 1), (1, -1), (-1, 1), (-1, -1))


def _geom(name: str, kind: str, at_m: Floats, size_m: Floats) -> str:
    return (
        f'<geom name="{name}" type="{kind}" pos="{_text(at_m)}" size="{_text(size_m)}" '
        'contype="0" conaffinity="0" mass="0"/>'
    )


def _text(values: Floats) -> str:
    return " ".join(repr(float(value)) for value in values)
