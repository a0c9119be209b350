"""Sounds that no cell should take for a request: noise, something like music, and babble.

Made by chance from a seed, 16 kHz mono 16 bit, for tests and benchmarks of the ears.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Samples = npt.NDArray[np.int16]

RATE_HZ = 16_000
_FULL_SCALE = 32_767.0
_LEVEL = 0.08
"""Root mean square of the louder sounds, of full scale: -22 dB, as loud as somebody speaking."""


_SILENT = 300
"""Samples below this are the silence around speech."""


def noise(seconds: float, seed: int, level: float = _LEVEL) -> Samples:
    """Pink-like noise, as of a ventilator.

    Args:
        level: root mean square, of full scale.
    """
    white = np.random.default_rng(seed).normal(0.0, 1.0, int(seconds * RATE_HZ) + 8)
    smooth = np.convolve(white, np.ones(8) / 8.0, mode="valid")[: int(seconds * RATE_HZ)]
    return _scaled(smooth, level)


def music(seconds: float, seed: int) -> Samples:
    """Chords of decaying partials, two a second."""
    rng = np.random.default_rng(seed)
    whole = np.zeros(int(seconds * RATE_HZ))
    time_s = np.arange(RATE_HZ) / RATE_HZ
    for start in range(0, len(whole), RATE_HZ // 2):
        base_hz = 110.0 * 2.0 ** (rng.integers(0, 24) / 12.0)
        chord = np.zeros(RATE_HZ)
        for ratio in (1.0, 1.25, 1.5):
            for partial in range(1, 6):
                tone = np.sin(2.0 * np.pi * base_hz * ratio * partial * time_s)
                chord += tone / partial * np.exp(-3.0 * time_s)
        piece = whole[start : start + RATE_HZ]
        piece += chord[: len(piece)]
    return _scaled(whole, _LEVEL)


def babble(sentences: Sequence[Samples], seconds: float, seed: int, voices: int = 4) -> Samples:
    """Several people who talk to each other, at random and without end.

    Args:
        sentences: what they say, each chosen again and again.
        voices: how many talk at once at most; each is silent about a third of the time.
    """
    rng = np.random.default_rng(seed)
    whole = np.zeros(int(seconds * RATE_HZ))
    for _ in range(voices):
        place = int(rng.integers(0, 3 * RATE_HZ))
        gain = rng.uniform(0.3, 1.0)
        while place < len(whole):
            said = sentences[int(rng.integers(len(sentences)))]
            piece = whole[place : place + len(said)]
            piece += gain * said[: len(piece)]
            place += len(said) + int(rng.exponential(1.0) * RATE_HZ)
    return _scaled(whole, _LEVEL)


def mixed(speech: Samples, background: Samples, ratio_db: float) -> Samples:
    """Speech over a background that is ``ratio_db`` weaker, by their mean power.

    Args:
        speech: what is silent in it does not count.
        background: at least as long.
    """
    below = background[: len(speech)].astype(np.float64)
    loud = speech[np.abs(speech.astype(np.int32)) > _SILENT].astype(np.float64)
    power = float(np.mean(np.square(loud))) if len(loud) else 0.0
    below_power = max(float(np.mean(np.square(below))), 1.0)
    gain = (power / below_power / 10.0 ** (ratio_db / 10.0)) ** 0.5
    both: Samples = np.clip(speech + gain * below, -32_768, 32_767).astype(np.int16)
    return both


def _scaled(sound: npt.NDArray[np.float64], level: float) -> Samples:
    rms = float(np.sqrt(np.square(sound).sum() / max(len(sound), 1))) or 1.0
    scaled: Samples = np.clip(sound / rms * level * _FULL_SCALE, -32_768, 32_767).astype(np.int16)
    return scaled
