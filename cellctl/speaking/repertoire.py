"""The sounds of texts: made in a thread of its own, once, so that nobody waits for a voice."""

from __future__ import annotations

import threading
from collections import OrderedDict, deque
from collections.abc import Callable
from contextlib import suppress

from cellctl.errors import HearingError
from cellctl.speaking.loudspeaker import prepared
from cellctl.speaking.reading import read_aloud
from cellctl.speaking.voices import Samples, Voice, open_voice

CACHE_LIMIT_BYTES = 64 << 20
"""Of sound that is kept: some ten minutes."""

Made = Callable[[Samples | HearingError], None]
"""Gets a sound, or why there is none."""


class Repertoire:
    """Sounds by text and language; the least used are forgotten.

    Args:
        voice: ``voice.voice``.
        volume: ``voice.volume``.
        language: what is mostly spoken; its voice is loaded at once.
    """

    def __init__(self, voice: str, volume: float, language: str) -> None:
        self._wanted = voice
        self._volume = volume
        self._voices: dict[str, Voice] = {}
        self._sounds: OrderedDict[tuple[str, str], Samples] = OrderedDict()
        self._size = 0
        self._wake = threading.Condition()
        self._ordered: deque[tuple[str, str, Made]] = deque()
        self._beforehand: deque[tuple[str, str]] = deque()
        self.ready = threading.Event()
        """The voice for ``language`` is loaded, if there is one."""
        self.voice = ""
        """Who spoke last, for people."""
        threading.Thread(target=self._run, args=(language,), name="repertoire", daemon=True).start()

    def order(self, text: str, language: str, made: Made) -> None:
        """Make a sound as soon as possible.

        Args:
            text: what to say.
            language: its code.
            made: called from another thread.
        """
        with self._wake:
            self._ordered.append((text, language, made))
            self._wake.notify()

    def prepare(self, text: str, language: str) -> None:
        """Make a sound when there is nothing else to do: it will be said."""
        with self._wake:
            self._beforehand.append((text, language))
            self._wake.notify()

    def sound(self, text: str, language: str) -> Samples:
        """What a text sounds like; blocks while it is made. From one thread only.

        Raises:
            HearingError: there is no voice for that language, or it failed.
        """
        key = text, language
        voice = self._voice(language)
        if key not in self._sounds:
            made = voice.speak(read_aloud(text, language))
            self._keep(key, prepared(made, self._volume))
        self._sounds.move_to_end(key)
        self.voice = voice.name
        return self._sounds[key]

    def _run(self, language: str) -> None:
        with suppress(HearingError):  # whoever orders a sound is told
            self._voice(language)
            import scipy.signal  # noqa: F401, PLC0415 - what ``prepared`` needs
        self.ready.set()
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._ordered or self._beforehand)
                ordered = self._ordered.popleft() if self._ordered else None
                beforehand = self._beforehand.popleft() if ordered is None else None
            if ordered is not None:
                text, language, made = ordered
                try:
                    made(self.sound(text, language))
                except HearingError as error:
                    made(error)
            elif beforehand is not None:
                with suppress(HearingError):
                    self.sound(*beforehand)

    def _voice(self, language: str) -> Voice:
        if language not in self._voices:
            self._voices[language] = open_voice(language, self._wanted)
        return self._voices[language]

    def _keep(self, key: tuple[str, str], samples: Samples) -> None:
        self._sounds[key] = samples
        self._size += samples.nbytes
        while self._size > CACHE_LIMIT_BYTES and len(self._sounds) > 1:
            _, oldest = self._sounds.popitem(last=False)
            self._size -= oldest.nbytes
