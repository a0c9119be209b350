"""From words to a shape, and from changes to other ones, with the designer in its own process."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from cellctl.assembly import Intent, Role, Utterance
from cellctl.clock import SystemClock
from cellctl.config import load_config
from cellctl.control.job import Job
from cellctl.control.ledger import Ledger
from cellctl.control.states import Event
from cellctl.control.wishes import Wishes
from cellctl.errors import DesignError
from cellctl.feeding.inventory import Counts
from cellctl.listening.hearing import Hearing
from cellctl.wording import load_wording
from cellctl.worker import WorkerProcess
from tests.cell.harness import CONFIG


def post(event: Event, then: Callable[[], None] | None = None) -> None:  # noqa: ARG001 - protocol
    """The controller's inbox, emptied at once."""
    if then is not None:
        then()


async def visit() -> None:
    config = load_config(CONFIG)
    designer = WorkerProcess("designer")
    wishes = Wishes(
        config,
        SystemClock(),
        hearing=Hearing(config.hearing),
        designer=designer,
        show=lambda _data: None,
        ledger=lambda: Ledger(counts=Counts(stock=40)),
        wording=load_wording("en"),
    )

    async def change(sentence: str) -> str:
        """What is designed after one more sentence."""
        job.change = await wishes.understand(Utterance(text=sentence, source="text"))
        assert job.change.intent is Intent.EDIT
        await wishes.generate(job, post)
        job.change = None
        assert job.generated is not None
        return job.generated.title

    try:
        # Nothing was designed, so that there is nothing to make a chair of.
        job = Job(Role.VISITOR, utterance=Utterance(text="make it a chair", source="text"))
        await wishes.interpret(job, post)
        await wishes.generate(job, post)
        assert job.request is not None
        assert (job.request.intent, job.request.objects) == (Intent.DESIGN, ("chair",))
        assert (await change("with arms")).endswith("arms")
        assert (await change("make it a bench")).startswith("bench")
        assert (await change("no put it back as it was")).endswith("arms")
        assert job.request.objects == ("chair",)
        assert not (await change("undo that")).endswith("arms")
        with pytest.raises(DesignError, match="Nothing was changed"):
            await change("undo")
    finally:
        await designer.close()


def test_a_change_without_a_design_is_a_wish_and_changes_are_taken_back() -> None:
    asyncio.run(visit())
