"""``cellctl keys``: who may reach the cell from other machines."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from cellctl import keys
from cellctl.assembly import Role
from cellctl.cli.options import ConfigOption, configuration
from cellctl.errors import UsageError
from cellctl.passphrase import OPERATOR_CREDENTIAL, PassphraseHash


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(
        help="Keys of clients on other machines, and the cell's own.", no_args_is_help=True
    )
    app.add_typer(group, name="keys")

    @group.command()
    def make(
        client: Annotated[
            str | None, typer.Option(help="Name of the client; without it, the cell's own pair.")
        ] = None,
        role: Annotated[Role, typer.Option(help="Which door the client may use.")] = Role.VISITOR,
        out: Annotated[
            Path | None, typer.Option(help="The client's key file; NAME.key here by default.")
        ] = None,
        config: ConfigOption = None,
    ) -> None:
        """Make the cell's key pair, or a key for one client."""
        folder = Path(configuration(config).bus.keys)
        if client is None:
            if out is not None:
                raise UsageError("--out is for a client's key: give --client NAME, too.")
            typer.echo(f"The cell has a key. Its public half is {keys.make_server(folder)}.")
            return
        file = out if out is not None else Path(f"{client}{keys.SECRET_SUFFIX}")
        keys.make_client(folder, client, role, file)
        typer.echo(
            f"{client} may use the {role}'s door with {file}. It is a secret: bring it to the "
            "client over a safe way, and keep no copy."
        )

    @group.command("list")
    def list_clients(config: ConfigOption = None) -> None:
        """Show who is allowed, by role, name and public key."""
        folder = Path(configuration(config).bus.keys)
        known = keys.clients(folder)
        for client in known:
            typer.echo(f"{client.role:<9} {client.name:<20} {client.public}")
        if not known:
            typer.echo(f"No clients in {folder}.")

    @group.command()
    def revoke(
        name: Annotated[str, typer.Argument(help="Name of the client.")],
        config: ConfigOption = None,
    ) -> None:
        """Take a client's access away, at once and without a restart."""
        keys.revoke(Path(configuration(config).bus.keys), name)
        typer.echo(f"{name} has no access any more.")

    @group.command()
    def passphrase(
        file: Annotated[Path, typer.Argument(help="Where its hash is written; must not exist.")],
    ) -> None:
        """Set the passphrase for the operator's view of the page; only a hash of it is kept."""
        if sys.stdin.isatty():
            said = typer.prompt("Passphrase", hide_input=True, confirmation_prompt=True)
        else:
            said = sys.stdin.readline().rstrip("\n")
        line = PassphraseHash.of(said).line
        keys.write_secret(file, f"{line}\n")
        typer.echo(
            f"Written to {file}. Give it to the page as the credential {OPERATOR_CREDENTIAL}: "
            f"LoadCredential={OPERATOR_CREDENTIAL}:{file.absolute()}"
        )
