"""From a request to a shape: ask the generators in turn."""

from __future__ import annotations

from cellctl.assembly import Request
from cellctl.config import CellConfig
from cellctl.errors import DesignError, UnknownObjectError
from cellctl.generating.catalogue import CatalogueGenerator
from cellctl.generating.generator import Generator
from cellctl.generating.parametric import ParametricGenerator
from cellctl.generating.wording import refuse_no_object
from cellctl.mesh import GeneratedMesh

GENERATORS: dict[str, Generator] = {
    generator.name: generator for generator in (ParametricGenerator(), CatalogueGenerator())
}
"""Those that need no network, by their names in ``generating.chain``."""


def design(request: Request, config: CellConfig) -> GeneratedMesh:
    """The shape from the first generator without a network that knows the object.

    Raises:
        NoObjectError: the request asks for no object, or for one that shall not be built.
        DesignError: none knows it, or the one that does cannot have it as it was asked for.
    """
    unknown: UnknownObjectError | None = None
    for name in config.generating.chain:
        if name in GENERATORS:
            try:
                return design_by(name, request, config)
            except UnknownObjectError as refusal:
                unknown = unknown or refusal
    raise unknown or DesignError("No generator without a network is in generating.chain.")


def design_by(name: str, request: Request, config: CellConfig) -> GeneratedMesh:
    """The shape from one of ``GENERATORS``.

    Raises:
        NoObjectError: the request asks for no object, or for one that shall not be built.
        UnknownObjectError: that generator does not know the object.
        DesignError: it knows it, and cannot have it as it was asked for.
    """
    refuse_no_object(request)
    return GENERATORS[name].generate(request, config)
