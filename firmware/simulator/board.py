# SPDX-License-Identifier: GPL-3.0-or-later
"""A board's microcontroller, simulated: runs one ELF in time that its user hands out.

Reads one JSON object a line from standard input and answers each with one on standard output; ends
when standard input closes. The requests are described in ``README.md`` beside this file.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
from collections.abc import Callable
from typing import IO, Any

from chips import CHIPS, make_device
from wire import SerialWire
from yasimavr.lib import core
from yasimavr.lib.arch_xt import CTLREQ_WRITE_SIGROW

PAINT = 0xC5
"""Fills the memory at power-on, so that the stack's deepest point shows."""
CLOCK_CHECK_S = 0.01
"""The clock that the program has chosen is looked at after this long."""
MCLKCTRLB, OSCCFG = 0x0061, 0x1282
PRESCALERS = (2, 4, 8, 16, 32, 64, 1, 1, 6, 10, 12, 24, 48)
OPCODE_LOOP = b"\xff\xcf"
"""rjmp to itself."""
SREG_I = 0x80
CAUSES = {
    "power": core.Device.ResetFlag.PowerOn,
    "brownout": core.Device.ResetFlag.BOD,
    "external": core.Device.ResetFlag.Ext,
    "software": core.Device.ResetFlag.SW,
}
ALIVE = {core.Device.State.Running, core.Device.State.Sleeping, core.Device.State.Halted}


class SimulationError(Exception):
    """The program did what no program may, or the simulator cannot go on."""


class Board:
    """One microcontroller with its program, and time that stands still between calls.

    Args:
        chip: one of ``CHIPS``.
        elf: the program, with its fuses.
        frequency_hz: what the program sets the main clock to.
        supply_v: the supply's voltage.
    """

    def __init__(self, chip: str, elf: str, frequency_hz: int, supply_v: float) -> None:
        self.device = make_device(chip)
        self.device.logger().set_level(core.Logger.Level.Error)
        core.global_logger().set_level(core.Logger.Level.Error)
        self.loop = core.SimLoop(self.device)
        self.loop.set_fast_mode(True)
        self.device.set_option(core.Device.Option.InfiniteLoopDetect, False)
        firmware = core.Firmware.read_elf(elf)
        if firmware is None:
            raise SimulationError(f"{elf} is no program")
        firmware.frequency = frequency_hz
        firmware.vcc = supply_v
        firmware.aref = 1.0
        self.device.load_firmware(firmware)
        if not firmware.has_memory(core.Firmware.Area.Fuses):
            raise SimulationError(f"{elf} holds no fuses")
        self._flash_size = self.device.config().core.flashsize
        self.frequency_hz = frequency_hz
        self.probe = core.DeviceDebugProbe(self.device)
        ram = self.device._descriptor_.mem.data_segments["ram"]
        self._ram = (ram.start, ram.end + 1)
        self._eeprom = self.device._descriptor_.mem.data_segments["eeprom"]
        # Of variables that start-up does not clear, only the symbols tell.
        ends = [symbol.addr + symbol.size for symbol in firmware.symbols()]
        ends.append(ram.start + firmware.datasize() + firmware.bsssize())
        self._static_end = max(end for end in ends if end <= ram.end)
        self._clock_checked = False
        self._events: list[list[Any]] = []
        self._hooks: list[Any] = []
        self.wire: SerialWire | None = None
        self.reset("power")

    @property
    def time_s(self) -> float:
        """How long the microcontroller has been simulated."""
        return float(self.loop.cycle() / self.frequency_hz)

    def watch(self, name: str) -> None:
        """Tell of every change of a pin's level from now on; of a pin with a +, its rises only."""
        pin = name.removesuffix("+")
        rises_only = pin != name

        def changed(signal: Any, _: int) -> None:
            if signal.sigid != core.Wire.SignalId.DigitalChange:
                return
            high = signal.data.value()
            if high or not rises_only:
                self._events.append([round(self.time_s, 8), pin, int(high)])

        hook = core.CallableSignalHook(changed)
        self._pin(pin).signal().connect(hook)
        self._hooks.append(hook)

    def set_serial_number(self, number: bytes) -> None:
        """Give the chip a serial number of its own."""
        request = core.ctlreq_data_t()
        request.data = core.vardata_t(number)
        self.device.ctlreq(core.sim_id_t("MISC"), CTLREQ_WRITE_SIGROW, request)

    def drive(self, pin: str, level: str) -> None:
        """Put a level on a pin: H, L, or Z for none, U and D for a weak one."""
        self._pin(pin).set_external_state(level)

    def advance(self, to_s: float) -> None:
        """Run up to this time.

        Raises:
            SimulationError: the program crashed, or runs at another clock than is simulated.
        """
        cycles = round(to_s * self.frequency_hz) - self.loop.cycle()
        if cycles > 0:
            self.loop.run(cycles)
        state = self.device.state()
        if state not in ALIVE:
            raise SimulationError(
                f"the program crashed at {self.time_s:.6f} s, at address "
                f"0x{self.probe.read_pc():04X}, state {state.name}"
            )
        if not self._clock_checked and self.time_s >= CLOCK_CHECK_S:
            self._check_clock()

    def events(self) -> list[list[Any]]:
        """Changes of watched pins since this was last asked: time, pin, level."""
        events, self._events = self._events, []
        return events

    def reset(self, cause: str) -> None:
        """Start the program anew; at power-on the memory holds nothing that was there before."""
        if cause == "power":
            start, end = self._ram
            self.probe.write_data(start, bytes([PAINT]) * (end - start))
        self.device.reset(int(CAUSES[cause]))

    def set_supply(self, volts: float) -> None:
        """Change the supply's voltage, which the converter measures against."""
        request = core.ctlreq_data_t()
        request.index = core.VREF.Source.VCC.value
        request.data = core.vardata_t(volts)
        self.device.ctlreq(core.IOCTL_VREF, core.CTLREQ_VREF_SET, request)

    def hang(self, interrupts: bool) -> None:
        """Catch the program in an endless loop, with or without interrupts going on."""
        address = self._flash_size - len(OPCODE_LOOP)
        self.probe.write_flash(address, OPCODE_LOOP)
        if not interrupts:
            self.probe.write_sreg(self.probe.read_sreg() & ~SREG_I)
        self.probe.write_pc(address)

    def read_eeprom(self) -> bytes:
        """All of it."""
        start, end = self._eeprom
        return bytes(self.probe.read_data(start, end + 1 - start))

    def write_eeprom(self, address: int, data: bytes) -> None:
        """Change what the EEPROM holds, behind the program's back."""
        self.probe.write_data(self._eeprom.start + address, data)

    def memory(self) -> dict[str, int]:
        """How much memory there is, is static, and was ever used by the stack, in bytes."""
        start, end = self._ram
        stack = bytes(self.probe.read_data(self._static_end, end - self._static_end))
        untouched = len(stack) - len(stack.lstrip(bytes([PAINT])))
        return {
            "size": end - start,
            "static": self._static_end - start,
            "stack": len(stack) - untouched,
        }

    def _pin(self, name: str) -> Any:
        pin = self.device.find_pin(core.sim_id_t(name))
        if pin is None:
            raise SimulationError(f"there is no pin {name}")
        return pin

    def _check_clock(self) -> None:
        self._clock_checked = True
        fuse = self.probe.read_ioreg(core.reg_addr_t(OSCCFG), False) & 0x03
        divider = self.probe.read_ioreg(core.reg_addr_t(MCLKCTRLB), False)
        factor = PRESCALERS[divider >> 1 & 0x0F] if divider & 1 else 1
        runs_hz = {1: 16_000_000, 2: 20_000_000}.get(fuse, 0) // factor
        if runs_hz != self.frequency_hz:
            raise SimulationError(
                f"the program runs at {runs_hz} Hz (fuse OSCCFG {fuse}, divider {factor}) and is "
                f"simulated at {self.frequency_hz} Hz"
            )


def _advance(
    board: Board, to_s: float, pins: dict[str, str] | None = None, serial: str = ""
) -> dict[str, Any]:
    for pin, level in (pins or {}).items():
        board.drive(pin, level)
    if board.wire is not None and serial:
        board.wire.send(bytes.fromhex(serial))
    board.advance(to_s)
    heard = board.wire.heard() if board.wire is not None else b""
    return {"events": board.events(), "serial": heard.hex()}


def _unplug(board: Board) -> None:
    if board.wire is not None:
        board.wire.silence()


def _write_eeprom(board: Board, address: int, data: str) -> None:
    board.write_eeprom(address, bytes.fromhex(data))


REQUESTS: dict[str, Callable[..., dict[str, Any] | None]] = {
    "advance": _advance,
    "reset": Board.reset,
    "hang": Board.hang,
    "supply": Board.set_supply,
    "unplug": _unplug,
    "read_eeprom": lambda board: {"data": board.read_eeprom().hex()},
    "write_eeprom": _write_eeprom,
    "memory": Board.memory,
}


def answer(board: Board, request: dict[str, Any]) -> dict[str, Any]:
    """Do what is asked.

    Raises:
        SimulationError: see ``Board``.
        KeyError, TypeError, ValueError: the request is malformed.
    """
    do = REQUESTS.get(request.pop("do"))
    if do is None:
        raise ValueError(f"there is no such request; there are {', '.join(REQUESTS)}")
    result = do(board, **request)
    return {"time_s": board.time_s, **(result or {})}


def main() -> int:
    """Serve until standard input closes; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--chip", choices=sorted(CHIPS), required=True)
    parser.add_argument("--elf", required=True)
    parser.add_argument("--frequency-hz", type=int, required=True)
    parser.add_argument("--supply-v", type=float, default=5.0)
    parser.add_argument("--serial", metavar="TXD,RXD", help="pins of the serial line")
    parser.add_argument("--baud", type=int, default=115_200)
    parser.add_argument(
        "--watch", default="", metavar="PIN,...", help="pins to tell changes of; PIN+: rises"
    )
    parser.add_argument("--serial-number", type=bytes.fromhex, default=bytes(10), metavar="HEX")
    options = parser.parse_args()
    # The simulator writes its own messages to standard output: they go to standard error instead.
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    # Ctrl-C is for whoever uses this: it closes standard input when it is done.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        board = Board(options.chip, options.elf, options.frequency_hz, options.supply_v)
        board.set_serial_number(options.serial_number)
        for pin in filter(None, options.watch.split(",")):
            board.watch(pin)
        if options.serial:
            hears, talks = options.serial.split(",")
            board.wire = SerialWire(
                board.device, board.loop.cycle_manager(), hears, talks, options.baud
            )
    except SimulationError as error:
        _say(answers, {"ok": False, "error": str(error)})
        return 1
    _say(answers, {"ok": True, "time_s": 0.0})
    for line in sys.stdin:
        try:
            reply = {"ok": True, **answer(board, json.loads(line))}
        except (SimulationError, KeyError, TypeError, ValueError) as error:
            reply = {"ok": False, "error": f"{error}"}
        _say(answers, reply)
    return 0


def _say(answers: IO[str], reply: dict[str, Any]) -> None:
    answers.write(json.dumps(reply) + "\n")
    answers.flush()


if __name__ == "__main__":
    sys.exit(main())
