"""A quick proof that a load is borne: every part hands what it bears down one path to the floor.

If no joint on these paths is overloaded, the structure stands [the lower bound theorem of limit
analysis: any balance of forces that overloads no joint is proof]. If one is, the structure may
stand all the same, because loads can be shared.
"""

from __future__ import annotations

from collections.abc import Iterable

from cellctl.assembly import Cell
from cellctl.sim.physics.joints import Joint, Material
from cellctl.sim.physics.loads import Push, pushes

Triple = tuple[float, float, float]


def unproven(
    cells: frozenset[Cell], material: Material, newest: Cell | None = None
) -> tuple[Push, ...]:
    """The pushes (and rest) under which single paths do not prove that a structure stands.

    Args:
        cells: all are joined to the floor.
        newest: the part that is being placed, if one is.
    """
    path = _parents(cells)
    loads = pushes(newest, cells, material)
    pushed_joints = _to_the_floor(newest, path)
    weight = dict.fromkeys(path, 1.0)
    moments = {cell: _cross(_centre(cell), (0.0, 0.0, -1.0)) for cell in path}
    left: set[Push] = set()
    for cell in reversed(path):
        joint, parent = _joint(cell, path[cell]), path[cell]
        down, moment = (0.0, 0.0, -weight[cell]), moments[cell]
        if newest is None or cell not in pushed_joints:
            if not _bears(joint, cell, down, moment, material):
                return loads
        else:
            x, y, z = _centre(newest)
            for push in loads:
                about = _plus(moment, _cross((x, y, z + 1.0), push))
                if not _bears(joint, cell, _plus(down, push), about, material):
                    left.add(push)
        if parent in path:
            weight[parent] += weight[cell]
            moments[parent] = _plus(moments[parent], moment)
    return tuple(push for push in loads if push in left)


def _to_the_floor(cell: Cell | None, path: dict[Cell, Cell]) -> set[Cell]:
    """The cells on one's way down, itself included."""
    found = set()
    while cell is not None and cell in path:
        found.add(cell)
        cell = path[cell]
    return found


def _parents(cells: frozenset[Cell]) -> dict[Cell, Cell]:
    """The next one on each cell's path, the floor's at its end; parents come first.

    Columns that reach the floor go straight down; the rest goes the fewest joints to one of them.
    """
    path: dict[Cell, Cell] = {}
    for cell in sorted(cells, key=lambda cell: (cell.z, cell)):
        if cell.z == 0 or cell.below() in path:
            path[cell] = cell.below()
    level = list(path)
    while level:
        reached = []
        for cell in level:
            for near in cell.neighbours():
                if near in cells and near not in path:
                    path[near] = cell
                    reached.append(near)
        level = reached
    return path


def _joint(cell: Cell, parent: Cell) -> Joint:
    axis = next(at for at in range(3) if cell[at] != parent[at])
    lower, upper = (parent, cell) if parent[axis] < cell[axis] else (cell, parent)
    return Joint(lower, upper, axis)


def _bears(joint: Joint, cell: Cell, force: Triple, moment: Triple, material: Material) -> bool:
    """Whether a joint bears the load on all that hangs on one side of it.

    Args:
        cell: that side of it.
        force: on all of that.
        moment: of the same, about the origin.
    """
    x, y, z = _centre(joint.upper)
    arm = (x - (joint.axis == 0), y - (joint.axis == 1), z - (joint.axis == 2))
    about = _minus(moment, _cross(arm, force))
    # What the lower part must do to the upper one.
    sign = -1.0 if cell == joint.upper else 1.0
    n, u, v = joint.axis, (joint.axis + 1) % 3, (joint.axis + 2) % 3
    magnet = material.magnet if joint.lower.z >= 0 else material.floor_magnet
    wrench = (sign * force[n], force[u], force[v], about[u], about[v], about[n])
    return material.bears(wrench, magnet)


def _centre(cell: Iterable[int]) -> Triple:
    x, y, z = cell
    return (2.0 * x + 1.0, 2.0 * y + 1.0, 2.0 * z + 1.0)


def _plus(a: Triple, b: Triple) -> Triple:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _minus(a: Triple, b: Triple) -> Triple:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _cross(a: Triple, b: Triple) -> Triple:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
