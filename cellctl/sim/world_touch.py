"""What the tool feels along the vertical: parts that it presses on, and magnets that hold it back.

Parts are rigid where they are judged; arm, tool and magnets give a little all the same, which is
what a force sensor lives on. Both are springs, and small: a tenth of a millimetre is felt.
"""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Set as AbstractSet

from cellctl.assembly import Cell
from cellctl.sim.plant import Floats

STIFFNESS_N_M = 2.0e4
"""Of arm and part together: how hard a part is pressed for each metre below its seat."""
_ASIDE_M = 0.03
"""A part presses on what is under it where it is no farther aside."""


def pressing_n(
    tcp: Floats,
    placed: AbstractSet[Cell],
    station: Floats,
    pitch_m: float,
    raised_m: Mapping[Cell, float],
) -> float:
    """How hard the held part is pressed on what is under it, in N.

    Args:
        tcp: 4x4 pose of the TCP in the workspace frame.
        placed: cells that hold a part.
        station: 4x4 pose, in the same frame, of the top of a part at the pick station.
        raised_m: how much higher than its cell a placed part stands.
    """
    x_m, y_m, top_m = tcp[:3, 3].tolist()
    bottom_m = top_m - pitch_m
    if max(abs(x_m - station[0, 3]), abs(y_m - station[1, 3])) < _ASIDE_M:
        return _spring_n(float(station[2, 3]) - pitch_m - bottom_m, pitch_m)
    column = int(x_m // pitch_m), int(y_m // pitch_m)
    centre_m = ((column[0] + 0.5) * pitch_m, (column[1] + 0.5) * pitch_m)
    if max(abs(x_m - centre_m[0]), abs(y_m - centre_m[1])) > _ASIDE_M:
        return 0.0
    layer = round(bottom_m / pitch_m) - 1
    under = Cell(*column, layer)
    if layer >= 0 and under not in placed:
        return 0.0
    return _spring_n((layer + 1) * pitch_m + raised_m.get(under, 0.0) - bottom_m, pitch_m)


def leaning_n(
    tcp: Floats, placed: AbstractSet[Cell], pitch_m: float, raised_m: Mapping[Cell, float]
) -> float:
    """How hard the face of an empty gripper is pressed on a placed part, in N.

    Args:
        tcp, placed, pitch_m, raised_m: as for ``pressing_n``.
    """
    x_m, y_m, face_m = tcp[:3, 3].tolist()
    under = Cell(int(x_m // pitch_m), int(y_m // pitch_m), round(face_m / pitch_m) - 1)
    aside_m = max(abs(x_m - (under.x + 0.5) * pitch_m), abs(y_m - (under.y + 0.5) * pitch_m))
    if aside_m > _ASIDE_M or under not in placed:
        return 0.0
    return _spring_n((under.z + 1) * pitch_m + raised_m.get(under, 0.0) - face_m, pitch_m)


def holding_back_n(lifted_m: float, magnet_n: float, parting_m: float) -> float:
    """How hard magnets hold a gripped part that is lifted, in N; negative where it is pressed."""
    if lifted_m <= 0.0:
        return lifted_m * STIFFNESS_N_M
    return magnet_n * min(1.0, lifted_m / parting_m)


def _spring_n(depth_m: float, pitch_m: float) -> float:
    return STIFFNESS_N_M * depth_m if 0.0 < depth_m < pitch_m / 2 else 0.0
