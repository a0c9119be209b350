"""From sound to utterances: a pure object that counts samples and knows no clock.

Sound goes in piece by piece; utterances, wake words and vain waits come out. The same object works
behind the microphone and, faster than real time, on recordings.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np

from cellctl.listening.ears.detectors import (
    CHUNK_BYTES,
    CHUNK_SAMPLES,
    SpeechDetector,
    WakeWordDetector,
)
from cellctl.listening.ears.events import (
    OWN_VOICE_STEP_S,
    Draft,
    Expecting,
    Heard,
    NoSpeech,
    Segment,
    SpokenAfter,
    WakeWordHeard,
)
from cellctl.listening.ears.own_voice import OwnVoice
from cellctl.listening.recogniser import SAMPLE_RATE_HZ

CHUNK_S = CHUNK_SAMPLES / SAMPLE_RATE_HZ
SPEECH_BEGINS = 0.5
"""Probability from which a chunk is speech, after silence."""
SPEECH_ENDS = 0.35
"""Probability below which it is none any more, after speech."""
FOREGROUND = 2.5
"""How much louder than the background speech has to be, as a ratio of levels: 8 dB. Other people
who talk further off are speech too, and would hide where a sentence ends."""
BACKGROUND_S = 10.0
"""The background is what is exceeded for four fifths of this time."""
_BACKGROUND_SHARE = 0.2
_BACKGROUND_LEAST_S = 1.0
BEFORE_S = 0.32
"""Sound that is kept from before the first speech: a soft consonant is no speech yet."""
OWN_LEVEL = 0.25
"""What can only be a command is one voice: what falls below this share of its loudest moment is
somebody else's, and what came before it rose from there too. 10 dB."""
REQUEST_SILENCE_S = 0.6
"""Silence that ends a request: people stop to think."""
DRAFT_SILENCE_S = 0.3
"""Silence after which a request may be complete: to recognise it begins then, and whoever does not
go on has not waited for it."""
COMMAND_SILENCE_S = 0.25
"""Silence that ends what can only be a command: the arm may be moving."""
SHORTEST_SPEECH_S = 0.1
"""Less is a click or a cough."""
COMMAND_LONGEST_S = 3.0
"""Of longer speech that nobody asked for, only so much of its end is passed on."""
SHORTEST_AFTER_WAKE_WORD_S = 0.3
"""The wake word's own end may still be speech; what follows it is longer."""
REQUEST_LONGEST_S = 12.0
"""A request is cut off here, counted from the wake word or the button."""
NO_SPEECH_S = 6.0
"""How long the ears wait for a request to begin."""
DUCKED = 0.1
"""What is left of the cell's own voice in what people say at the same time: 20 dB less."""
_DRAFT_CHUNKS = round(DRAFT_SILENCE_S / CHUNK_S)
WAKE_WORD_PAUSE_S = 1.5
"""One spoken wake word is noticed once."""


class Pipeline:
    """Endpointing, wake word and activation.

    Args:
        speech: tells speech from noise.
        wake_word: what activates; None when only ``listen`` does, or nothing has to.
        open_to_all: every utterance counts as a request, with nothing before it.
    """

    def __init__(
        self,
        speech: SpeechDetector,
        wake_word: WakeWordDetector | None = None,
        *,
        open_to_all: bool = False,
    ) -> None:
        self.expecting: Expecting = "request"
        """What may be said now; set by whoever knows what the cell is doing."""
        self._speech = speech
        self._wake_word = wake_word
        self.open_to_all = open_to_all
        self._rest = b""
        self._now_s = 0.0
        self._after: SpokenAfter = ""
        self._activated_s = 0.0
        self._woken_s = -WAKE_WORD_PAUSE_S
        self._before: deque[bytes] = deque(maxlen=round(BEFORE_S / CHUNK_S))
        self._levels: deque[float] = deque(maxlen=round(BACKGROUND_S / CHUNK_S))
        self._spoken: deque[bytes] = deque()
        self._loudest = 0.0
        self._speech_s = 0.0
        self._speech_begin_s = self._speech_end_s = 0.0
        self._mark = 0
        self.own_voice = OwnVoice(CHUNK_S, OWN_VOICE_STEP_S)
        """What is expected to be heard of the cell itself, by ``now_s``."""
        self._wakes_itself = False

    @property
    def recording(self) -> SpokenAfter:
        """What made the ears take what is said now for a request; empty while they do not."""
        return self._after

    @property
    def how_to_begin(self) -> str:
        """What a person has to do before a request, in words."""
        if self._wake_word is None:
            return "Press the button and say what you would like."
        return f"Say \u201c{self._wake_word.word}\u201d, then what you would like."

    @property
    def now_s(self) -> float:
        """How much sound has come in."""
        return self._now_s

    def listen(self, after: SpokenAfter = "push_to_talk") -> None:
        """Take what is said from now on for a request."""
        self._after, self._activated_s = after, self._now_s
        self._drop()
        if after == "wake_word":
            self._before.clear()  # it holds the wake word's end

    def forget(self) -> None:
        """Begin anew: sound was lost, and what comes next does not follow what came before."""
        self._rest, self._after = b"", ""
        self._drop()
        self._before.clear()

    def feed(self, sound: bytes) -> Iterator[Heard]:
        """Take in some sound, of any length; yields what it brought to an end.

        Args:
            sound: 16 kHz mono 16 bit PCM that follows what was fed before.
        """
        sound = self._rest + sound
        whole = len(sound) - len(sound) % CHUNK_BYTES
        self._rest = sound[whole:]
        for start in range(0, whole, CHUNK_BYTES):
            yield from self._chunk(sound[start : start + CHUNK_BYTES])

    def _chunk(self, chunk: bytes) -> Iterator[Heard]:
        self._now_s += CHUNK_S
        if self._wakes(chunk):
            assert self._wake_word is not None
            yield WakeWordHeard(word=self._wake_word.word)
            self.listen("wake_word")
        talking = bool(self._spoken)
        probability = self._speech.probability(chunk)
        near = self._is_near(chunk) and self._is_own()
        if self._is_echo():
            near, chunk = False, _ducked(chunk)
        if near and probability >= (SPEECH_ENDS if talking else SPEECH_BEGINS):
            if talking and self._loudest < OWN_LEVEL * self._levels[-1] and not self._whole:
                self._drop()  # what was heard so far was further off
                talking = False
            if not talking:
                self._spoken.extend(self._before)
                self._speech_begin_s = self._now_s - CHUNK_S
            self._loudest = max(self._loudest, self._levels[-1])
            self._speech_s += CHUNK_S
            self._mark += 1
            self._speech_end_s = self._now_s
            talking = True
        if not talking:
            self._before.append(chunk)
            if self._after and self._now_s - self._activated_s > NO_SPEECH_S:
                self._after = ""
                yield NoSpeech()
            return
        self._spoken.append(chunk)
        if self._whole and self._silent_chunks == _DRAFT_CHUNKS and self._is_long_enough:
            yield Draft(pcm=b"".join(self._spoken), mark=self._mark)
        if self._complete():
            segment = self._cut()
            if segment is not None:
                yield segment

    def own_voice_began(self, at_s: float, levels: tuple[float, ...], wakes: bool) -> None:
        """The cell itself is heard from a moment of ``now_s`` on; see ``OwnVoiceBegan``."""
        self.own_voice.began(at_s, levels)
        self._wakes_itself = wakes

    def _is_echo(self) -> bool:
        """Whether the newest sound may be the cell's own voice."""
        return self.own_voice.covers(self._now_s, self._levels[-1])

    @property
    def _silent_chunks(self) -> int:
        """How many chunks ago the newest speech was."""
        return round((self._now_s - self._speech_end_s) / CHUNK_S)

    @property
    def _is_long_enough(self) -> bool:
        woken = self._after == "wake_word"
        least_s = SHORTEST_AFTER_WAKE_WORD_S if woken else SHORTEST_SPEECH_S
        return self._speech_s >= least_s

    def _is_near(self, chunk: bytes) -> bool:
        """Whether this is louder than what goes on in the background all the time."""
        samples = np.frombuffer(chunk, dtype=np.int16).astype(np.float64)
        level = float(np.sqrt(np.square(samples).mean()))
        self._levels.append(level)
        if len(self._levels) * CHUNK_S < _BACKGROUND_LEAST_S:
            return True
        background = sorted(self._levels)[int(_BACKGROUND_SHARE * len(self._levels))]
        return level >= FOREGROUND * background

    def _is_own(self) -> bool:
        """Whether the newest sound is as loud as the voice that speaks a command."""
        return self._whole or self._levels[-1] >= OWN_LEVEL * self._loudest

    @property
    def _whole(self) -> bool:
        """Whether a whole request is being spoken, in which people pause and lower their voice."""
        requested = self._after or self.open_to_all
        return bool(requested) and self.expecting == "request"

    def _wakes(self, chunk: bytes) -> bool:
        if self._wake_word is None or not self._wake_word.heard(chunk):
            return False
        if self._now_s - self._woken_s < WAKE_WORD_PAUSE_S:
            return False
        if self._wakes_itself and self.own_voice.spoke(self._now_s):
            return False
        self._woken_s = self._now_s
        return True

    def _complete(self) -> bool:
        """Whether what is being said has come to its end, or must."""
        requested = self._after or (self.open_to_all and self.expecting == "request")
        if requested:
            begun_s = self._activated_s if self._after else self._now_s - self._length_s
            if self._now_s - begun_s > REQUEST_LONGEST_S:
                return True
        elif self._length_s > BEFORE_S + COMMAND_LONGEST_S:
            self._spoken.popleft()
        silence_s = REQUEST_SILENCE_S if self._whole else COMMAND_SILENCE_S
        return self._now_s - self._speech_end_s > silence_s - CHUNK_S / 2

    @property
    def _length_s(self) -> float:
        return len(self._spoken) * CHUNK_S

    def _cut(self) -> Segment | None:
        """End the utterance; None when it was too short to be one."""
        pcm, long_enough = b"".join(self._spoken), self._is_long_enough
        self._drop()
        if not long_enough:
            return None
        after, self._after = self._after, ""
        if not after and self.open_to_all and self.expecting == "request":
            after = "open"
        return Segment(
            pcm=pcm,
            after=after,
            mark=self._mark,
            speech_end_s=self._speech_end_s,
            speech_s=self._speech_end_s - self._speech_begin_s,
        )

    def _drop(self) -> None:
        self._before.extend(self._spoken)
        self._spoken.clear()
        self._speech_s = self._loudest = 0.0


def _ducked(chunk: bytes) -> bytes:
    """The same sound, much fainter: what a recogniser gets of the cell's own voice."""
    samples = np.frombuffer(chunk, dtype=np.int16)
    return (samples * DUCKED).astype(np.int16).tobytes()
