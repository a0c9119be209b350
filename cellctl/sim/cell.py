"""The whole emulated cell in one process: world, robot, gripper and conveyor on one clock."""

from __future__ import annotations

import difflib
from typing import Any

import numpy as np
import structlog

from cellctl.assembly import Cell
from cellctl.boards.constants import ResetCause
from cellctl.config import CellConfig
from cellctl.errors import UsageError
from cellctl.sim.as_built import as_built
from cellctl.sim.boards import Board, GripperBoard, make_boards
from cellctl.sim.faults import FAULTS, Device, Fault
from cellctl.sim.latch import LatchFault
from cellctl.sim.messages import Argument, CellTruth
from cellctl.sim.ur.controller import UrController
from cellctl.sim.ur.options import UrOptions
from cellctl.sim.wiring import CellPlant
from cellctl.sim.world import World
from cellctl.sim.world_geometry import inverse, pose_matrix, rotation
from cellctl.sim.world_values import Imperfections, Violation

log = structlog.get_logger(__name__)

Arguments = dict[str, Argument]
_BOARDS = (Device.CONVEYOR, Device.GRIPPER_BOARD)


class EmulatedCell:
    """Owns the emulators; ``start`` it, ``advance`` it in small steps of cell time, ``stop`` it.

    Args:
        config: an emulated cell; ``cell.clock_rate`` is the speed-up.
        imperfections: how far the belt and its parts are from perfect.

    Raises:
        UsageError: the configuration is of a real cell, or asks for compiled boards that are not
            there or cannot run as fast.
    """

    def __init__(self, config: CellConfig, imperfections: Imperfections | None = None) -> None:
        if config.emulation is None:
            raise UsageError(
                f"The cell {config.cell.name!r} is a real one and cannot be emulated.",
                'Name a configuration with cell.kind = "emulated".',
            )
        self.config = config
        self.seed = config.emulation.seed
        built = as_built(config)
        self.world = World(built, self.seed, imperfections, _log_violation)
        self.latch, self.gripper_board, self.conveyor = make_boards(self.world, config)
        self._plant = CellPlant(self.world, self.latch, config.gripper)
        self.robot = UrController(
            UrOptions(
                model=config.robot.model,
                host=config.robot.host,
                controller_version=config.emulation.controller_version,
                clock_rate=config.cell.clock_rate,
                initial_joints_rad=config.robot.home_rad,
                tool_voltage_v=config.tool.voltage_v,
            ),
            self._plant,
        )
        self._faults: list[str] = []

    async def start(self) -> None:
        """Open the robot's ports and the boards' pseudo-terminals.

        Raises:
            OSError: one of the robot's ports is taken.
            UsageError: a board's port is taken.
        """
        await self.robot.start()
        try:
            for board in self._boards():
                board.start()
        except BaseException:
            await self.stop()
            raise

    async def stop(self) -> None:
        """Close everything; safe to repeat."""
        for board in self._boards():
            board.stop()
        await self.robot.stop()

    def advance(self, dt_s: float) -> None:
        """Let cell time pass."""
        self.world.advance(dt_s)
        self.robot.advance(dt_s)
        self._plant.advance(dt_s)
        self.latch.advance(dt_s)
        for board in self._boards():
            board.advance(dt_s)

    def inject(self, name: str, arguments: Arguments) -> None:
        """Make a fault of the table happen.

        Raises:
            UsageError: no such fault, or not with these arguments.
        """
        fault, values = _checked(name, arguments)
        match fault.device:
            case Device.ROBOT if fault.effect == "guide":
                self._guide(values)
            case Device.ROBOT:
                self.robot.inject(fault.effect, **values)
            case Device.CONVEYOR:
                self.conveyor.inject(fault.effect, **values)
            case Device.GRIPPER:
                self._inject_gripper(fault, values)
            case Device.GRIPPER_BOARD:
                self._talking_gripper().inject(fault.effect, **values)
            case Device.WORLD:
                self._inject_world(fault, values)
        label = _label(fault, values)
        lasting = not fault.once and fault.device not in _BOARDS
        if lasting and label not in self._faults:
            self._faults.append(label)
        log.info("fault injected", fault=name, **arguments)

    def clear(self, name: str, arguments: Arguments) -> None:
        """Mend what a fault broke; nothing happens where nothing is broken.

        Raises:
            UsageError: no such fault, or it is over by itself.
        """
        fault, values = _checked(name, arguments)
        if fault.once:
            raise UsageError(f"{name} happens once: there is nothing to clear.", fault.remedy)
        match fault.device:
            case Device.ROBOT:
                self.robot.clear(fault.effect, **values)
            case Device.CONVEYOR:
                self.conveyor.clear(fault.effect)
            case Device.GRIPPER:
                self.latch.clear(LatchFault(fault.effect))
            case Device.GRIPPER_BOARD:
                self._talking_gripper().clear(fault.effect)
            case Device.WORLD if fault.effect == "stick_to_gripper":
                self.world.free_parts()
            case Device.WORLD if fault.effect == "raise":
                self.world.raised_m.pop(_cell(values), None)
            case Device.WORLD:
                self.world.straighten_parts()
        label = _label(fault, values)
        if label in self._faults:
            self._faults.remove(label)
        log.info("fault cleared", fault=name, **arguments)

    def truth(self, lost_s: float) -> CellTruth:
        """All that is the case; ``lost_s`` is the clock's."""
        world = self.world
        return CellTruth(
            cell_time_s=world.time_s,
            lost_s=lost_s,
            seed=self.seed,
            parts=world.parts(),
            counts=world.counts(),
            built=tuple(sorted(world.built, key=lambda cell: (cell.z, cell.x, cell.y))),
            violations=tuple(world.violations),
            imperfections=world.imperfections,
            faults=self._active_faults(),
            robot=self.robot.truth(),
            conveyor=self.conveyor.truth().model_dump(mode="json"),
            latch=self.latch.truth(),
            gripper_board=self.gripper_board.truth() if self.gripper_board is not None else {},
        )

    def _boards(self) -> tuple[Board, ...]:
        boards = (self.conveyor, self.gripper_board)
        return tuple(board for board in boards if board is not None)

    def _talking_gripper(self) -> GripperBoard:
        if self.gripper_board is None:
            raise UsageError(
                "The gripper's board has no serial port in this cell.", "Set gripper.port."
            )
        return self.gripper_board

    def _active_faults(self) -> tuple[str, ...]:
        # Some of the boards' faults end by themselves: they know best which are left.
        left = {(Device.CONVEYOR, name) for name in self.conveyor.truth().faults}
        if self.gripper_board is not None:
            left |= {(Device.GRIPPER_BOARD, name) for name in self.gripper_board.fault_names()}
        on_boards = [
            fault.name for fault in FAULTS.values() if (fault.device, fault.effect) in left
        ]
        return (*self._faults, *on_boards)

    def _inject_gripper(self, fault: Fault, values: dict[str, Any]) -> None:
        if fault.effect == "glitch":
            self._plant.glitch(values["duration_s"])
        elif fault.effect != "reboot":
            self.latch.inject(LatchFault(fault.effect))
        elif self.gripper_board is not None:
            self.gripper_board.reset(ResetCause.POWER)
        else:
            self.latch.reboot()

    def _guide(self, values: dict[str, Any]) -> None:
        """Somebody guides the arm until the tip of a pin is at a point of the cell frame."""
        built = self.world.config
        tip = np.eye(4)
        tilt = np.array([values["tilt_x_rad"], values["tilt_y_rad"], 0.0])
        tip[:3, :3] = rotation(tilt) @ np.diag([1.0, -1.0, -1.0])
        tip[:3, 3] = [values[name] for name in ("x_m", "y_m", "z_m")]
        pin = pose_matrix((0.0, 0.0, values["pin_m"], 0.0, 0.0, 0.0))
        tool = pose_matrix(built.tool.frame) @ pin
        self.world.lose_sight()
        self.robot.guide(inverse(pose_matrix(built.base.frame)) @ tip @ inverse(tool))

    def _inject_world(self, fault: Fault, values: dict[str, Any]) -> None:
        match fault.effect:
            case "empty":
                self.world.empty_belt()
            case "yaw":
                self.world.turn_next_part(values["yaw_rad"])
            case "stick":
                self.world.stick_next_part()
            case "remove":
                self.world.remove_next_part()
            case "drop":
                self.world.drop_held_part()
            case "stick_to_gripper":
                self.world.parts_stick = True
            case "take_placed":
                self.world.take_placed_part(_cell(values))
            case "put":
                self.world.put_part(_cell(values))
            case "raise":
                self.world.raise_part(_cell(values), values["height_m"])


def _checked(name: str, arguments: Arguments) -> tuple[Fault, dict[str, Any]]:
    fault = FAULTS.get(name)
    if fault is None:
        near = difflib.get_close_matches(name, FAULTS, n=3, cutoff=0.4) or sorted(FAULTS)
        raise UsageError(f"There is no fault {name!r}.", f"Try: {', '.join(near)}.")
    return fault, fault.complete(arguments)


def _cell(values: dict[str, Any]) -> Cell:
    return Cell(values["x"], values["y"], values["z"])


def _label(fault: Fault, values: dict[str, Any]) -> str:
    """What tells a fault from others of its name: the arguments that must be given."""
    telling = [f"{p.name}={values[p.name]}" for p in fault.parameters if p.required]
    return " ".join([fault.name, *telling])


def _log_violation(violation: Violation) -> None:
    log.warning("violation", **violation.model_dump(mode="json"))
