"""The interpreter that a configuration asks for."""

from __future__ import annotations

from cellctl.config import CellConfig
from cellctl.listening.understanding.embedded import EmbeddedInterpreter
from cellctl.listening.understanding.interpreter import Interpreter


def interpreter_for(config: CellConfig) -> Interpreter:
    """The configured back end; the embedded one is always behind it.

    Raises:
        ConfigError: the configured one cannot be used.
    """
    embedded = EmbeddedInterpreter()
    if config.understanding.back_end == "embedded":
        return embedded
    # The client for HTTP takes a quarter of a second to load, which most cells never need.
    from cellctl.listening.understanding.language_model.interpreter import (  # noqa: PLC0415
        language_model,
    )

    return language_model(config.understanding, embedded)
