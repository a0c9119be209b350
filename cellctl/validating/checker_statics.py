"""Whether a state of a structure stands, for the judge of plans; shares no code with the planner.

The planner minimises the magnets' pull over forces of contact points. Here the pull is fixed at
what a joint may be asked for, and a balance of the joints' *resultants* is sought: at each joint a
press, two shears, a twist and two tilts of either sign, within the planes that bound them.

Whatever is found is compared with equations and planes of the whole state before it counts, so how
it was found does not matter. Three ways are tried, the cheapest first: what the joints would bear
if they gave like springs around the part that comes or goes; a programme for these surroundings,
with the joints elsewhere as they are; a programme for the whole. Only the last says that a state
falls.
"""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Set as AbstractSet

import numpy as np
from scipy.optimize import linprog

from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.validating.checker_model import Bools, Floats, Ints, Model, Z

_NEAR = 20
"""About how many parts are balanced anew first."""


def stands(cells: AbstractSet[Cell], config: CellConfig, pressed: Cell | None = None) -> bool:
    """Whether some forces within the joints' strength over the least margin balance all loads.

    Args:
        cells: what stands.
        config: the cell, with its ``[stability]``.
        pressed: a part that is being placed: it is pressed down too, and where it is set on
            something also pushed aside, in any of four directions.
    """
    state = Standing(cells, config, cells)
    return state.rests() and (pressed is None or state.bears_pressing(pressed))


class Standing:
    """A structure that parts come to and go from, with forces that balance it at rest.

    Args:
        cells: all that are to stand at some time.
        config: the cell, with its ``[stability]``.
        standing: what stands at first.
    """

    def __init__(
        self, cells: AbstractSet[Cell], config: CellConfig, standing: AbstractSet[Cell]
    ) -> None:
        self._model = Model(cells, config)
        self._stability = config.stability
        self._here: Bools = np.array([cell in standing for cell in self._model.cells], dtype=bool)
        self._resultants = np.zeros((len(self._model.upper), 6))
        for cell in standing:
            self._bear_straight(self._model.number[cell])
        self._touched = list(range(len(self._model.cells)))
        self._spread: dict[tuple[int, ...], Floats | None] = {}
        """How springs spread what is left over of some parts, as long as the same parts stand."""

    def rests(self) -> bool:
        """Whether what stands now stays so."""
        found = self._balanced(self._model.rest(self._here), self._touched)
        if found is not None:
            self._resultants = found
        return found is not None

    def place(self, cell: Cell) -> bool:
        """Put a part; whether that holds, while it is pressed in and after."""
        body = self._model.number[cell]
        self._here[body] = True
        self._spread.clear()
        self._bear_straight(body)
        self._touched = [body]
        return self.rests() and self.bears_pressing(cell)

    def remove(self, cell: Cell) -> bool:
        """Take a part away; whether the rest stands after."""
        body = self._model.number[cell]
        self._here[body] = False
        self._spread.clear()
        self._resultants[~self._model.joined(self._here)] = 0.0
        self._touched = [other for other in self._model.beside[body] if self._here[other]]
        return self.rests()

    def bears_pressing(self, cell: Cell) -> bool:
        """Whether a part can be pressed in; what stands must rest."""
        body, pull_n = self._model.number[cell], self._stability.magnet_force_n
        down = self._stability.placement_down_n / pull_n
        side = self._stability.placement_side_n / pull_n
        under = self._model.beneath[body]
        set_down = cell.z == 0 or (under >= 0 and self._here[under])
        # A force (fx, fy) at the height of the top face turns by (-fy, fx) about the centre.
        pushes = [
            np.array([i * side, j * side, -down, -j * side, i * side, 0.0])
            for i, j in (((1, 0), (-1, 0), (0, 1), (0, -1)) if set_down else ((0, 0),))
        ]
        return all(self.bears({cell: push}) for push in pushes)

    def bears(self, loads: Mapping[Cell, Floats]) -> bool:
        """Whether these are borne besides the weights, each force (3) and moment (3) of a part,
        in pulls of a magnet and halves of an edge; what stands must rest."""
        load = self._model.rest(self._here)
        touched = [self._model.number[cell] for cell in sorted(loads)]
        for cell, felt in loads.items():
            load[self._model.number[cell]] += felt * self._model.pull
        return self._balanced(load, touched) is not None

    def _bear_straight(self, body: int) -> None:
        """Send a part's weight down its column, if that stands on the floor."""
        model, joints = self._model, []
        while body >= 0 and self._here[body]:
            joints.append(model.column_joint[body])
            body = model.beneath[body]
        if joints and joints[-1] >= 0 and model.lower[joints[-1]] < 0:
            self._resultants[joints, Z] += model.weight

    def _balanced(self, load: Floats, touched: list[int]) -> Floats | None:
        """Resultants that balance a load; None if there are none."""
        model, here = self._model, self._here
        if model.holds(self._resultants, load, here):
            return self._resultants
        whole = np.flatnonzero(here)
        near = np.array(model.around(touched, here, _NEAR), dtype=np.int64)
        regions = [near] if len(near) < len(whole) else []
        for attempt, among in ((self._springs, [near]), (self._programme, [*regions, whole])):
            for bodies in among:
                found = attempt(load, bodies)
                if found is not None and model.holds(found, load, here):
                    return found
        return None

    def _region(self, load: Floats, bodies: Ints) -> tuple[Bools, Floats]:
        """Joints within some parts, and what is left over of these, (6 parts,)."""
        within = np.zeros(len(self._here), dtype=bool)
        within[bodies] = True
        over = self._model.left_over(self._resultants, load)[within]
        return self._model.joined(within), over.ravel()

    def _springs(self, load: Floats, bodies: Ints) -> Floats | None:
        """Spread what is left over as springs would; None if some parts are held by nothing."""
        joints, over = self._region(load, bodies)
        key = tuple(bodies.tolist())
        if key not in self._spread:
            self._spread[key] = self._spreading(bodies, joints)
        spread = self._spread[key]
        if spread is None:
            return None
        found = self._resultants.copy()
        found[joints] -= (spread @ over).reshape(-1, 6)
        return found

    def _spreading(self, bodies: Ints, joints: Bools) -> Floats | None:
        """What each joint of springs takes up of each load, (6 joints, 6 parts)."""
        rows, columns = _six(bodies), _six(np.flatnonzero(joints))
        balance = self._model.balance_of(rows, columns)
        eased = balance * self._model.ease[joints].ravel()
        try:
            spread: Floats = eased.T @ np.linalg.inv(eased @ balance.T)
        except np.linalg.LinAlgError:
            return None
        return spread

    def _programme(self, load: Floats, bodies: Ints) -> Floats | None:
        """Resultants anew within some parts; None if they cannot balance."""
        model = self._model
        joints, over = self._region(load, bodies)
        numbers = np.flatnonzero(joints)
        if not len(numbers):
            return None
        rows, columns = _six(bodies), _six(numbers)
        each = model.offsets.shape[1]
        planes = (each * numbers[:, None] + np.arange(each)).ravel()
        balance = model.balance[rows][:, columns]
        present = self._resultants[joints].ravel()
        found = linprog(
            np.zeros(len(columns)),
            A_ub=model.limits[planes][:, columns],
            b_ub=model.offsets[joints].ravel() + 1e-9,
            A_eq=balance,
            b_eq=balance @ present - over,
            bounds=(None, None),
            method="highs-ds",
        )
        if found.status != 0:
            return None
        resultants = self._resultants.copy()
        resultants[joints] = found.x.reshape(-1, 6)
        return resultants


def _six(numbers: Ints) -> Ints:
    """The six places of each number."""
    places: Ints = (6 * numbers[:, None] + np.arange(6)).ravel()
    return places
