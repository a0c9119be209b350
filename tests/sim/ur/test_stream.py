"""The state stream, in process and by a clock that is set by hand: rates, contents, late ticks."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Awaitable, Callable

import pytest

from cellctl.sim.ur.__main__ import EmptyPlant
from cellctl.sim.ur.controller import UrController
from cellctl.sim.ur.options import UrOptions
from cellctl.sim.ur.wire import Kind, PackageReader, package
from tests.sim.ur.harness import fresh_host

TICK_S = 0.002


class Link:
    """A controller, its hand-set clock, and one RTDE client on a socket."""

    def __init__(self, options: UrOptions) -> None:
        self.now_s = 0.0
        self.controller = UrController(options, EmptyPlant(), lambda: self.now_s)
        self._packages = PackageReader()
        self._arrived: list[tuple[int, bytes]] = []

    async def connect(self) -> None:
        await self.controller.start()
        self._reader, self._writer = await asyncio.open_connection(
            self.controller.options.host, 30004
        )

    async def close(self) -> None:
        self._writer.close()
        await self._writer.wait_closed()
        await self.controller.stop()

    async def ask(self, kind: Kind, payload: bytes) -> bytes:
        """Send a request and return the reply."""
        self._writer.write(package(kind, payload))
        while not self._arrived:
            await self._read()
        reply_kind, reply = self._arrived.pop(0)
        assert reply_kind == kind
        return reply

    async def stream(self, frequency_hz: float, names: str) -> str:
        """Ask for variables and start; returns their types."""
        reply = await self.ask(Kind.SETUP_OUTPUTS, struct.pack(">d", frequency_hz) + names.encode())
        assert await self.ask(Kind.START, b"") == b"\x01"
        return reply[1:].decode()

    async def run(self, ticks: int, tick_s: float = TICK_S) -> list[bytes]:
        """Let time pass, and return the data packages that it brought."""
        before = self.controller.truth()["rtde"]["packages_sent"]  # type: ignore[index]
        for _ in range(ticks):
            self.now_s += tick_s
            self.controller.advance(tick_s * self.controller.options.clock_rate)
            await asyncio.sleep(0)
        expected = self.controller.truth()["rtde"]["packages_sent"] - before  # type: ignore[index]
        while len(self._arrived) < expected:
            await self._read()
        arrived, self._arrived = self._arrived, []
        assert all(kind == Kind.DATA for kind, _ in arrived)
        return [payload for _, payload in arrived]

    async def _read(self) -> None:
        data = await asyncio.wait_for(self._reader.read(65536), 10.0)
        assert data
        self._arrived.extend(self._packages.feed(data))


def on_link(options: UrOptions, talk: Callable[[Link], Awaitable[None]]) -> None:
    async def main() -> None:
        link = Link(options)
        await link.connect()
        try:
            await talk(link)
        finally:
            await link.close()

    asyncio.run(main())


@pytest.mark.parametrize(
    ("version", "rate", "asked_hz", "sent_hz"),
    [
        ("5.12", 1.0, 500.0, 500),
        ("5.12", 1.0, 50.0, 50),
        ("5.12", 20.0, 500.0, 500),
        ("3.15", 1.0, 125.0, 125),
        ("3.15", 1.0, 500.0, 125),
    ],
)
def test_the_stream_has_the_rate_asked_for_in_wall_time(
    version: str, rate: float, asked_hz: float, sent_hz: int
) -> None:
    async def talk(link: Link) -> None:
        await link.stream(asked_hz, "timestamp,")
        packages = await link.run(500)
        assert len(packages) == pytest.approx(sent_hz, abs=1)
        (timestamp,) = struct.unpack(">d", packages[-1][1:])
        assert timestamp == pytest.approx(1.0 * rate, rel=0.02)

    model = "ur10" if version == "3.15" else "ur10e"
    on_link(
        UrOptions(
            host=fresh_host(),
            model=model,  # type: ignore[arg-type]
            controller_version=version,  # type: ignore[arg-type]
            clock_rate=rate,
        ),
        talk,
    )


def test_a_late_tick_sends_one_package_and_no_flood() -> None:
    async def talk(link: Link) -> None:
        await link.stream(500.0, "timestamp,")
        assert len(await link.run(1, 0.5)) == 1
        assert len(await link.run(10)) == 10

    on_link(UrOptions(host=fresh_host()), talk)


def test_variables_come_in_the_order_asked_for_and_with_their_types() -> None:
    async def talk(link: Link) -> None:
        names = "robot_mode,actual_q,runtime_state,actual_digital_output_bits,"
        assert await link.stream(500.0, names) == "INT32,VECTOR6D,UINT32,UINT64"
        (payload,) = await link.run(1)
        mode, *joints, runtime, bits = struct.unpack(">Bi6dIQ", payload)[1:]
        assert (mode, runtime, bits) == (7, 1, 0)
        assert tuple(joints) == link.controller.options.initial_joints_rad

    on_link(UrOptions(host=fresh_host()), talk)


def test_what_is_unknown_is_not_found_and_does_not_start() -> None:
    async def talk(link: Link) -> None:
        asked = struct.pack(">d", 500.0) + b"timestamp,no_such_thing,ft_raw_wrench,"
        reply = await link.ask(Kind.SETUP_OUTPUTS, asked)
        assert reply == b"\x00DOUBLE,NOT_FOUND,NOT_FOUND"
        assert await link.ask(Kind.START, b"") == b"\x00"

    on_link(UrOptions(host=fresh_host(), controller_version="3.15", model="ur10"), talk)
