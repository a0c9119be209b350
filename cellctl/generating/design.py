"""From a request to a shape: ask the generators in turn."""

from __future__ import annotations

from collections.abc import Sequence

from cellctl.assembly import Request
from cellctl.config import CellConfig
from cellctl.errors import DesignError, NoObjectError
from cellctl.generating.generator import Generator
from cellctl.generating.parametric import ParametricGenerator
from cellctl.mesh import GeneratedMesh

GENERATORS: tuple[Generator, ...] = (ParametricGenerator(),)
"""In order of preference."""


def design(
    request: Request, config: CellConfig, generators: Sequence[Generator] = GENERATORS
) -> GeneratedMesh:
    """The shape from the first generator that can design what was asked for.

    Raises:
        NoObjectError: the request asks for no object, or for one that shall not be built.
        DesignError: no generator can; the message is that of the first, the most exact one.
    """
    if not request.buildable:
        raise NoObjectError(
            request.refusal
            or request.reason
            or f"{request.text!r} names no object. Say what to build, such as a simple stool."
        )
    refusals: list[DesignError] = []
    for generator in generators:
        try:
            return generator.generate(request, config)
        except DesignError as refusal:
            refusals.append(refusal)
    raise refusals[0] if refusals else DesignError("No generator is configured.")
