"""What is said in front of the cell stays in the cell: libraries that would call home must not."""

from __future__ import annotations

import os

_SETTINGS = {
    "ORT_DISABLE_TELEMETRY": "1",  # ONNX Runtime reports its use from 1.29 on
    "HF_HUB_OFFLINE": "1",  # models are found on disk or not at all
    "HF_HUB_DISABLE_TELEMETRY": "1",
}


def keep_libraries_offline() -> None:
    """Tell speech libraries, by their environment variables, to leave the network alone.

    They read these once, when they are first imported: call this before.
    """
    os.environ.update(_SETTINGS)
