"""Removals and change-overs as build plans: what the report shows and the arm will run."""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Callable, Sequence

from cellctl.assembly import Assembly, BuildPlan, Cell, Change, Check, Step
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.validating.access import Access, Gripper
from cellctl.validating.changing.breaking import How
from cellctl.validating.changing.changeover import ChangeOver, change_over
from cellctl.validating.changing.moves import Belt, Judge, Move, find_moves
from cellctl.validating.rules import Cells
from cellctl.validating.stability import Physics
from cellctl.validating.words import count, listed, parts


def plan_removal(
    standing: Cells,
    config: CellConfig,
    *,
    keep: Cells = frozenset(),
    title: str = "object",
    parts_on_belt: int | None = None,
    access: Access | None = None,
) -> BuildPlan:
    """Take apart what stands, part by part; its steps have neither clearance nor duration yet.

    Args:
        standing: what stands.
        config: the cell.
        keep: what stays.
        title: of the object that stands.
        parts_on_belt: how many lie there; what its capacity leaves, if None.
        access: what bars the way to a part; the gripper's way down alone, if None.

    Raises:
        PlanError: there is nothing to take, or no order in which every state stands.
    """
    if not standing - keep:
        raise PlanError("Nothing stands that could be taken apart.")
    belt = _belt(config, len(standing), parts_on_belt)
    if len(standing - keep) > belt.capacity - belt.parts:
        raise PlanError(
            f"{parts(len(standing - keep))} would come back; the belt has room for "
            f"{belt.capacity - belt.parts} more.",
            "Take parts off the belt and count them first.",
        )
    judge = Judge(Physics.of(config), access or Gripper.of(config))
    moves = find_moves(standing, standing - keep, frozenset(), judge, belt)
    return _plan(moves, keep, config, title=f"{title}, taken apart", provenance="what stands")


def plan_change_over(
    standing: Cells,
    wanted: Cells,
    config: CellConfig,
    *,
    title: str = "object",
    provenance: str = "from cells",
    mirrors: bool = False,
    parts_on_belt: int | None = None,
    reachable: Callable[[Cell], bool] | None = None,
    access: Access | None = None,
) -> BuildPlan:
    """Change what stands into the next object; its steps have neither clearance nor duration yet.

    Args:
        standing: what stands.
        wanted: the next object, anywhere.
        config: the cell.
        title: of the next object.
        provenance: where its shape came from.
        mirrors: whether its mirror image serves as well.
        parts_on_belt: how many lie there; what its capacity leaves, if None.
        reachable: whether the arm can put a part there; every cell, if None.
        access: what bars the way to a cell; the gripper's way down alone, if None.

    Raises:
        PlanError: it does not fit, there are too few parts, or there is no order of moves in
            which every state stands.
    """
    belt = _belt(config, len(standing), parts_on_belt)
    found = change_over(
        standing,
        wanted,
        config.grid,
        Physics.of(config),
        access or Gripper.of(config),
        mirrors=mirrors,
        belt=belt,
        reachable=reachable,
    )
    return _plan(
        found.steps,
        found.wanted_cells,
        config,
        title=title,
        provenance=provenance,
        changes=_told(found, len(standing)),
    )


def _belt(config: CellConfig, standing: int, parts: int | None) -> Belt:
    """The belt; unless its parts are counted, it holds what is not built in, as far as they fit."""
    capacity = config.feeder.capacity_parts
    if parts is None:
        parts = max(0, min(capacity, config.limits.inventory_parts) - standing)
    return Belt(parts, capacity)


def _plan(
    moves: Sequence[Move],
    remaining: Cells,
    config: CellConfig,
    *,
    title: str,
    provenance: str,
    changes: tuple[Change, ...] = (),
) -> BuildPlan:
    pitch_m = config.voxel.pitch_m
    steps = tuple(
        Step(
            index=index,
            kind=move.kind,
            cell=move.cell,
            margin=None if math.isinf(move.margin) else round(move.margin, 4),
            take_off=move.removal.take_off(pitch_m) if move.removal is not None else None,
        )
        for index, move in enumerate(moves)
    )
    return BuildPlan(
        plan_id=_plan_id(moves, config),
        title=title,
        pitch_m=pitch_m,
        assembly=Assembly.of(remaining, pitch_m),
        steps=steps,
        checks=_checks(moves, config),
        changes=changes,
        provenance=provenance,
    )


def _checks(moves: Sequence[Move], config: CellConfig) -> tuple[Check, ...]:
    """What was proven, with its figures."""
    if not moves:
        still = "Nothing is moved; it stands as it did."
        return (Check(name="stability", passed=True, message=still),)
    least = min((move.margin for move in moves), default=math.inf)
    much = (
        "need none of their pull" if math.isinf(least) else f"hold {least:.2f} times what is asked"
    )
    stability = Check(
        name="stability",
        passed=least >= config.stability.least_margin,
        message=f"Every state stands; the magnets {much} at the worst.",
    )
    removals = [move.removal for move in moves if move.removal is not None]
    if not removals:
        return (stability,)
    ways = Counter(removal.how for removal in removals)
    most_n = max(removal.force_n for removal in removals)
    return (
        stability,
        Check(
            name="removal",
            passed=True,
            message=f"{_ways(ways)}; the arm needs {most_n:.0f} N at most.",
        ),
    )


def _ways(ways: Counter[How]) -> str:
    """``2 parts are peeled off and 1 pulled off``: how many come off which way, where any does."""
    done: tuple[tuple[How, str], ...] = (
        ("peel", "peeled off"),
        ("twist", "twisted off"),
        ("pull", "pulled off"),
    )
    (number, word), *others = [(ways[way], word) for way, word in done if ways[way]]
    first = f"{parts(number, 'is', 'are')} {word}"
    return listed([first, *(f"{number} {word}" for number, word in others)])


def _told(found: ChangeOver, standing: int) -> tuple[Change, ...]:
    """What a visitor is told of a change-over."""
    anew = found.moves + found.moves_saved
    kept = len(found.kept)
    stay = f"{kept} of {parts(standing)} {'stays' if kept == 1 else 'stay'}"
    told = [
        Change(
            what=f"{stay}; {count(found.moves, 'move')} instead of {anew}."
            if found.moves
            else "It stands already; nothing is moved.",
            why="What both objects have in common need not be built again.",
        )
    ]
    if said := found.transform.describe():
        told.append(Change(what=f"It is {said}.", why="More parts can stay so."))
    return tuple(told)


def _plan_id(moves: Sequence[Move], config: CellConfig) -> str:
    """The same moves in the same cell have the same."""
    identity = {
        "moves": [(move.kind.value, move.cell) for move in moves],
        "pitch_m": config.voxel.pitch_m,
        "workspace": config.workspace.model_dump(),
        "base": config.base.frame,
        "feeder": config.feeder.frame,
    }
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:16]
