"""The page's way to the cell: what may wait, what may not, and whose shape is shown."""

from __future__ import annotations

import asyncio
import hashlib
from pathlib import Path

import pytest
import zmq

from cellctl.assembly import Role
from cellctl.config import CellConfig, load_config
from cellctl.control.door import Answer
from cellctl.errors import UsageError
from cellctl.kiosk.bus_link import BusLink
from cellctl.kiosk.take_home import JobFiles
from cellctl.messages import (
    ControlReply,
    ControlRequest,
    DialogueData,
    FileCommand,
    FileData,
    JobData,
    PlainCommand,
    SayCommand,
)
from tests.control.served import PATIENCE_S, serving, settings
from tests.kiosk.test_mirror import snapshot
from tests.leaks import REPOSITORY

WAITING = 40


def link_to(folder: Path) -> tuple[BusLink, CellConfig]:
    config = load_config(REPOSITORY / "config" / "sim.toml")
    own = config.model_copy(update={"bus": settings(folder)})
    return BusLink(own), own


def answer(request: ControlRequest, **told: object) -> ControlReply:
    return ControlReply.model_validate({"id": request.id, "ok": True, "state": "idle", **told})


def test_a_stop_goes_out_however_many_others_wait(tmp_path: Path) -> None:
    async def exercise() -> None:
        held, stopped = asyncio.Event(), asyncio.Event()

        async def handle(request: ControlRequest, _: bytes | None, _role: Role) -> Answer:
            if request.body.command == "stop":
                stopped.set()
            else:
                await held.wait()
            return Answer(answer(request))

        link, own = link_to(tmp_path)
        async with serving(own.bus, handle):
            waiting = [
                asyncio.create_task(link.ask(SayCommand(text="a stool"), timeout_s=PATIENCE_S))
                for _ in range(WAITING)
            ]
            await asyncio.sleep(0)
            try:
                async with asyncio.timeout(PATIENCE_S / 2):
                    await link.ask(PlainCommand(command="stop"))
                assert stopped.is_set()
                assert not any(task.done() for task in waiting)
            finally:
                held.set()
                await asyncio.gather(*waiting)

    asyncio.run(exercise())


def test_a_shape_that_was_changed_is_not_shown_as_it_was(tmp_path: Path) -> None:
    async def exercise() -> None:
        asked = 0

        async def handle(request: ControlRequest, _: bytes | None, _role: Role) -> Answer:
            nonlocal asked
            assert isinstance(request.body, FileCommand)
            asked += 1
            content = f"shape {asked}".encode()
            data = FileData(
                job_id=request.body.job_id,
                kind=request.body.kind,
                name="shape.glb",
                media_type="model/gltf-binary",
                size_bytes=len(content),
                sha256=hashlib.sha256(content).hexdigest(),
            )
            return Answer(answer(request, data=data), zmq.Frame(content))

        link, own = link_to(tmp_path)
        files = JobFiles(link)
        async with serving(own.bus, handle):
            shown = []
            for plan_id in ("first", "first", "changed", "changed"):
                job = JobData(job_id="job", role=Role.VISITOR, phase="confirming", plan_id=plan_id)
                link.mirror.take_snapshot(snapshot(job=job))
                shown.append((await files.get("job", "mesh")).content.decode())
            link.mirror.take_snapshot(snapshot())
            shown.append((await files.get("job", "mesh")).content.decode())
        assert shown == ["shape 1", "shape 1", "shape 2", "shape 2", "shape 2"]

    asyncio.run(exercise())


def test_what_is_no_jobs_id_is_refused_before_anybody_is_asked(tmp_path: Path) -> None:
    link, _ = link_to(tmp_path)
    with pytest.raises(UsageError, match="is no job"):
        asyncio.run(link.file("mesh", "x" * 65))


def test_a_question_is_shown_with_the_plan_that_it_is_about(tmp_path: Path) -> None:
    """The plan comes with the whole picture only, the question's name with every message."""

    async def exercise() -> None:
        talk = DialogueData(phase="asking", question="build", asked="the first")
        now = snapshot(dialogue=talk, inventory={"plan": 1})

        async def handle(request: ControlRequest, _: bytes | None, _role: Role) -> Answer:
            return Answer(answer(request, snapshot=now))

        link, own = link_to(tmp_path)
        seen: list[tuple[str, int]] = []
        told = asyncio.Event()

        def look() -> None:
            if (there := link.mirror.snapshot) is not None:
                seen.append((there.dialogue.asked, there.inventory["plan"]))
                told.set()

        async with asyncio.timeout(PATIENCE_S), serving(own.bus, handle) as bus, link.following():
            link.mirror.watch(look)
            while not seen:
                await told.wait()
            talk = talk.model_copy(update={"asked": "the second"})
            now = snapshot(bus.seq + 1, dialogue=talk, inventory={"plan": 2})
            while seen[-1][0] != "the second":
                told.clear()
                bus.publish(talk, "validating_confirming")
                now = now.model_copy(update={"seq": bus.seq})
                await told.wait()
        assert set(seen) == {("the first", 1), ("the second", 2)}

    asyncio.run(exercise())
