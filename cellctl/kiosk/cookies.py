"""What visitors' cookies are signed with: kept while the service is only started again."""

from __future__ import annotations

import os
import secrets
from pathlib import Path
from typing import Final

import structlog

log = structlog.get_logger(__name__)

_FOLDER: Final = "RUNTIME_DIRECTORY"
"""Where systemd names the service's own folder; nobody else may look into it."""
_FILE: Final = "cookie-secret"
_SHORTEST: Final = 32


def cookie_secret() -> str:
    """The secret of this service, so that visitors are known again after the page was restarted.

    Without a folder of the service each process has a secret of its own.
    """
    fresh = secrets.token_urlsafe(_SHORTEST)
    folder = os.environ.get(_FOLDER, "").partition(":")[0]
    if not folder:
        return fresh
    file = Path(folder) / _FILE
    try:
        if file.exists() and len(kept := file.read_text(encoding="ascii")) >= _SHORTEST:
            return kept
        file.unlink(missing_ok=True)
        with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as target:
            target.write(fresh)
    except (OSError, ValueError) as error:
        log.warning("visitors are not known again after a restart", reason=str(error))
    return fresh
