"""The judge of every plan: it trusts nothing that the planner computed, and shares no code with it.

Only the values themselves are common. Neighbours, supports, access and the stability of every state
are worked out anew, the last by another formulation (checker_statics.py), so that a mistake in one
is not made by both.
"""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet

from cellctl.assembly import BuildPlan, Cell, Check, Step, StepKind
from cellctl.config import CellConfig
from cellctl.validating.checker_removal import taking_off
from cellctl.validating.checker_statics import Standing

_WRIST_M = 0.24
"""Width of the arm's wrist, which follows the gripper down."""
_SIDES = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))


def verify(
    plan: BuildPlan,
    config: CellConfig,
    parts: int | None = None,
    standing: frozenset[Cell] = frozenset(),
) -> tuple[Check, ...]:
    """Judge a plan, step by step, for a cell.

    Args:
        plan: its steps place and remove parts.
        config: the cell.
        parts: how many parts there are to place; the configured inventory without it.
        standing: what stands before the first step.

    Returns:
        One check each of steps, inventory, workspace, grounding, access, stability, removal (if
        parts are taken) and end shape, in this order. A check that fails names the cells. Stability
        and removal are judged up to the first step that something else makes impossible or that
        does not hold.
    """
    available = config.limits.inventory_parts if parts is None else parts
    states = list(_states(plan, standing))
    sound = next(
        (i for i, (step, before) in enumerate(states) if not _possible(step, before)), None
    )
    judged = states if sound is None else states[:sound]
    return (
        _steps(plan, states),
        _inventory(states, available),
        _workspace(plan, config, standing),
        _grounding(states, standing),
        _access(states, config),
        *_held(judged, standing, config),
        _end_shape(plan, states, standing),
    )


State = tuple[Step, frozenset[Cell]]
"""A step, and what stands before it."""


def _states(plan: BuildPlan, standing: frozenset[Cell]) -> Iterator[State]:
    now = set(standing)
    for step in plan.steps:
        yield step, frozenset(now)
        if step.kind is StepKind.PLACE:
            now.add(step.cell)
        else:
            now.discard(step.cell)


def _after(step: Step, before: frozenset[Cell]) -> frozenset[Cell]:
    return before | {step.cell} if step.kind is StepKind.PLACE else before - {step.cell}


def _possible(step: Step, before: frozenset[Cell]) -> bool:
    """Whether a part can be put where none is, or taken where one is."""
    return (step.cell in before) is (step.kind is StepKind.REMOVE)


def _steps(plan: BuildPlan, states: list[State]) -> Check:
    wrong = [step.cell for step, before in states if not _possible(step, before)]
    counted = all(step.index == number for number, step in enumerate(plan.steps))
    message = (
        f"{len(plan.steps)} steps, each on a cell that is free to be placed or there to be taken."
        if not wrong
        else "Parts would be placed where one stands, or taken where none does."
    )
    if not counted:
        message = "The steps are not numbered from 0 without gaps."
    return _check("steps", message, wrong, counted)


def _inventory(states: list[State], available: int) -> Check:
    """Parts that are taken down can be placed again."""
    left, least, short = available, available, []
    for step, _ in states:
        left += -1 if step.kind is StepKind.PLACE else 1
        if left < 0:
            short.append(step.cell)
        least = min(least, left)
    message = f"{available} parts are there; at most {available - least} are in use at once."
    return _check("inventory", message, short)


def _workspace(plan: BuildPlan, config: CellConfig, standing: frozenset[Cell]) -> Check:
    size = [int(edge_m / config.voxel.pitch_m + 1e-9) for edge_m in config.workspace.size_m]
    outside = [
        cell
        for cell in sorted({step.cell for step in plan.steps} | standing)
        if any(not 0 <= index < room for index, room in zip(cell, size, strict=True))
    ]
    same = abs(plan.pitch_m - config.voxel.pitch_m) < 1e-6
    message = f"The workspace has {size[0]} x {size[1]} x {size[2]} cells."
    if not same:
        message = f"The plan is for parts of {plan.pitch_m:g} m, the cell has others."
    return _check("workspace", message, outside, same)


def _grounding(states: list[State], standing: frozenset[Cell]) -> Check:
    """After every step each part is joined to the floor through parts, face by face."""
    wrong = list(_adrift(standing))
    for step, before in states:
        if step.kind is StepKind.PLACE:
            x, y, z = step.cell
            beside = [Cell(x + i, y + j, z + k) for i, j, k in (*_SIDES, (0, 0, -1))]
            if z > 0 and not any(cell in before for cell in beside):
                wrong.append(step.cell)
        else:
            wrong += _adrift(_after(step, before)) - _adrift(before)
    return _check("grounding", "Every part rests on the floor or is joined to it.", wrong)


def _adrift(cells: AbstractSet[Cell]) -> set[Cell]:
    """Parts from which no way through parts leads to the floor."""
    reached = {cell for cell in cells if cell.z == 0}
    front = list(reached)
    while front:
        x, y, z = front.pop()
        for i, j, k in (*_SIDES, (0, 0, 1), (0, 0, -1)):
            beside = Cell(x + i, y + j, z + k)
            if beside in cells and beside not in reached:
                reached.add(beside)
                front.append(beside)
    return set(cells) - reached


def _access(states: list[State], config: CellConfig) -> Check:
    """The gripper comes straight down, part and wrist with it."""
    pitch_m, tool = config.voxel.pitch_m, config.tool
    wrong = []
    for step, before in states:
        x, y, z = step.cell
        for other in before - {step.cell}:
            gap_m = (max(abs(other.x - x), abs(other.y - y)) - 0.5) * pitch_m
            rise_m = (other.z - z) * pitch_m
            column = gap_m < 0.0 and other.z > z
            body = gap_m < tool.width_m / 2 - 1e-9 and other.z > z
            wrist = gap_m < _WRIST_M / 2 - 1e-9 and rise_m > tool.height_m + 1e-9
            if column or body or wrist:
                wrong.append(step.cell)
                break
    return _check("access", "The gripper reaches every part from above.", wrong)


def _held(states: list[State], standing: frozenset[Cell], config: CellConfig) -> tuple[Check, ...]:
    """Every state stands: at rest, while parts are pressed in, and while they come off.

    The checks of stability and, if parts are taken, of removal; both end with the first step that
    does not hold.
    """
    least = config.stability.least_margin
    everything = standing | {step.cell for step, _ in states}
    now = Standing(everything, config, standing)
    removals = any(step.kind is StepKind.REMOVE for step, _ in states)
    wrong, unheld, unmoved = "", list[Cell](), list[Cell]()
    if standing and not now.rests():
        wrong, unheld = "What stands before the first step would fall.", list(standing)
    for step, before in states if not unheld else ():
        placing = step.kind is StepKind.PLACE
        if not (now.place(step.cell) if placing else now.remove(step.cell)):
            word = "placed" if placing else "taken"
            wrong = f"When {list(step.cell)} is {word}, the joints bear less than {least:g} times "
            wrong, unheld = f"{wrong}what is asked of them.", [step.cell]
            break
        if not placing and (why := _comes_off(now, step, before, config)):
            wrong, unmoved = f"When {list(step.cell)} comes off: {why}.", [step.cell]
            break
    message = (
        f"Every one of {len(states)} states bears {least:g} times its load."
        if states
        else "There is no state to judge."
    )
    stability = _check("stability", wrong if unheld else message, unheld)
    if not removals:
        return (stability,)
    message = f"Every part comes off as stated, and the rest bears {least:g} times what it does."
    return (stability, _check("removal", wrong if unmoved else message, unmoved))


def _comes_off(now: Standing, step: Step, before: frozenset[Cell], config: CellConfig) -> str:
    """Why a part cannot be taken in the stated way, in words; empty if it can. It is gone now."""
    way = taking_off(before, step.cell, step.take_off, config)
    if not way.wrong and not now.bears(way.loads):
        return "the joints of the rest bear less than what that asks of them"
    return way.wrong


def _end_shape(plan: BuildPlan, states: list[State], standing: frozenset[Cell]) -> Check:
    end = _after(*states[-1]) if states else standing
    wanted = frozenset(plan.assembly.cells)
    message = f"The {len(wanted)} wanted cells stand in the end, and no others."
    return _check("end shape", message, sorted(end ^ wanted))


def _check(name: str, message: str, wrong: list[Cell], also: bool = True) -> Check:
    passed = not wrong and also
    cells = tuple(sorted(set(wrong), key=lambda c: (c.z, c.x, c.y)))
    if wrong and not message.startswith(("When", "What", "Parts")):
        message = f"Not so: {message} Cells: {', '.join(str(list(c)) for c in cells[:6])}."
    return Check(name=name, passed=passed, message=message, cells=cells)
