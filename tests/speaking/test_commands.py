"""``cellctl voice`` and the doctor's look at the loudspeaker, as somebody who sets a cell up."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from cellctl.cli import doctor_sound
from cellctl.cli.findings import Level
from cellctl.sim.microphone import VirtualMicrophone
from tests.cell.harness import cell_config
from tests.speaking.test_mouth import heard_s

pytestmark = pytest.mark.wire


def cellctl(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the command in a process of its own."""
    command = [sys.executable, "-m", "cellctl", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=100.0, check=False)


def test_a_voice_is_tried_without_a_daemon(room: VirtualMicrophone, tmp_path: Path) -> None:
    recording = tmp_path / "said.raw"
    room.loudspeaker.record(recording)
    done = cellctl("voice", "test", "--text", "Two plus 2.", "--device", "spk")
    assert done.returncode == 0, done.stderr
    assert "said 'Two plus 2.' on VirtualLoudspeaker" in done.stdout
    room.loudspeaker.end()
    assert heard_s(recording) > 0.4

    missing = cellctl("voice", "test", "--device", "attic")
    assert missing.returncode != 0
    assert "no loudspeaker 'attic'" in missing.stderr
    assert "cellctl voice devices" in missing.stderr
    assert "sink    spk: VirtualLoudspeaker" in cellctl("voice", "devices").stdout


@pytest.mark.parametrize(
    ("section", "levels"),
    [
        ({"loudspeaker": "spk"}, [Level.OK, Level.OK]),
        ({"loudspeaker": "attic", "voice": "martian"}, [Level.WARNING, Level.PROBLEM]),
    ],
)
def test_the_doctor_looks_for_a_loudspeaker_and_a_voice(
    room: VirtualMicrophone, section: dict[str, str], levels: list[Level]
) -> None:
    del room
    found = doctor_sound.loudspeaker(cell_config(voice=section), None)
    assert [finding.level for finding in found] == levels
