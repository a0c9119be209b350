"""The control program that ``ur_rtde`` uploads, re-implemented: its main loop, threads and moves.

One step of the generators below is one cycle of the controller, as ``sync()`` is in URScript. The
program talks to its client through registers only: a command number in integer register 0, the
arguments behind it; the state (1 ready, 2 done) and results the other way.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from typing import Literal

from cellctl.sim.ur.kinematics import matrix_pose
from cellctl.sim.ur.machine import Machine, ProgramError, Window
from cellctl.sim.ur.motion import JointServo, JointSpeed, LineSpeed
from cellctl.sim.ur.options import Six
from cellctl.sim.ur.queries import QUERIES, solve
from cellctl.sim.ur.script import Script
from cellctl.sim.ur.trajectory import MotionError, Waypoint, runs

_STATE = 0
_PROGRESS = 2
_READY = 1
_DONE = 2
_STOP = 255
_REALTIME = frozenset({6, 9, 10, 11, 24, 25, 26, 27, 38, 58, 66, 67, 68, 69, 70, 71})
"""Commands that are carried out each cycle and that no client waits for."""

_RUNNING_BIT = 1 << 15
_SERVO_RAD_S2 = 40.0
"""Largest joint acceleration of a servo movement: what the client's own check allows."""

Steps = Generator[None, None, None]


class ControlProgram:
    """One run of the control program, from its upload to its end.

    Args:
        script: what was uploaded.
        machine: the controller that runs it.
    """

    def __init__(self, script: Script, machine: Machine) -> None:
        self.script = script
        self._machine = machine
        self._window = Window(machine.registers, script.int_offset, script.double_offset)
        self._progress_writes = 0
        self._operation_id = 0
        self._stops_lines = False
        """The program's one flag for how a stop brakes. It starts as "joints" and an asynchronous
        stop sets it to "line" for good: a synchronous ``stopL`` before that is a ``stopj``."""
        self._move: Steps | None = None
        self._stop: Steps | None = None
        self._speed: LineSpeed | JointSpeed | None = None
        self._servo: JointServo | None = None
        self._main = self._run()

    def cycle(self) -> bool:
        """One controller cycle.

        Returns:
            False when the program has ended.

        Raises:
            ProgramError: a runtime error has ended it.
        """
        self._move = _stepped(self._move)
        self._stop = _stepped(self._stop)
        return _stepped(self._main) is not None

    def _run(self) -> Steps:
        if not self.script.is_control:
            # Another program: it is not interpreted, and reports to be done as the client expects.
            self._window.put_integer(_STATE, _DONE)
            yield
            return
        self._signal_finished()
        self._window.put_integer(_STATE, _READY)
        executing = False
        while True:
            command = self._window.integer(0)
            if command in _REALTIME:
                yield from self._execute(command)
                self._window.put_integer(_STATE, _READY)
            elif command == 0:
                executing = False
                self._window.put_integer(_STATE, _READY)
            elif command == _STOP:
                return
            elif not executing:
                yield from self._execute(command)
                self._window.put_integer(_STATE, _DONE)
                executing = True
            yield

    def _execute(self, command: int) -> Steps:
        if query := QUERIES.get(command):
            query(self._machine, self._window)
        elif action := self._actions().get(command):
            yield from action()

    def _actions(self) -> dict[int, Callable[[], Steps]]:
        return {
            1: self._move_joints,
            2: self._move_joints_to_pose,
            3: self._move_line,
            4: self._move_line_to_joints,
            9: self._set_joint_speed,
            10: self._set_line_speed,
            11: self._set_servo_joints,
            15: self._stop_speed,
            16: self._stop_servo,
            24: self._set_servo_pose,
            33: self._stop_move,
            34: self._stop_move,
            45: self._move_path,
        }

    # Moves

    def _move_joints(self) -> Steps:
        yield from self._move_to("joint", self._window.six(0))

    def _move_joints_to_pose(self) -> Steps:
        yield from self._move_to("joint", solve(self._machine, self._window.six(0)))

    def _move_line(self) -> Steps:
        yield from self._move_to("line", self._window.six(0))

    def _move_line_to_joints(self) -> Steps:
        arm = self._machine.arm
        target = arm.kinematics.flange(self._window.six(0)) @ arm.tcp
        yield from self._move_to("line", matrix_pose(target))

    def _move_path(self) -> Steps:
        yield from self._start_move(self._path_steps())

    def _move_to(self, kind: Literal["line", "joint"], target: Six) -> Steps:
        waypoint = Waypoint(kind, target, self._window.number(6), self._window.number(7))
        yield from self._start_move(self._travel([waypoint], announce=False))

    def _start_move(self, steps: Steps) -> Steps:
        """Run a move here, or beside the main loop when the client asked for that."""
        self._refuse_if_speeding()
        self._kill_move()
        if self._window.integer(1) == 1:
            self._move = self._beside(steps)
            self._move = _stepped(self._move)
        else:
            yield from steps

    def _beside(self, steps: Steps) -> Steps:
        self._write_progress(0)
        yield from steps
        self._signal_finished()

    def _path_steps(self) -> Steps:
        near_rad = self._machine.arm.joints_rad
        waypoints = []
        for move in self.script.path:
            waypoint = move.waypoint
            if move.needs_inverse:
                near_rad = solve(self._machine, waypoint.target, near_rad)
                waypoint = replace(waypoint, target=near_rad)
            waypoints.append(waypoint)
        yield from self._travel(waypoints, announce=True)

    def _travel(self, waypoints: Sequence[Waypoint], *, announce: bool) -> Steps:
        """Move through waypoints; ``announce`` reports each one when it is set out for."""
        arm = self._machine.arm
        yield from self._come_to_rest()
        announced = -1
        for run in runs(waypoints):
            try:
                trajectory = arm.planner.plan(arm.joints_rad, arm.tcp, run)
            except MotionError as error:
                self._machine.trip_protective(str(error))
                yield
                return
            arm.start(trajectory)
            while True:
                reached = trajectory.waypoint.number
                while announce and announced < reached:
                    announced += 1
                    self._write_progress(announced)
                if not arm.follows(trajectory):
                    break
                yield

    def _come_to_rest(self) -> Steps:
        """What a new move finds under way is braked first: the arm starts from rest."""
        arm = self._machine.arm
        if arm.busy:
            arm.brake("replaced by another move", self._machine.options.program_stop_rad_s2)
            while arm.busy:
                yield

    def _kill_move(self) -> None:
        if self._move is not None:
            self._move.close()
            self._move = None
            self._signal_finished()

    # Stops

    def _stop_move(self) -> Steps:
        deceleration = self._window.number(0)
        if self._stop is not None:
            self._stop.close()
            self._stop = None
            self._signal_finished()
        else:
            self._kill_move()
        if self._window.integer(1) == 1:
            self._stops_lines = True
            self._stop = _stepped(self._stop_beside(deceleration))
        else:
            yield from self._brake(deceleration, line=self._stops_lines)

    def _stop_beside(self, deceleration: float) -> Steps:
        self._write_progress(0)
        yield from self._brake(deceleration, line=self._stops_lines)
        self._signal_finished()

    def _brake(self, deceleration: float, *, line: bool) -> Steps:
        if not deceleration > 0.0:
            raise ProgramError("a stop needs a deceleration greater than 0")
        arm = self._machine.arm
        if line:
            arm.stop_line(deceleration)
        else:
            arm.stop_joints(deceleration)
        while arm.busy:
            yield

    # Speeds and servo movements

    def _set_line_speed(self) -> Steps:
        arm = self._machine.arm
        if not isinstance(self._speed, LineSpeed) or not arm.follows(self._speed):
            self._speed = LineSpeed(arm.tcp_twist, arm.tcp, arm.kinematics)
            arm.start(self._speed)
        self._speed.target = self._window.six(0)
        self._speed.acceleration_m_s2 = self._window.number(6)
        yield from ()

    def _set_joint_speed(self) -> Steps:
        arm = self._machine.arm
        if not isinstance(self._speed, JointSpeed) or not arm.follows(self._speed):
            self._speed = JointSpeed(arm.velocity_rad_s)
            arm.start(self._speed)
        self._speed.target_rad_s = self._window.six(0)
        self._speed.acceleration_rad_s2 = self._window.number(6)
        yield from ()

    def _stop_speed(self) -> Steps:
        line = not isinstance(self._speed, JointSpeed)
        self._speed = None
        yield from self._brake(self._window.number(0), line=line)

    def _set_servo_joints(self) -> Steps:
        yield from self._servo_to(self._window.six(0))

    def _set_servo_pose(self) -> Steps:
        yield from self._servo_to(solve(self._machine, self._window.six(0)))

    def _servo_to(self, target_rad: Six) -> Steps:
        arm = self._machine.arm
        if self._servo is None or not arm.follows(self._servo):
            self._servo = JointServo(arm.velocity_rad_s, _SERVO_RAD_S2)
            arm.start(self._servo)
        self._servo.target_rad = target_rad
        self._servo.lookahead_s = max(self._window.number(9), self._machine.options.cycle_s)
        yield from ()

    def _stop_servo(self) -> Steps:
        self._servo = None
        yield from self._brake(self._window.number(0), line=True)

    def _refuse_if_speeding(self) -> None:
        holder = self._speed or self._servo
        if holder is not None and self._machine.arm.follows(holder):
            raise ProgramError("another thread is already controlling the robot")

    # Asynchronous progress

    def _signal_finished(self) -> None:
        self._write_progress(-1)

    def _write_progress(self, value: int) -> None:
        """Bits 0-14 progress, 15 running, 16-22 count of writes, 24-30 count of operations."""
        self._progress_writes = (self._progress_writes + 1) % 128
        if value == 0:
            self._operation_id = (self._operation_id + 1) % 128
        word = self._progress_writes << 16 | self._operation_id << 24
        if value >= 0:
            word |= min(value, _RUNNING_BIT - 1) | _RUNNING_BIT
        self._window.put_integer(_PROGRESS, word)


def _stepped(steps: Steps | None) -> Steps | None:
    """Run a thread for one cycle; None when it has ended."""
    if steps is None:
        return None
    try:
        next(steps)
    except StopIteration:
        return None
    return steps
