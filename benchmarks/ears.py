"""How well the ears hear: ``python -m benchmarks.ears [--minutes N]``.

Feeds the ears' pipeline and the recogniser that a cell in English gets, faster than real time, and
prints: the share of stop words heard, clean and over babble; wake words heard; and what babble,
music-like sound and noise are mistaken for. Voices: the packaged one and espeak-ng's. Babble is
made of the recordings in ``$CELLCTL_TEST_DATA/speech`` that are no commands, else of those voices.
All of them are synthetic and without a room: expect worse from a far microphone.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cellctl.config import HearingSection
from cellctl.listening.commands import spoken_command
from cellctl.listening.ears.detectors import MicroWakeWordDetector, SileroDetector
from cellctl.listening.ears.events import Segment, WakeWordHeard
from cellctl.listening.ears.pipeline import Pipeline
from cellctl.listening.ears.words import overheard_command
from cellctl.listening.transcription import load, says_stop, transcribe_pcm
from cellctl.listening.wav import read_wav
from cellctl.sim import sounds
from cellctl.sim.sounds import Samples
from cellctl.speaking.voices import speak_to_wav

STOPS = ("stop", "stop stop", "stop it", "stop now", "halt", "please stop")
WAKE_WORDS = ("okay_nabu", "hey_jarvis", "hey_mycroft", "alexa")
ESPEAK_VOICES = ("en-us", "en-gb", "en-us+f2", "en-us+f4", "en-us+m3", "en-gb+m5")
TALK = ("I like this one", "where is the coffee", "it moves quite fast", "how does that work")
_PIECE_S = 20.0


def say(text: str, voice: str, folder: Path) -> Samples:
    """A sentence in one voice, without the silence around it."""
    path = folder / "said.wav"
    if voice == "hibari":
        speak_to_wav(text, path)
    else:
        command = ["espeak-ng", "-v", voice, "-w", str(path), text]
        subprocess.run(command, check=True, timeout=30.0)  # noqa: S603 - fixed words
    samples = read_wav(path, 60.0)
    loud = np.flatnonzero(np.abs(samples.astype(np.int32)) > 300)
    return samples[loud[0] : loud[-1] + 1]


def talk(folder: Path, voices: list[str]) -> list[Samples]:
    """What people in the room say."""
    data = os.environ.get("CELLCTL_TEST_DATA")
    if data:
        said = json.loads(Path(data, "speech", "sentences.json").read_text(encoding="utf-8"))
        names = {each["file"] for each in said if spoken_command(each["text"]) is None}
        paths = sorted(Path(data, "speech").glob("*/*.wav"))
        return [read_wav(path, 60.0) for path in paths if path.name in names]
    return [say(text, voice, folder) for text in TALK for voice in voices]


def pipeline(wake_word: str | None = None) -> Pipeline:
    """As while a job is under way."""
    detector = MicroWakeWordDetector(wake_word) if wake_word is not None else None
    made = Pipeline(SileroDetector(), detector)
    made.expecting = "command"
    return made


def command(settings: HearingSection, segment: Segment) -> str | None:
    """What the cell makes of an utterance while a job is under way."""
    if says_stop(settings, segment.pcm):
        return "stop"
    return overheard_command(transcribe_pcm(settings, segment.pcm).text)


def stops(settings: HearingSection, folder: Path, voices: list[str]) -> None:
    """Share of stop words heard."""
    people = talk(folder, voices)
    for name, ratio_db in (("clean", None), ("babble, 20 dB", 20.0), ("babble, 10 dB", 10.0)):
        said = heard = glanced = 0
        delays_s = []
        for number, (text, voice) in enumerate((t, v) for t in STOPS for v in voices):
            before = sounds.noise(8.0, number, 0.0006)
            after = sounds.noise(2.0, number, 0.0006)
            sound = np.concatenate([before, say(text, voice, folder), after])
            if ratio_db is not None:
                background = sounds.babble(people, len(sound) / 16_000 + 0.1, number)
                sound = sounds.mixed(sound, background, ratio_db)
            said += 1
            found = False
            for event in pipeline().feed(sound.tobytes()):
                if not isinstance(event, Segment) or found:
                    continue
                began_s = time.perf_counter()
                glance = says_stop(settings, event.pcm)
                if glance:
                    delays_s.append(time.perf_counter() - began_s)
                glanced += glance
                found = glance or command(settings, event) == "stop"
            heard += found
        delay = f", {statistics.median(delays_s):.2f} s each" if delays_s else ""
        _print(
            f"stop, {name}: {heard} of {said} heard ({100 * heard / said:.0f} %), "
            f"{glanced} at a glance{delay}"
        )


def wake_words(folder: Path, voices: list[str]) -> None:
    """Wake words heard, each in every voice."""
    for word in WAKE_WORDS:
        heard = 0
        for number, voice in enumerate(voices):
            quiet = sounds.noise(1.0, number, 0.0006)
            sound = np.concatenate([quiet, say(word.replace("_", " "), voice, folder), quiet])
            events = list(pipeline(word).feed(sound.tobytes()))
            heard += any(isinstance(event, WakeWordHeard) for event in events)
        _print(f"wake word {word}: {heard} of {len(voices)} heard")


def disturbances(people: list[Samples], minutes: float) -> dict[str, Iterator[Samples]]:
    """Sound that means nothing to the cell, in pieces."""
    seeds = range(max(1, round(minutes * 60.0 / _PIECE_S)))
    return {
        "babble": (sounds.babble(people, _PIECE_S, seed) for seed in seeds),
        "music": (sounds.music(_PIECE_S, seed) for seed in seeds),
        "noise": (sounds.noise(_PIECE_S, seed) for seed in seeds),
    }


def false_alarms(settings: HearingSection, people: list[Samples], minutes: float) -> None:
    """What disturbances are mistaken for, by the hour."""
    for name, pieces in disturbances(people, minutes).items():
        # One network for each word; the utterances come out of the first.
        ears = {word: pipeline(word) for word in WAKE_WORDS}
        woken = dict.fromkeys(WAKE_WORDS, 0)
        utterances = 0
        commands: dict[str, int] = {}
        hours, began_s = 0.0, time.process_time()
        for piece in pieces:
            hours += len(piece) / 16_000 / 3600.0
            for word, ear in ears.items():
                for event in ear.feed(piece.tobytes()):
                    woken[word] += isinstance(event, WakeWordHeard)
                    if word != WAKE_WORDS[0] or not isinstance(event, Segment):
                        continue
                    utterances += 1
                    if (found := command(settings, event)) is not None:
                        commands[found] = commands.get(found, 0) + 1
        cpu = (time.process_time() - began_s) / hours / 3600.0
        alarms = ", ".join(f"{n / hours:.1f} {word}" for word, n in commands.items()) or "none"
        wakes = ", ".join(f"{n} {word}" for word, n in woken.items() if n) or "none"
        _print(
            f"{name}, {60 * hours:.0f} min: {utterances} utterances; false commands an hour: "
            f"{alarms}; false wake words in all: {wakes}; {cpu:.2f} s of processor a second"
        )


def _print(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0, help="of each disturbance; or 0")
    arguments = parser.parse_args()
    voices = ["hibari", *(ESPEAK_VOICES if shutil.which("espeak-ng") else ())]
    settings = HearingSection()
    _print(f"recogniser: {load(settings)}; voices: {', '.join(voices)}")
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        wake_words(folder, voices)
        stops(settings, folder, voices)
        if arguments.minutes > 0.0:
            false_alarms(settings, talk(folder, voices), arguments.minutes)
    return 0


if __name__ == "__main__":
    sys.exit(main())
