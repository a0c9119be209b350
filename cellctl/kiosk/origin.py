"""Where a request to the page comes from."""

from __future__ import annotations

import ipaddress

from fastapi import Request


def address_of(request: Request) -> str:
    """The network address of the one who asks; empty when it is not known."""
    return request.client.host if request.client is not None else ""


def is_here(request: Request) -> bool:
    """Whether it comes from the cell's own computer."""
    return is_loopback(address_of(request))


def is_loopback(address: str) -> bool:
    """Whether a network address is the cell's own computer's."""
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False
