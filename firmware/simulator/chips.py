# SPDX-License-Identifier: GPL-3.0-or-later
"""The microcontrollers of the boards, as yasimavr's device models.

Derived from the descriptions of the ATtiny402, 804 and 1604 that come with yasimavr (copyright
2024-2026 Clement Savergne). What differs: the vectors that the manufacturer's headers number
otherwise, the signature, the analog comparator's address, the timer's way to its pins, the
watchdog, the brown-out detector's registers, and a serial number.
"""

from __future__ import annotations

import os
from typing import Any, NamedTuple

from yasimavr.device_library import descriptors
from yasimavr.device_library.builders._builders_arch_xt import XT_BaseDevice, XT_DeviceBuilder
from yasimavr.lib import core

BOD_REGISTERS = (0x0080, 0x0081, 0x0088, 0x0089, 0x008A, 0x008B)
_PERIPHERALS = [
    *("CPUINT", "SLPCTRL", "CLKCTRL", "RSTCTRL", "NVMCTRL", "MISC", "PORTA", "PORTMUX", "RTC"),
    *("TCA0", "TCB0", "VREF", "ADC0", "ACP0", "USART0", "SPI0", "TWI0", "FUSES", "USERROW", "WDT"),
]
_MULTIPLEXED = ("TCA0", "USART0", "SPI0", "TWI0")
_COMMON_VECTORS = [
    *("RESET", "CRCSCAN", "BOD", "PORTA", "PORTB", "PORTC", "RTC_CNT", "RTC_PIT", "TCA0_OVF"),
    *("TCA0_HUNF", "TCA0_CMP0", "TCA0_CMP1", "TCA0_CMP2", "TCB0"),
]
_TAIL_VECTORS = [
    *("TWI0_TWIS", "TWI0_TWIM", "SPI0", "USART0_RXC", "USART0_DRE", "USART0_TXC", "NVMCTRL_EE"),
]
_VECTORS_412 = [
    *(*_COMMON_VECTORS, "TCD0_OVF", "TCD0_TRIG", "AC0", "ADC0_RESRDY", "ADC0_WCOMP"),
    *_TAIL_VECTORS,
]
_VECTORS_0_SERIES = [
    *(*_COMMON_VECTORS, "_14", "_15", "_16", "AC0", "_18", "_19", "ADC0_RESRDY", "ADC0_WCOMP"),
    *("_22", "_23", *_TAIL_VECTORS),
]


class Chip(NamedTuple):
    """How a microcontroller differs from the description it starts from."""

    base: str
    signature: tuple[int, int, int]
    vectors: list[str]
    changes: dict[str, dict[str, Any]]
    """Of peripherals, by name."""


CHIPS = {
    "attiny412": Chip("attiny402", (0x1E, 0x92, 0x23), _VECTORS_412, {"ACP0": {"base": 0x0670}}),
    "attiny804": Chip("attiny804", (0x1E, 0x93, 0x25), _VECTORS_0_SERIES, {}),
    "attiny1604": Chip("attiny1604", (0x1E, 0x94, 0x25), _VECTORS_0_SERIES, {}),
}


class _Device(XT_BaseDevice):  # type: ignore[misc]
    """A model with the watchdog attached and the timer wired to its pins."""

    def __init__(self, descriptor: Any, builder: Any) -> None:
        super().__init__(descriptor, builder)
        names = [*_PERIPHERALS, *(name for name in ("PORTB",) if name in descriptor.peripherals)]
        builder.build_peripherals(self, names)
        self.bod = _plain_registers()
        self.attach_peripheral(self.bod)

    def arch_init(self) -> bool:
        """Called by the base class once the peripherals exist."""
        for name in _MULTIPLEXED:
            self._builder_.add_pin_driver_mux_configs(self, name)
        return True


def make_device(name: str) -> Any:
    """A microcontroller without a program.

    Raises:
        KeyError: there is no such chip.
    """
    chip = CHIPS[name]
    path = os.path.join(descriptors.LibraryRepository, f"{chip.base}.yml")  # noqa: PTH118
    config = descriptors.load_config_file(path)
    config["name"] = name
    config["device_signature"] = list(chip.signature)
    config["interrupts"]["vectors"] = chip.vectors
    all_awake = [0xFF] * ((len(chip.vectors) + 7) // 8)
    config["interrupts"]["sleep_mask"] |= {"Idle": all_awake}
    for peripheral, changes in chip.changes.items():
        config["peripherals"][peripheral] |= changes
    descriptor = descriptors.DeviceDescriptor()
    descriptor._load_config(config, descriptors.ConfigRepositories)
    return XT_DeviceBuilder.build_device(descriptor, _Device)


def _plain_registers() -> Any:
    """The brown-out detector's registers, which only keep what is written to them."""
    registers = []
    for address in BOD_REGISTERS:
        register = core.DummyController.dummy_register_t()
        register.reg = core.regmask_t(core.reg_addr_t(address), core.bitmask_t(0xFF))
        register.reset = 0
        registers.append(register)
    return core.DummyController(core.sim_id_t("BOD"), registers)
