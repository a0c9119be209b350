"""Connections that are dropped, frozen or refused, owned inputs, and packages that are wrong."""

from __future__ import annotations

import socket
import struct
import subprocess
import sys
from collections.abc import Iterator

import pytest
from dashboard_client import DashboardClient
from rtde_io import RTDEIOInterface
from rtde_receive import RTDEReceiveInterface

from cellctl.errors import ExitStatus
from tests.sim.ur.harness import Clients, Emulator, wait_until

LOST_AFTER_S = 2.5
"""The clients give a silent controller up after this time."""


@pytest.fixture
def emulator() -> Iterator[Emulator]:
    with Emulator() as running:
        yield running


@pytest.mark.parametrize("arguments", ["", "reset=true"])
def test_a_dropped_connection_is_noticed_and_can_be_made_again(
    emulator: Emulator, arguments: str
) -> None:
    receive = RTDEReceiveInterface(emulator.host)
    emulator.inject("drop_connections", arguments)
    wait_until(lambda: not receive.isConnected())
    assert receive.reconnect()
    before_s = receive.getTimestamp()
    wait_until(lambda: receive.getTimestamp() > before_s)
    receive.disconnect()


def test_a_frozen_controller_is_given_up_and_lives_on(emulator: Emulator) -> None:
    receive = RTDEReceiveInterface(emulator.host)
    before_s = receive.getTimestamp()
    emulator.inject("freeze")
    wait_until(lambda: not receive.isConnected(), 2 * LOST_AFTER_S)
    assert receive.getTimestamp() - before_s < LOST_AFTER_S
    assert emulator.truth()["connections"]["30004"] == 1
    emulator.clear("freeze")
    assert receive.reconnect()
    # Cell time went on while nobody could see it.
    assert receive.getTimestamp() - before_s > 0.9 * LOST_AFTER_S
    wait_until(lambda: emulator.truth()["connections"]["30004"] == 1)
    receive.disconnect()


def test_a_short_freeze_is_made_up_for(emulator: Emulator) -> None:
    dashboard = DashboardClient(emulator.host)
    dashboard.connect()
    emulator.inject("freeze")
    with socket.create_connection((emulator.host, 29999), 5.0) as late:
        late.settimeout(5.0)
        late.sendall(b"robotmode\n")
        emulator.clear("freeze")
        with late.makefile("rb") as replies:
            assert replies.readline().startswith(b"Connected:")
            assert replies.readline() == b"Robotmode: RUNNING\n"
    assert "RUNNING" in dashboard.robotmode()
    dashboard.disconnect()


def test_a_controller_that_refuses_keeps_the_connections_it_has(emulator: Emulator) -> None:
    receive = RTDEReceiveInterface(emulator.host)
    emulator.inject("refuse_connections")
    with pytest.raises(RuntimeError, match="Could not connect"):
        RTDEReceiveInterface(emulator.host)
    before_s = receive.getTimestamp()
    wait_until(lambda: receive.getTimestamp() > before_s)
    emulator.clear("refuse_connections")
    other = RTDEReceiveInterface(emulator.host)
    other.disconnect()
    receive.disconnect()


def test_inputs_belong_to_the_connection_that_asked_first(emulator: Emulator) -> None:
    first = RTDEIOInterface(emulator.host)
    with pytest.raises(RuntimeError, match="already in use"):
        RTDEIOInterface(emulator.host)
    assert first.setStandardDigitalOut(0, True)
    wait_until(lambda: emulator.truth()["outputs"] == 1)
    first.disconnect()
    wait_until(lambda: emulator.truth()["connections"]["30004"] == 0)
    second = RTDEIOInterface(emulator.host)
    assert second.setStandardDigitalOut(0, False)
    wait_until(lambda: emulator.truth()["outputs"] == 0)
    second.disconnect()


def test_an_unknown_variable_is_named_by_the_client(emulator: Emulator) -> None:
    with pytest.raises(RuntimeError, match="no_such_variable"):
        RTDEReceiveInterface(emulator.host, 500.0, ["timestamp", "no_such_variable"])


def test_wrong_packages_are_counted_and_hurt_nobody(emulator: Emulator) -> None:
    with socket.create_connection((emulator.host, 30004), 5.0) as rogue:
        rogue.sendall(struct.pack(">HBB", 4, ord("U"), 7))  # data for a recipe that is not there
        rogue.sendall(struct.pack(">HB", 3, ord("?")))
        rogue.sendall(struct.pack(">HB", 3, ord("O")))  # too short to be one
        wait_until(lambda: emulator.truth()["rtde"]["malformed"] == 3)
        rogue.sendall(struct.pack(">HB", 1, ord("U")))  # shorter than its own header
        rogue.settimeout(5.0)
        assert rogue.recv(1) == b""
    with socket.create_connection((emulator.host, 30003), 5.0) as rogue:
        rogue.sendall(b"this is no program\nend\n")
        wait_until(lambda: emulator.truth()["counters"]["program_errors"] == 1)
    with Clients(emulator.host) as robot:
        assert robot.control.moveL(robot.lifted(0.02), 0.25, 1.2)


def test_a_taken_address_is_refused_in_words(emulator: Emulator) -> None:
    command = [sys.executable, "-m", "cellctl.sim.ur", "--host", emulator.host]
    second = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )
    assert second.returncode == ExitStatus.USAGE
    assert f"cannot listen on {emulator.host}:30004" in second.stderr
