"""What the rest of the cell may ask of the latch gripper."""

from __future__ import annotations

from typing import Protocol


class Gripper(Protocol):
    """A latch that holds one voxel. It keeps its voxel on any loss of power, link or process."""

    async def latch(self) -> None:
        """Close on a part and wait until the gripper confirms a completed latch.

        Raises:
            CellFault: ``gripper_silent`` or ``gripper_fault``.
        """
        ...

    async def check_wiring(self) -> float:
        """Prove both lines by moving the latch: open, closed, open. Never with a part in it, which
        it would drop; a new cell's commissioning asks for it.

        Returns:
            Time from the command to the confirmation of a latch, in seconds (cell time).

        Raises:
            CellFault: ``gripper_silent`` or ``gripper_fault``; says which line does not do what.
        """
        ...

    async def unlatch(self) -> None:
        """Let the part go and wait until the gripper confirms it.

        Raises:
            CellFault: ``gripper_silent`` or ``gripper_fault``.
        """
        ...
