"""PortAudio: loading it, starting it anew, and finding the device that is meant."""

from __future__ import annotations

import contextlib
from typing import Any

from cellctl.errors import HearingError

SERVER_DEVICES = ("pulse", "pipewire")
"""PortAudio's names for the sound server as a whole."""


class DeviceError(HearingError):
    """A microphone or a loudspeaker cannot be opened."""


def portaudio() -> Any:
    """The library's module.

    Raises:
        HearingError: it is not installed.
    """
    try:
        import sounddevice  # noqa: PLC0415 - starts PortAudio, only where it is used
    except (ImportError, OSError) as error:
        raise HearingError(
            f"The sound library is missing: {error}.",
            "pip install 'cellctl[speech]', and on Debian apt install libportaudio2.",
        ) from error
    return sounddevice


def restart(library: Any) -> None:
    """Let PortAudio look for devices anew; no stream may be open.

    Raises:
        DeviceError: it does not start.
    """
    try:
        with contextlib.suppress(library.PortAudioError):
            library._terminate()
        library._initialize()
    except library.PortAudioError as error:
        raise DeviceError(f"PortAudio does not start: {error}.") from error


def devices(library: Any, direction: str) -> dict[int, str]:
    """Names of what could be opened, by PortAudio's number.

    Args:
        library: PortAudio, started.
        direction: ``input`` or ``output``.
    """
    return {
        number: str(device["name"])
        for number, device in enumerate(library.query_devices())
        if device[f"max_{direction}_channels"] > 0
    }


def listed(direction: str) -> list[str]:
    """Names of everything that could be opened, as it is now.

    Raises:
        HearingError: PortAudio is not installed or does not start.
    """
    library = portaudio()
    restart(library)
    return list(devices(library, direction).values())
