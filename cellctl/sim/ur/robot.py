"""The robot behind the network: its arm, its safety system, and the program it runs."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import IntEnum

from cellctl.sim.plant import Plant
from cellctl.sim.ur.arm import Arm
from cellctl.sim.ur.lines import Lines
from cellctl.sim.ur.machine import ProgramError
from cellctl.sim.ur.options import (
    FOLLOWING_S,
    FORCE_NOISE_N,
    GIVING_M_N,
    PLACE_NOISE_M,
    Six,
    UrOptions,
    Vector,
)
from cellctl.sim.ur.program import ControlProgram
from cellctl.sim.ur.registers import Registers, input_register
from cellctl.sim.ur.rtde import InputValue
from cellctl.sim.ur.safety import RobotMode, Safety
from cellctl.sim.ur.script import ScriptError, parse_script
from cellctl.sim.ur.trajectory import MotionError
from cellctl.sim.ur.watchdog import Watchdog

_LONGEST_STEP_S = 0.008
_HISTORY_CYCLES = 500


class Runtime(IntEnum):
    """RTDE's ``runtime_state``."""

    STOPPED = 1
    PLAYING = 2
    PAUSING = 3
    PAUSED = 4


@dataclass
class Counters:
    """What has happened to programs since the start."""

    uploads: int = 0
    uploads_refused: int = 0
    program_errors: int = 0
    protective_stops: int = 0
    last_error: str = ""
    last_program_end: str = ""


class Robot:
    """Everything of the controller except its sockets.

    It is what a program sees (``machine.Machine``) and what somebody at the teach pendant or on the
    dashboard can do (``dashboard.Pendant``).

    Args:
        options: what it is.
        plant: the physical cell that the arm and the digital lines belong to.
        wall_clock: monotonic wall time in seconds, for the watchdog.
    """

    def __init__(self, options: UrOptions, plant: Plant, wall_clock: Callable[[], float]) -> None:
        self.options = options
        self.registers = Registers()
        self.arm = Arm(options)
        self.watchdog = Watchdog(options.watchdog_stall_s, wall_clock)
        self.watched_register = 0
        self.joint_history: deque[Six] = deque([options.initial_joints_rad], _HISTORY_CYCLES)
        self.safety = Safety(options)
        self.lines = Lines(plant)
        self.remote = True
        self.counters = Counters()
        self.runtime = Runtime.STOPPED
        self.time_s = 0.0
        self.registers.tool_output_voltage = options.tool_voltage_v
        self.program_name = ""
        self._plant = plant
        self._noise = random.Random(1)  # noqa: S311 - repeatable chance
        self._noise_n = FORCE_NOISE_N[options.model]
        self._program: ControlProgram | None = None
        self._powering_down = False
        self._force_n = 0.0
        """At the TCP, when the arm moved last."""
        self.show()

    # The passing of time

    def advance(self, duration_s: float) -> None:
        """Let cell time pass, in steps of at most 8 ms."""
        self.lines.exchange()
        steps = max(1, math.ceil(duration_s / _LONGEST_STEP_S - 1e-9))
        for _ in range(steps):
            self._step(duration_s / steps)
        self.show()

    def _step(self, duration_s: float) -> None:
        self.time_s += duration_s
        self.safety.advance(duration_s)
        if self._program is not None and self.runtime is Runtime.PLAYING:
            self._cycle(self._program)
        try:
            self.arm.advance(duration_s)
        except MotionError as error:
            self.arm.abandon("protective stop", self.options.protective_stop_rad_s2)
            self.trip_protective(str(error))
        self.joint_history.append(self.arm.joints_rad)
        if (commanded := self.arm.commanded) is not None:
            self._plant.commanded(*commanded)
        self._plant.robot_moved(self.arm.flange, self.arm.joints_array, duration_s)
        if self.arm.moving:
            self._feel()
        if not self.arm.moving:
            self._at_rest()

    def _feel(self) -> None:
        """Stop an arm that runs into something; one that leaves it may go."""
        x_n, y_n, z_n = self._plant.tcp_force_n().tolist()
        before_n, self._force_n = self._force_n, math.hypot(x_n, y_n, z_n)
        limit_n = self.options.tcp_force_limit_n
        if self._force_n > max(limit_n, before_n) and not self.safety.protective:
            self.trip_protective(f"a force of {self._force_n:.0f} N at the TCP")

    def _cycle(self, program: ControlProgram) -> None:
        try:
            if not program.cycle():
                self.end_program("ended by itself")
        except ProgramError as error:
            self.counters.program_errors += 1
            self.counters.last_error = str(error)
            self.end_program("runtime error")

    def _at_rest(self) -> None:
        if self.runtime is Runtime.PAUSING:
            self.runtime = Runtime.PAUSED
        if (self.safety.emergency or self._powering_down) and (
            self.safety.robot_mode is not RobotMode.POWER_OFF
        ):
            self._powering_down = False
            self.safety.power_off()

    # Programs

    def upload(self, text: str) -> None:
        """A program has been sent. It takes the place of the one that runs."""
        self.counters.uploads += 1
        if not self.remote:
            self.counters.uploads_refused += 1
            return
        was_paused = self.runtime in (Runtime.PAUSED, Runtime.PAUSING)
        self.end_program("replaced by an upload")
        if (was_paused and self.options.paused_upload == "stop") or not self.safety.may_move:
            self.counters.uploads_refused += 1
            return
        try:
            script = parse_script(text)
        except ScriptError as error:
            self.counters.program_errors += 1
            self.counters.last_error = str(error)
            return
        self.watched_register = script.int_offset
        self.program_name = script.name
        self._program = ControlProgram(script, self)
        self.runtime = Runtime.PLAYING
        self.arm.release()

    def end_program(self, cause: str) -> None:
        """Stop the program if there is one: the arm brakes, the watchdog is dropped."""
        if self._program is None:
            return
        self._program = None
        self.runtime = Runtime.STOPPED
        self.counters.last_program_end = cause
        self.watchdog.disarm()
        self.arm.brake(cause, self.options.program_stop_rad_s2)

    def _pause(self, cause: str, deceleration_rad_s2: float) -> None:
        self.arm.hold(cause, deceleration_rad_s2)
        if self.runtime is Runtime.PLAYING:
            self.runtime = Runtime.PAUSING

    def _unhold(self) -> None:
        """Let the arm go when neither the safety system nor a paused program holds it."""
        if self.safety.may_move and self.runtime in (Runtime.STOPPED, Runtime.PLAYING):
            self.arm.release()

    # What the client writes

    def write_inputs(self, values: Mapping[str, InputValue]) -> None:
        """Take the variables of one RTDE package."""
        for name, value in values.items():
            register = input_register(name)
            if register is None or isinstance(value, tuple):
                continue
            kind, index = register
            if kind == "double":
                self.registers.input_double[index] = value
            else:
                self.registers.input_int[index] = int(value)
                if index == self.watched_register:
                    self.watchdog.written()
        self.lines.write(values)
        fraction = values.get("speed_slider_fraction")
        if values.get("speed_slider_mask") and isinstance(fraction, float):
            self.arm.slider = min(1.0, max(0.0, fraction))

    def watchdog_tripped(self) -> None:
        """The client has been silent for too long."""
        self.watchdog.trip()
        self.end_program("watchdog")

    # Machine: what a program can do

    def trip_protective(self, cause: str) -> None:
        """Make a protective stop; one that is active only starts its waiting time anew."""
        if not self.safety.protective:
            self.counters.protective_stops += 1
            self.counters.last_error = cause
        self.safety.trip_protective(cause)
        if self.options.protective_stop_program == "stop":
            self.end_program("protective stop")
        self._pause("protective stop", self.options.protective_stop_rad_s2)

    def set_payload(self, mass_kg: float, cog_m: Vector, inertia: Six | None = None) -> None:
        """Take another payload; without ``inertia`` (kg m2) the present one stays."""
        self.registers.payload = mass_kg
        self.registers.payload_cog = cog_m
        if inertia is not None:
            self.registers.payload_inertia = inertia

    # Pendant: what a person can do, on the dashboard too

    @property
    def program_state(self) -> str:
        """STOPPED, PLAYING or PAUSED."""
        paused = self.runtime in (Runtime.PAUSING, Runtime.PAUSED)
        return "PAUSED" if paused else self.runtime.name

    def robot_mode_name(self) -> str:
        """As the dashboard spells it."""
        return self.safety.robot_mode.name

    def safety_name(self) -> str:
        """As the dashboard spells it."""
        return self.safety.mode.name

    def play(self) -> bool:
        """Go on with a paused program; False if there is none or the arm may not move."""
        if self.runtime is not Runtime.PAUSED or not self.safety.may_move:
            return False
        self.runtime = Runtime.PLAYING
        self.arm.release()
        return True

    def pause(self) -> bool:
        """Pause the running program; False if none runs."""
        if self.runtime is not Runtime.PLAYING:
            return False
        self._pause("pause", self.options.pause_rad_s2)
        return True

    def stop_program(self) -> bool:
        """Stop the program; False if none was running or paused."""
        if self._program is None:
            return False
        self.end_program("stopped on the dashboard")
        return True

    def power_on(self) -> bool:
        """Power the arm; False if an emergency stop is pressed."""
        return self.safety.power_on()

    def power_off(self) -> None:
        """Stop, and take the power off the arm when it is at rest."""
        self.end_program("power off")
        self._powering_down = True

    def lose_power(self) -> None:
        """The controller's supply fails for a moment: brakes fall in, outputs are low, and after
        its start the arm is off."""
        self.end_program("power lost")
        self.arm.brake("power lost", self.options.emergency_stop_rad_s2)
        self.safety.power_off()
        self.lines.outputs = 0

    def release_brakes(self) -> bool:
        """Release the brakes; False if an emergency stop is pressed."""
        return self.safety.release_brakes()

    def unlock(self) -> bool:
        """Unlock a protective stop; False if it is too early."""
        unlocked = self.safety.unlock()
        self._unhold()
        return unlocked

    def close_popup(self) -> None:
        """Close the safety popup."""
        self.safety.popup = ""

    def set_safeguard(self, active: bool) -> None:
        """Open or close the safeguard's circuit."""
        self.safety.safeguard = active
        if active:
            self._pause("safeguard stop", self.options.safeguard_stop_rad_s2)
            return
        self._unhold()
        if self.options.safeguard_release == "resume":
            self.play()

    def set_emergency(self, pressed: bool) -> None:
        """Press or release the emergency stop button."""
        if not pressed:
            self.safety.release_emergency()
            return
        self.safety.press_emergency()
        self.end_program("emergency stop")
        self.arm.brake("emergency stop", self.options.emergency_stop_rad_s2)

    def set_remote(self, remote: bool) -> None:
        """Switch the pendant to remote or to local control."""
        self.remote = remote
        if not remote and self.options.local_control_stops_program:
            self.end_program("local control")

    # What RTDE shows

    def show(self) -> None:
        """Bring the registers that RTDE streams up to date."""
        registers, arm = self.registers, self.arm
        self.safety.show(registers)
        registers.timestamp = self.time_s
        registers.actual_q = registers.target_q = arm.joints_rad
        registers.actual_qd = registers.target_qd = arm.velocity_rad_s
        registers.target_qdd = arm.acceleration_rad_s2
        registers.actual_TCP_speed = registers.target_TCP_speed = arm.tcp_twist
        outside_n = self._plant.tcp_force_n().tolist()
        self._show_place(outside_n)
        x_n, y_n, z_n = (force_n + self._noise.gauss(0.0, self._noise_n) for force_n in outside_n)
        registers.actual_TCP_force = (x_n, y_n, z_n, 0.0, 0.0, 0.0)
        registers.tcp_force_scalar = math.hypot(x_n, y_n, z_n)
        registers.tcp_offset = arm.tcp_offset
        registers.speed_scaling = arm.rate
        registers.target_speed_fraction = arm.slider
        registers.actual_momentum = registers.payload * arm.tcp_speed_m_s
        registers.actual_digital_input_bits = self.lines.inputs
        registers.actual_digital_output_bits = self.lines.outputs
        registers.runtime_state = self.runtime
        powered = self.safety.robot_mode is not RobotMode.POWER_OFF
        playing = self.runtime is Runtime.PLAYING
        registers.robot_status_bits = int(powered) | int(playing) << 1 | 1 << 3

    def _show_place(self, outside_n: Sequence[float]) -> None:
        """Where the TCP is wanted and where it is: behind while it moves, and pushed off by what it
        meets."""
        options, arm = self.options, self.arm
        giving, behind_s = GIVING_M_N[options.model], FOLLOWING_S[options.model]
        x, y, z, *turn = arm.tcp_pose
        ahead = [at + speed * behind_s for at, speed in zip((x, y, z), arm.tcp_twist, strict=False)]
        # No arm is pushed farther: its controller stops it.
        most_m = giving * options.tcp_force_limit_n
        noise_m = PLACE_NOISE_M[options.model]
        at = [
            here
            + max(-most_m, min(most_m, giving * force_n))
            + (self._noise.gauss(0.0, noise_m) if noise_m > 0.0 else 0.0)
            for here, force_n in zip((x, y, z), outside_n, strict=True)
        ]
        self.registers.target_TCP_pose = _pose(ahead, turn)
        self.registers.actual_TCP_pose = _pose(at, turn)

    def truth(self) -> dict[str, object]:
        """Everything a test may want to know, as plain values; SI units, cell time."""
        arm, watchdog = self.arm, self.watchdog
        return {
            "time_s": self.time_s,
            "joints_rad": list(arm.joints_rad),
            "joint_speeds_rad_s": list(arm.velocity_rad_s),
            "tcp_pose": list(arm.tcp_pose),
            "tcp_speed_m_s": arm.tcp_speed_m_s,
            "tcp_offset": list(arm.tcp_offset),
            "moving": arm.moving,
            "payload_kg": self.registers.payload,
            "payload_cog_m": list(self.registers.payload_cog),
            "tool_voltage_v": self.registers.tool_output_voltage,
            "robot_mode": self.safety.robot_mode.name,
            "safety_mode": self.safety.mode.name,
            "safety_popup": self.safety.popup,
            "remote": self.remote,
            "program": self.program_state,
            "program_name": self.program_name,
            "speed_slider": arm.slider,
            "speed_scaling": arm.rate,
            "outputs": self.lines.outputs,
            "inputs": self.lines.inputs,
            "blend_overlaps": arm.planner.overlaps,
            "braking": None if arm.braking is None else asdict(arm.braking),
            "watchdog": {
                "armed": watchdog.window_s is not None,
                "window_s": watchdog.window_s,
                "silence_s": watchdog.silence_s,
                "trips": watchdog.trips,
                "last_trip_silence_s": watchdog.last_trip_silence_s,
                "last_trip_wall_s": watchdog.last_trip_wall_s,
            },
            "counters": asdict(self.counters),
        }


def _pose(at: Sequence[float], turn: Sequence[float]) -> Six:
    (x, y, z), (rx, ry, rz) = at, turn
    return (x, y, z, rx, ry, rz)
