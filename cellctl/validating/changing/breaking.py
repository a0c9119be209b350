"""How a part comes off: by which movement, with what force, and what that does to its neighbours.

While a part begins to move, each of its joints is at its limit, so what it hands to the neighbours
does not depend on how strong the arm is. The movement is one of a rigid body, and says for each
joint what happens there:

- its faces *open* all over: the magnets pull the neighbour after the part with their full force;
- its faces open like a hinge: the magnets pull, and the contact at the hinge presses back with the
  same force (the arm carries the part, and neither lifts nor leans), which leaves a couple, and
  friction where the hinge slides besides;
- its faces *slide*: friction drags the neighbour along;
- its faces would press into each other: the part cannot move so.

The magnets' force falls off within millimetres, so only the beginning of the movement counts.

This is the mechanism of limit analysis for joints whose limit is known (Livesley, 1978), except
that friction does not dilate: pressing between the faces is that of their own magnets.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells, lateral
from cellctl.validating.stability import Physics

Floats = npt.NDArray[np.float64]

_STILL = 1e-9
"""Speeds below this are rounding; the part moves with 1 pitch or 1 radian in the unit of time."""

_TOWARDS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))


Effect = tuple[float | bytes, ...]
"""A movement's force and loads: what tells two movements apart."""

How = Literal["pull", "peel", "twist"]


class Hinge(NamedTuple):
    """The level axis about which a peeled part turns, seen from the part's centre, in halves of
    its edge."""

    towards: float
    """How far it is on the side to which the part's top goes."""
    up: float
    """How far it is above the centre."""


class Way(NamedTuple):
    """A movement by which a part may come off."""

    how: How
    """``pull``: straight up; ``peel``: tilted first; ``twist``: turned about the vertical first."""
    direction: tuple[int, int] | None = None
    """Of a peel: where the part's top goes, along x, y or a diagonal."""
    hinge: Hinge | None = None
    """Of a peel: what it turns about. A part that rests on something turns about a lower edge; one
    that hangs at its neighbours about an upper one, or about an axis nearer to the gripper, which
    rubs less on a neighbour at its flank."""


class Breaking(NamedTuple):
    """What it takes to break all joints of a part by one movement."""

    way: Way
    force_n: float
    """Of the arm, the part's weight included: straight up; of a peel or twist, its couple divided
    by the part's edge."""
    loads: dict[Cell, Floats]
    """What each neighbour feels: (6,), force in N and moment about its centre in N m."""


PULL = Way("pull")

TWIST = Way("twist")

_BETWEEN = Hinge(0.4, 1.0)
"""For a part that hangs at one neighbour and rubs on another: the joint of the latter bears the
drag better than with the hinge at the edge, where it would be lifted, or at the middle, where it
would be drawn off."""

_ASTRIDE = Hinge(0.15, 0.0)
"""For a part between two neighbours: it turns between them, and lifts just enough to carry the
neighbours' own weight."""

SLIDING = (Hinge(0.0, 0.0), Hinge(0.7, 1.0), Hinge(1.0, -0.5), Hinge(1.0, 0.0))
"""For whatever nothing else serves: the part turns along its neighbours rather than away from them,
so that friction bears part of what they weigh, and none is lifted. Without these, twice as many
random structures could not be taken apart; a grid of 25 hinges helps no more."""


class _Face(NamedTuple):
    """One joint of a part whose centre is the origin."""

    neighbour: Cell | None
    """Seen from the part; None for the floor."""
    normal: Floats
    """From the part to the neighbour, (3,)."""
    pull_n: float
    """What its magnets hold."""


def breakings(cells: Cells, cell: Cell, physics: Physics) -> tuple[Breaking, ...]:
    """Every movement that the part can make, the gentlest (least force) first; then those along its
    neighbours, and twisting last.

    These ask least of the arm, but rest on friction, and part the faces least: they are for where
    nothing else serves.

    Args:
        cells: what stands, ``cell`` included.
        cell: the part to take.
        physics: what holds it.
    """
    sides = tuple(
        Cell(*np.subtract(neighbour, cell).tolist())
        for neighbour in cell.neighbours()
        if neighbour.z < 0 or neighbour in cells
    )
    found: dict[Effect, Breaking] = {}
    for effect, breaking in _with_sides(sides, cell.z == 0, physics):
        # A hinge in mid-air may be below or above, with the same effect: the first serves that
        # has room.
        if effect not in found and _may_tilt(cells, cell, breaking.way):
            loads = {
                Cell(cell.x + side.x, cell.y + side.y, cell.z + side.z): load
                for side, load in breaking.loads.items()
            }
            found[effect] = breaking._replace(loads=loads)
    return tuple(found.values())


@lru_cache(maxsize=256)
def _with_sides(
    sides: tuple[Cell, ...], floor: bool, physics: Physics
) -> tuple[tuple[Effect, Breaking], ...]:
    """As ``breakings``, of a part at [0, 0, 0] with these neighbours and all room to tilt."""
    faces = tuple(_faces(sides, floor, physics))
    found: list[tuple[Effect, Breaking]] = []
    for way in _ways(physics):
        breaking = _breaking(faces, way, physics)
        if breaking is not None:
            felt = [(load.round(9) + 0.0).tobytes() for load in breaking.loads.values()]
            found.append(((round(breaking.force_n, 6), *felt), breaking))
    # Rounding must not decide between two movements that are alike: then their order does.
    return tuple(sorted(found, key=lambda one: (_resort(one[1].way), one[0][0])))


def _resort(way: Way) -> int:
    """How late a movement is tried: what rests on friction only where nothing else serves."""
    return 2 if way == TWIST else int(way.hinge in SLIDING)


def _ways(physics: Physics) -> Iterator[Way]:
    """Every movement that is considered."""
    yield PULL
    yield TWIST
    for direction in _TOWARDS:
        # A diagonal edge of the contact is a side of the square that stands on its corner, or the
        # corner of a whole face.
        edge = 1.0
        if all(direction):
            edge = 0.5**0.5 if physics.contact == "diamond" else 2.0**0.5
        yield Way("peel", direction, Hinge(edge, -1.0))
        yield Way("peel", direction, Hinge(edge, 1.0))
        if not all(direction):
            yield Way("peel", direction, _BETWEEN)
            yield Way("peel", direction, _ASTRIDE)
            for hinge in SLIDING:
                yield Way("peel", direction, hinge)


def _may_tilt(cells: Cells, cell: Cell, way: Way) -> bool:
    """Whether part and gripper have room to tilt, apart from the part's own joints."""
    if way == TWIST:
        leaning = {(beside.x, beside.y) for beside in lateral(cell)}
        return not any(other.z > cell.z and (other.x, other.y) in leaning for other in cells)
    if way.direction is None or way.hinge is None:
        return True
    dx, dy = way.direction
    leaning = {(cell.x + dx, cell.y), (cell.x, cell.y + dy), (cell.x + dx, cell.y + dy)}
    leaning.discard((cell.x, cell.y))
    if any(other.z > cell.z and (other.x, other.y) in leaning for other in cells):
        return False
    # Along a diagonal, the part's edge passes the part that only an edge joins it to.
    sign = 1 if way.hinge.up < 0.0 else -1
    return not (dx and dy and Cell(cell.x + sign * dx, cell.y + sign * dy, cell.z) in cells)


def _faces(sides: tuple[Cell, ...], floor: bool, physics: Physics) -> Iterator[_Face]:
    for side in sides:
        rests = floor and side.z < 0
        held = physics.floor_grips or not rests
        normal = np.array(side, dtype=np.float64)
        yield _Face(None if rests else side, normal, physics.magnet_force_n if held else 0.0)


def _breaking(faces: tuple[_Face, ...], way: Way, physics: Physics) -> Breaking | None:
    """One movement of a part with these faces; None where it would press into a neighbour."""
    half_m = physics.pitch_m / 2
    speed = _Velocity.of(way, physics)
    work = physics.weight_n * float(speed.at(np.zeros(3))[2])
    loads = {}
    for face in faces:
        points = _contact_points(face.normal, physics)
        opening = np.array([-speed.at(point) @ face.normal for point in points])
        if opening.min() < -_STILL:
            return None
        centre = half_m * face.normal
        opens = float(-speed.at(centre) @ face.normal) > _STILL
        touching = points[opening < _STILL]
        force, moment = np.zeros(3), np.zeros(3)
        if opens:
            force -= face.pull_n * face.normal
            work += face.pull_n * float(-speed.at(centre) @ face.normal)
        if len(touching):
            contact = touching.mean(axis=0) if opens else centre
            velocity = speed.at(contact)
            along = velocity - (velocity @ face.normal) * face.normal
            twist = half_m * float(speed.angular @ face.normal)
            pressing = face.pull_n * face.normal if opens else np.zeros(3)
            slip = float(np.abs(along).sum()) + abs(twist)
            if slip > _STILL:
                # The programme bounds the sum of shears and twist of a joint; so does this one
                # slip, in proportion to how fast it moves each way.
                drag_n = physics.friction * face.pull_n
                pressing = pressing + drag_n * along / slip
                moment += drag_n * half_m * twist / slip * face.normal
                work += drag_n * float(np.hypot(np.linalg.norm(along), twist))
            force += pressing
            moment += np.cross(contact - centre, pressing)
        if face.neighbour is not None:
            # The neighbour's centre lies half a pitch behind the face.
            about_centre = moment + np.cross(-half_m * face.normal, force)
            loads[face.neighbour] = np.concatenate([force, about_centre])
            loads[face.neighbour].flags.writeable = False  # shared by all parts alike
    lever_m = 1.0 if way.how == "pull" else physics.pitch_m
    return Breaking(way, work / lever_m, loads)


class _Velocity(NamedTuple):
    """The movement of a rigid body at its beginning, of unit speed."""

    linear: Floats
    """Of the part's centre, (3,)."""
    angular: Floats
    """(3,)."""

    @classmethod
    def of(cls, way: Way, physics: Physics) -> _Velocity:
        up = np.array([0.0, 0.0, 1.0])
        if way == TWIST:
            return cls(np.zeros(3), up)
        if way.direction is None or way.hinge is None:
            return cls(up, np.zeros(3))
        towards = np.array([*way.direction, 0.0]) / np.hypot(*way.direction)
        hinge = physics.pitch_m / 2 * (way.hinge.towards * towards + way.hinge.up * up)
        angular = np.cross(up, towards)
        return cls(np.cross(angular, -hinge), angular)

    def at(self, point: Floats) -> Floats:
        """Of a point of the body (3,), from its centre."""
        velocity: Floats = self.linear + np.cross(self.angular, point)
        return velocity


def _contact_points(normal: Floats, physics: Physics) -> Floats:
    """Where the two faces of a joint touch: the corners of the contact, (4, 3)."""
    axis = int(np.argmax(np.abs(normal)))
    unit = np.eye(3)
    u, v = unit[(axis + 1) % 3], unit[(axis + 2) % 3]
    corners = (u, -u, v, -v) if physics.contact == "diamond" else (u + v, u - v, v - u, -u - v)
    points: Floats = physics.pitch_m / 2 * (normal + np.array(corners))
    return points
