"""Designing in the process of a command, by the same chain that a running cell has."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rich.console import Console

from cellctl.assembly import Request
from cellctl.config import CellConfig
from cellctl.control.design_chain import design_by_chain
from cellctl.mesh import GeneratedMesh


def design_here(request: Request, config: CellConfig) -> GeneratedMesh:
    """The shape of a request; what a service tells meanwhile goes to standard error.

    Raises:
        NoObjectError, DesignError: there is none.
    """
    console = Console(stderr=True, highlight=False)

    async def compute(function: Callable[..., GeneratedMesh], *arguments: object) -> GeneratedMesh:
        return function(*arguments)

    designed = asyncio.run(
        design_by_chain(request, config, compute, lambda line: console.print(line, markup=False))
    )
    return designed.mesh
