"""How well requests are understood: ``python -m benchmarks.requests [--verbose]``.

Reads six sets and prints how often the embedded back end is right, how long it takes for a
sentence, and what memory the process has:

- ``$CELLCTL_TEST_DATA/requests/dev.jsonl``: sentences with gold answers, by split; the decision
  (object or none), the phrase, the intent, the count, the attributes and the sizes.
- ``sentences/everyday_*.txt``: what people say to assistants and to each other, and no request.
- ``sentences/wishes.txt``: plain wishes for objects, each with the phrases that are right for it.

- ``sentences/unseen_*.txt``: sentences of every kind with intent and right phrases.
- ``sentences/visitors_*.jsonl``: what families, carpenters, children, teachers and people whose
  English is not their first say and how recognisers hear it, with gold answers.
- ``sentences/chatter.txt``: what visitors say to each other, each with a thing in it.

Every second wish and everyday sentence ("held out") was left unseen until the rules stood.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import sys
import time
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from cellctl.assembly import Edit, Intent, Request
from cellctl.listening.understanding.embedded import EmbeddedInterpreter
from cellctl.listening.understanding.interpreter import DEFAULT_SETTING

_AXES = {"length": "width", "x": "width", "y": "depth", "z": "height"}
_TOLERANCE_M = 0.005
ASPECTS = ("decision", "phrase", "intent", "count", "attributes", "sizes")
SENTENCES = Path(__file__).parent / "sentences"
_INTERPRETER = EmbeddedInterpreter()
_times_s: list[float] = []
_cpu_s: list[float] = []


def understand(text: str) -> Request:
    """What the embedded back end makes of it; its time is kept."""
    start_s, start_cpu_s = time.perf_counter(), time.thread_time()
    request = _INTERPRETER.interpret(text, DEFAULT_SETTING)
    _times_s.append(time.perf_counter() - start_s)
    _cpu_s.append(time.thread_time() - start_cpu_s)
    return request


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
        "intent": intent in gold["intent"].split("/"),
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


def everyday(verbose: bool) -> None:
    """How many sentences that ask for nothing are taken for a wish."""
    taken: Counter[str] = Counter()
    total: Counter[str] = Counter()
    for index, text in enumerate(_lines("everyday_*.txt")):
        half = ("seen", "held out")[index % 2]
        total[half] += 1
        request = understand(text)
        if request.intent is Intent.DESIGN:
            taken[half] += 1
            if verbose:
                sys.stdout.write(f"{text!r}: taken for a wish for {request.phrase!r}\n")
    for half in total:
        share = 100 * taken[half] / total[half]
        sys.stdout.write(f"no request, {half}: {taken[half]}/{total[half]} taken for one, ")
        sys.stdout.write(f"{share:.1f} %\n")


def wishes(verbose: bool) -> None:
    """How many plain wishes are missed, and of how many the phrase is right."""
    missed: Counter[str] = Counter()
    right: Counter[str] = Counter()
    total: Counter[str] = Counter()
    for index, line in enumerate(_lines("wishes.txt")):
        half = ("seen", "held out")[index % 2]
        text, _, gold = (part.strip() for part in line.partition("|"))
        total[half] += 1
        request = understand(text)
        missed[half] += request.intent is not Intent.DESIGN
        right[half] += request.phrase in gold.split("/")
        if verbose and request.phrase not in gold.split("/"):
            sys.stdout.write(f"{text!r}: {request.phrase!r}, not {gold!r}\n")
    for half, number in total.items():
        sys.stdout.write(f"wishes, {half}: {missed[half]}/{number} missed, ")
        sys.stdout.write(f"{100 * missed[half] / number:.1f} %; ")
        sys.stdout.write(f"phrase right {100 * right[half] / number:.1f} %\n")


def unseen(verbose: bool) -> None:
    """Sets of sentences of every kind, their gold answers written before any of them was tried."""
    for path in sorted(SENTENCES.glob("unseen_*.txt")):
        right: Counter[str] = Counter()
        lines = _lines(path.name)
        for line in lines:
            text, intent, phrases = (part.strip() for part in line.split("|"))
            request = understand(text)
            gold = {"phrase": phrases.split("/"), "intent": intent, "count": request.count}
            verdict = judge(gold, request)
            right.update(aspect for aspect, good in verdict.items() if good)
            if verbose and not all(verdict.values()):
                sys.stdout.write(
                    f"{text!r}: {request.intent.value}, {request.phrase!r}; "
                    f"not {intent}, {phrases}; {request.why}\n"
                )
        figures = ", ".join(
            f"{aspect} {100 * right[aspect] / len(lines):.0f} %"
            for aspect in ("decision", "phrase", "intent")
        )
        sys.stdout.write(f"{path.stem}, {len(lines)} of every kind: {figures}\n")


def visitors(verbose: bool) -> None:
    """Each set of visitors' sentences with gold answers, and the chatter that wants nothing."""
    for path in sorted(SENTENCES.glob("visitors_*.jsonl")):
        right: Counter[str] = Counter()
        total: Counter[str] = Counter()
        for line in path.read_text(encoding="utf-8").splitlines():
            gold = json.loads(line)
            request = understand(gold["text"])
            verdict = judge(gold, request)
            if "edit" in gold:
                verdict["edit"] = any(_is_edit(edit, gold["edit"]) for edit in request.edits)
            total.update(verdict.keys())
            right.update(aspect for aspect, good in verdict.items() if good)
            if verbose and not all(verdict.values()):
                misses = ", ".join(aspect for aspect, good in verdict.items() if not good)
                found = f"{request.intent.value}, {request.phrase!r}; {request.why}"
                sys.stdout.write(f"{gold['text']!r}: {misses} wrong: {found}\n")
        figures = ", ".join(f"{a} {100 * right[a] / total[a]:.0f} %" for a in total)
        sys.stdout.write(f"{path.stem}, {total['intent']}: {figures}\n")
    chatter = _lines("chatter.txt")
    taken = [text for text in chatter if understand(text).intent is Intent.DESIGN]
    sys.stdout.write(f"chatter: {len(taken)}/{len(chatter)} taken for a wish\n")
    if verbose:
        sys.stdout.write("".join(f"{text!r}: taken for a wish\n" for text in taken))


def _is_edit(edit: Edit, gold: dict[str, str]) -> bool:
    """Whether an edit is what the gold answer says of it; ``length`` is along the longer side."""
    found: dict[str, set[str | None]] = {
        "op": {edit.op},
        "part": {edit.part, edit.attribute, f"{edit.part}s"},
        "axis": {edit.axis, "width" if edit.axis == "length" else edit.axis},
        "dir": {edit.direction},
    }
    return all(value in found[key] for key, value in gold.items())


def _lines(pattern: str) -> list[str]:
    texts = [path.read_text(encoding="utf-8") for path in sorted(SENTENCES.glob(pattern))]
    return [line.strip() for text in texts for line in text.splitlines() if line.strip()]


def gold_answers(folder: Path, verbose: bool) -> None:
    """The table of splits and aspects."""
    right: dict[str, Counter[str]] = defaultdict(Counter)
    total: dict[str, Counter[str]] = defaultdict(Counter)
    for gold in load(folder):
        request = understand(gold["text"])
        verdict = judge(gold, request)
        for split in (gold["split"], "all"):
            total[split].update(verdict.keys())
            right[split].update(aspect for aspect, good in verdict.items() if good)
        if verbose and not all(verdict.values()):
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


def main() -> int:
    """Measure and print; exit status 2 without the gold answers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--verbose", action="store_true", help="print every miss")
    options = parser.parse_args()
    folder = os.environ.get("CELLCTL_TEST_DATA")
    if not folder:
        sys.stderr.write("CELLCTL_TEST_DATA does not name the folder with the evaluation data.\n")
        return 2
    understand("a stool")
    first_s, _ = _times_s.pop(), _cpu_s.pop()
    gold_answers(Path(folder), options.verbose)
    everyday(options.verbose)
    wishes(options.verbose)
    unseen(options.verbose)
    visitors(options.verbose)
    ordered = sorted(_times_s)
    sys.stdout.write(
        f"{len(ordered)} sentences: median {1e3 * statistics.median(ordered):.2f} ms, "
        f"p95 {1e3 * ordered[int(0.95 * len(ordered))]:.2f} ms "
        f"({1e3 * sorted(_cpu_s)[int(0.95 * len(ordered))]:.2f} ms of processor time), "
        f"longest {1e3 * ordered[-1]:.1f} ms; "
        f"the first of all, which reads the tables, {1e3 * first_s:.0f} ms\n"
    )
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    sys.stdout.write(f"memory of this process at most {peak_mb:.0f} MB\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
