"""``RemoteArm``: the robot arm, held by a child process that may be killed at any time.

ur_rtde can crash, hang or hold the interpreter when a connection drops, so it never runs in the
daemon. The child (``arm_worker``) is started fresh for every connection, told what to do over a
socket pair, and killed whenever there is any doubt about it; nothing in it is ever repaired. If it
dies in mid-move, the robot's own watchdog stops the arm.
"""

from __future__ import annotations

import asyncio
import math
from pathlib import Path as FilePath

import structlog

from cellctl.assembling.arm import ArmCheck, ArmIdentity, ArmState, Path, Switch
from cellctl.assembling.arm_check import refuse_mismatch
from cellctl.assembling.arm_child import ArmChild, ChildLostError, StoppedError
from cellctl.assembling.arm_messages import (
    Close,
    Connect,
    Done,
    Follow,
    MoveJoints,
    Prepare,
    SetOutput,
    Stop,
    Verify,
    WaitInput,
)
from cellctl.assembling.chosen_speed import ChosenSpeed
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import Kinematics
from cellctl.config import CellConfig, Joints
from cellctl.errors import CellFault

_RECOVER_TIMEOUT_S = 60.0
"""For unlocking (5 s), power and brakes (some seconds each), and connecting (wall time)."""
_STOP_TIMEOUT_S = 8.0
_KINEMATIC_TOLERANCE_M = 0.012
"""A calibrated arm differs from the nominal one by 1 to 2 mm, a UR10 from a UR10e by 30 mm."""

_log = structlog.get_logger(__name__)


class RemoteArm:
    """The ``Arm`` of a cell, real or emulated.

    Args:
        config: the cell.
        speed_file: where the speed that somebody chose on the pendant is kept; None forgets it with
            this object.
    """

    def __init__(self, config: CellConfig, speed_file: FilePath | None = None) -> None:
        self._config = config
        self._frames = Frames(config)
        self._kinematics = Kinematics(config.robot.model)
        self._child: ArmChild | None = None
        self._identity: ArmIdentity | None = None
        self._checked: ArmCheck | None = None
        self._ordered: dict[int, bool] = {}
        """The level that each output was last ordered to have; arm processes come and go."""
        self._loss: CellFault | None = None
        self._chosen_speed = ChosenSpeed(speed_file)
        self._changing = asyncio.Lock()
        """Held while one arm process takes the place of another."""

    @property
    def process_id(self) -> int | None:
        """Of the arm process, while there is one."""
        return self._child.pid if self._child is not None and self._child.alive else None

    @property
    def identity(self) -> ArmIdentity | None:
        return self._identity

    @property
    def checked(self) -> ArmCheck | None:
        return self._checked

    async def connect(self) -> ArmIdentity:
        state = self.state()
        if self._identity is not None and state is not None and state.program_running:
            return self._identity
        return await self._open(recover=False)

    async def verify(self) -> ArmCheck:
        state = self.state()
        if state is not None and state.moving:
            raise CellFault("internal", "The robot's settings are checked at rest only.")
        check = (await self._ask(Verify(number=0))).check
        assert check is not None, "an answered check has been made"
        self._checked = check
        refuse_mismatch(check, self._config, self._identity, self._ordered)
        return check

    def state(self) -> ArmState | None:
        return self._child.state if self._child is not None else None

    async def follow(
        self, path: Path, planned_duration_s: float, switch: Switch | None = None
    ) -> None:
        if not path:
            return
        if switch is not None:
            self._ordered.pop(switch.line, None)
        await self._move(
            Follow(number=0, path=path, planned_duration_s=planned_duration_s, switch=switch)
        )
        if switch is not None:
            self._ordered[switch.line] = switch.high

    async def prepare(self, path: Path) -> None:
        if path:
            await self._move(Prepare(number=0, path=path))

    async def move_joints(self, target_rad: Joints, speed_rad_s: float) -> None:
        await self._move(MoveJoints(number=0, target_rad=target_rad, speed_rad_s=speed_rad_s))

    async def stop(self) -> None:
        # Without an arm process nothing moves: the robot's watchdog has seen to that.
        if self._child is not None and self._child.alive:
            await self._ask(Stop(number=0))

    async def set_output(self, line: int, high: bool) -> None:
        # Whoever stops waiting cannot know the level: it may be set all the same.
        self._ordered.pop(line, None)
        await self._ask(SetOutput(number=0, line=line, high=high))
        self._ordered[line] = high

    async def wait_input(self, line: int, high: bool, timeout_s: float) -> bool:
        order = WaitInput(number=0, line=line, high=high, timeout_s=timeout_s)
        return (await self._ask(order)).level_seen

    async def recover(self) -> None:
        await self._open(recover=True)

    async def close(self) -> None:
        async with self._changing:
            child = self._child
            if child is not None and child.alive:
                try:
                    async with asyncio.timeout(_STOP_TIMEOUT_S):
                        await child.ask(Close(number=0))
                except (ChildLostError, CellFault, TimeoutError) as error:
                    _log.warning("arm_close_failed", error=str(error))
            await self._drop()

    async def _move(self, order: Prepare | Follow | MoveJoints) -> None:
        try:
            await self._ask(order)
        except StoppedError:
            raise asyncio.CancelledError("The arm was stopped.") from None
        except asyncio.CancelledError:
            # Nobody waits for this movement any more, so it must not go on.
            await self.stop()
            raise

    async def _ask(
        self, order: Prepare | Follow | MoveJoints | Stop | SetOutput | WaitInput | Verify
    ) -> Done:
        child = self._child
        if child is None:
            raise CellFault("robot_lost", "The robot is not connected.")
        try:
            return await child.ask(order)
        except ChildLostError as error:
            raise await self._explain_loss(child, error) from error

    async def _open(self, *, recover: bool) -> ArmIdentity:
        """Start a new arm process and let it connect.

        Raises:
            CellFault: whatever keeps the robot from working.
        """
        async with self._changing:
            await self._drop()
            timeout_s = self._config.robot.connect_timeout_s
            timeout_s += _RECOVER_TIMEOUT_S if recover else 0.0
            child = await self._start()
            try:
                identity = await self._connected(child, timeout_s, recover=recover)
                self._check_kinematics(child)
            except BaseException:
                await child.kill()
                raise
            child.watch()
            self._child, self._identity = child, identity
            return identity

    async def _start(self) -> ArmChild:
        heartbeat_s = self._config.robot.host_silence_s / 5.0
        return await ArmChild.start(heartbeat_s, self._chosen_speed.choose)

    async def _connected(
        self, child: ArmChild, timeout_s: float, *, recover: bool = False, inspect: bool = False
    ) -> ArmIdentity:
        tool = self._config.tool
        order = Connect(
            number=0,
            robot=self._config.robot,
            tcp=tool.frame,
            payload_kg=tool.payload_kg,
            payload_cog_m=tool.payload_cog_m,
            speed_fraction=self._chosen_speed.fraction,
            recover=recover,
            inspect=inspect,
        )
        try:
            async with asyncio.timeout(timeout_s):
                identity = (await child.ask(order)).identity
        except TimeoutError as error:
            raise CellFault(
                "robot_lost", f"It did not connect within {timeout_s:.0f} s."
            ) from error
        except ChildLostError as error:
            raise CellFault("robot_lost", f"The arm process was lost: {error}") from error
        assert identity is not None, "every connection has an identity"
        return identity

    def _check_kinematics(self, child: ArmChild) -> None:
        """The pose that the controller reports must be the one that its joints mean here."""
        state = child.state
        assert state is not None, "a connection begins with a state"
        tcp = self._frames.tcp(self._kinematics.forward(state.joints_rad))
        apart_m = math.dist(tcp[:3, 3], state.tcp_pose[:3])
        if apart_m > _KINEMATIC_TOLERANCE_M:
            raise CellFault(
                "robot_mismatch",
                f"The TCP is {apart_m * 1e3:.0f} mm from where a {self._config.robot.model} with "
                "this joint position has it.",
            )

    async def _explain_loss(self, child: ArmChild, error: ChildLostError) -> CellFault:
        """Bury a lost arm process, and let a new one find out what the robot says."""
        async with self._changing:
            if self._child is child:
                _log.error("arm_process_lost", reason=str(error))
                await self._drop()
                self._loss = await self._inspect(str(error))
            loss = self._loss or CellFault("robot_lost", str(error))
            return CellFault(loss.code, loss.detail)

    async def _inspect(self, how: str) -> CellFault:
        """End what the robot still runs, which a killed arm process cannot do any more, and see
        why it stands still."""
        child = await self._start()
        try:
            await self._connected(child, self._config.robot.connect_timeout_s, inspect=True)
        except CellFault as fault:
            return fault
        finally:
            await child.kill()
        return CellFault("program_stopped", f"The arm process was lost: {how}")

    async def _drop(self) -> None:
        child, self._child, self._identity = self._child, None, None
        if child is not None:
            await child.kill()
