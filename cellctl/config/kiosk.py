"""The table of the page in front of the cell."""

from __future__ import annotations

import ipaddress
import re
from typing import Annotated, Literal, Self
from urllib.parse import urlsplit

from pydantic import Field, model_validator

from cellctl.config.section import Port, Section


class KioskSection(Section):
    """The page that ``cellctl kiosk`` serves."""

    address: str = "127.0.0.1"
    """IP address that it is served on: loopback, unless others than this computer shall see it."""
    port: Port = 8080
    """Its TCP port."""
    public_url: str = ""
    """Address under which a visitor's phone reaches the page, such as ``http://cell.local:8080``;
    the code to take an object home shows it. Empty: no code, unless ``address`` is not loopback."""
    host_names: tuple[str, ...] = ()
    """Further names under which browsers reach the page. Its addresses, this computer's name (also
    with ``.local``) and the one in ``public_url`` are known; a request that names another host is
    refused, for somebody else may have pointed that name here."""
    most_pages: Annotated[int, Field(ge=1, le=1000)] = 100
    """So many pages may be open at once, of which one address may have 20; for browsers on this
    computer there is always room."""
    call_text: Annotated[str, Field(max_length=200)] = ""
    """Whom a visitor should call when the cell needs help, such as ``Call 1234.``; shown with every
    fault. Empty: a sentence that asks to tell the people who look after the cell."""
    theme: Literal["auto", "light", "dark"] = "auto"
    """``auto`` follows what the browser's system prefers; every visitor can choose."""
    visitors_may_act: bool = True
    """``false`` shows only: no buttons, no typed words."""

    operator_from: Literal["here", "network"] = "here"
    """Who may log in to the operator's view: ``here``, browsers on this computer (or behind a proxy
    on it); ``network``, whoever the page is served to. The passphrase is as safe on its way as the
    connection: let a proxy with TLS serve it to a network that others use, too."""
    operator_idle_s: Annotated[float, Field(ge=60.0, le=86_400.0)] = 900.0
    """An operator who does nothing for so long is logged out (wall time)."""

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        try:
            ipaddress.ip_address(self.address)
        except ValueError:
            raise ValueError(f"address must be an IP address (not {self.address!r})") from None
        parts = urlsplit(self.public_url)
        if self.public_url and (parts.scheme not in {"http", "https"} or not parts.hostname):
            raise ValueError(
                f"public_url must be like http://cell.local:8080 (not {parts.geturl()!r})"
            )
        for name in self.host_names:
            if not re.fullmatch(r"[A-Za-z0-9.-]{1,253}", name):
                raise ValueError(f"host_names are names without a port (not {name!r})")
        return self

    @property
    def home(self) -> str:
        """The address that others use, without a slash at its end; empty when there is none."""
        if self.public_url:
            return self.public_url.rstrip("/")
        address = ipaddress.ip_address(self.address)
        if address.is_loopback or address.is_unspecified:
            return ""
        host = f"[{address}]" if address.version == 6 else str(address)
        return f"http://{host}:{self.port}"
