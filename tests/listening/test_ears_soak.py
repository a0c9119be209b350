"""Half an hour of babble, music and noise, and a day of it in wake-word mode: nothing begins."""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

from cellctl.config import HearingSection
from cellctl.listening.ears.child import make_pipeline
from cellctl.listening.ears.events import Segment, WakeWordHeard
from cellctl.listening.wav import read_wav
from cellctl.sim import sounds
from cellctl.sim.sounds import Samples

pytestmark = pytest.mark.soak

PIECE_S = 60.0
SETTINGS = HearingSection(microphone="", activation="wake_word")


def begun(seeds: range, folder: Path) -> list[str]:
    """What an hour, or how long it may be, of disturbances begins: a line for each."""
    sentences = [read_wav(path, 60.0) for path in sorted(folder.glob("speech/*/*.wav"))]
    pipeline, found = make_pipeline(SETTINGS), []
    for seed in seeds:
        for event in pipeline.feed(disturbance(sentences, seed).tobytes()):
            at = f"seed {seed}, {pipeline.now_s:.1f} s"
            if isinstance(event, WakeWordHeard):
                found.append(f"{at}: {event.word}")
            elif isinstance(event, Segment) and event.after:
                found.append(f"{at}: a request after {event.after}")
    return found


def disturbance(sentences: list[Samples], seed: int) -> Samples:
    """A minute of one kind after the other."""
    match seed % 3:
        case 0:
            return sounds.babble(sentences, PIECE_S, seed, voices=1 + seed % 5)
        case 1:
            return sounds.music(PIECE_S, seed)
        case _:
            return sounds.noise(PIECE_S, seed)


def test_half_an_hour_of_disturbance_begins_nothing(test_data: Path) -> None:
    assert begun(range(30), test_data) == []


@pytest.mark.timeout(10_800)
def test_a_day_of_disturbance_begins_nothing(test_data: Path) -> None:
    """24 hours of sound; some 0.05 s of processor for each second."""
    minutes, workers = 24 * 60, os.cpu_count() or 1
    share = -(-minutes // workers)
    shares = [range(n * share, min((n + 1) * share, minutes)) for n in range(workers)]
    # Not forked: the networks have threads, which a fork would leave half alive.
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        found = [line for lines in pool.map(begun, shares, [test_data] * workers) for line in lines]
    print(f"{minutes / 60:.0f} h: {len(found)} false beginnings")  # noqa: T201
    assert found == []
