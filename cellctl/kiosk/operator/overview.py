"""The cell as it is: in three dimensions, and in a few figures."""

from __future__ import annotations

from cellctl.kiosk.components import Text, box, shown
from cellctl.kiosk.operator.desk import Desk, lasting
from cellctl.kiosk.operator.wishes import Wishes
from cellctl.kiosk.scene.pictures import cell_picture
from cellctl.kiosk.scene.view import CellView
from cellctl.messages import Snapshot

_ROWS = ("robot", "belt", "gripper", "ears", "health", "checks")


class Overview:
    """The first part of the view."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        say = desk.words.say
        with box("div", "grid grid--cell"):
            with box("figure", "panel scene"):
                self._view = CellView(desk.page.site.config, say("cell.scene"))
                self._view.props["data-no3d"] = say("visit.no_3d")
            with box("div", "stack"):
                with box("section", "panel", aria_labelledby="figures"):
                    Text("h2", say("cell.figures"), "panel__title").props["id"] = "figures"
                    with box("dl", "facts"):
                        self._rows = {name: self._row(name) for name in _ROWS}
                self._wishes = Wishes(desk)
        self._nothing = Text("p", say("page.never_sentence"), "hint")

    def _row(self, name: str) -> Text:
        Text("dt", self._desk.words.say(f"cell.{name}"))
        return Text("dd", "-")

    def show(self) -> None:
        """Show the cell as it is known now."""
        snapshot, words = self._desk.snapshot, self._desk.words
        shown(self._nothing, snapshot is None)
        self._wishes.show(snapshot)
        if snapshot is None:
            return
        picture = cell_picture(snapshot)
        self._view.show(picture, words.say("cell.scene_told", count=len(picture.standing)))
        self._view.pose(snapshot.arm.joints_rad if snapshot.arm.connected else ())
        for name, value in self._figures(snapshot).items():
            self._rows[name].say(value)

    def _figures(self, snapshot: Snapshot) -> dict[str, str]:
        words = self._desk.words
        arm, belt, gripper = snapshot.arm, snapshot.conveyor, snapshot.gripper
        lost = words.say("cell.lost")
        moves = words.say("cell.moving" if arm.moving else "cell.resting")
        waiting = words.say("cell.part_waits" if belt.part_present else "cell.no_part")
        health = snapshot.health
        job = snapshot.job
        failed = [check.message for check in job.checks if not check.passed] if job else []
        return {
            "robot": f"{moves} · {words.say(f'safety.{arm.safety}')}" if arm.connected else lost,
            "belt": " · ".join(filter(None, (belt.activity, waiting))) if belt.connected else lost,
            "gripper": words.say(f"holding.{gripper.holding}"),
            "ears": snapshot.ears.sentence or words.say(f"ears.{snapshot.ears.state}"),
            "health": words.say(
                "cell.health_told",
                p99=f"{health.loop_blocked_p99_s * 1000:.0f}",
                worst=f"{health.loop_blocked_max_s * 1000:.0f}",
                uptime=lasting(words, health.uptime_s),
            ),
            "checks": "; ".join(failed) or words.say("cell.checks_passed"),
        }
