"""Words reach the disk by policy only."""

from __future__ import annotations

import json
from pathlib import Path

from cellctl.clock import SystemClock
from cellctl.config import DialogueSection
from cellctl.control.dialogue.transcript import Transcript


def test_nothing_is_kept_by_default(tmp_path: Path) -> None:
    folder = tmp_path / "transcripts"
    transcript = Transcript(DialogueSection().transcripts, folder, SystemClock())
    transcript.keep("visitor", "a stool")
    transcript.keep("cell", "A stool.")
    assert list(tmp_path.iterdir()) == []


def test_where_the_policy_says_text_both_sides_are_kept(tmp_path: Path) -> None:
    folder = tmp_path / "transcripts"
    transcript = Transcript("text", folder, SystemClock())
    transcript.keep("visitor", "ein schöner Hocker")
    transcript.keep("cell", "Ein Hocker.")
    transcript.keep("visitor", "")
    (file,) = folder.iterdir()
    lines = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
    assert [(line["who"], line["text"]) for line in lines] == [
        ("visitor", "ein schöner Hocker"),
        ("cell", "Ein Hocker."),
    ]
    assert folder.stat().st_mode & 0o077 == 0


def test_a_disk_that_takes_nothing_does_not_end_the_conversation(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    Transcript("text", tmp_path / "file", SystemClock()).keep("visitor", "a stool")
    assert (tmp_path / "file").read_text() == "in the way"
