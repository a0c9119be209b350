"""The linear programmes of equilibrium, given to the solver that is fastest for their size."""

from __future__ import annotations

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_array

from cellctl.errors import PlanError
from cellctl.validating.stability.joints import Floats

_SMALL_ROWS = 450
"""Up to this many rows GLOP's dual simplex is faster than HiGHS' interior-point method."""
_GLOP = "use_preprocessing:false use_dual_simplex:true"


class Optimum(NamedTuple):
    """A solution of a programme."""

    value: float
    """Infinite where nothing fulfils the conditions."""
    variables: Floats
    duals: Floats
    """What the value grows by as the right side of an equation does, one an equation."""


INFEASIBLE = Optimum(float("inf"), np.empty(0), np.empty(0))


def minimise(cost: Floats, rows: csr_array, sides: Floats, low: Floats, equations: int) -> Optimum:
    """Minimise ``cost @ x`` with ``x >= low``; the first rows are equations, the others ``<=``.

    Args:
        cost: (n,).
        rows: (m, n).
        sides: right sides, (m,).
        low: (n,).
        equations: how many rows are equations.

    Raises:
        PlanError: the solver found neither a solution nor that there is none.
    """
    if len(sides) <= _SMALL_ROWS:
        found = _by_glop(cost, rows, sides, low, equations)
        if found is not None:
            return found
    return _by_highs(cost, rows, sides, low, equations)


def _by_glop(
    cost: Floats, rows: csr_array, sides: Floats, low: Floats, equations: int
) -> Optimum | None:
    """None where GLOP gives up, as it may for numerical reasons."""
    # Loaded when first needed: it takes a fifth of a second. Its stubs misname numpy's types.
    glop: Any = import_module("ortools.linear_solver.python.model_builder_helper")
    least = sides.copy()
    least[equations:] = -np.inf
    model = glop.ModelBuilderHelper()
    model.fill_model_from_sparse_data(low, np.full(len(cost), np.inf), cost, least, sides, rows)
    solver = glop.ModelSolverHelper("GLOP")
    solver.set_solver_specific_parameters(_GLOP)
    solver.solve(model)
    status = solver.status()
    if status == glop.SolveStatus.OPTIMAL:
        return Optimum(
            float(solver.objective_value()),
            np.array(solver.variable_values()),
            np.array(solver.dual_values())[:equations],
        )
    if status == glop.SolveStatus.INFEASIBLE:
        return INFEASIBLE
    return None


def _by_highs(cost: Floats, rows: csr_array, sides: Floats, low: Floats, equations: int) -> Optimum:
    found = linprog(
        cost,
        A_ub=rows[equations:],
        b_ub=sides[equations:],
        A_eq=rows[:equations],
        b_eq=sides[:equations],
        bounds=np.column_stack([low, np.full(len(low), np.inf)]),
        method="highs-ipm",
    )
    if found.status == 2:
        return INFEASIBLE
    if found.status != 0:
        raise PlanError(
            f"The stability of this object cannot be computed: {found.message}",
            "Ask for a smaller object.",
            rule="stability",
        )
    return Optimum(float(found.fun), found.x, np.asarray(found.eqlin.marginals))
