"""What is wrong, and the way out: the fault, a part in doubt, and notices."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Final, get_args

from nicegui.element import Element

from cellctl.errors import FaultEntry
from cellctl.kiosk.components import Button, Kind, Text, box, icon, shown
from cellctl.kiosk.operator.desk import MOVING_S, Desk
from cellctl.kiosk.operator.now import order
from cellctl.kiosk.operator.remedies import REMEDIES, steps
from cellctl.messages import (
    FaultData,
    HandCommand,
    PartPlace,
    RecoverCommand,
    RefillCommand,
    Snapshot,
)
from cellctl.notices import Notice

_PLACES: Final[tuple[PartPlace, ...]] = get_args(PartPlace)
_ELSEWHERE: Final = {"count": "parts", "missing": "parts", "hand": "hand", "recover": ""}
"""Actions that need more than a button: where in the view they are done."""


class Troubles:
    """Fault, doubt and notices; nothing when all is well."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._fault = _Fault(desk)
        self._doubt = _Doubt(desk)
        self._notices = _Notices(desk)

    def show(self) -> None:
        """Show the cell as it is known now."""
        snapshot = self._desk.snapshot
        self._fault.show(snapshot)
        self._doubt.show(snapshot)
        self._notices.show(snapshot)


class _Fault:
    """The fault with its causes, its remedy, and the buttons that do it."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        say = desk.words.say
        self._shown: FaultData | None = None
        self._buttons: dict[str, Button] = {}
        with box("section", "trouble trouble--fault", role="alert") as self._whole:
            with box("div", "trouble__head"):
                icon("warn")
                self._title = Text("h2", "", "trouble__title")
                self._code = Text("code", "", "trouble__code")
            self._detail = Text("p", "", "trouble__detail")
            with box("div", "trouble__ways"):
                with box("div"):
                    Text("h3", say("fault.causes"), "label")
                    self._causes = box("ul", "trouble__causes")
                with box("div"):
                    Text("h3", say("fault.remedy"), "label")
                    self._remedy = Text("p", "", "trouble__remedy")
                    self._actions = box("div", "trouble__actions")
            self._later = Text("p", "", "small")

    def show(self, snapshot: Snapshot | None) -> None:
        """Show the fault, and which of its actions are possible."""
        fault = snapshot.fault if snapshot is not None else FaultData()
        shown(self._whole, fault.entry is not None)
        if fault != self._shown:
            self._shown = fault
            if fault.entry is not None:
                self._tell(fault, fault.entry)
        if snapshot is None or fault.entry is None:
            return
        for step in steps(snapshot, fault.entry.code):
            self._buttons[step.action].enable(step.possible and not self._stale)

    @property
    def _stale(self) -> bool:
        return self._desk.page.site.mirror.stale

    def _tell(self, fault: FaultData, entry: FaultEntry) -> None:
        words = self._desk.words
        self._title.say(entry.title)
        self._code.say(entry.code)
        during = words.say("fault.during", state=words.say(f"state.{fault.during}"))
        self._detail.show(" ".join(part for part in (fault.detail, during) if part))
        self._remedy.say(entry.remedy)
        later = "; ".join(fault.later)
        self._later.show(words.say("fault.later", faults=later) if later else "")
        self._causes.clear()
        with self._causes:
            for cause in entry.causes:
                Text("li", cause)
        self._actions.clear()
        with self._actions:
            self._buttons = {name: action(self._desk, name) for name in REMEDIES[entry.code]}


def action(desk: Desk, name: str) -> Button:
    """The button of one action of a remedy."""
    words = desk.words
    kind: Kind = "strong" if name in {"reset", "resume"} else "plain"
    if name in _ELSEWHERE:

        async def lead() -> None:
            desk.go(_ELSEWHERE[name])

        return Button(words.say(f"act.{name}"), lead, kind=kind)
    return Button(words.say(f"act.{name}"), _deed(desk, name), kind=kind)


def _deed(desk: Desk, name: str) -> Callable[[], Awaitable[None]]:
    """What a button of a remedy does."""
    match name:
        case "refill":
            return desk.ordering(RefillCommand())
        case "rise":
            return desk.asking_first("rise", _moving(desk, HandCommand(move="rise")))
        case "open_held":
            body = HandCommand(move="open", part_held=True)
            return desk.asking_first("open_held", _moving(desk, body))
        case "resume" | "cancel":
            return desk.asking_first(name, desk.ordering(order(name)))
        case _:
            return desk.ordering(order(name))


def _moving(desk: Desk, body: HandCommand) -> Callable[[], Awaitable[None]]:
    async def move() -> None:
        await desk.order(body, MOVING_S)

    return move


class _Doubt:
    """A part of which nobody can know where it is: what is believed, and the choices."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        say = desk.words.say
        with box("section", "trouble trouble--doubt", aria_labelledby="doubt") as self._whole:
            Text("h2", say("doubt.title"), "trouble__title").props["id"] = "doubt"
            self._sentence = Text("p", "", "trouble__detail")
            Text("p", say("doubt.what"), "small")
            with box("div", "trouble__actions"):
                self._buttons = [
                    Button(
                        say(f"place.{place}"),
                        desk.asking_first(
                            f"recover_{place}", desk.ordering(RecoverCommand(part=place))
                        ),
                    )
                    for place in _PLACES
                ]

    def show(self, snapshot: Snapshot | None) -> None:
        """Show the doubt, while there is one or a part is in the gripper of a paused cell."""
        in_doubt = snapshot is not None and bool(snapshot.doubt)
        possible = self._desk.takes("recover")
        held = (
            snapshot is not None
            and snapshot.gripper.holding not in {"nothing", "gripped"}
            and possible
        )
        shown(self._whole, in_doubt or held)
        sentence = f"{snapshot.doubt}." if snapshot is not None and in_doubt else ""
        self._sentence.say(sentence or self._desk.words.say("doubt.held"))
        for button in self._buttons:
            button.enable(possible)


class _Notices:
    """What is wrong and does not stop the cell."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._whole: Element = box("div", "notes")
        self._shown: tuple[Notice, ...] = ()

    def show(self, snapshot: Snapshot | None) -> None:
        """Show the notices of now."""
        parts = (snapshot.gripper, snapshot.ears, snapshot.voice) if snapshot is not None else ()
        wanted = tuple(part.notice for part in parts if part.notice is not None)
        shown(self._whole, bool(wanted))
        if wanted == self._shown:
            return
        self._shown = wanted
        self._whole.clear()
        with self._whole:
            for notice in wanted:
                with box("section", "trouble trouble--note"):
                    Text("h2", notice.title, "trouble__title")
                    Text("p", notice.remedy, "trouble__detail")
