"""The steps of a plan as what becomes of each part, and the colours that tell their order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from cellctl.assembly import BuildPlan, Cell, StepKind
from cellctl.drawing.scene import Colour

FIRST_TO_LAST: Final[tuple[Colour, ...]] = (
    (0.20, 0.22, 0.46),
    (0.16, 0.46, 0.60),
    (0.24, 0.66, 0.58),
    (0.66, 0.79, 0.40),
    (0.98, 0.77, 0.29),
)
"""From the first step to the last: its lightness rises throughout, so that the order can be seen
without colours too, and it has no red, which marks what is wrong or weak."""
STANDING: Final[Colour] = (0.62, 0.62, 0.61)
"""What stood there before the first step."""


@dataclass(frozen=True)
class Life:
    """One part: when it comes and when it goes."""

    cell: Cell
    placed: int | None
    """Index of the step that puts it there; None for what stands before the first step."""
    removed: int | None
    """Index of the step that takes it away; None for what stays."""

    def stands_after(self, steps: int) -> bool:
        """Whether it is there when so many steps are done."""
        came = self.placed is None or self.placed < steps
        return came and (self.removed is None or self.removed >= steps)


def lives_of(plan: BuildPlan) -> tuple[Life, ...]:
    """Every part that a plan knows, those that stand before it first, then as they are placed.

    What a plan takes away before it puts it there, and what its object has without a step for it,
    stood before.
    """
    here: dict[Cell, int | None] = {}
    ended: list[Life] = []
    for step in plan.steps:
        if step.kind is StepKind.PLACE:
            here[step.cell] = step.index
        else:
            ended.append(Life(step.cell, here.pop(step.cell, None), step.index))
    kept = [Life(cell, None, None) for cell in plan.assembly.cells if cell not in here]
    stay = [Life(cell, placed, None) for cell, placed in here.items()]
    return tuple(
        sorted(
            (*kept, *stay, *ended),
            key=lambda life: (life.placed if life.placed is not None else -1, life.cell[::-1]),
        )
    )


def order_colour(index: int | None, steps: int) -> Colour:
    """The colour of what the step of that index places, of so many steps; None: stood before."""
    if index is None:
        return STANDING
    at = index / max(1, steps - 1) * (len(FIRST_TO_LAST) - 1)
    low = min(int(at), len(FIRST_TO_LAST) - 2)
    share = at - low
    r, g, b = (
        a + (z - a) * share for a, z in zip(FIRST_TO_LAST[low], FIRST_TO_LAST[low + 1], strict=True)
    )
    return (r, g, b)


def moments(plan: BuildPlan, count: int) -> tuple[int, ...]:
    """After how many steps pictures of the build say most, so many of them.

    They are the ends of layers where there are not too many, and what lies between them in halves
    where there are too few. Where something stands before the first step, that is the first one.

    Returns:
        Numbers of steps done, rising, the last of them all steps; fewer where there are fewer, and
        none where there are no steps.
    """
    total = len(plan.steps)
    if total == 0:
        return ()
    if any(life.placed is None for life in lives_of(plan)):
        return (0, *_ends(plan, count - 1))
    return _ends(plan, count)


def _ends(plan: BuildPlan, count: int) -> tuple[int, ...]:
    """``moments`` after the first step."""
    total = len(plan.steps)
    steps = plan.steps
    ends = [at for at in range(1, total) if steps[at].cell.z != steps[at - 1].cell.z] + [total]
    if len(ends) > count:
        ends = [ends[round(len(ends) * (k + 1) / count) - 1] for k in range(count)]
    found = [0, *ends]
    while len(found) - 1 < min(count, total):
        longest = max(range(1, len(found)), key=lambda k: found[k] - found[k - 1])
        found.insert(longest, (found[longest - 1] + found[longest]) // 2)
    return tuple(found[1:])
