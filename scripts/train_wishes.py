"""Find the weights by which a thing that a sentence mentions is taken for wished for.

    apt-get install wordnet-base
    PYTHONPATH=. python scripts/train_wishes.py

Sources, none of which is needed to run cellctl:

- the project's own sentences with their answers, ``benchmarks/sentences``, which say what is wished
  for and what is only mentioned. Every set in there is part of what the model knows: how well it
  does on sentences that it has not seen must be measured on a set that is not yet in there, or with
  ``--left-out``, which weighs each set by a model of all the others.
- WordNet 3.0's examples of use (Debian ``wordnet-base``): English prose, in which nobody asks for
  anything. Its licence stands in ``words.LICENSE``.

The model is a logistic regression with a quadratic penalty; ``understanding/likely.py`` has its
features and uses it.
"""

from __future__ import annotations

import argparse
import gzip
import json
import os
import re
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize
from scipy.sparse import csr_matrix

from cellctl.listening.frames import plain_words
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.phrases import repair
from cellctl.listening.request import tokens
from cellctl.listening.snapping import snap
from cellctl.listening.understanding.likely import SURE, Mention, features, mentions
from cellctl.listening.understanding.words import look_up

Array = npt.NDArray[np.float64]

_ROOT = Path(__file__).parent.parent
_SENTENCES = _ROOT / "benchmarks/sentences"
_TARGET = _ROOT / "cellctl/listening/understanding/wishes.json.gz"
_WORDNET = Path("/usr/share/wordnet")
_PROSE = "prose"
_PROSE_SENTENCES = 20_000
_LEAST_WORD, _LEAST_FEATURE, _LEAST_PROSE = 4, 2, 3
"""How often a word, a feature in our sentences, and a feature in all of them must occur."""
_PROSE_WEIGHT, _TALK_WEIGHT = 0.3, 3.0
"""Of a thing in prose, and of one that a visitor mentions without wishing for it."""
_PENALTY = 1.0
_NEGLIGIBLE = 0.03


@dataclass(frozen=True)
class Example:
    """A thing in a sentence, and whether it is wished for."""

    source: str
    text: str
    words: tuple[str, ...]
    mention: Mention
    wished: bool


def sentences() -> Iterator[tuple[str, str, str, list[str]]]:
    """Set, sentence, intent and right phrases of every sentence with an answer."""
    for path in sorted(_SENTENCES.iterdir()):
        for line in filter(None, map(str.strip, path.read_text(encoding="utf-8").splitlines())):
            if path.suffix == ".jsonl":
                gold = json.loads(line)
                yield path.stem, gold["text"], gold["intent"], gold["phrase"]
            elif path.stem == "wishes":
                text, _, phrases = line.partition("|")
                yield path.stem, text.strip(), "design", phrases.strip().split("/")
            elif "|" in line:
                text, intent, phrases = (part.strip() for part in line.split("|"))
                yield path.stem, text, intent.split("/")[0], phrases.split("/")
            else:
                yield path.stem, line, "none", ["false"]


def prose(folder: Path) -> Iterator[str]:
    """WordNet's examples of use, evenly over the whole of it."""
    found = [
        example
        for path in sorted(folder.glob("data.*"))
        for line in path.read_text(encoding="latin-1").splitlines()
        if "| " in line
        for example in re.findall(r'"([^"]{12,90})"', line.split("| ", 1)[1])
    ]
    yield from found[:: max(1, len(found) // _PROSE_SENTENCES)]


def examples(source: str, text: str, intent: str, phrases: list[str]) -> Iterator[Example]:
    """The things in one sentence of which it is known whether they are wished for."""
    if intent not in ("design", "none") or (intent == "none" and phrases != ["false"]):
        return
    words = tuple(plain_words(tuple(repair(snap(tokens(text)).words))))
    named = [re.split(r" (?:with|for|to) ", phrase)[0] for phrase in phrases if phrase != "false"]
    heads = {singular(phrase.split()[-1]) for phrase in named}
    for mention in mentions(words):
        if intent == "none":
            yield Example(source, text, words, mention, wished=False)
        elif mention.phrase.objects[0] in heads or mention.phrase.text in phrases:
            yield Example(source, text, words, mention, wished=True)


def vocabulary(known: list[Example]) -> frozenset[str]:
    """The words that count as such: frequent ones, and no names of things."""
    counts = Counter(word for each in known for word in set(each.words))
    grammar = LEXICON.enders | LEXICON.finite
    frequent = {word for word, count in counts.items() if count >= _LEAST_WORD}
    return frozenset(
        word
        for word in frequent
        if word in grammar or (entry := look_up(word)) is None or entry.parts[:1] != "n"
    )


class Table:
    """Examples as a matrix of features.

    Args:
        known: all of them, those of prose last.
        words: what counts as such.
    """

    def __init__(self, known: list[Example], words: frozenset[str]) -> None:
        found = [features(each.words, each.mention, words) for each in known]
        everywhere = Counter(name for names in found for name in names)
        ours = Counter(
            name
            for each, names in zip(known, found, strict=True)
            if each.source != _PROSE
            for name in names
        )
        self.names = sorted(
            name
            for name, count in everywhere.items()
            if count >= _LEAST_PROSE and ours[name] >= _LEAST_FEATURE
        )
        index = {name: column for column, name in enumerate(self.names)}
        cells = [
            (row, index[name])
            for row, names in enumerate(found)
            for name in sorted(names)
            if name in index
        ]
        rows, columns = zip(*cells, strict=True)
        shape = (len(known), len(index))
        self.matrix = csr_matrix((np.ones(len(cells)), (rows, columns)), shape=shape)
        self.wished = np.array([1.0 if each.wished else -1.0 for each in known])
        self.weight = np.array(
            [
                _PROSE_WEIGHT if each.source == _PROSE else 1.0 if each.wished else _TALK_WEIGHT
                for each in known
            ]
        )

    def fit(self, chosen: npt.NDArray[np.bool_]) -> Array:
        """Weights from some of the rows, the bias last."""
        matrix, wished, weight = self.matrix[chosen], self.wished[chosen], self.weight[chosen]

        def loss(values: Array) -> tuple[float, Array]:
            margin = wished * (matrix @ values[:-1] + values[-1])
            pull = -weight * wished / (1 + np.exp(margin))
            slope = np.append(matrix.T @ pull + _PENALTY * values[:-1], pull.sum())
            penalty = _PENALTY / 2 * float((values[:-1] ** 2).sum())
            return float((weight * np.logaddexp(0.0, -margin)).sum()) + penalty, slope

        start = np.zeros(len(self.names) + 1)
        found = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": 200})
        return np.asarray(found.x, dtype=np.float64)

    def likelihood(self, values: Array) -> Array:
        """Of every row."""
        return np.asarray(1 / (1 + np.exp(-(self.matrix @ values[:-1] + values[-1]))))


def left_out(table: Table, known: list[Example]) -> None:
    """Prints how each set is judged by a model of the others."""
    sources = np.array([each.source for each in known])
    for source in sorted(set(sources) - {_PROSE}):
        held = sources == source
        likelihood = table.likelihood(table.fit(~held))
        for sign, name in ((1.0, "wished for"), (-1.0, "mentioned")):
            rows = held & (table.wished == sign)
            if rows.any():
                taken = int((likelihood[rows] >= SURE).sum())
                share = f"{taken:>5} of {int(rows.sum()):>5}"
                sys.stdout.write(f"{source:<12} {name:<11} {share} taken for a wish\n")


def main() -> None:
    """Train, and write the weights, or print how well it does without each set."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--wordnet", type=Path, default=_WORDNET)
    parser.add_argument("--output", type=Path, default=_TARGET)
    parser.add_argument("--left-out", action="store_true", help="measure, and write nothing")
    options = parser.parse_args()
    ours = [each for sentence in sentences() for each in examples(*sentence)]
    words = vocabulary(ours)
    others = [
        each
        for text in prose(options.wordnet)
        for each in examples(_PROSE, text, "none", ["false"])
    ]
    known = [*ours, *others]
    table = Table(known, words)
    if options.left_out:
        left_out(table, known)
        return
    values = table.fit(np.ones(len(known), dtype=np.bool_))
    weights = {
        name: round(float(value), 2)
        for name, value in zip(table.names, values[:-1], strict=True)
        if abs(value) >= _NEGLIGIBLE
    }
    content = {"bias": round(float(values[-1]), 2), "words": sorted(words), "weights": weights}
    packed = gzip.compress(json.dumps(content).encode(), mtime=0)
    options.output.write_bytes(packed)
    sys.stdout.write(
        f"{len(ours)} things of ours, {len(others)} in prose; {len(weights)} weights, "
        f"{len(packed) / 1024:.0f} KB\n"
    )


if __name__ == "__main__":
    main()
