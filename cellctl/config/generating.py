"""The table of where shapes come from."""

from __future__ import annotations

from typing import Annotated, Literal, Self
from urllib.parse import urlsplit

from pydantic import Field, model_validator

from cellctl.config.section import Positive, Section

GeneratorName = Literal["description", "catalogue", "model", "meshy", "tripo", "server"]


class GeneratingSection(Section):
    """Where shapes come from: who is asked, in which order, and how long."""

    chain: tuple[GeneratorName, ...] = ("description", "catalogue")
    """Asked in this order, until one knows the object. ``description`` and ``catalogue`` need no
    network; ``model`` has the language model of [understanding] describe simple solids; ``meshy``
    and ``tripo`` are services in the cloud, ``server`` is a machine of one's own."""
    catalogue: str = ""
    """File of the catalogue; empty is the one that comes with cellctl."""
    meshy_url: str = "https://api.meshy.ai/openapi"
    """Of Meshy's interface; its key is the credential meshy-key, or $CELLCTL_MESHY_KEY."""
    tripo_url: str = "https://openapi.tripo3d.ai"
    """Of Tripo's interface; its key is the credential tripo-key, or $CELLCTL_TRIPO_KEY."""
    server_url: str = ""
    """Where a prompt is posted and a GLB is answered; its key, if it wants one, is the credential
    server-key, or $CELLCTL_SERVER_KEY."""
    timeout_s: Positive = 300.0
    """For one model from a service, from the request to the last byte (wall time)."""
    answer_timeout_s: Positive = 30.0
    """For one answer of Meshy, Tripo or the language model (wall time)."""
    max_download_mb: Annotated[float, Field(gt=0.0, le=1000.0)] = 64.0
    """The largest model that is taken from a service, in megabytes."""

    @model_validator(mode="after")
    def _usable(self) -> Self:
        if not self.chain:
            raise ValueError("chain must name at least one generator")
        if len(set(self.chain)) != len(self.chain):
            raise ValueError(f"chain must name each generator once (not {list(self.chain)})")
        for name in ("meshy", "tripo", "server"):
            url = str(getattr(self, f"{name}_url"))
            if name in self.chain:
                _check_url(f"{name}_url", url)
        return self


def _check_url(name: str, url: str) -> None:
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ValueError(f"{name} must be an http(s) address (not {url!r})")
    if parts.username or parts.password or parts.query:
        raise ValueError(f"{name} must hold no secret: keys are credentials")
    if parts.scheme == "http" and name != "server_url" and parts.hostname != "127.0.0.1":
        raise ValueError(f"{name} must be an https address, for a key is sent there")
