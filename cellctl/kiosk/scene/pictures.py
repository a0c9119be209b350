"""What the 3D view shows, from what is known of the cell: pure functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from cellctl.assembly import Cell
from cellctl.messages import Snapshot


@dataclass(frozen=True)
class Picture:
    """One state of the 3D view.

    ``cell`` shows the workspace, the arm and the belt; ``table`` an object that turns, before it is
    built.
    """

    mode: Literal["cell", "table"]
    standing: tuple[Cell, ...] = ()
    planned: tuple[Cell, ...] = ()
    """Of the plan, what does not stand yet."""
    held: bool = False
    belt_parts: int = 0
    belt_waiting: bool = False
    """A part waits at the pick station."""
    kept: tuple[Cell, ...] = ()
    """On the table: parts as the shape wanted them."""
    added: tuple[Cell, ...] = ()
    """Parts that the planner added."""
    left_out: tuple[Cell, ...] = ()
    """Cells of the shape that the planner left out."""
    mesh: str = ""
    """Address of the shape's GLB; empty for none."""

    def as_json(self) -> dict[str, Any]:
        """For ``cell_view.js``."""
        return {
            "mode": self.mode,
            "held": self.held,
            "belt": {"count": self.belt_parts, "waiting": self.belt_waiting},
            "mesh": self.mesh,
        } | {
            name: [list(cell) for cell in getattr(self, name)]
            for name in ("standing", "planned", "kept", "added", "left_out")
        }


def cell_picture(snapshot: Snapshot) -> Picture:
    """The cell as it is."""
    standing = frozenset(snapshot.standing)
    job, plan = snapshot.job, snapshot.plan
    under_way = job is not None and not job.outcome and plan is not None
    planned = frozenset(plan.assembly.cells) - standing if plan is not None and under_way else ()
    waiting = snapshot.conveyor.part_present
    return Picture(
        "cell",
        standing=tuple(sorted(standing)),
        planned=tuple(sorted(planned)),
        held=snapshot.gripper.holding in {"part", "releasing"},
        belt_parts=snapshot.inventory.get("belt", 0),
        belt_waiting=waiting,
    )


def table_picture(snapshot: Snapshot, mesh: str) -> Picture:
    """The planned object by itself, with what was changed.

    Args:
        snapshot: has a plan.
        mesh: address of the shape's GLB; empty for none.
    """
    assert snapshot.plan is not None
    cells, wanted = frozenset(snapshot.plan.assembly.cells), frozenset(snapshot.plan.wanted)
    added = cells - wanted if wanted else frozenset()
    return Picture(
        "table",
        kept=tuple(sorted(cells - added)),
        added=tuple(sorted(added)),
        left_out=tuple(sorted(wanted - cells)),
        mesh=mesh,
    )
