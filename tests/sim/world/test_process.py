"""The emulated cell as a process: it starts, tells the truth, breaks on demand and ends."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import zmq

from cellctl.config import CellConfig
from cellctl.errors import ExitStatus, UsageError
from cellctl.sim.client import NoEmulatedCellError, SimClient
from cellctl.sim.faults import FAULTS, Fault
from cellctl.sim.isolation import isolated, write_config
from cellctl.sim.messages import Argument, CellTruth, Reply
from cellctl.sim.spawn import StartError, emulated_cell
from cellctl.sim.world_values import Imperfections, Where
from tests.sim.world.hand import PARTS, emulated_config

PATIENCE_S = 60.0


@pytest.fixture
def config() -> Iterator[CellConfig]:
    with tempfile.TemporaryDirectory() as folder:
        yield isolated(emulated_config(), Path(folder))


def until(cell: SimClient, holds: Callable[[CellTruth], bool]) -> CellTruth:
    """Wait for something to be the case."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not holds(truth := cell.truth()):
        assert time.monotonic() < deadline_s, f"waited in vain: {truth}"
    return truth


def test_it_tells_the_truth_and_breaks_on_demand(config: CellConfig) -> None:
    with emulated_cell(config, speed=20.0) as cell:
        truth = cell.truth()
        assert truth.counts[Where.BELT] == PARTS
        assert truth.violations == ()
        assert truth.robot["robot_mode"] == "RUNNING"
        assert cell.ping().speed == 20.0
        later = until(cell, lambda now: now.cell_time_s > truth.cell_time_s + 2.0)
        assert later.robot["time_s"] > truth.robot["time_s"]

        cell.inject("protective_stop", cause="a test")
        until(cell, lambda now: now.robot["safety_mode"] == "PROTECTIVE_STOP")
        cell.inject("stuck_input", line=config.gripper.status_input, high=True)
        until(cell, lambda now: now.robot["inputs"] & 1 << config.gripper.status_input)
        cell.clear("stuck_input", line=config.gripper.status_input)
        until(cell, lambda now: not now.robot["inputs"])

        cell.inject("belt_empty")
        assert cell.truth().counts[Where.STOCK] == PARTS
        assert cell.refill(7) == 7
        cell.set_imperfections(Imperfections(missing_share=0.5), relay=True)
        assert 5 < cell.truth().counts[Where.STOCK] < 55
        assert cell.hand_over() == cell.clear_workspace() == 0

        with pytest.raises(UsageError, match="gripper_stuck"):
            cell.inject("griper_stuck")
        cell.shutdown()
        with pytest.raises(NoEmulatedCellError):
            until(cell, lambda _: False)


def test_the_robot_can_refuse_and_the_conveyor_can_be_unplugged(config: CellConfig) -> None:
    address = (config.robot.host, 30004)
    with emulated_cell(config) as cell:
        socket.create_connection(address, PATIENCE_S).close()
        cell.inject("refuse_connections")
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(address, PATIENCE_S)
        cell.clear("refuse_connections")
        socket.create_connection(address, PATIENCE_S).close()

        assert Path(config.feeder.port).exists()
        cell.inject("board_unplugged")
        assert not Path(config.feeder.port).exists()
        assert cell.truth().faults == ("board_unplugged",)
        cell.clear("board_unplugged")
        assert Path(config.feeder.port).exists()


def test_an_injected_output_level_works_the_latch(config: CellConfig) -> None:
    with emulated_cell(config, speed=10.0) as cell:
        cell.inject("stuck_output", line=config.gripper.command_output, high=True)
        until(cell, lambda now: not now.latch["latched"] and not now.latch["moving"])
        cell.clear("stuck_output", line=config.gripper.command_output)
        truth = until(cell, lambda now: bool(now.latch["status"]))
        assert truth.latch["latched"]
        until(cell, lambda now: now.robot["inputs"] == 1 << config.gripper.status_input)


@pytest.fixture(scope="module")
def live() -> Iterator[SimClient]:
    """One emulated cell for tests that leave it as it was."""
    with (
        tempfile.TemporaryDirectory() as folder,
        emulated_cell(isolated(emulated_config(), Path(folder))) as cell,
    ):
        yield cell


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (b"", "No valid request"),
        (b"\xff\x00", "No valid request"),
        (b'{"do": "dance"}', "dance"),
        (b'{"do": "refill", "parts": 0}', "parts"),
        (b'{"do": "inject"}', "fault"),
        (b'{"do": "ping", "nonsense": 1}', "nonsense"),
        (b'{"do": "inject", "fault": "part_yawed", "arguments": {"yaw_rad": [1]}}', "yaw_rad"),
        (b'{"do": "clear", "fault": "belt_empty"}', "nothing to clear"),
    ],
)
def test_a_malformed_request_gets_an_answer(live: SimClient, request_: bytes, message: str) -> None:
    with zmq.Context() as context, context.socket(zmq.REQ) as asking:
        asking.setsockopt(zmq.LINGER, 0)
        asking.connect(live.endpoint)
        asking.send(request_)
        assert asking.poll(int(PATIENCE_S * 1000))
        reply = Reply.model_validate_json(asking.recv())
    assert not reply.ok
    assert message in reply.error


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_every_fault_can_be_injected_and_ended(live: SimClient, fault: Fault) -> None:
    arguments: dict[str, Argument] = {p.name: 0 for p in fault.parameters if p.required}
    if fault.name == "part_taken":
        live.clear_workspace()
        with pytest.raises(UsageError, match="no part stands"):
            live.inject(fault.name, **arguments)
        live.inject("part_put", **arguments)
    live.inject(fault.name, **arguments)
    if fault.once:
        with pytest.raises(UsageError, match="nothing to clear"):
            live.clear(fault.name, **arguments)
    else:
        assert [label.split()[0] for label in live.truth().faults] == [fault.name]
        live.clear(fault.name, **arguments)
    assert live.truth().faults == ()


def test_two_cells_live_side_by_side(config: CellConfig) -> None:
    with tempfile.TemporaryDirectory() as folder:
        other = isolated(emulated_config(), Path(folder))
        with emulated_cell(config) as one, emulated_cell(other) as two:
            one.inject("belt_empty")
            assert two.truth().counts[Where.STOCK] == 0


def test_an_address_that_is_taken_is_told_and_the_first_cell_lives_on(config: CellConfig) -> None:
    with emulated_cell(config) as cell:
        with pytest.raises(StartError, match="addresses"), emulated_cell(config):
            pass
        assert cell.ping().cell == config.cell.name


def test_a_control_socket_that_is_taken_is_told(config: CellConfig, tmp_path: Path) -> None:
    with emulated_cell(config) as cell:
        other = isolated(emulated_config(), tmp_path)
        assert config.emulation is not None
        clash = other.model_copy(update={"emulation": config.emulation})
        with pytest.raises(StartError, match=r"emulation\.control"), emulated_cell(clash):
            pass
        assert cell.ping().cell == config.cell.name


def test_a_real_cell_is_not_emulated(config: CellConfig) -> None:
    real = config.model_copy(update={"emulation": None})
    with pytest.raises(UsageError, match="real"), emulated_cell(real):
        pass


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_it_starts_from_a_file_and_ends_on_a_signal(
    config: CellConfig, tmp_path: Path, number: signal.Signals
) -> None:
    path = tmp_path / "cell.toml"
    write_config(config, path)
    command = [sys.executable, "-m", "cellctl.sim", "--config", str(path), "--speed", "5"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"ready\n"
            process.send_signal(number)
            assert process.wait(PATIENCE_S) == ExitStatus.DONE
        finally:
            process.kill()
    assert not os.path.lexists(config.feeder.port)


def test_it_ends_with_its_parent(config: CellConfig) -> None:
    command = [sys.executable, "-m", "cellctl.sim", "--config", "-"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as process:
        try:
            assert process.stdin is not None
            assert process.stdout is not None
            process.stdin.write(config.model_dump_json().encode() + b"\n")
            process.stdin.flush()
            assert process.stdout.readline() == b"ready\n"
            process.stdin.close()
            assert process.wait(PATIENCE_S) == ExitStatus.DONE
        finally:
            process.kill()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not one line of JSON"),
        (json.dumps({"cell": {}}), "is missing"),
    ],
)
def test_a_wrong_configuration_ends_it_with_a_message(text: str, message: str) -> None:
    command = [sys.executable, "-m", "cellctl.sim", "--config", "-"]
    done = subprocess.run(
        command, input=text, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == ExitStatus.USAGE
    assert message in done.stderr
