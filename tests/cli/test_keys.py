"""Keys as an operator handles them, and a daemon that keeps its secrets."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cellctl import keys
from cellctl.assembly import Role
from cellctl.cli.app import command_line
from cellctl.client import CellClient
from cellctl.config import BusSection, CellConfig, load_config
from cellctl.errors import ConfigError, RefusedError
from cellctl.sim.isolation import isolated, write_config
from tests.cell.harness import CONFIG
from tests.control.test_keys import free_port

PATIENCE_S = 60.0


def wide_cell(folder: Path) -> tuple[CellConfig, Path]:
    """An emulated cell that other machines reach, and its configuration's file."""
    ports = {name: f"tcp://*:{free_port()}" for name in ("status", "visitor", "operator")}
    bus = BusSection.model_validate({**ports, "keys": str(folder / "keys")})
    config = isolated(load_config(CONFIG), folder).model_copy(update={"bus": bus})
    write_config(config, folder / "cell.toml")
    return config, folder / "cell.toml"


def run(*arguments: str) -> str:
    """Run a command in this process; what it printed."""
    done = CliRunner().invoke(command_line(), arguments, catch_exceptions=False)
    assert done.exit_code == 0
    return done.output


def test_a_wide_end_point_without_keys_is_no_right_configuration(tmp_path: Path) -> None:
    _, file = wide_cell(tmp_path)
    with pytest.raises(ConfigError, match="works with keys only"):
        run("config", "check", str(file))
    run("keys", "make", "--config", str(file))
    assert "right" in run("config", "check", str(file))


def test_keys_are_made_listed_and_revoked(tmp_path: Path) -> None:
    _, file = wide_cell(tmp_path)
    config = ("--config", str(file))
    run("keys", "make", *config)
    assert "No clients" in run("keys", "list", *config)
    for name, role in (("desk", "operator"), ("page", "visitor")):
        out = tmp_path / f"{name}.key"
        said = run("keys", "make", "--client", name, "--role", role, "--out", str(out), *config)
        secret = keys.client_key(out).own.secret.decode()
        assert secret not in said
        assert secret not in run("keys", "list", *config)
    assert [line.split()[:2] for line in run("keys", "list", *config).splitlines()] == [
        ["operator", "desk"],
        ["visitor", "page"],
    ]
    run("keys", "revoke", "page", *config)
    assert "page" not in run("keys", "list", *config)


@pytest.mark.wire
def test_a_daemon_tells_no_secret_whatever_is_asked(tmp_path: Path) -> None:
    config, file = wide_cell(tmp_path)
    run("keys", "make", "--config", str(file))
    files = {}
    for name, role in (("desk", Role.OPERATOR), ("page", Role.VISITOR)):
        files[name] = tmp_path / f"{name}.key"
        keys.make_client(tmp_path / "keys", name, role, files[name])
    environment = {**os.environ, "CELLCTL_KEY": str(files["page"])}
    with (tmp_path / "daemon.log").open("wb") as sink:
        daemon = subprocess.Popen(
            [sys.executable, "-m", "cellctl", "run", "--log-level", "debug", "--config", str(file)],
            stdin=subprocess.DEVNULL,
            stdout=sink,
            stderr=sink,
        )
    try:
        with (
            CellClient.for_role(config, Role.OPERATOR, 10.0, files["desk"]) as desk,
            CellClient.for_role(config, Role.OPERATOR, 10.0, files["page"]) as intruder,
        ):
            snapshot = desk.wait_ready(PATIENCE_S).model_dump_json()
            with pytest.raises(RefusedError, match="does not take this key"):
                intruder.snapshot()
            seen = subprocess.run(
                [sys.executable, "-m", "cellctl", "status", "--config", str(file)],
                capture_output=True,
                text=True,
                env=environment,
                timeout=PATIENCE_S,
                check=True,
            )
            keys.revoke(tmp_path / "keys", "desk")
            with pytest.raises(RefusedError, match="does not take this key"):
                desk.command("stop")
    finally:
        daemon.terminate()
        daemon.wait(PATIENCE_S)
    log = (tmp_path / "daemon.log").read_text()
    assert "cellctl starts" in log
    pairs = [keys.client_key(each).own for each in files.values()]
    pairs.append(keys.server_key(tmp_path / "keys"))
    for text in (log, snapshot, seen.stdout + seen.stderr):
        assert text
        for pair in pairs:
            assert pair.secret.decode() not in text
            assert pair.public.decode() not in text
