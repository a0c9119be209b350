"""The arm process: ``python -m cellctl.assembling.arm_worker FD``.

A child of the daemon that holds ur_rtde and nothing else. ``FD`` is its end of a socket pair; what
the library prints goes to its standard output, which the daemon logs. It ends itself, and with that
lets the controller's watchdog stop the arm, whenever its own state is in doubt:

- the daemon is gone (the socket closes): the arm is stopped first;
- the robot is lost: ur_rtde's objects are then broken for good;
- one round of the loop takes longer than a call of ur_rtde may take: the kernel's alarm ends the
  process even inside the library.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
import time
import traceback
from collections.abc import Generator
from contextlib import suppress

from cellctl.assembling import arm_orders
from cellctl.assembling.arm import ArmCheck
from cellctl.assembling.arm_dashboard import Dashboard
from cellctl.assembling.arm_link import Link
from cellctl.assembling.arm_messages import (
    LINE_LIMIT_BYTES,
    ORDERS,
    STOPPED_CODE,
    Close,
    Connect,
    Done,
    Failed,
    Follow,
    Heartbeat,
    MoveJoints,
    Order,
    Prepare,
    Report,
    SetOutput,
    Stop,
    Verify,
    WaitInput,
    encode,
)
from cellctl.assembling.arm_receiver import RUNNING, Receiver, safety_fault
from cellctl.assembly import Value
from cellctl.errors import CellFault

HANG_S = 2.5
"""No round of the loop may take longer; a path's upload is the longest."""

_ROUND_S = 0.004
_IDLE_ROUND_S = 0.01
"""With nothing under way; an order ends the wait for the next round at once."""
_KICKS_A_PERIOD = 5
"""Of the controller's watchdog, at least."""
_REPORT_PERIOD_S = 0.012
_CONNECT_LIMIT_S = 120.0
_LAST_STOP_S = 3.0
_LAST_WORDS_S = 0.5
_NICENESS = -10

Task = Generator[None, None, bool | ArmCheck | None]
"""What remains to be done for an order; returns False only for an input that was not seen, and
what was read back where that was asked."""


class Worker:
    """One loop that listens to the daemon, reads the robot, kicks the watchdog and moves on
    whatever order is under way.

    Args:
        daemon: this end of the socket pair.
    """

    def __init__(self, daemon: socket.socket) -> None:
        daemon.setblocking(False)
        self._daemon = daemon
        self._received = b""
        self._unsent = b""
        self._heard_at_s = time.monotonic()
        self._reported_at_s = 0.0
        self._robot: Connect | None = None
        self._link: Link | None = None
        self._dashboard: Dashboard | None = None
        self._movement: tuple[int, Task] | None = None
        self._tasks: dict[int | None, Task] = {}
        """What may run beside a movement, by number of its order; None for a stop of our own."""
        self._close: int | None = None

    def run(self) -> None:
        """Work until the daemon says so or is gone.

        Raises:
            CellFault: ``robot_lost``.
        """
        while self._close is None or self._close in self._tasks:
            signal.setitimer(signal.ITIMER_REAL, HANG_S)
            wait_s = self._round_s()
            select.select([self._daemon], [self._daemon] if self._unsent else [], [], wait_s)
            if not self._listen():
                self._stop_for_good()
                return
            if self._link is not None:
                self._round(self._link)
            self._flush()
        if self._link is not None:
            self._link.end_program()
        self._send(Done(number=self._close))
        self._say_last_words()

    def _round_s(self) -> float:
        if self._movement is not None or self._tasks or self._robot is None:
            return _ROUND_S
        return min(_IDLE_ROUND_S, 1.0 / (_KICKS_A_PERIOD * self._robot.robot.watchdog_hz))

    def _round(self, link: Link) -> None:
        try:
            link.tick()
        except CellFault as fault:
            self._fail_all(fault)
            raise
        self._watch_daemon(link)
        self._watch_gate(link)
        self._advance(link)
        # A daemon that does not read gets the answers once it does, but no stale states.
        if time.monotonic() - self._reported_at_s >= _REPORT_PERIOD_S and not self._unsent:
            self._report(link)

    def _report(self, link: Link) -> None:
        """Send the newest state; also before every answer, so that it shows what came of it."""
        self._reported_at_s = time.monotonic()
        state = link.sample.state(link.speed_fraction)
        self._send(Report(state=state, speed_fraction=link.speed_fraction))

    def _listen(self) -> bool:
        """Take what the daemon sent; False when it is gone."""
        try:
            data = self._daemon.recv(1 << 16)
        except BlockingIOError:
            return True
        except OSError:
            return False
        self._heard_at_s = time.monotonic()
        *lines, self._received = (self._received + data).split(b"\n")
        for line in lines:
            self._obey(ORDERS.validate_json(line))
        return bool(data) and len(self._received) <= LINE_LIMIT_BYTES

    def _obey(self, order: Order) -> None:
        if isinstance(order, Heartbeat):
            return
        try:
            if isinstance(order, Connect):
                self._connect(order)
            elif isinstance(order, Close):
                self._close = order.number
                if self._link is not None:
                    self._begin_stop(self._link, order.number)
            else:
                assert self._link is not None, "the daemon connects first"
                self._begin(self._link, order)
        except CellFault as fault:
            self._send(Failed(number=order.number, code=fault.code, detail=fault.detail))
            if self._link is None:
                # Half a connection is of no use, and cannot be taken down safely.
                self._say_last_words()
                raise

    def _begin(
        self,
        link: Link,
        order: Prepare | Follow | MoveJoints | Stop | SetOutput | WaitInput | Verify,
    ) -> None:
        assert self._robot is not None, "set together with the link"
        assert self._dashboard is not None, "set together with the link"
        factor = self._robot.robot.move_timeout_factor
        if isinstance(order, Stop):
            self._begin_stop(link, order.number)
        elif isinstance(order, SetOutput):
            self._tasks[order.number] = link.set_output(order.line, order.high)
        elif isinstance(order, WaitInput):
            self._tasks[order.number] = arm_orders.wait_input(link, order)
        elif self._movement is not None:
            raise CellFault("internal", "The arm is already under way.")
        elif isinstance(order, Verify):
            robot = self._robot.robot
            self._tasks[order.number] = arm_orders.verify(link, self._dashboard, robot)
        elif isinstance(order, Prepare):
            self._movement = (order.number, arm_orders.prepare(link, order))
        elif isinstance(order, Follow):
            self._movement = (order.number, arm_orders.follow(link, order, factor))
        else:
            self._movement = (order.number, arm_orders.move_joints(link, order, factor))

    def _begin_stop(self, link: Link, number: int | None) -> None:
        self._end_movement(STOPPED_CODE, "")
        self._tasks[number] = arm_orders.stop(link)

    def _advance(self, link: Link) -> None:
        """Resume everything that is under way."""
        # A movement that begins waits for a stop of our own, which opens the gate at its end.
        if self._movement is not None and None not in self._tasks:
            number, movement = self._movement
            try:
                next(movement)
            except StopIteration:
                self._movement = None
                self._report(link)
                self._send(Done(number=number))
            except CellFault as fault:
                self._end_movement(*self._explain(fault))
                self._tasks.setdefault(None, arm_orders.stop(link))
        for key, task in list(self._tasks.items()):
            try:
                next(task)
            except StopIteration as end:
                del self._tasks[key]
                if key is not None and key != self._close:
                    self._report(link)
                    check = end.value if isinstance(end.value, ArmCheck) else None
                    seen = end.value is not False
                    self._send(Done(number=key, level_seen=seen, check=check))
            except CellFault as fault:
                del self._tasks[key]
                if key is not None:
                    self._send(Failed(number=key, code=fault.code, detail=fault.detail))

    def _end_movement(self, code: str, detail: str) -> None:
        if self._movement is not None:
            number, movement = self._movement
            self._movement = None
            movement.close()
            self._send(Failed(number=number, code=code, detail=detail))

    def _explain(self, fault: CellFault) -> tuple[str, str]:
        """Code and detail of what ended a movement; the dashboard knows of local control."""
        if fault.code == "program_stopped" and self._dashboard is not None:
            with suppress(CellFault):
                if not self._dashboard.remote():
                    return "local_control", fault.detail
        return fault.code, fault.detail

    def _watch_daemon(self, link: Link) -> None:
        """Stop a movement that nobody watches any more."""
        if self._movement is None or self._robot is None:
            return
        silence_s = time.monotonic() - self._heard_at_s
        if silence_s > self._robot.robot.host_silence_s:
            self._end_movement("program_stopped", f"The daemon was silent for {silence_s:.1f} s.")
            self._tasks.setdefault(None, arm_orders.stop(link))

    def _watch_gate(self, link: Link) -> None:
        """Stop the path that waits behind the gate when somebody else opens it."""
        if self._movement is None and link.gate_was_opened():
            self._tasks.setdefault(None, arm_orders.stop(link))

    def _connect(self, order: Connect) -> None:
        """Open everything, in the one order that works; nothing moves."""
        signal.setitimer(signal.ITIMER_REAL, _CONNECT_LIMIT_S)
        _take_precedence(order.robot.real_time_priority)
        dashboard = Dashboard(order.robot)
        identity = dashboard.identity(order.robot.model)
        receiver = Receiver(order.robot)
        if order.recover:
            dashboard.leave_stop(receiver)
        if (fault := safety_fault(receiver.sample)) is not None:
            raise fault
        if receiver.sample.robot_mode != RUNNING:
            raise CellFault("robot_lost", "The arm has no power or its brakes are on.")
        # A script that is sent while another is paused may only stop that one.
        dashboard.end_program(receiver)
        if not order.inspect:
            link = Link(order.robot, receiver, order.speed_fraction)
            link.describe_tool(order.tcp, order.payload_kg, order.payload_cog_m)
            link.open_gate()
            link.guard()
            self._link, self._robot, self._dashboard = link, order, dashboard
            self._report(link)
        self._send(Done(number=order.number, identity=identity))

    def _stop_for_good(self) -> None:
        """The daemon is gone: leave an arm at rest behind."""
        if self._link is None:
            return
        deadline_s = time.monotonic() + _LAST_STOP_S
        for _ in arm_orders.stop(self._link):
            if time.monotonic() > deadline_s:
                return
            time.sleep(_ROUND_S)
            self._link.tick()
        self._link.end_program()

    def _fail_all(self, fault: CellFault) -> None:
        self._end_movement(fault.code, fault.detail)
        for number in self._tasks:
            if number is not None:
                self._send(Failed(number=number, code=fault.code, detail=fault.detail))
        self._say_last_words()

    def _send(self, message: Value) -> None:
        self._unsent += encode(message)

    def _flush(self) -> None:
        with suppress(BlockingIOError):
            if self._unsent:
                self._unsent = self._unsent[self._daemon.send(self._unsent) :]

    def _say_last_words(self) -> None:
        self._daemon.settimeout(_LAST_WORDS_S)
        with suppress(OSError):
            self._daemon.sendall(self._unsent)


def _take_precedence(priority: int) -> None:
    """Come before all other work on this computer, as far as that is granted.

    The library's threads, which are started later, inherit it: the loop waits for them at times.
    """
    if priority:
        with suppress(PermissionError):
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(priority))


def main() -> None:
    """Serve the daemon at the other end of the descriptor named on the command line.

    Ends without running destructors: those of ur_rtde wait, abort or never return.
    """
    # The daemon decides what a signal to the whole group means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    # What cannot be printed at once is lost: nothing but the robot may hold this process up.
    os.set_blocking(1, False)
    os.set_blocking(2, False)
    with suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, _NICENESS)  # the library's threads inherit it
    status = 0
    try:
        Worker(socket.socket(fileno=int(sys.argv[1]))).run()
    except CellFault as fault:
        print(fault, file=sys.stderr)  # noqa: T201  # the daemon logs it
        status = 3
    except BaseException:  # noqa: BLE001  # whatever it is, the process must end, and say why
        traceback.print_exc()
        status = 1
    finally:
        with suppress(BlockingIOError):
            sys.stderr.flush()
        os._exit(status)


if __name__ == "__main__":
    main()
