from __future__ import annotations

import asyncio
import os
import signal
from pathlib import Path

import numpy as np
import psutil
import pytest
from scipy.io import wavfile

from cellctl.config import HearingSection
from cellctl.errors import HearingError
from cellctl.listening.hearing import MAX_TEXT_CHARACTERS, Hearing
from cellctl.listening.request import read_request
from tests.listening.conftest import Speak


def test_a_wav_file_is_heard_and_nothing_is_left_behind(no_models: Path, speak: Speak) -> None:
    async def scenario() -> None:
        async with Hearing(HearingSection(model_folder=str(no_models))) as hearing:
            assert await hearing.warm_up() == "whisper tiny.en"
            pid = hearing.worker_pid
            assert pid is not None
            listening = asyncio.create_task(hearing.hear_wav(speak("I want a simple stool")))
            turns = 0
            while not listening.done():
                await asyncio.sleep(0.01)
                turns += 1
            assert turns >= 5, "the loop stood still while the model listened"
            utterance = await listening
            assert utterance.source == "wav"
            assert utterance.recogniser == "whisper tiny.en"
            assert 0.5 < utterance.audio_s < 5.0
            assert read_request(utterance.text).phrase == "simple stool"
            assert hearing.worker_pid == pid, "the model stays loaded"
        assert not psutil.pid_exists(pid)
        await hearing.close()

    asyncio.run(scenario())


def test_silence_is_heard_as_nothing_without_a_model(no_models: Path, silent_wav: Path) -> None:
    async def scenario() -> None:
        # A model path that cannot be loaded proves that none was asked for.
        settings = HearingSection(model_path=str(no_models / "none"), model_folder=str(no_models))
        async with Hearing(settings) as hearing:
            utterance = await hearing.hear_wav(silent_wav)
            assert utterance.text == ""
            assert utterance.audio_s == 2.0
            assert read_request(utterance.text).reason == "I heard nothing."
            with pytest.raises(HearingError, match=r"hearing\.model_path"):
                await hearing.warm_up()

    asyncio.run(scenario())


def test_an_unreadable_file_is_refused_and_the_next_one_heard(
    no_models: Path, tmp_path: Path, silent_wav: Path
) -> None:
    async def scenario() -> None:
        unreadable = tmp_path / "unreadable.wav"
        unreadable.write_bytes(b"not sound at all")
        async with Hearing(HearingSection(model_folder=str(no_models))) as hearing:
            with pytest.raises(HearingError, match="not a wav file") as caught:
                await hearing.hear_wav(unreadable)
            assert caught.value.hint
            assert (await hearing.hear_wav(silent_wav)).audio_s == 2.0

    asyncio.run(scenario())


def test_a_recogniser_killed_in_the_middle_is_started_again(
    no_models: Path, tmp_path: Path, speak: Speak
) -> None:
    long_wav = tmp_path / "long.wav"
    noise = np.random.default_rng(1).normal(0.0, 3000.0, 16_000 * 25).astype(np.int16)
    wavfile.write(long_wav, 16_000, noise)

    async def scenario() -> None:
        async with Hearing(HearingSection(model_folder=str(no_models))) as hearing:
            await hearing.warm_up()
            first = hearing.worker_pid
            assert first is not None
            listening = asyncio.create_task(hearing.hear_wav(long_wav))
            busy = psutil.Process(first)
            used_s = busy.cpu_times().user
            async with asyncio.timeout(20.0):
                # Only the process itself knows that it has begun.
                while busy.cpu_times().user < used_s + 0.1:  # noqa: ASYNC110
                    await asyncio.sleep(0.01)
            os.kill(first, signal.SIGKILL)
            with pytest.raises(HearingError, match="could not be recognised") as caught:
                await listening
            assert "again" in caught.value.hint
            utterance = await hearing.hear_wav(speak("the letter T"))
            assert read_request(utterance.text).phrase == "letter t"
            second = hearing.worker_pid
            assert second is not None
            assert second != first
        assert not psutil.pid_exists(first)
        assert not psutil.pid_exists(second)

    asyncio.run(scenario())


def test_text_is_taken_as_if_spoken() -> None:
    hearing = Hearing(HearingSection())
    utterance = hearing.hear_text("  I want\ta simple  stool\n")
    assert utterance.text == "I want a simple stool"
    assert utterance.source == "text"
    with pytest.raises(HearingError, match=str(MAX_TEXT_CHARACTERS)):
        hearing.hear_text("a" * (MAX_TEXT_CHARACTERS + 1))
