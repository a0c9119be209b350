"""Saying aloud what the cell says."""

from __future__ import annotations

from cellctl.speaking.speaker import SilentSpeaker, Speaker

__all__ = ["SilentSpeaker", "Speaker"]
