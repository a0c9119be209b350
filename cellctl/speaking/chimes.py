"""Two short chimes, made of decaying tones: rising for "I listen now", falling for "heard"."""

from __future__ import annotations

import numpy as np

from cellctl.speaking.events import Chime
from cellctl.speaking.voices import Sound

_RATE_HZ = 24_000
_TONES_HZ: dict[Chime, tuple[float, ...]] = {
    "listening": (587.3, 880.0),  # D5, A5
    "heard": (880.0, 659.3),  # A5, E5
}
_TONE_S = 0.09
_DECAY_S = 0.06
_LEVEL = 0.35


def chime(name: Chime) -> Sound:
    """The sound of a chime; some 0.3 s."""
    tones = _TONES_HZ[name]
    length = int(_RATE_HZ * (_TONE_S * (len(tones) - 1) + 4 * _DECAY_S))
    whole = np.zeros(length)
    for number, tone_hz in enumerate(tones):
        start = int(number * _TONE_S * _RATE_HZ)
        time_s = np.arange(length - start) / _RATE_HZ
        rise = np.minimum(1.0, time_s / 0.005)
        whole[start:] += rise * np.exp(-time_s / _DECAY_S) * np.sin(2 * np.pi * tone_hz * time_s)
    return Sound((whole / np.abs(whole).max() * _LEVEL * 32_767).astype(np.int16), _RATE_HZ)
