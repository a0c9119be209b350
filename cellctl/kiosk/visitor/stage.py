"""The 3D view beside the words: an object that turns, or the cell at work."""

from __future__ import annotations

from cellctl.kiosk.components import Text, attribute, box, shown
from cellctl.kiosk.scene.pictures import Picture, cell_picture, table_picture
from cellctl.kiosk.scene.view import CellView
from cellctl.kiosk.shell import Page
from cellctl.kiosk.visitor.telling import Telling
from cellctl.messages import Snapshot


class Stage:
    """The view and its captions."""

    def __init__(self, page: Page) -> None:
        self._page = page
        words = page.words
        with box("figure", "stage") as self._whole:
            self._view = CellView(page.site.config, words.say("visit.voxels"))
            self._view.props["data-no3d"] = words.say("visit.no_3d")
            with box("figcaption", "stage__captions") as self._captions:
                self._shape = Text("span", words.say("visit.shape"), "stage__caption")
                self._voxels = Text("span", words.say("visit.voxels"), "stage__caption")
                with box("span", "stage__legend") as self._legend:
                    self._added = Text("span", words.say("visit.legend_added"), "legend--added")
                    self._left_out = Text(
                        "span", words.say("visit.legend_left_out"), "legend--left_out"
                    )

    def show(self, now: Telling) -> None:
        """Show the object that is asked about, else the cell."""
        snapshot = self._page.site.mirror.snapshot
        shown(self._whole, snapshot is not None)
        if snapshot is None:
            return
        turns = now.phase == "asking" and now.question == "build" and snapshot.plan is not None
        picture = table_picture(snapshot, _mesh(snapshot)) if turns else cell_picture(snapshot)
        attribute(self._whole, "data-mode", picture.mode)
        shown(self._captions, turns)
        shown(self._shape, bool(picture.mesh))
        shown(self._added, bool(picture.added))
        shown(self._left_out, bool(picture.left_out))
        shown(self._legend, bool(picture.added or picture.left_out))
        self._view.show(picture, self._label(picture))
        self._view.pose(snapshot.arm.joints_rad if snapshot.arm.connected else ())

    def _label(self, picture: Picture) -> str:
        """What it shows, for those who do not see it."""
        count = len(picture.standing) if picture.mode == "cell" else len(picture.kept)
        return self._page.words.say(f"visit.{picture.mode}_picture", count=count)


def _mesh(snapshot: Snapshot) -> str:
    """Address of the shape that the job's object was made from; empty where there is none.

    It is another one for each plan, so that no browser keeps the shape before a change.
    """
    job = snapshot.job
    designed = job is not None and job.request is not None
    return f"/job/{job.job_id}/mesh.glb?plan={job.plan_id}" if job is not None and designed else ""
