"""What the rest of the cell may ask of the latch gripper."""

from __future__ import annotations

from typing import Protocol


class Gripper(Protocol):
    """A latch that holds one voxel. It keeps its voxel on any loss of power, link or process."""

    async def latch(self, *, prove: bool = True, begun: bool = False) -> None:
        """Close on a part and wait until the gripper confirms a completed latch.

        Args:
            prove: wait for ``proof`` as well.
            begun: it was told to close already, when it was open and nothing was confirmed.

        Raises:
            CellFault: ``gripper_silent`` or ``gripper_fault``.
        """
        ...

    async def proof(self) -> None:
        """See that the latch stays confirmed for longer than a fault could look like it, from now
        on; where it does not, the arm is stopped.

        Raises:
            CellFault: ``gripper_fault`` or ``gripper_reset``: it was revoked.
        """
        ...

    async def feels_part(self) -> bool:
        """Whether a part is in the closed latch, by a sensor of the gripper's own.

        Raises:
            CellFault: ``gripper_silent``: it has none, or that does not answer.
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
