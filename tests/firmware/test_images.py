"""The compiled images: they fit, are the same every time, and hold what the chips need."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.firmware.image import Image, build, toolchain
from tests.leaks import REPOSITORY

PROGRAMS = ("gripper", "conveyor")
FLASH_LIMITS = {"gripper": 3_500, "conveyor": 16_384 - 512}
MEMORY_LIMITS = {"gripper": 200, "conveyor": 1_024 - 128}
"""Variables and stack together, in bytes; the chips have 256 and 1 024."""
IOREG, SPM = 0xD8, 0x9D
"""The keys that open protected registers, and self-programming."""
MCLKCTRLB, WDT_CTRLA, WDT_STATUS, NVMCTRL_CTRLA = 0x61, 0x100, 0x101, 0x1000
PROTECTED = (0x40, 0x60, MCLKCTRLB, 0x62, 0x70, 0x78, WDT_CTRLA, WDT_STATUS, NVMCTRL_CTRLA)
"""Every register that the programs could reach and that takes no write without a key; the first,
RSTCTRL.RSTFR, needs none and is here to show that the search finds stores."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both programs, compiled."""
    folder = tmp_path_factory.mktemp("images")
    build(folder)
    return folder


@pytest.fixture(params=PROGRAMS)
def image(folder: Path, request: pytest.FixtureRequest) -> Image:
    """One of them."""
    return Image(folder / f"{request.param}.elf")


def test_the_programs_fit_their_chips(image: Image) -> None:
    name = image.path.stem
    assert image.flash <= FLASH_LIMITS[name]
    assert image.static_memory + image.deepest_stack() <= MEMORY_LIMITS[name]


def test_the_deepest_stack_is_not_underrated(image: Image) -> None:
    # main alone pushes its frame, calls, and is interrupted by a handler that saves registers.
    assert image.deepest_stack() >= 20


def test_two_builds_are_the_same_to_the_bit(folder: Path, tmp_path: Path) -> None:
    build(tmp_path)
    for name in PROGRAMS:
        for kind in ("elf", "hex"):
            file = f"{name}.{kind}"
            assert (tmp_path / file).read_bytes() == (folder / file).read_bytes(), file


def test_an_image_holds_no_path_and_no_date(image: Image) -> None:
    data = image.path.read_bytes()
    assert str(REPOSITORY).encode() not in data
    assert b"/tmp" not in data
    assert not re.search(rb"20[2-9]\d-[01]\d-[0-3]\d", data)


def test_the_fuses_are_those_of_the_documents(image: Image, tmp_path: Path) -> None:
    page = (REPOSITORY / "docs" / "firmware.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| (\d) \| `0x([0-9A-F]{2})` \|", page, re.MULTILINE)
    documented = {int(number): int(value, 16) for _, number, value in rows}
    fuses = image.fuses(tmp_path)
    assert len(fuses) == 9
    assert documented == {number: fuses[number] for number in documented}
    assert set(documented) == {0, 1, 2, 5, 6, 7, 8}
    assert fuses[3] == fuses[4] == 0


def test_the_hex_files_hold_the_program_and_nothing_else(folder: Path) -> None:
    for name in PROGRAMS:
        text = (folder / f"{name}.hex").read_text(encoding="ascii")
        records = [bytes.fromhex(line[1:]) for line in text.split()]
        assert all(sum(record) % 256 == 0 for record in records)
        size = sum(record[0] for record in records if record[3] == 0)
        assert size == Image(folder / f"{name}.elf").flash


def test_protected_registers_are_written_with_their_keys_and_not_otherwise(image: Image) -> None:
    writes = image.protected_writes()
    wanted = {
        (IOREG, MCLKCTRLB, 0x01),  # prescaler on, by two: 10 MHz
        (IOREG, WDT_CTRLA, 0x06),  # 256 ms
        (IOREG, WDT_STATUS, 0x80),  # locked
    }
    if image.path.stem == "gripper":
        wanted.add((SPM, NVMCTRL_CTRLA, 0x03))  # erase and write
    assert set(writes) == wanted
    for address in PROTECTED[1:]:
        assert image.stores(address) == sum(register == address for _, register, _ in writes)
    assert image.stores(PROTECTED[0]) == 1


def test_the_watchdog_is_fed_in_one_place(image: Image) -> None:
    fed = [found for found in image.instructions.values() if found.name == "wdr"]
    assert len(fed) == 1


def test_the_compiler_is_the_locked_one() -> None:
    assert (toolchain() / "avr-gcc").is_file()
