"""Logging: structlog throughout, one job id from the sentence to the last part."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, MutableMapping
from typing import Any

import structlog

Forward = Callable[[str, str], None]


def configure(
    level: str = "info", *, json: bool | None = None, forward: Forward | None = None
) -> None:
    """Send log lines to standard error.

    Args:
        level: debug, info, warning or error.
        json: one JSON object a line; by default when standard error is no terminal.
        forward: also gets the level and a sentence of every warning and error.
    """
    as_json = json if json is not None else not sys.stderr.isatty()
    renderer: structlog.typing.Processor = (
        structlog.processors.JSONRenderer()
        if as_json
        # A traceback shows no values: one of them could be a key.
        else structlog.dev.ConsoleRenderer(exception_formatter=structlog.dev.plain_traceback)
    )
    processors: list[structlog.typing.Processor] = [
        structlog.contextvars.merge_contextvars,
        structlog.processors.add_log_level,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
    ]
    if forward is not None:
        processors.append(_forwarding(forward))
    if as_json:
        processors.append(structlog.processors.format_exc_info)
    # Of refused events the machine's answer tells; the library's own warning adds nothing.
    logging.getLogger("transitions").setLevel(logging.ERROR)
    structlog.configure(
        processors=[*processors, renderer],
        wrapper_class=structlog.make_filtering_bound_logger(
            logging.getLevelNamesMapping()[level.upper()]
        ),
        logger_factory=structlog.PrintLoggerFactory(file=sys.stderr),
        cache_logger_on_first_use=False,
    )


def _forwarding(forward: Forward) -> structlog.typing.Processor:
    def processor(
        _logger: Any, _method: str, event: MutableMapping[str, Any]
    ) -> MutableMapping[str, Any]:
        if event["level"] in {"warning", "error"}:
            hidden = {"event", "level", "timestamp", "exc_info"}
            facts = ", ".join(
                f"{name}: {value}" for name, value in event.items() if name not in hidden
            )
            forward(event["level"], f"{event['event']} ({facts})" if facts else event["event"])
        return event

    return processor
