"""Sound files: any plain RIFF/WAVE file becomes 16 kHz mono samples, or a clear error.

The header is read here rather than by a library, so that length is known before any sample is
read, and each thing that can be wrong with a file has its own sentence. Layout after "Multimedia
Programming Interface and Data Specifications 1.0" (IBM, Microsoft, 1991) and, for
``WAVE_FORMAT_EXTENSIBLE``, mmreg.h.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from cellctl.errors import HearingError
from cellctl.listening.recogniser import SAMPLE_RATE_HZ, Samples

_PCM, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE
_KNOWN_RATES_HZ = range(4_000, 384_001)
_MAX_CHANNELS = 32
_FRAME_S = 0.03
_SILENCE_RMS = 0.003
"""Of full scale, about -50 dBFS: below quiet speech, above the noise of a sound card."""

FloatSamples = npt.NDArray[np.float64]


@dataclass(frozen=True)
class _Format:
    encoding: int
    channels: int
    rate_hz: int
    bits: int

    @property
    def frame_bytes(self) -> int:
        return self.channels * self.bits // 8


def read_wav(path: Path, max_audio_s: float) -> Samples:
    """Read a wav file as mono 16 bit samples at ``SAMPLE_RATE_HZ``.

    Takes integer samples of 8, 16, 24 and 32 bit and float samples of 32 and 64 bit, at 4 to
    384 kHz, with up to 32 channels (averaged). A file cut short is read as far as it goes.

    Raises:
        HearingError: the file cannot be opened, is not a wav file, is compressed, is empty, or is
            longer than ``max_audio_s``.
    """
    try:
        with path.open("rb") as file:
            kind, data = _read_chunks(file, path, max_audio_s)
    except OSError as error:
        raise HearingError(
            f"{path}: cannot be read: {error.strerror or error}.",
            "Name a wav file that exists and may be read.",
        ) from error
    mono = _decode(data, kind).reshape(-1, kind.channels).mean(axis=1)
    if kind.rate_hz != SAMPLE_RATE_HZ:
        mono = _resample(mono, kind.rate_hz)
    samples: Samples = np.clip(np.rint(mono * 32767.0), -32768, 32767).astype(np.int16)
    return samples


def is_silent(samples: Samples) -> bool:
    """True when no 30 ms of the audio are louder than -50 dBFS: not worth a recogniser's time."""
    frame = int(_FRAME_S * SAMPLE_RATE_HZ)
    count = len(samples) // frame
    if count == 0:
        return True
    levels = samples[: count * frame].astype(np.float64) / 32768.0
    frames = (levels - levels.mean()).reshape(count, frame)
    return bool(np.sqrt(np.square(frames).mean(axis=1)).max() < _SILENCE_RMS)


def duration_s(samples: Samples) -> float:
    """Length of the audio in seconds."""
    return len(samples) / SAMPLE_RATE_HZ


def _read_chunks(file: BinaryIO, path: Path, max_audio_s: float) -> tuple[_Format, bytes]:
    """Find the format and read the samples: whole frames, at least one, not too many."""
    head = file.read(12)
    if len(head) == 0:
        raise HearingError(f"{path}: is empty.", "Record it again.")
    if len(head) < 12 or head[:4] != b"RIFF" or head[8:12] != b"WAVE":
        raise HearingError(
            f"{path}: is not a wav file (it does not start with RIFF ... WAVE).",
            "Convert it, for example with ffmpeg -i INPUT -ar 16000 -ac 1 OUTPUT.wav.",
        )
    kind: _Format | None = None
    while len(header := file.read(8)) == 8:
        name, size = header[:4], int.from_bytes(header[4:], "little")
        if name == b"fmt ":
            kind = _parse_format(file.read(size), path)
        elif name == b"data":
            if kind is None:
                break
            return kind, _read_samples(file, size, kind, path, max_audio_s)
        else:
            file.seek(size, 1)
        if size % 2:
            file.seek(1, 1)  # chunks start at even offsets
    missing = "format" if kind is None else "sound"
    raise HearingError(f"{path}: the wav file has no {missing} chunk.", "Record it again.")


def _parse_format(chunk: bytes, path: Path) -> _Format:
    if len(chunk) < 16:
        raise HearingError(f"{path}: the wav file's format chunk is too short.", "Record it again.")
    encoding, channels, rate_hz, _, _, bits = struct.unpack("<HHIIHH", chunk[:16])
    if encoding == _EXTENSIBLE and len(chunk) >= 26:
        # The sub-format's GUID starts with the plain encoding.
        encoding = int.from_bytes(chunk[24:26], "little")
    if (encoding, bits) not in {(_PCM, 8), (_PCM, 16), (_PCM, 24), (_PCM, 32)} | {
        (_FLOAT, 32),
        (_FLOAT, 64),
    }:
        raise HearingError(
            f"{path}: wav encoding {encoding} with {bits} bit samples is not supported.",
            "Use uncompressed samples: 8 to 32 bit integers, or 32 or 64 bit floats.",
        )
    if not 1 <= channels <= _MAX_CHANNELS or rate_hz not in _KNOWN_RATES_HZ:
        raise HearingError(
            f"{path}: the wav file's header is wrong: {channels} channels at {rate_hz} Hz.",
            f"1 to {_MAX_CHANNELS} channels at 4 to 384 kHz can be read.",
        )
    return _Format(encoding, channels, rate_hz, bits)


def _read_samples(
    file: BinaryIO, size: int, kind: _Format, path: Path, max_audio_s: float
) -> bytes:
    limit = int(max_audio_s * kind.rate_hz) * kind.frame_bytes
    data = file.read(min(size, limit + kind.frame_bytes))
    if len(data) > limit:
        raise HearingError(
            f"{path}: is longer than {max_audio_s:g} s.",
            "Use a shorter recording, or raise hearing.max_audio_s.",
        )
    whole = len(data) - len(data) % kind.frame_bytes
    if whole == 0:
        raise HearingError(f"{path}: the wav file holds no sound.", "Record it again.")
    return data[:whole]


def _decode(data: bytes, kind: _Format) -> FloatSamples:
    """Interleaved samples in -1.0 ... 1.0."""
    if kind.encoding == _FLOAT:
        floats = np.frombuffer(data, dtype=f"<f{kind.bits // 8}").astype(np.float64)
        return np.clip(np.nan_to_num(floats), -1.0, 1.0)
    if kind.bits == 8:
        return (np.frombuffer(data, dtype=np.uint8).astype(np.float64) - 128.0) / 128.0
    if kind.bits == 24:
        # Each sample becomes the upper three bytes of a 32 bit one.
        padded = np.zeros((len(data) // 3, 4), dtype=np.uint8)
        padded[:, 1:] = np.frombuffer(data, dtype=np.uint8).reshape(-1, 3)
        return padded.view("<i4").reshape(-1).astype(np.float64) / 2.0**31
    integers = np.frombuffer(data, dtype=f"<i{kind.bits // 8}").astype(np.float64)
    return integers / 2.0 ** (kind.bits - 1)


def _resample(mono: FloatSamples, rate_hz: int) -> FloatSamples:
    from scipy.signal import resample_poly  # noqa: PLC0415 - slow to import, seldom needed

    divisor = math.gcd(rate_hz, SAMPLE_RATE_HZ)
    resampled: Any = resample_poly(mono, SAMPLE_RATE_HZ // divisor, rate_hz // divisor)
    return np.asarray(resampled, dtype=np.float64)
