"""How well speech is understood: ``python -m benchmarks.speech [--voices N] [--sentences N]``.

Reads ``$CELLCTL_TEST_DATA/speech`` (one folder of wav files for each voice, and ``sentences.json``
that says what is said) with the recogniser that a cell in English gets, and the interpreter behind
it. Prints for each voice: the word error rate, in how many sentences intent and object are those of
``speech_gold.toml``, in how many of these what was said of the object is right as well (legs,
tiers, the letter), and the recognition time; at the end what a misunderstanding may do: how many
became a thing that nobody asked for, which the cell reads back and asks about, and how many became
a "yes", which nothing would stop. The voices are synthetic and without a room: expect worse from a
far microphone.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import time
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cellctl.assembly import Request
from cellctl.config import HearingSection
from cellctl.listening.models import open_recogniser
from cellctl.listening.recogniser import Recogniser
from cellctl.listening.request import read_request, tokens
from cellctl.listening.wav import duration_s, read_wav

_MAX_AUDIO_S = 30.0
GOLD = Path(__file__).parent / "speech_gold.toml"


@dataclass
class Score:
    """What one voice came to."""

    words: int = 0
    errors: int = 0
    sentences: int = 0
    understood: int = 0
    exact: int = 0
    false_wishes: int = 0
    false_yes: int = 0
    audio_s: float = 0.0
    cpu_s: float = 0.0
    latencies_s: list[float] = field(default_factory=list)

    def row(self, name: str) -> str:
        """One line of the table."""
        p95_s = sorted(self.latencies_s)[int(0.95 * len(self.latencies_s))]
        understood = f"{self.understood}/{self.sentences}"
        exact = f"{self.exact}/{self.sentences}"
        return (
            f"{name:<16}{100 * self.errors / self.words:>8.1f} %{understood:>12}{exact:>10}"
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


def right(gold: dict[str, Any], request: Request) -> bool:
    """Whether intent and object are what was asked for."""
    if request.intent.value != gold["intent"] or request.command != gold.get("command"):
        return False
    if "edit" in gold:
        edits = [(edit.op, edit.axis, edit.direction) for edit in request.edits]
        return edits == [tuple(gold["edit"])]
    return request.objects == ((gold["object"],) if "object" in gold else ())


def measure(
    recogniser: Recogniser,
    folder: Path,
    sentences: list[dict[str, str]],
    gold: dict[str, dict[str, Any]],
    *,
    verbose: bool,
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
        wanted = gold[Path(sentence["file"]).stem]
        request = read_request(heard)
        if right(wanted, request):
            score.understood += 1
            score.exact += request.attributes == wanted.get("attributes", {})
            continue
        score.false_wishes += request.buildable
        score.false_yes += request.command == "yes"
        if verbose:
            sys.stdout.write(
                f"  {said!r} was heard as {heard!r}: {request.intent.value} "
                f"{request.phrase if request.buildable else request.command or ''}\n"
            )
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
    gold = tomllib.loads(GOLD.read_text(encoding="utf-8"))["gold"]
    sys.stdout.write(
        f"{recogniser.name}\n{'voice':<16}{'word errors':>10}{'right':>11}{'exact':>10}"
        f"{'median s':>12}{'p95 s':>10}{'CPU s/audio s':>14}\n"
    )
    scores = []
    for folder in sorted(path for path in speech.iterdir() if path.is_dir())[: options.voices]:
        scores.append(measure(recogniser, folder, sentences, gold, verbose=options.verbose))
        sys.stdout.write(scores[-1].row(folder.name))
        sys.stdout.flush()
    total, understood = sum(s.sentences for s in scores), sum(s.understood for s in scores)
    sys.stdout.write(
        f"all: {understood} of {total} right ({100 * understood / total:.1f} %), "
        f"{sum(s.exact for s in scores)} exact; of the others "
        f"{sum(s.false_wishes for s in scores)} became a thing that is asked about, "
        f"{sum(s.false_yes for s in scores)} a yes\n"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
