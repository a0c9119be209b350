"""How well speech is heard: ``python -m benchmarks.speech [--voices N] [--sentences N]``.

Reads ``$CELLCTL_TEST_DATA/speech`` (one folder of wav files for each voice, and ``sentences.json``
that says what is said) with the recogniser that a cell in English gets, and prints for each voice:
the word error rate, how many sentences end in the request that the spoken text would have given
(intent, phrase, attributes, command), and the recognition time. The voices are synthetic and
without a room: expect worse from a far microphone.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from cellctl.assembly import Request
from cellctl.config import HearingSection
from cellctl.listening.models import open_recogniser
from cellctl.listening.recogniser import Recogniser
from cellctl.listening.request import read_request, tokens
from cellctl.listening.wav import duration_s, read_wav

_MAX_AUDIO_S = 30.0


@dataclass
class Score:
    """What one voice came to."""

    words: int = 0
    errors: int = 0
    sentences: int = 0
    understood: int = 0
    audio_s: float = 0.0
    cpu_s: float = 0.0
    latencies_s: list[float] = field(default_factory=list)

    def row(self, name: str) -> str:
        """One line of the table."""
        p95_s = sorted(self.latencies_s)[int(0.95 * len(self.latencies_s))]
        understood = f"{self.understood}/{self.sentences}"
        return (
            f"{name:<16}{100 * self.errors / self.words:>8.1f} %{understood:>12}"
            f"{statistics.median(self.latencies_s):>12.2f}{p95_s:>10.2f}"
            f"{self.cpu_s / self.audio_s:>14.2f}\n"
        )


def word_errors(said: list[str], heard: list[str]) -> int:
    """Least number of words to insert, delete or replace (Levenshtein)."""
    previous = list(range(len(heard) + 1))
    for row, word in enumerate(said, start=1):
        current = [row]
        for column, other in enumerate(heard, start=1):
            replaced = previous[column - 1] + (word != other)
            current.append(min(replaced, previous[column] + 1, current[-1] + 1))
        previous = current
    return previous[-1]


def same_request(one: Request, other: Request) -> bool:
    """Whether the cell would do the same for both."""
    return all(
        getattr(one, name) == getattr(other, name)
        for name in ("intent", "phrase", "objects", "count", "attributes", "command")
    )


def measure(
    recogniser: Recogniser, folder: Path, sentences: list[dict[str, str]], *, verbose: bool
) -> Score:
    """Hear one voice say the sentences."""
    score = Score()
    for sentence in sentences:
        samples = read_wav(folder / sentence["file"], _MAX_AUDIO_S)
        start_s, start_cpu_s = time.perf_counter(), time.process_time()
        heard = recogniser.transcribe(samples).text
        score.latencies_s.append(time.perf_counter() - start_s)
        score.cpu_s += time.process_time() - start_cpu_s
        score.audio_s += duration_s(samples)
        said = sentence["text"]
        score.words += len(tokens(said))
        score.errors += word_errors(tokens(said), tokens(heard))
        score.sentences += 1
        understood = same_request(read_request(said), read_request(heard))
        score.understood += understood
        if verbose and not understood:
            sys.stdout.write(f"  {said!r} was heard as {heard!r}\n")
    return score


def main() -> int:
    """Measure and print; exit status 2 without data."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--voices", type=int, default=None, help="only the first N voices")
    parser.add_argument("--sentences", type=int, default=None, help="only the first N sentences")
    parser.add_argument("--verbose", action="store_true", help="print what was misunderstood")
    options = parser.parse_args()
    data = os.environ.get("CELLCTL_TEST_DATA")
    if not data:
        sys.stderr.write("CELLCTL_TEST_DATA does not name the folder with the evaluation data.\n")
        return 2
    speech = Path(data) / "speech"
    listed = (speech / "sentences.json").read_text(encoding="utf-8")
    sentences: list[dict[str, str]] = json.loads(listed)[: options.sentences]
    recogniser = open_recogniser(HearingSection())
    sys.stdout.write(
        f"{recogniser.name}\n{'voice':<16}{'word errors':>10}{'requests':>11}"
        f"{'median s':>12}{'p95 s':>10}{'CPU s/audio s':>14}\n"
    )
    for folder in sorted(path for path in speech.iterdir() if path.is_dir())[: options.voices]:
        score = measure(recogniser, folder, sentences, verbose=options.verbose)
        sys.stdout.write(score.row(folder.name))
    return 0


if __name__ == "__main__":
    sys.exit(main())
