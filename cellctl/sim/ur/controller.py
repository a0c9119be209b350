"""The emulated controller: a robot, its three network services, and the faults to inject."""

from __future__ import annotations

import difflib
import time
from collections.abc import Callable
from dataclasses import asdict

from cellctl.errors import UsageError
from cellctl.sim.plant import Floats, Plant
from cellctl.sim.ur.dashboard import dashboard_server
from cellctl.sim.ur.lines import LINES, Wires
from cellctl.sim.ur.options import TOOL_VOLTAGES_V, UrOptions
from cellctl.sim.ur.robot import Robot, Runtime
from cellctl.sim.ur.rtde import RtdeService
from cellctl.sim.ur.script import script_server


class UrController:
    """One robot controller on one address.

    ``start`` opens its ports on the running event loop; from then on ``advance`` must be called
    for every tick. Nothing here blocks, and everything runs in the loop's thread.

    Args:
        options: what it is.
        plant: the physical cell that the arm and the digital lines belong to.
        wall_clock: monotonic wall time in seconds; what concerns the network runs by it.
    """

    def __init__(
        self,
        options: UrOptions,
        plant: Plant,
        wall_clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.options = options
        self.robot = Robot(options, plant, wall_clock)
        self._rtde = RtdeService(
            options.host,
            self.robot.registers,
            options.version,
            options.cycle_s,
            self.robot.write_inputs,
        )
        self._servers = (
            self._rtde.server,
            script_server(options.host, self.robot.upload),
            dashboard_server(options.host, self.robot),
        )
        self._wall_clock = wall_clock
        self._wall_s = wall_clock()
        self._pending_s = 0.0

    async def start(self) -> None:
        """Open the three ports.

        Raises:
            OSError: one of them cannot be listened on; none is left open.
        """
        try:
            for server in self._servers:
                server.open()
        except OSError:
            await self.stop()
            raise

    async def stop(self) -> None:
        """Close the ports and every connection."""
        for server in self._servers:
            server.close()

    def advance(self, dt_s: float) -> None:
        """Let cell time pass; call it for every tick of the process, about every 2 ms.

        The controller acts once a cycle of its own (2 or 8 ms of cell time); shorter ticks add up.
        The state stream and the watchdog run by the wall clock instead, so that a tick that makes
        up for lost time in one go neither floods the clients nor uses up their window.
        """
        self._pending_s += dt_s
        if self._pending_s + dt_s / 2.0 < self.options.cycle_s:
            return
        cell_s, self._pending_s = self._pending_s, 0.0
        wall_s = self._wall_clock()
        elapsed_s, self._wall_s = wall_s - self._wall_s, wall_s
        self._watch(elapsed_s)
        self.robot.advance(cell_s)
        self._rtde.stream(elapsed_s)

    def _watch(self, elapsed_s: float) -> None:
        robot = self.robot
        if not robot.watchdog.due(elapsed_s) or robot.runtime is not Runtime.PLAYING:
            return
        self._rtde.server.read_pending()
        if robot.watchdog.due(0.0):
            robot.watchdog_tripped()

    def inject(self, fault: str, **arguments: object) -> None:
        """Cause a fault; ``docs/emulated-controller.md`` lists them.

        Raises:
            UsageError: there is no such fault, or its arguments are wrong.
        """
        self._apply(fault, arguments, active=True)

    def clear(self, fault: str, **arguments: object) -> None:
        """End a fault that lasts.

        Raises:
            UsageError: there is no such fault, it cannot be cleared this way, or its arguments are
                wrong.
        """
        self._apply(fault, arguments, active=False)

    def truth(self) -> dict[str, object]:
        """The robot's state, program, stops and counters as plain values."""
        return {
            **self.robot.truth(),
            "rtde": asdict(self._rtde.traffic),
            "connections": {str(server.port): len(server.connections) for server in self._servers},
        }

    def _apply(self, fault: str, arguments: dict[str, object], *, active: bool) -> None:
        moments: dict[str, Callable[..., None]] = {
            "protective_stop": self._protective_stop,
            "drop_connections": self._drop_connections,
            "kill_program": self._kill_program,
            "power_lost": self._lose_power,
            "payload_changed": self._change_payload,
            "tcp_changed": self._change_tcp,
            "tool_voltage_changed": self._change_tool_voltage,
            "output_changed": self._change_output,
            "speed_slider": self._move_slider,
        }
        states: dict[str, Callable[..., None]] = {
            "safeguard_stop": self.robot.set_safeguard,
            "emergency_stop": self.robot.set_emergency,
            "reduced_mode": self._reduce,
            "local_control": lambda active: self.robot.set_remote(not active),
            "freeze": self._freeze,
            "refuse_connections": self._refuse,
            "stuck_output": self._stuck_output,
            "stuck_input": self._stuck_input,
            "flipped_output": self._flipped_output,
            "flipped_input": self._flipped_input,
        }
        try:
            if fault in states:
                states[fault](active, **arguments)
            elif fault in moments and active:
                moments[fault](**arguments)
            elif fault in moments:
                raise UsageError(f"{fault} passes by itself and cannot be cleared.")
            else:
                names = [*moments, *states]
                near = difflib.get_close_matches(fault, names, n=1) or names
                raise UsageError(f"There is no fault {fault!r}.", f"Try {', '.join(near)}.")
        except TypeError as error:
            raise UsageError(f"{fault}: wrong arguments {sorted(arguments)}: {error}.") from error

    def _protective_stop(self, cause: str = "injected") -> None:
        self.robot.trip_protective(cause)

    def _kill_program(self) -> None:
        self.robot.end_program("killed")

    def _lose_power(self) -> None:
        self.robot.lose_power()
        self._drop_connections(reset=True)

    def _drop_connections(self, *, reset: bool = False) -> None:
        for server in self._servers:
            server.drop(reset=reset)

    def _change_payload(self, payload_kg: float = 3.0) -> None:
        self.robot.set_payload(payload_kg, self.robot.registers.payload_cog)

    def _change_tcp(self, z_m: float = 0.2) -> None:
        self.robot.arm.set_tcp((0.0, 0.0, z_m, 0.0, 0.0, 0.0))

    def _change_tool_voltage(self, voltage_v: int = 24) -> None:
        if voltage_v not in TOOL_VOLTAGES_V:
            raise UsageError(f"The tool's connector has no {voltage_v} V; it has 0, 12 or 24 V.")
        self.robot.registers.tool_output_voltage = voltage_v

    def _change_output(self, line: int, high: bool = False) -> None:
        _check_line(line)
        self.robot.lines.switch(line, high)

    def guide(self, flange: Floats) -> None:
        """Somebody guides the arm by hand until its flange is there (4x4 in the base frame).

        Raises:
            UsageError: it is out of reach, or the arm is under way.
        """
        arm = self.robot.arm
        joints = arm.kinematics.joints(flange, arm.joints_rad)
        if joints is None or arm.moving:
            raise UsageError("The arm cannot be guided there now.")
        arm.jump(joints)

    def _move_slider(self, fraction: float = 0.02) -> None:
        if not 0.0 <= fraction <= 1.0:
            raise UsageError(f"The speed slider goes from 0 to 1, not to {fraction:g}.")
        self.robot.arm.slider = fraction

    def _reduce(self, active: bool) -> None:
        self.robot.safety.reduced = active

    def _freeze(self, active: bool) -> None:
        for server in self._servers:
            server.freeze(active)

    def _refuse(self, active: bool) -> None:
        for server in self._servers:
            if active:
                server.refuse()
            else:
                server.open()

    def _stuck_output(self, active: bool, line: int, high: bool = False) -> None:
        _stick(self.robot.lines.output_wires, active, line, high)

    def _stuck_input(self, active: bool, line: int, high: bool = False) -> None:
        _stick(self.robot.lines.input_wires, active, line, high)

    def _flipped_output(self, active: bool, line: int) -> None:
        _flip(self.robot.lines.output_wires, active, line)

    def _flipped_input(self, active: bool, line: int) -> None:
        _flip(self.robot.lines.input_wires, active, line)


def _stick(wires: Wires, active: bool, line: int, high: bool) -> None:
    _check_line(line)
    if active:
        wires.stuck[line] = high
    else:
        wires.stuck.pop(line, None)


def _flip(wires: Wires, active: bool, line: int) -> None:
    _check_line(line)
    if active:
        wires.flipped.add(line)
    else:
        wires.flipped.discard(line)


def _check_line(line: int) -> None:
    if not 0 <= line < LINES:
        raise UsageError(f"There is no line {line}; lines are 0 to {LINES - 1}.")
