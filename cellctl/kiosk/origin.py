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
    parsed = _parsed(address)
    return parsed is not None and parsed.is_loopback


def device_of(address: str) -> str:
    """By what an address is counted: with IPv6 by its network, for one device has as many addresses
    of it as it likes."""
    parsed = _parsed(address)
    if parsed is None or parsed.version == 4 or parsed.is_loopback:
        return str(parsed or address)
    # Within one link all devices share the network, and each has one address of it.
    return str(parsed) if parsed.is_link_local else str(ipaddress.ip_network((parsed, 64), False))


def _parsed(address: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """An address, that of IPv4 where one is only written as IPv6; None where it is none."""
    try:
        parsed = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return None
    mapped = parsed.ipv4_mapped if parsed.version == 6 else None
    return mapped or parsed
