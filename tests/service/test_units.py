"""The units: how exposed they are, and what is left to the daemon under their restrictions."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cellctl.config import KioskSection, load_config
from cellctl.sim.isolation import write_config
from tests.cell.harness import CONFIG, bar
from tests.house.test_install import Target
from tests.leaks import REPOSITORY
from tests.service.machine import Machine, machine, why_not

UNITS = sorted((REPOSITORY / "systemd").glob("*.service"))
WORST_EXPOSURE = 1.8
BROWSER = "cellctl-browser@.service"
BROWSER_EXPOSURE = 4.2
"""A browser's own sandbox needs namespaces and system calls, and it draws on a screen."""
LIBRARIES = ("sounddevice", "vosk", "ctranslate2", "onnxruntime", "scipy.spatial", "rtde_control")

ALLOWED = (
    *("write_state", "write_run", "write_tmp", "read_configuration"),
    *("reach_loopback", "reach_private", "audio", "dialout"),
)
REFUSED = (
    *("write_etc", "write_program", "see_home", "reach_internet", "socket_packet"),
    *("socket_ipv6", "other_device", "more_priority"),
)
# There is no journal daemon in the machine.
LOG = "/var/log/services.log"
INSTALL = "/opt/upgrade/scripts/install"
EMULATED = f"""[Service]
StandardOutput=append:{LOG}
StandardError=append:{LOG}
User=cellctl
RuntimeDirectory=cellctl-emulated
ExecStart=/opt/cellctl/venv/bin/cellctl sim
"""
PROBE = f"""[Service]
StandardError=append:{LOG}
Type=oneshot
Restart=no
ExecStart=
Environment="LIBRARIES={" ".join(LIBRARIES)}"
ExecStart=/opt/cellctl/venv/bin/python /opt/cellctl/probe.py /var/lib/cellctl/probe.json $LIBRARIES
"""
LOGGED = f"""[Service]
StandardOutput=append:{LOG}
StandardError=append:{LOG}
"""
PAGE_PROBE = f"""{LOGGED}
Type=oneshot
Restart=no
ExecStart=
ExecStart=/opt/cellctl/venv/bin/cellctl pause
ExecStart=/opt/cellctl/venv/bin/cellctl resume
ExecStart=/bin/sh -c '! ls /var/lib/cellctl'
ExecStart=/usr/bin/python3 -c 'import socket; socket.socket(socket.AF_INET6)'
"""
"""Orders through the operator's door, a look at what is the daemon's own, and what IPv6 needs."""
IMPATIENT = f"""[Service]
StandardOutput=append:{LOG}
StandardError=append:{LOG}
WatchdogSec=2
RestartSec=0
"""


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is missing")
@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit.name)
def test_the_exposure_is_small(unit: Path) -> None:
    result = subprocess.run(
        ["systemd-analyze", "security", "--offline=yes", "--no-pager", str(unit)],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    found = re.search(r"Overall exposure level for \S+: ([0-9.]+)", result.stdout)
    assert found, result.stdout + result.stderr
    worst = BROWSER_EXPOSURE if unit.name == BROWSER else WORST_EXPOSURE
    assert float(found[1]) <= worst, result.stdout


def test_the_browser_shows_the_page_that_is_served_and_may_reach_no_other_host() -> None:
    unit = (REPOSITORY / "systemd" / BROWSER).read_text(encoding="utf-8")
    kiosk = KioskSection()
    assert f"PAGE=http://{kiosk.address}:{kiosk.port}/" in unit
    assert re.findall(r"^IPAddress\w+=.*", unit, flags=re.MULTILINE) == [
        "IPAddressDeny=any",
        "IPAddressAllow=localhost",
    ]


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machine]:
    if reason := why_not():
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("service")
    target = Target(folder)
    result = target.run("make", "-s", "install")
    assert result.returncode == 0, result.stderr
    base = load_config(CONFIG)
    changes = {
        "cell": base.cell.model_copy(update={"clock_rate": 5.0}),
        # A job is under way until somebody says yes, however busy the machine is.
        "policy": base.policy.model_copy(update={"confirmation_timeout_s": 3000.0}),
        # A busy machine must not stop the arm; the watchdog is proven elsewhere.
        "robot": base.robot.model_copy(update={"host": "192.168.7.7", "watchdog_hz": 5.0}),
        "feeder": base.feeder.model_copy(update={"port": "/run/cellctl-emulated/conveyor"}),
        "journal": base.journal.model_copy(update={"path": "/var/lib/cellctl/journal.db"}),
    }
    write_config(base.model_copy(update=changes), target.root / "etc/cellctl/cell.toml")
    (target.root / "opt/cellctl/bar.json").write_bytes(bar(2, 1, 3))
    shutil.copy(REPOSITORY / "tests/service/probe.py", target.root / "opt/cellctl/probe.py")
    # The machine has a /tmp of its own, and the repository may lie in ours.
    for name in ("scripts", "cellctl", "docs", "config", "systemd"):
        shutil.copytree(REPOSITORY / name, target.root / "opt/upgrade" / name)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(REPOSITORY / name, target.root / "opt/upgrade" / name)
    shutil.copy(target.python, target.root / "opt/upgrade" / target.python.name)
    units = target.root / "etc/systemd/system"
    (units / "emulated.service").write_text(EMULATED)
    shutil.copy(units / "cellctl.service", units / "probe.service")
    shutil.copy(units / "cellctl-kiosk.service", units / "page-probe.service")
    changed = {"probe": PROBE, "cellctl": IMPATIENT, "page-probe": PAGE_PROBE}
    for name, text in (changed | {"cellctl-kiosk": LOGGED}).items():
        (units / f"{name}.service.d").mkdir()
        (units / f"{name}.service.d" / "test.conf").write_text(text)
    with machine(target.root, LOG) as running:
        running.run("systemd-sysusers", "/etc/sysusers.d/cellctl.conf")
        running.run("systemd-tmpfiles", "--create", "/etc/tmpfiles.d/cellctl.conf")
        for group in ("audio", "dialout"):
            running.run("install", "-m", "0640", "-g", group, "/dev/null", f"/srv/{group}")
        yield running


def wait(cell: Machine, what: str, holds: Callable[[], bool], patience_s: float = 60.0) -> None:
    """Wait for something that systemd or the daemon tells."""
    deadline_s = time.monotonic() + patience_s
    while not holds():
        assert time.monotonic() < deadline_s, (
            f"waited in vain for {what}\n{cell.run('cellctl', 'status', check=False).stdout}\n"
            f"{cell.log_tail()}"
        )
        time.sleep(0.05)


def start(cell: Machine) -> None:
    """Start the emulated cell, and the daemon once its conveyor and robot are there."""
    cell.run("systemctl", "start", "emulated.service")
    wait(
        cell,
        "the emulated cell",
        lambda: cell.run("cellctl", "sim", "truth", check=False).returncode == 0,
    )
    cell.run("systemctl", "start", "cellctl.service")  # returns when the daemon has said READY
    wait(cell, "an idle cell", lambda: state(cell) == "idle")


def state(cell: Machine) -> str:
    """Of the daemon's machine; goes on, as an operator does, when the robot heard us too late.

    A busy machine makes that happen: what is proven here is not the arm's watchdog.
    """
    snapshot = json.loads(cell.run("cellctl", "status", "--json").stdout)
    fault, now = snapshot["fault"]["entry"], str(snapshot["state"]["state"])
    if fault is not None and now == "fault_stopped":
        assert fault["code"] in {"program_stopped", "robot_lost"}, snapshot["fault"]
        cell.run("cellctl", "reset", check=False)
    elif now == "paused_resting":
        cell.run("cellctl", "resume", check=False)
    return now


def asked(cell: Machine) -> bool:
    """Whether the object waits for a yes; it is asked for until it does."""
    now = state(cell)
    if now == "idle":
        cell.run("cellctl", "build", "/opt/cellctl/bar.json", check=False)
    return now == "validating_confirming"


def built(cell: Machine) -> bool:
    """Whether the object stands; says yes to it."""
    if state(cell) == "validating_confirming":
        cell.run("cellctl", "yes", check=False)
    snapshot = json.loads(cell.run("cellctl", "status", "--json").stdout)
    return bool(snapshot["job"]["outcome"] == "built")


@pytest.mark.wire
@pytest.mark.shared_cell
def test_what_the_units_restrictions_leave_to_the_daemon(cell: Machine) -> None:
    cell.run("systemctl", "start", "probe.service")
    found = json.loads(cell.path("/var/lib/cellctl/probe.json").read_text())
    assert found["uid"] != 0
    assert found["capabilities"] == 0
    assert found["no_new_privileges"] == "1"
    assert found["seccomp"] == "2"
    assert {name: found[name] for name in ALLOWED} == dict.fromkeys(ALLOWED, "yes")
    assert [name for name in REFUSED if found[name] == "yes"] == []
    assert found["mount"] == -1
    # Whether it is granted depends on the rights of the machine that this one runs on.
    assert cell.property_of("cellctl.service", "LimitNICE") == "30"  # 20 less the niceness
    assert cell.property_of("cellctl.service", "LimitRTPRIO") == "5"
    assert found["child_process"] == 0
    assert found["callback"]
    assert found["libraries"] == dict.fromkeys(LIBRARIES, "yes")


@pytest.mark.wire
@pytest.mark.shared_cell
def test_the_service_builds_and_is_started_again_when_it_hangs(cell: Machine) -> None:
    start(cell)
    assert cell.property_of("cellctl.service", "StatusText")

    wait(cell, "a question", lambda: asked(cell))
    refusal = cell.run("bash", INSTALL, check=False)
    assert refusal.returncode == 1
    assert "refused: a job is under way" in refusal.stderr
    wait(cell, "the object", lambda: built(cell))
    truth = json.loads(cell.run("cellctl", "sim", "truth").stdout)
    # Nearest to the station.
    assert sorted(truth["built"]) == [[x, 0, z] for x in (0, 1) for z in (0, 1, 2)]
    assert truth["violations"] == []

    cell.run("systemctl", "kill", "--kill-who=main", "--signal=STOP", "cellctl.service")
    wait(cell, "a restart", lambda: cell.property_of("cellctl.service", "NRestarts") == "1")
    wait(cell, "the daemon", lambda: cell.property_of("cellctl.service", "ActiveState") == "active")
    snapshot = json.loads(cell.run("cellctl", "status", "--json").stdout)
    assert len(snapshot["standing"]) == 6, f"{snapshot}\n{cell.log_tail()}"

    cell.run("systemctl", "stop", "cellctl.service")
    assert cell.property_of("cellctl.service", "Result") == "success"


@pytest.mark.wire
@pytest.mark.shared_cell
def test_the_page_reaches_the_operators_door_and_nothing_else_of_the_daemon(cell: Machine) -> None:
    start(cell)
    cell.run("systemctl", "start", "page-probe.service")
    assert cell.property_of("page-probe.service", "Result") == "success"
    assert state(cell) == "idle"

    cell.run("systemctl", "start", "cellctl-kiosk.service")
    look = "import urllib.request as u; print(u.urlopen('http://127.0.0.1:8080/operator').status)"
    python = "/opt/cellctl/venv/bin/python"
    wait(cell, "the page", lambda: cell.run(python, "-c", look, check=False).stdout == "200\n")
    cell.run("systemctl", "stop", "cellctl-kiosk.service", "cellctl.service")
    assert cell.property_of("cellctl-kiosk.service", "Result") == "success"


@pytest.mark.wire
@pytest.mark.shared_cell
def test_an_upgrade_that_does_not_start_is_taken_back(cell: Machine) -> None:
    start(cell)
    before = json.loads(cell.run("cellctl", "status", "--json").stdout)
    # What it makes is no daemon: it ends at once.
    python = "PYTHON=/opt/upgrade/python3.11"
    upgrade = cell.run("env", python, "LOG=/dev/null", "bash", INSTALL, check=False)
    assert upgrade.returncode == 1, upgrade.stderr
    assert "the old one runs again, with its journal" in upgrade.stderr
    assert cell.property_of("cellctl.service", "ActiveState") == "active"
    after = json.loads(cell.run("cellctl", "status", "--json").stdout)
    assert after["standing"] == before["standing"]
    assert after["inventory"] == before["inventory"]
    assert cell.path("/opt/cellctl/venv.failed").is_dir()
    assert not cell.path("/opt/cellctl/venv.old").exists()
    cell.run("systemctl", "stop", "cellctl.service")
