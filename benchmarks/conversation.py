"""How fast the cell answers: ``python -m benchmarks.conversation [--wishes N]``.

An emulated cell, its daemon, and a private sound server: wishes are played into the virtual
microphone by the packaged voice, and what the cell says comes out of the virtual loudspeaker. For
each wish, from the last sound of the person's voice (wall time):

- *heard*: the words are known and published;
- *understood*: the cell begins to say what it understood;
- *asks*: the question with parts and minutes is on the screen, and the cell begins to say it.

Prints the median and the worst, and where the time goes. Nothing is built: each question is
answered with a no; what was misheard is told, and not counted.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from cellctl.assembly import Role
from cellctl.cli.daemon_process import running_daemon, wait_idle
from cellctl.client import CellClient
from cellctl.config import CellConfig, load_config
from cellctl.listening.wav import read_wav
from cellctl.messages import (
    ConfirmCommand,
    JobData,
    ListenCommand,
    SpeechData,
    StateData,
    StatusData,
    VoiceData,
)
from cellctl.sim.isolation import isolated
from cellctl.sim.microphone import VirtualMicrophone
from cellctl.sim.spawn import emulated_cell
from cellctl.speaking.voices import speak_to_wav

CONFIG = Path(__file__).parents[1] / "config" / "sim.toml"
WISHES = (
    "I want a simple stool",
    "the letter T",
    "a shelf with two tiers",
    "make me a coffee table",
    "a stool with three legs",
    "build me a small bench",
    "I would like a side table",
    "a simple box",
    "build me an arch",
    "make the letter A",
)
STAGES = ("heard", "understood", "shown", "asks")
_PATIENCE_S = 60.0


def configured() -> CellConfig:
    """The emulated cell, with ears and a voice; no wake word, so that its time does not count."""
    base = load_config(CONFIG)
    sections = {
        "policy": {"confirmation": "ask", "confirmation_timeout_s": 600.0},
        "hearing": {"microphone": "", "activation": "push_to_talk"},
        "voice": {"loudspeaker": "spk"},
    }
    updates = {
        name: getattr(base, name).model_copy(update=values) for name, values in sections.items()
    }
    return CellConfig.model_validate(base.model_copy(update=updates).model_dump(exclude_none=True))


class Watch:
    """When things were published, by this machine's monotonic clock."""

    def __init__(self, cell: CellClient) -> None:
        self._cell = cell
        self.saying = ""

    def until(self, holds: Callable[[StatusData], bool]) -> float:
        """Wait for a message; returns when it came.

        Raises:
            TimeoutError: it did not come.
        """
        deadline_s = time.monotonic() + _PATIENCE_S
        while time.monotonic() < deadline_s:
            for message in self._cell.messages(0.05):
                payload = message.payload()
                if isinstance(payload, VoiceData):
                    self.saying = payload.saying or self.saying
                if holds(payload):
                    return time.monotonic()
        raise TimeoutError("The cell did not get there.")


def measure(cell: CellClient, microphone: VirtualMicrophone, wav: Path) -> dict[str, float]:
    """Say one wish, and no to the question; seconds from its last sound, by stage. Empty when it
    was misheard."""
    watch = Watch(cell)
    samples = np.abs(read_wav(wav, 30.0).astype(np.int32))
    last_s = float(np.flatnonzero(samples > 300)[-1]) / 16_000
    cell.request(ListenCommand())
    ended_s = microphone.begin(wav) + last_s
    taken: dict[str, float] = {}
    taken["heard"] = watch.until(lambda data: isinstance(data, SpeechData)) - ended_s
    spoken: dict[str, float] = {}

    def follow(data: StatusData) -> bool:
        if isinstance(data, VoiceData) and data.saying:
            key = "asks" if "Shall I build it?" in data.saying else "understood"
            spoken.setdefault(key, time.monotonic() - ended_s)
        if isinstance(data, StateData) and data.state == "validating_confirming":
            spoken.setdefault("shown", time.monotonic() - ended_s)
        misheard = isinstance(data, JobData) and data.outcome == "no_object"
        return misheard or ("asks" in spoken and "shown" in spoken)

    watch.until(follow)
    if "shown" not in spoken:
        return {}
    cell.request(ConfirmCommand(answer=False, asked=""))
    watch.until(lambda data: isinstance(data, StateData) and data.state == "idle")
    watch.until(lambda data: isinstance(data, VoiceData) and not data.saying)
    return taken | spoken


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wishes", type=int, default=len(WISHES), help="only the first N")
    wishes = WISHES[: parser.parse_args().wishes]
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory(prefix="conv-") as name:
        folder = Path(name)
        (folder / "server").mkdir(mode=0o700)
        wavs = [folder / f"{number}.wav" for number in range(len(wishes))]
        for wish, wav in zip(wishes, wavs, strict=True):
            speak_to_wav(wish, wav)
        with VirtualMicrophone(folder / "server") as microphone:
            os.environ.update(microphone.environment)
            own = isolated(configured(), folder)
            with (
                emulated_cell(own, 1.0),
                running_daemon(own, folder) as daemon,
                CellClient.for_role(own, Role.OPERATOR) as cell,
            ):
                wait_idle(cell, daemon)
                cell.subscribe()
                Watch(cell).until(lambda data: isinstance(data, VoiceData))
                ready_s = time.monotonic() + _PATIENCE_S
                while "not loaded" in cell.snapshot().recogniser and time.monotonic() < ready_s:
                    time.sleep(0.2)
                measure(cell, microphone, wavs[0])  # loads what is loaded late
                taken = []
                for wish, wav in zip(wishes, wavs, strict=True):
                    found = measure(cell, microphone, wav)
                    if not found:
                        sys.stdout.write(f"{wish:<28}misheard\n")
                        continue
                    taken.append(found)
                    row = "".join(f"{found.get(stage, 0.0):>12.2f}" for stage in STAGES)
                    sys.stdout.write(f"{wish:<28}{row}\n")
                    sys.stdout.flush()
        shutil.rmtree(folder / "server")
    for stage in STAGES:
        values = [each[stage] for each in taken if stage in each]
        if values:
            sys.stdout.write(
                f"{stage:<12} median {statistics.median(values):.2f} s, worst {max(values):.2f} s "
                f"({len(values)} of {len(taken)})\n"
            )
    sys.stdout.write(f"load of the machine when it began: {load:.1f}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
