"""The command line as a whole: every command is found, whether all are loaded or one."""

from __future__ import annotations

import importlib

import pytest
import typer
from typer.main import get_command
from typer.testing import CliRunner

from cellctl.cli.app import COMMANDS, command_line


@pytest.mark.parametrize("module", COMMANDS)
def test_the_table_names_what_a_module_registers(module: str) -> None:
    alone = typer.Typer()
    importlib.import_module(f"cellctl.cli.{module}").register(alone)
    commands = [
        command.name or command.callback.__name__.replace("_", "-")
        for command in alone.registered_commands
        if command.callback is not None
    ]
    groups = [group.name for group in alone.registered_groups]
    assert [*commands, *groups] == list(COMMANDS[module])


def test_one_command_is_found_without_the_others_and_any_with_them() -> None:
    every = {name for names in COMMANDS.values() for name in names}
    assert set(get_command(command_line()).commands) == every  # type: ignore[attr-defined]
    for name in every:
        helped = CliRunner().invoke(command_line(name), [name, "--help"])
        assert helped.exit_code == 0, name
        assert f"cellctl {name}" in helped.stdout
    assert set(get_command(command_line("status")).commands) < every  # type: ignore[attr-defined]


def test_what_is_mistyped_is_answered_with_what_is_near() -> None:
    for name in ("staus", "--help", ""):
        assert len(get_command(command_line(name)).commands) > 40  # type: ignore[attr-defined]
    refused = CliRunner().invoke(command_line("staus"), ["staus"])
    assert refused.exit_code == 2
    assert "status" in refused.output
