"""``cellctl kiosk``: the page in front of the cell."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from cellctl import logs
from cellctl.cli.options import ConfigOption, KeyOption, configuration, named_key
from cellctl.errors import UsageError


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def kiosk(
        config: ConfigOption = None,
        address: Annotated[
            str | None, typer.Option(help="IP address to serve on; else kiosk.address.")
        ] = None,
        port: Annotated[
            int | None, typer.Option(min=1, max=65535, help="TCP port; else kiosk.port.")
        ] = None,
        key: KeyOption = None,
        log_level: Annotated[
            Literal["debug", "info", "warning", "error"], typer.Option(help="How much to log.")
        ] = "info",
    ) -> None:
        """Serve the page for visitors and operators until it is told to end."""
        try:
            from cellctl.kiosk.server import serve  # noqa: PLC0415 - an extra
        except ImportError as error:
            raise UsageError(
                "The page needs NiceGUI, which is not installed.",
                "Install cellctl with its extra: cellctl[kiosk].",
            ) from error

        logs.configure(log_level)
        settings = configuration(config)
        changed = {name: value for name, value in (("address", address), ("port", port)) if value}
        section = type(settings.kiosk).model_validate(settings.kiosk.model_dump() | changed)
        serve(settings.model_copy(update={"kiosk": section}), named_key(key))
