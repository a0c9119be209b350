"""The paper's prompts, spoken, each to a finished object; and words that ask for nothing."""

from __future__ import annotations

import json
import wave
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cellctl.assembly import Cell
from cellctl.speaking.voices import speak_to_wav
from cellctl.validating.rules import pieces
from tests.cell.harness import RunningCell, bar, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    # Less quick than others: a recogniser works beside the arm here.
    with running_cell(speed=6.0) as running:
        yield running


@pytest.fixture
def idle(cell: RunningCell) -> Iterator[RunningCell]:
    cell.begin_test()
    yield cell
    cell.bring_back()


def spoken(text: str, folder: Path) -> tuple[str, bytes]:
    path = folder / "wish.wav"
    speak_to_wav(text, path)
    return path.name, path.read_bytes()


def legs(cells: tuple[Cell, ...]) -> int:
    """How many legs stand on the floor, however thick."""
    return len(pieces(cell for cell in cells if cell.z == 0))


def tiers(cells: tuple[Cell, ...]) -> int:
    """Full layers above the floor."""
    width, depth = (len({cell[axis] for cell in cells}) for axis in (0, 1))
    layers = [sum(1 for cell in cells if cell.z == z) for z in range(1, 6)]
    return sum(1 for parts in layers if parts == width * depth)


def build(cell: RunningCell, text: str, folder: Path) -> tuple[Cell, ...]:
    """Speak a wish, wait until it stands, and return the cells that do."""
    cell.visitor.hear(*spoken(text, folder))
    job = cell.finish()
    assert job.outcome == "built", job
    cell.assert_as_planned()
    return cell.truth().built


def test_a_simple_stool(idle: RunningCell, tmp_path: Path) -> None:
    built = build(idle, "I want a simple stool", tmp_path)
    assert legs(built) == 3
    assert 20 <= len(built) <= 40
    seen = idle.states_seen()
    while seen[0] in {"starting", "idle"}:  # told before the wish, and read after it
        seen.pop(0)
    assert seen[:4] == ["listening", "generating", "validating", "feeding"]
    assert "assembling" in seen
    assert set(seen[3:]) <= {"feeding", "assembling", "idle"}
    snapshot = idle.client.snapshot()
    assert [part.cell for part in snapshot.parts] == [step.cell for step in snapshot.plan.steps]  # type: ignore[union-attr]
    assert snapshot.inventory["structure"] == len(built)
    print(f"loop blocked {snapshot.health.loop_blocked_p99_s:.3f} s at its 99th percentile")  # noqa: T201


@pytest.mark.soak
def test_a_shelf_with_two_tiers(idle: RunningCell, tmp_path: Path) -> None:
    built = build(idle, "a shelf with two tiers", tmp_path)
    assert tiers(built) == 2


def test_the_letter_t(idle: RunningCell, tmp_path: Path) -> None:
    built = build(idle, "the letter T", tmp_path)
    top = max(cell.z for cell in built)
    bar = {cell.x for cell in built if cell.z == top}
    (column,) = {cell.x for cell in built if cell.z < top}
    assert len(bar) == 3
    assert column == sorted(bar)[1]


@pytest.mark.soak
def test_a_table_with_one_leg(idle: RunningCell, tmp_path: Path) -> None:
    built = build(idle, "assemble me a table with one leg", tmp_path)
    assert legs(built) == 1
    assert sum(1 for cell in built if cell.z == max(c.z for c in built)) >= 9


def refused(cell: RunningCell, name: str, wav: bytes) -> str:
    """Let the cell hear something that it should not build; returns what it says to it."""
    before = cell.truth()
    cell.visitor.hear(name, wav)
    job = cell.finish()
    assert job.outcome == "no_object", job
    after = cell.truth()
    assert after.built == ()
    assert after.robot["joints_rad"] == before.robot["joints_rad"]
    return job.message


def test_create_beauty_is_asked_to_be_restated(idle: RunningCell, tmp_path: Path) -> None:
    message = refused(idle, *spoken("create beauty", tmp_path))
    assert "beauty" in message
    assert "stool" in message


def test_an_unreadable_recording(idle: RunningCell) -> None:
    idle.visitor.hear("broken.wav", b"RIFF and then nothing that is sound")
    job = idle.finish()
    assert job.outcome == "unreadable"
    assert "wav" in job.message.lower()


def test_a_silent_recording(idle: RunningCell, tmp_path: Path) -> None:
    path = tmp_path / "silence.wav"
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, 16_000, 0, "NONE", ""))
        file.writeframes(np.zeros(32_000, dtype=np.int16).tobytes())
    message = refused(idle, path.name, path.read_bytes())
    assert "heard nothing" in message


def test_stop_is_heard_while_building(idle: RunningCell, tmp_path: Path) -> None:
    stop = spoken("stop", tmp_path)
    idle.client.build("block.json", bar(3, 3, 2))  # which takes longer than hearing a word
    idle.wait_state("assembling_placing")
    idle.visitor.hear(*stop)
    snapshot = idle.wait_state("paused_resting")
    assert not snapshot.arm.moving
    idle.client.command("resume")
    assert idle.finish().outcome == "built"
    idle.assert_as_planned()


def test_status_messages_follow_their_schemas(idle: RunningCell) -> None:
    idle.client.say("create beauty")
    idle.finish()
    numbers = [message.seq for message in idle.seen]
    assert numbers == sorted(set(numbers))
    for message in idle.seen:
        assert json.loads(message.payload().model_dump_json()) == json.loads(
            json.dumps(message.data)
        )
