"""The page that describes the protocol, and what is generated from it, say the same."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from cellctl.boards import constants
from cellctl.boards.constants import ConveyorFlag, GripperFlag
from cellctl.boards.line import COMMAND_START, decode_command, decode_reply
from cellctl.boards.protocol_tables import OUTPUTS, c_header, python_constants, table
from tests.leaks import REPOSITORY

DOCUMENT = (REPOSITORY / "docs" / "serial-protocol.md").read_text(encoding="utf-8")
FILES = ("cellctl/boards/constants.py", "firmware/common/protocol.h")


@pytest.mark.parametrize(("name", "write"), list(zip(FILES, OUTPUTS, strict=True)))
def test_a_file_on_disk_is_what_the_page_says(name: str, write: Callable[[str], str]) -> None:
    assert (REPOSITORY / name).read_text(encoding="utf-8") == write(DOCUMENT), "run `make protocol`"


def test_both_sides_have_the_same_numbers() -> None:
    defined = dict(re.findall(r"^#define PROTOCOL_(\w+) ([0-9a-fx]+)u$", c_header(DOCUMENT), re.M))
    for name in ("COMMAND_LIMIT", "CRC_POLYNOMIAL", "PITCH_MAX", "LATCH_PULSE_US"):
        assert int(defined[name], 0) == getattr(constants, name)
    assert int(defined["SILENCE_MS"]) == 1000 * constants.SILENCE_S
    assert int(defined["PITCH_UNIT_UM"]) == round(1e6 * constants.PITCH_UNIT_M)
    assert int(defined["TRAVEL_LIMIT_PITCHES_PERCENT"]) == 100 * constants.TRAVEL_LIMIT_PITCHES
    for flag in ConveyorFlag:
        assert int(defined[f"CONVEYOR_FLAG_{flag.name}"], 0) == flag
    for bit in GripperFlag:
        assert int(defined[f"GRIPPER_FLAG_{bit.name}"], 0) == bit


def test_a_changed_table_changes_both_sides() -> None:
    changed = DOCUMENT.replace("| `SILENCE_S` | 0.2 |", "| `SILENCE_S` | 0.3 |")
    assert "SILENCE_S: Final = 0.3\n" in python_constants(changed)
    assert "#define PROTOCOL_SILENCE_MS 300u\n" in c_header(changed)


def test_a_page_without_a_table_is_refused() -> None:
    with pytest.raises(ValueError, match="no table of 'register'"):
        python_constants(DOCUMENT.replace("| register |", "| number |"))


def test_every_command_has_a_board_and_an_argument_that_is_known() -> None:
    for row in table(DOCUMENT, "letter"):
        assert row["boards"] in {"both", "conveyor", "gripper"}
        assert row["argument"] in {"none", "pitch", "register", "value"}


def test_the_examples_of_the_page_are_valid() -> None:
    examples = re.findall(r"[><!][0-9A-Za-z][0-9A-Za-z. ]*\*[0-9A-F]{2}", DOCUMENT)
    assert len(examples) == 4
    for example in examples:
        frame = example.encode()
        decode = decode_command if frame.startswith(COMMAND_START) else decode_reply
        decode(frame)
