"""The chain of generators: a wish goes from one to the next until one knows the object.

What computes runs where the caller says, such as in the designer process; what waits for a service
runs here, in the caller's loop, and ends with the caller's task.
"""

from __future__ import annotations

import asyncio
import dataclasses
import importlib
from collections.abc import Awaitable, Callable, Collection
from typing import TYPE_CHECKING, NamedTuple, Protocol

from cellctl.config import CellConfig
from cellctl.control.design_model import ask_model
from cellctl.control.designing import design_by, read_description, read_model
from cellctl.credentials import find_credential
from cellctl.errors import DesignError, UnknownObjectError
from cellctl.generating.wording import refuse_no_object, with_article

if TYPE_CHECKING:
    from cellctl.assembly import Request
    from cellctl.generating.remote.http import Service
    from cellctl.mesh import GeneratedMesh

Progress = Callable[[str], None]
"""Receives a line for the visitor."""

BY_MYSELF = frozenset({"description", "catalogue"})
"""Generators that need no network."""
_NAMES = {"meshy": "Meshy", "tripo": "Tripo", "server": "the model server"}


class Designed(NamedTuple):
    """A shape, and the generator of ``generating.chain`` that made it."""

    mesh: GeneratedMesh
    by: str


class Compute(Protocol):
    """Runs a function that takes its time, somewhere that does not keep the loop."""

    def __call__(
        self, function: Callable[..., GeneratedMesh], *arguments: object
    ) -> Awaitable[GeneratedMesh]:
        """The function's result, or what it raises."""
        ...


async def design_by_chain(
    request: Request,
    config: CellConfig,
    compute: Compute,
    progress: Progress,
    *,
    skip: Collection[str] = (),
) -> Designed:
    """The shape from the first generator of ``generating.chain`` that can make it.

    Its provenance says who made it, and why none before did.

    Args:
        request: what is wanted.
        config: the cell.
        compute: runs what takes its time.
        progress: told how far a service is.
        skip: generators that are not asked.

    Raises:
        NoObjectError: the request asks for no object, or for one that shall not be built.
        DesignError: none can make it; the message is that of the one that came nearest.
    """
    refuse_no_object(request)
    passed: list[str] = []
    unknown: DesignError | None = None
    failed: DesignError | None = None
    for name in config.generating.chain:
        if name in skip:
            continue
        try:
            if name in BY_MYSELF:
                mesh = await compute(design_by, name, request, config)
            elif name == "model":
                mesh = await _modelled(request, config, compute, progress)
            else:
                content = await _asked(name, request, config, progress)
                mesh = await compute(read_model, content, request, _NAMES[name])
        except UnknownObjectError as refusal:
            unknown = unknown or refusal
            passed.append(f"{name}: not known")
        except DesignError as refusal:
            if name in BY_MYSELF:
                raise  # it knows the object, and why it cannot be had so
            failed = refusal
            passed.append(f"{name}: {refusal.message}")
            progress(refusal.message)
        else:
            if passed:
                why = f"{mesh.provenance}; before it {'; '.join(passed)}"
                mesh = dataclasses.replace(mesh, provenance=why)
            return Designed(mesh, name)
    if failed is not None and unknown is not None:
        raise DesignError(failed.message, f"{failed.hint} {unknown.hint}".strip()) from failed
    raise failed or unknown or DesignError("No generator is configured.")


async def _modelled(
    request: Request, config: CellConfig, compute: Compute, progress: Progress
) -> GeneratedMesh:
    """The shape of what a language model describes."""
    name = config.understanding.model_name
    progress(f"I am asking {name} to describe {_prompt(request)}.")
    return await compute(
        read_description, await ask_model(_prompt(request), config), request, config, name
    )


async def _asked(name: str, request: Request, config: CellConfig, progress: Progress) -> bytes:
    """A GLB from a service."""
    # Loading the client takes longer than the loop may be kept.
    await asyncio.to_thread(importlib.import_module, "cellctl.generating.remote.tasks")
    from cellctl.generating.remote import meshy, server, tripo  # noqa: PLC0415 - few cells have one
    from cellctl.generating.remote.tasks import make_model  # noqa: PLC0415

    settings, prompt = config.generating, _prompt(request)
    timeout_s, most_bytes = settings.timeout_s, int(settings.max_download_mb * 1e6)
    progress(f"I am asking {_NAMES[name]} for {prompt}.")
    match name:
        case "meshy":
            service = _service(name, settings.meshy_url, meshy.KEY, config)
            return await make_model(
                meshy.Meshy(service), prompt, progress, timeout_s=timeout_s, most_bytes=most_bytes
            )
        case "tripo":
            service = _service(name, settings.tripo_url, tripo.KEY, config)
            return await make_model(
                tripo.Tripo(service), prompt, progress, timeout_s=timeout_s, most_bytes=most_bytes
            )
        case _:
            service = _service(name, settings.server_url, server.KEY, config, needs_key=False)
            return await server.ask_server(
                service, prompt, progress, timeout_s=timeout_s, most_bytes=most_bytes
            )


def _service(
    name: str, url: str, key_name: str, config: CellConfig, *, needs_key: bool = True
) -> Service:
    """A service and its key.

    Raises:
        ServiceError: it wants a key and there is none.
        ConfigError: the key cannot be read.
    """
    from cellctl.generating.remote.http import Service, ServiceError  # noqa: PLC0415

    found = find_credential(key_name)
    if found is None and needs_key:
        raise ServiceError(
            f"There is no key for {_NAMES[name]} ({key_name}).",
            "The operator has to give one, as docs/designing.md says.",
        )
    return Service(
        name=_NAMES[name],
        url=url,
        key_name=key_name,
        key=found.secret if found is not None else None,
        answer_timeout_s=config.generating.answer_timeout_s,
    )


def _prompt(request: Request) -> str:
    """What a service is told: the phrase, and nothing else of what was said."""
    return with_article(request.phrase)
