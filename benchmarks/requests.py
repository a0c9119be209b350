"""How well requests are understood: ``python -m benchmarks.requests [--verbose]``.

Reads ``$CELLCTL_TEST_DATA/requests/dev.jsonl`` (sentences with gold answers) and prints, for each
split, how often the decision (object or none), the phrase, the intent, the count, the attributes
and the sizes are right.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from cellctl.assembly import Intent, Request
from cellctl.listening.request import read_request

_AXES = {"length": "width", "x": "width", "y": "depth", "z": "height"}
_TOLERANCE_M = 0.005
ASPECTS = ("decision", "phrase", "intent", "count", "attributes", "sizes")


def load(folder: Path) -> list[dict[str, Any]]:
    """The sentences with their gold answers."""
    lines = (folder / "requests" / "dev.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines if line.strip()]


def judge(gold: dict[str, Any], request: Request) -> dict[str, bool]:
    """Whether each aspect that the gold answer speaks of is right."""
    named = request.phrase != "false"
    # In the gold answers a plain question is simply no request.
    intent = "none" if request.intent is Intent.QUERY else request.intent.value
    verdict = {
        "decision": any((phrase != "false") == named for phrase in gold["phrase"]),
        "phrase": request.phrase in gold["phrase"],
        "intent": intent == gold["intent"],
    }
    if gold["intent"] == "design":
        verdict["count"] = request.count == gold["count"]
    if "attrs" in gold:
        verdict["attributes"] = all(
            request.attributes.get(name) == value for name, value in gold["attrs"].items()
        )
    if "dims" in gold:
        wanted = {_AXES.get(axis, axis): cm / 100.0 for axis, cm in gold["dims"].items()}
        found: dict[str, float] = {str(axis): size for axis, size in request.dimensions_m.items()}
        verdict["sizes"] = wanted.keys() == found.keys() and all(
            abs(found[axis] - size) < _TOLERANCE_M for axis, size in wanted.items()
        )
    return verdict


def main() -> int:
    """Measure and print; exit status 2 without data."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--verbose", action="store_true", help="print every miss")
    options = parser.parse_args()
    folder = os.environ.get("CELLCTL_TEST_DATA")
    if not folder:
        sys.stderr.write("CELLCTL_TEST_DATA does not name the folder with the evaluation data.\n")
        return 2
    right: dict[str, Counter[str]] = defaultdict(Counter)
    total: dict[str, Counter[str]] = defaultdict(Counter)
    times_s = []
    for gold in load(Path(folder)):
        start_s = time.perf_counter()
        request = read_request(gold["text"])
        times_s.append(time.perf_counter() - start_s)
        verdict = judge(gold, request)
        for split in (gold["split"], "all"):
            total[split].update(verdict.keys())
            right[split].update(aspect for aspect, good in verdict.items() if good)
        if options.verbose and not all(verdict.values()):
            misses = ", ".join(aspect for aspect, good in verdict.items() if not good)
            sys.stdout.write(
                f"{gold['text']!r}: {misses} wrong: {request.intent}, {request.phrase!r}, "
                f"{request.count}, {request.attributes}, {request.dimensions_m}\n"
            )
    sys.stdout.write(f"{'split':<8}" + "".join(f"{aspect:>18}" for aspect in ASPECTS) + "\n")
    for split in total:
        cells = (
            f"{right[split][a]}/{total[split][a]} {100 * right[split][a] / total[split][a]:5.1f} %"
            if total[split][a]
            else "-"
            for a in ASPECTS
        )
        sys.stdout.write(f"{split:<8}" + "".join(f"{cell:>18}" for cell in cells) + "\n")
    ordered = sorted(times_s)
    p95_ms = 1e3 * ordered[int(0.95 * len(ordered))]
    sys.stdout.write(f"{len(times_s)} sentences, p95 {p95_ms:.2f} ms each\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
