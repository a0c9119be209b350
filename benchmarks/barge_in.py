"""How well an answer is heard while the cell still speaks: ``python -m benchmarks.barge_in``.

Mixes fifty answers in several voices over the cell's own question, at several levels of its echo,
feeds the ears' pipeline and the recogniser that a cell in English gets, and prints the share that
is taken for what it is, for the opposite, or for an unclear sentence; and what the echo alone, and
talk that answers nothing, are taken for. All voices are synthetic and without a room.
"""

from __future__ import annotations

import argparse
import itertools
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from benchmarks.ears import say
from cellctl.config import HearingSection
from cellctl.listening.ears.detectors import SileroDetector
from cellctl.listening.ears.events import OWN_VOICE_STEP_S, Heard, Segment
from cellctl.listening.ears.pipeline import Pipeline
from cellctl.listening.ears.words import overheard_command
from cellctl.listening.own_words import of_others
from cellctl.listening.recogniser import SAMPLE_RATE_HZ
from cellctl.listening.transcription import load, transcribe_pcm
from cellctl.sim import sounds
from cellctl.sim.sounds import Samples

QUESTION = "A stool with four legs, thirty parts, about three minutes. Shall I build it?"
ANSWERS = {"yes": "yes", "yes please": "yes", "yes build it": "yes", "no": "no", "no thanks": "no"}
TALK = ("less", "I know", "who is that", "chess", "look at it", "so", "guess what", "you know")
VOICES = ("en-us", "en-gb", "en-us+f2", "en-us+f4", "en-gb+m5")
MOMENTS_S = (1.4, 3.1)
ECHOES_DB = (-40.0, -20.0, -12.0, -6.0)
DELAY_S = 0.15
"""From the moment that a sound is said to be played to when it is heard."""


class Room:
    """A microphone that hears the cell ask, and somebody talk over it; every sentence counts.

    Args:
        echo_db: how loud the cell is heard, against how loud it plays.
        question: what it asks.
    """

    def __init__(self, echo_db: float, question: Samples) -> None:
        self._gain = 10.0 ** (echo_db / 20.0)
        self._question = question
        self._pipeline = Pipeline(SileroDetector(), open_to_all=True)
        self._feed(sounds.noise(2.0, 1, 0.0006))
        self.asks(None, 0.0)  # it learns how loud the echo is

    def asks(self, person: Samples | None, at_s: float) -> list[Segment]:
        """What is heard while the question is asked."""
        question = self._question
        self._pipeline.own_voice_began(self._pipeline.now_s, _levels(question), False)
        length_s = len(question) / SAMPLE_RATE_HZ + 1.2
        sound = sounds.noise(length_s, 2, 0.0006).astype(np.float64)
        start = round(DELAY_S * SAMPLE_RATE_HZ)
        sound[start : start + len(question)] += self._gain * question
        if person is not None:
            start = round(at_s * SAMPLE_RATE_HZ)
            sound[start : start + len(person)] += person[: len(sound) - start]
        heard = self._feed(np.clip(sound, -32_768, 32_767).astype(np.int16))
        return [event for event in heard if isinstance(event, Segment)]

    def _feed(self, sound: Samples) -> list[Heard]:
        return list(self._pipeline.feed(sound.tobytes()))


def _levels(sound: Samples) -> tuple[float, ...]:
    step = round(OWN_VOICE_STEP_S * SAMPLE_RATE_HZ)
    whole = sound[: len(sound) // step * step].astype(np.float64).reshape(-1, step)
    return tuple(float(level) for level in np.sqrt(np.square(whole).mean(axis=1)))


def taken(settings: HearingSection, found: list[Segment], told: list[str]) -> str:
    """What the cell takes the utterances for: ``yes``, ``no``, another command, ``unclear``, or
    nothing; everything recognised is added to ``told``."""
    outcome = "nothing"
    for segment in found:
        text = transcribe_pcm(settings, segment.pcm).text
        told.append(text)
        command = overheard_command(text)
        others = of_others(text, QUESTION, command=command is not None)
        word = overheard_command(others)
        if word is not None:
            return word
        outcome = "unclear" if others else outcome
    return outcome


def main() -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", action="store_true", help="print each answer that is missed")
    parser.add_argument("--echo-db", type=float, nargs="*", default=ECHOES_DB)
    arguments = parser.parse_args()
    if shutil.which("espeak-ng") is None:
        sys.exit("espeak-ng is needed for the voices.")
    settings = HearingSection()
    _print(f"recogniser: {load(settings)}")
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        question = say(QUESTION, "hibari", folder)
        said = [
            (text, voice, at_s, say(text, voice, folder))
            for text, voice, at_s in itertools.product(ANSWERS, VOICES, MOMENTS_S)
        ]
        talk = [say(text, voice, folder) for text in TALK for voice in VOICES[:3]]
    for echo_db in arguments.echo_db:
        room = Room(echo_db, question)
        counts: Counter[str] = Counter()
        for text, voice, at_s, sound in said:
            told: list[str] = []
            found = taken(settings, room.asks(sound, at_s), told)
            right = found == ANSWERS[text]
            counts["right" if right else "opposite" if found in {"yes", "no"} else found] += 1
            if arguments.every and not right:
                _print(f"  {text!r} by {voice} at {at_s} s: {found} {told}")
        _print(f"echo {echo_db:.0f} dB: {counts['right']} of {len(said)} right, {dict(counts)}")
        others: Counter[str] = Counter()
        for number, sound in enumerate(talk):
            told = []
            found = taken(settings, room.asks(sound, MOMENTS_S[number % 2]), told)
            others[found] += 1
            if arguments.every and found in {"yes", "no"}:
                _print(f"  talk taken for {found}: {told}")
        alone = Counter(taken(settings, room.asks(None, 0.0), []) for _ in range(5))
        _print(f"  {len(talk)} other words taken for {dict(others)}; echo alone {dict(alone)}")
    return 0


def _print(text: str) -> None:
    print(text, flush=True)  # noqa: T201 - a benchmark prints its figures


if __name__ == "__main__":
    sys.exit(main())
