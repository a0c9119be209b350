"""What is believed of the cell: a fold over the acts that are settled.

The running daemon and one that reads the journal after a crash use the same fold, so that they
cannot believe different things.
"""

from __future__ import annotations

from cellctl.assembly import Cell, Value
from cellctl.control.acts import Act, ActKind
from cellctl.feeding.inventory import Counts, InventoryError, Move


class Ledger(Value):
    """Where the parts are, and what the latch has."""

    counts: Counts
    standing: frozenset[Cell] = frozenset()
    """Cells of the workspace that hold a part."""
    lift_unchecked: bool = False
    """Nobody has yet seen that the part in the gripper left the station."""
    missed: bool = False
    """The latch may be closed, and on nothing: the last pick left its part at the station, or a
    person says that it is empty."""
    belt_indexes: int | None = None
    """The board's counter when the part in the gripper was picked."""
    gripped: Cell | None = None
    """The gripper has hold of the part that stands at this cell, or may have: the latch has closed
    on it to take it off, or was told to let it go, and nobody has felt that it is free."""
    taken_from: Cell | None = None
    """The cell that the part in the gripper was taken off; None for one that came by the belt."""

    @property
    def holding(self) -> bool:
        """Whether the gripper holds a part."""
        return self.counts.gripper == 1

    def after(self, act: Act) -> Ledger:
        """What is believed after an act that is settled.

        Raises:
            InventoryError: the act cannot have happened, by what is believed now.
        """
        counts = act.counts if act.counts is not None else self.counts.after_all(act.moves)
        if act.kind is not ActKind.OWN and counts.total != self.counts.total:
            raise InventoryError(
                f"{act.kind.value}: {self.counts.total} parts would become {counts.total}.",
                "Parts come and go only with `cellctl inventory own NUMBER`.",
            )
        standing = self._standing_after(act)
        if len(standing) != counts.structure:
            raise InventoryError(
                f"{act.kind.value}: {counts.structure} parts are counted in the structure, "
                f"and {len(standing)} cells hold one.",
                "Count the parts and tell it with `cellctl inventory set`.",
            )
        holding = counts.gripper == 1
        taken = act.cell if Move.TAKE_OFF in act.moves else self.taken_from
        picked = act.kind is ActKind.PICK and Move.PICK in act.moves
        missed = Move.MISS in act.moves or _told_empty(act)
        carried = act.kind is ActKind.PLACE and act.outcome == "done"
        return Ledger(
            counts=counts,
            standing=standing,
            # The next part is called in only after the one in the gripper was seen to leave.
            lift_unchecked=holding
            and (picked or (self.lift_unchecked and not carried and act.kind is not ActKind.FEED)),
            missed=missed or (self.missed and not picked and act.kind is not ActKind.HAND_OPEN),
            belt_indexes=act.belt_indexes if picked else self.belt_indexes,
            gripped=self._gripped_after(act, standing),
            taken_from=taken if holding and Move.PICK not in act.moves else None,
        )

    def _gripped_after(self, act: Act, standing: frozenset[Cell]) -> Cell | None:
        unfelt = act.kind is ActKind.RELEASE and act.outcome == "interrupted"
        if (act.kind is ActKind.GRIP and act.outcome == "done") or unfelt:
            return act.cell if act.cell in standing else None
        opened = act.kind in {ActKind.LET_STAND, ActKind.HAND_OPEN} and act.outcome == "done"
        # What an operator says of a taking that is in doubt ends it, wherever the part is.
        told = act.kind is ActKind.TAKE_OFF and act.outcome == "failed"
        return None if opened or told or self.gripped not in standing else self.gripped

    def _standing_after(self, act: Act) -> frozenset[Cell]:
        if Move.PLACE in act.moves:
            assert act.cell is not None, "a part is placed at a cell"
            if act.cell in self.standing:
                raise InventoryError(f"Two parts would stand at {act.cell}.")
            # One that was let go and fell never stood.
            return self.standing if Move.LOSE_PLACED in act.moves else self.standing | {act.cell}
        if Move.LOSE_PLACED in act.moves or Move.TAKE_OFF in act.moves:
            assert act.cell is not None, "a part that is gone had a cell"
            return self.standing - {act.cell}
        if act.kind in {ActKind.CLEAR, ActKind.HAND_OVER} and act.outcome == "done":
            return frozenset()
        return self.standing


_GONE = {Move.TAKE_OUT, Move.SCRAP_GRIPPED, Move.LOSE_GRIPPED}


def _told_empty(act: Act) -> bool:
    """A person says that the part is not in the gripper, whatever its latch does."""
    if act.kind is ActKind.HAND_OPEN:
        return False
    placed = Move.PLACE in act.moves and act.kind is not ActKind.RELEASE
    return placed or not _GONE.isdisjoint(act.moves)
