from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from cellctl.errors import HearingError
from cellctl.listening.recogniser import SAMPLE_RATE_HZ
from cellctl.listening.wav import duration_s, is_silent, read_wav

TONE_HZ = 440.0


def tone(rate_hz: int, length_s: float = 0.5) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    times_s = np.arange(int(rate_hz * length_s)) / rate_hz
    return 0.5 * np.sin(2 * np.pi * TONE_HZ * times_s)


def frequency_hz(samples: np.ndarray[tuple[int], np.dtype[np.int16]]) -> float:
    spectrum = np.abs(np.fft.rfft(samples.astype(np.float64)))
    return float(np.argmax(spectrum)) * SAMPLE_RATE_HZ / len(samples)


def wav_bytes(body: bytes, encoding: int = 1, channels: int = 1, bits: int = 16) -> bytes:
    rate_hz, frame = 16_000, channels * bits // 8
    form = struct.pack("<HHIIHH", encoding, channels, rate_hz, rate_hz * frame, frame, bits)
    chunks = b"fmt " + struct.pack("<I", 16) + form + b"data" + struct.pack("<I", len(body)) + body
    return b"RIFF" + struct.pack("<I", 4 + len(chunks)) + b"WAVE" + chunks


@pytest.mark.parametrize("rate_hz", [8_000, 11_025, 16_000, 22_050, 24_000, 44_100, 48_000, 96_000])
def test_any_sample_rate_keeps_length_pitch_and_level(tmp_path: Path, rate_hz: int) -> None:
    path = tmp_path / "tone.wav"
    wavfile.write(path, rate_hz, (tone(rate_hz) * 32767).astype(np.int16))
    samples = read_wav(path, 30.0)
    assert samples.dtype == np.int16
    assert duration_s(samples) == pytest.approx(0.5, abs=0.001)
    assert frequency_hz(samples) == pytest.approx(TONE_HZ, abs=4.0)
    assert np.abs(samples).max() == pytest.approx(0.5 * 32767, rel=0.05)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("8 bit", (tone(16_000) * 127 + 128).astype(np.uint8)),
        ("16 bit", (tone(16_000) * 32767).astype(np.int16)),
        ("32 bit", (tone(16_000) * 2147483647).astype(np.int32)),
        ("float", tone(16_000).astype(np.float32)),
        ("double", tone(16_000)),
    ],
)
def test_any_sample_format_is_the_same_sound(
    tmp_path: Path, name: str, data: np.ndarray[tuple[int], np.dtype[np.generic]]
) -> None:
    path = tmp_path / f"{name}.wav"
    wavfile.write(path, 16_000, data)
    expected = tone(16_000) * 32767
    assert np.abs(read_wav(path, 30.0) - expected).max() < 400, "a step of 8 bit sound is 256"


def test_24_bit_samples(tmp_path: Path) -> None:
    path = tmp_path / "24.wav"
    expected = (tone(16_000) * (2**23 - 1)).astype("<i4")
    body = expected.view(np.uint8).reshape(-1, 4)[:, :3].tobytes()
    path.write_bytes(wav_bytes(body, bits=24))
    assert np.abs(read_wav(path, 30.0) - tone(16_000) * 32767).max() < 2


def test_channels_are_averaged(tmp_path: Path) -> None:
    path = tmp_path / "stereo.wav"
    left = (tone(16_000) * 32767).astype(np.int16)
    wavfile.write(path, 16_000, np.stack([left, np.zeros_like(left)], axis=1))
    assert np.abs(read_wav(path, 30.0) - left / 2).max() < 2


def test_a_file_cut_short_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "cut.wav"
    whole = wav_bytes((tone(16_000) * 32767).astype(np.int16).tobytes())
    path.write_bytes(whole[: len(whole) // 2 + 1])
    assert 0.2 < duration_s(read_wav(path, 30.0)) < 0.3


def test_floats_that_are_no_numbers_are_silence(tmp_path: Path) -> None:
    path = tmp_path / "nan.wav"
    path.write_bytes(wav_bytes(np.full(1600, np.nan, "<f4").tobytes(), encoding=3, bits=32))
    assert not read_wav(path, 30.0).any()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"RIFF", "not a wav file"),
        (b"ID3\x04 this is an mp3 file, really", "not a wav file"),
        (b"RIFF\x04\x00\x00\x00WAVE", "no format chunk"),
        (wav_bytes(b"")[:36], "no sound chunk"),
        (wav_bytes(b""), "holds no sound"),
        (wav_bytes(b"\x00"), "holds no sound"),
        (wav_bytes(b"\x00" * 64, encoding=0x11, bits=4), "not supported"),
        (wav_bytes(b"\x00" * 64, channels=0), "0 channels"),
        (b"RIFF\x0c\x00\x00\x00WAVEfmt \x02\x00\x00\x00\x01\x00", "too short"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "odd.wav"
    path.write_bytes(content)
    with pytest.raises(HearingError, match=message) as caught:
        read_wav(path, 30.0)
    assert str(path) in caught.value.message
    assert caught.value.hint


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(HearingError, match="cannot be read"):
        read_wav(tmp_path / "nowhere.wav", 30.0)
    with pytest.raises(HearingError, match="cannot be read"):
        read_wav(tmp_path, 30.0)


def test_length_is_limited_before_the_samples_are_read(tmp_path: Path) -> None:
    path = tmp_path / "long.wav"
    wavfile.write(path, 16_000, np.zeros(16_000 * 2 + 1, np.int16))
    with pytest.raises(HearingError, match="longer than 2 s"):
        read_wav(path, 2.0)
    wavfile.write(path, 16_000, np.zeros(16_000 * 2, np.int16))
    assert duration_s(read_wav(path, 2.0)) == 2.0


def test_silence_is_told_from_sound() -> None:
    noise = np.random.default_rng(1).normal(0.0, 20.0, 16_000)
    assert is_silent(noise.astype(np.int16))
    assert is_silent((noise + 3000).astype(np.int16)), "a constant offset is no sound"
    assert is_silent(np.zeros(10, np.int16)), "too short to hold a word"
    noise[8000:9600] += tone(16_000, 0.1) * 2000
    assert not is_silent(noise.astype(np.int16))
