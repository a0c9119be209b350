"""What the rest of the cell may ask of the conveyor."""

from __future__ import annotations

from typing import Protocol

from cellctl.assembly import Value


class BeltIdentity(Value):
    """What the conveyor's board says it is."""

    role: str
    port: str
    serial_number: str
    protocol_version: int
    firmware_version: str


class BeltState(Value):
    """What the conveyor's board knows."""

    part_present: bool
    """The sensor at the pick station sees a part."""
    moving: bool
    indexes: int
    """How many parts it has brought to the pick station since it was switched on."""


class Belt(Protocol):
    """A conveyor with one pick station. Every method raises ``CellFault`` on trouble."""

    async def connect(self) -> BeltIdentity:
        """Open the port and check who answers; safe to repeat.

        Raises:
            CellFault: ``belt_lost`` or ``belt_mismatch``.
        """
        ...

    async def state(self) -> BeltState:
        """Ask the board; connects first where the link was lost.

        Raises:
            CellFault: ``belt_lost`` or ``belt_mismatch``.
        """
        ...

    async def present(self) -> None:
        """Bring the next part to the pick station and return when it lies there; returns at once
        when one already does. A lost reply never advances the belt twice. Cancelling it stops
        the belt.

        Raises:
            CellFault: ``belt_empty`` when nothing came, ``belt_jam`` when the belt did not move,
                ``belt_lost`` or ``belt_mismatch``.
        """
        ...

    async def make_room(self) -> None:
        """Move everything on the belt one pitch backward and return when there is room for a part
        at the pick station. Cancelling it stops the belt.

        Raises:
            CellFault: ``belt_jam`` when the belt did not move or a part is still at the station,
                ``belt_lost`` or ``belt_mismatch``.
        """
        ...

    async def halt(self) -> None:
        """Stop the belt where it is; whatever it does for somebody raises ``CancelledError``.

        Raises:
            CellFault: ``belt_lost`` or ``belt_mismatch``.
        """
        ...

    async def close(self) -> None:
        """Let go of the port."""
        ...
