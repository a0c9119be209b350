"""What the cell says to people, in their language: one file of messages a language.

A file is TOML: a few lines about the language, and tables of messages with named fields. A message
that counts something is a list, of which the language's rule picks one form by ``count``.
"""

from __future__ import annotations

from cellctl.wording.files import languages, load_wording
from cellctl.wording.line import Line
from cellctl.wording.wording import REFERENCE_LANGUAGE, Wording

__all__ = ["REFERENCE_LANGUAGE", "Line", "Wording", "languages", "load_wording"]
