"""What a visitor takes home: a page with a picture and a 3D file, and the code that leads there."""

from __future__ import annotations

import segno
from fastapi import Response
from nicegui import app

from cellctl.config import CellConfig
from cellctl.errors import CellctlError
from cellctl.kiosk.components import Text, box, icon
from cellctl.kiosk.shell import Page
from cellctl.kiosk.take_home import JobFiles, picture_svg
from cellctl.kiosk.words import Words
from cellctl.messages import FileKind

_HOUR = {"Cache-Control": "private, max-age=3600"}


def code_image(address: str) -> str:
    """The QR code of an address, as the address of an image."""
    return segno.make(address, error="m").svg_data_uri(scale=8, border=2, dark="#1b2026")


def add_files(files: JobFiles, config: CellConfig) -> None:
    """Serve the files of jobs."""

    @app.get("/job/{job_id}/mesh.glb")
    async def mesh(job_id: str) -> Response:
        return await _file(files, job_id, "mesh")

    @app.get("/job/{job_id}/object.glb")
    async def steps(job_id: str) -> Response:
        return await _file(files, job_id, "steps")

    @app.get("/job/{job_id}/picture.svg")
    async def picture(job_id: str, lang: str = "") -> Response:
        try:
            plan = await files.plan(job_id)
        except CellctlError as error:
            return _missing(error)
        words = Words(lang or config.dialogue.language)
        drawn = picture_svg(plan, files.title(job_id, plan), config, words)
        return Response(drawn, media_type="image/svg+xml", headers=_HOUR)


async def _file(files: JobFiles, job_id: str, kind: FileKind) -> Response:
    """A file of a job, under the name that it is saved by."""
    try:
        found = await files.get(job_id, kind)
    except CellctlError as error:
        return _missing(error)
    name = {"Content-Disposition": f'inline; filename="{found.data.name}"'}
    return Response(found.content, media_type=found.data.media_type, headers=name | _HOUR)


def _missing(error: CellctlError) -> Response:
    return Response(str(error), status_code=404, media_type="text/plain")


async def take_page(page: Page, files: JobFiles, job_id: str) -> None:
    """Build the page of one job's object.

    Args:
        page: the frame.
        files: where they come from.
        job_id: whose object.
    """
    words = page.words
    try:
        plan = await files.plan(job_id)
    except CellctlError:
        with box("section", "take"):
            Text("h1", words.say("take.gone"), "visit__state")
            Text("p", words.say("take.gone_how"), "visit__sentence")
        return
    title = files.title(job_id, plan)
    name = f"{title}-{job_id}".replace(" ", "-").lower()
    address = f"/job/{job_id}/picture.svg?lang={words.language}"
    with box("section", "take"):
        Text("h1", title, "visit__state")
        picture = box("img", "take__picture", src=address)
        picture.props["alt"] = words.say("take.picture_of", title=title)
        with box("div", "take__files"):
            with box("a", "button button--strong", href=address) as save:
                icon("home")
                Text("span", words.say("take.picture"))
            save.props["download"] = f"{name}.svg"
            save.on("click.prevent", js_handler="(event) => cellctl.save(event.currentTarget)")
            with box("a", "button button--plain", href=f"/job/{job_id}/object.glb") as model:
                icon("cell")
                Text("span", words.say("take.model"))
            model.props["download"] = f"{name}.glb"
        Text("p", words.say("take.how"), "small")
