"""The hardware of one cell, as what is done to all of it at once."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

import structlog

from cellctl.assembling.arm import Arm
from cellctl.control.gripper_watch import GripperWatch
from cellctl.control.moving import ArmAndLatch
from cellctl.errors import CellFault
from cellctl.feeding.service import BeltService
from cellctl.listening.hearing import Hearing
from cellctl.worker import WorkerProcess

log = structlog.get_logger(__name__)

_PATIENCE_S = 30.0
"""Longest time for which one device may keep a stop waiting (wall time)."""


@dataclass(frozen=True)
class Devices:
    """The hardware, the stages' services, and the people's ears."""

    arm: Arm
    hands: ArmAndLatch
    belt: BeltService
    gripper_board: GripperWatch
    hearing: Hearing
    designer: WorkerProcess

    async def connect(self) -> None:
        """Connect with the robot and the belt at the same time, then see who is on the gripper's
        port; safe to repeat.

        Raises:
            CellFault: of any of them.
        """
        identity, belt = await asyncio.gather(
            self.arm.connect(), self.belt.connect(), return_exceptions=True
        )
        for result in (identity, belt):
            if isinstance(result, BaseException):
                raise result
        await self.gripper_board.verify()
        log.info("robot connected", identity=str(identity))

    async def verify(self) -> None:
        """Read back that the robot and the belt are what the plan is for.

        Raises:
            CellFault: ``robot_mismatch``, ``belt_mismatch``, ``gripper_mismatch`` or of a device
                that does not answer.
        """
        check = await self.arm.verify()
        await self.belt.connect()
        await self.gripper_board.verify()
        log.info("checked before motion", check=str(check))

    async def halt(self) -> None:
        """Stop arm and belt, both even if one of them fails.

        Raises:
            CellFault: the arm or the belt could not be told to stop.
        """
        try:
            async with asyncio.timeout(_PATIENCE_S):
                results = await asyncio.gather(
                    self.arm.stop(), self.belt.halt(), return_exceptions=True
                )
        except TimeoutError:
            raise CellFault("robot_lost", "It does not confirm that it stopped.") from None
        for result in results:
            if isinstance(result, BaseException):
                raise result

    async def recover(self) -> None:
        """Leave a stop of the robot's own, and take up the belt again; moves nothing.

        Raises:
            CellFault: the cause is still there.
        """
        await self.arm.recover()
        await self.hands.adopt_line()
        await self.belt.recover()
        await self.gripper_board.verify()
