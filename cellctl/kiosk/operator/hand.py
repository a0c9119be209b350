"""Movements by hand: in steps, home, above a cell; the latch, the belt, the gripper's board."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from typing import Final

from cellctl.assembly import Cell
from cellctl.kiosk.components import Button, Text, box
from cellctl.kiosk.operator.desk import MOVING_S, Desk
from cellctl.kiosk.operator.form import Field, Form, Values, cells, number
from cellctl.messages import GripperCommand, HandCommand, HandMove

_WAYS: Final[tuple[tuple[str, tuple[int, int, int]], ...]] = (
    ("x_less", (-1, 0, 0)),
    ("x_more", (1, 0, 0)),
    ("y_less", (0, -1, 0)),
    ("y_more", (0, 1, 0)),
    ("z_less", (0, 0, -1)),
    ("z_more", (0, 0, 1)),
)
_STEPS_MM: Final = (1, 5, 20, 50)
_ROUTES: Final[tuple[HandMove, ...]] = ("rise", "retreat", "home", "above_station")
_DEVICES: Final[tuple[HandMove, ...]] = ("close", "open", "check_lines", "index")


class Hand:
    """What an operator's hand can do, while the cell is paused."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._step_mm = 5
        self._buttons: list[Button] = []
        say = desk.words.say
        self._why = Text("p", "", "hint")
        with box("div", "grid grid--two"):
            with box("section", "panel", aria_labelledby="jog"):
                Text("h2", say("hand.jog"), "panel__title").props["id"] = "jog"
                Text("p", say("hand.jog_what"), "small")
                self._jogging()
            with box("section", "panel", aria_labelledby="routes"):
                Text("h2", say("hand.routes"), "panel__title").props["id"] = "routes"
                Text("p", say("hand.routes_what"), "small")
                with box("div", "row"):
                    for move in _ROUTES:
                        self._add(move, self._asking(move))
                self._above = Form(
                    desk.words,
                    (Field("cell", say("hand.cell"), "text", hint="2,3,0"),),
                    say("hand.above_cell"),
                    self._go_above,
                )
            with box("section", "panel", aria_labelledby="latch"):
                Text("h2", say("hand.latch"), "panel__title").props["id"] = "latch"
                self._holding = Text("p", "", "small")
                with box("div", "row"):
                    for move in _DEVICES:
                        self._add(move, self._asking(move))
                    self._add(
                        "open_held",
                        desk.asking_first(
                            "open_held", self._moving(HandCommand(move="open", part_held=True))
                        ),
                    )
            self._board_panel()
        self._pose = Text("p", "", "small mono")

    def _add(self, name: str, act: Callable[[], Awaitable[None]]) -> Button:
        button = Button(self._desk.words.say(f"hand.{name}"), act)
        self._buttons.append(button)
        return button

    def _asking(self, move: HandMove) -> Callable[[], Awaitable[None]]:
        return self._desk.asking_first(move, self._moving(HandCommand(move=move)))

    def _moving(self, body: HandCommand) -> Callable[[], Awaitable[None]]:
        async def move() -> None:
            await self._desk.order(body, MOVING_S)

        return move

    def _jogging(self) -> None:
        """Small steps are given at once: they are slow, checked, and end with the step."""
        say = self._desk.words.say
        with box("div", "chips", role="radiogroup", aria_label=say("hand.step")):
            self._chips = {step: self._chip(step) for step in _STEPS_MM}
        self._mark()
        with box("div", "jog"):
            for label, way in _WAYS:
                button = self._add(f"jog_{label}", self._jog(way))
                button.classes(f"jog__{label}")
            for label, sign in (("turn_left", 1), ("turn_right", -1)):
                self._add(label, self._turn(sign)).classes(f"jog__{label}")

    def _chip(self, step: int) -> Button:
        async def choose() -> None:
            self._step_mm = step
            self._mark()

        chip = Button(f"{step} mm", choose, classes="chip")
        chip.props["role"] = "radio"
        return chip

    def _mark(self) -> None:
        for step, chip in self._chips.items():
            chip.props["aria-checked"] = "true" if step == self._step_mm else "false"
            chip.update()

    def _jog(self, way: tuple[int, int, int]) -> Callable[[], Awaitable[None]]:
        async def move() -> None:
            x_m, y_m, z_m = (axis * self._step_mm / 1000.0 for axis in way)
            await self._desk.order(HandCommand(move="jog", delta_m=(x_m, y_m, z_m)), MOVING_S)

        return move

    def _turn(self, sign: int) -> Callable[[], Awaitable[None]]:
        async def move() -> None:
            turn_rad = sign * math.radians(min(15.0, float(self._step_mm)))
            await self._desk.order(HandCommand(move="jog", turn_rad=turn_rad), MOVING_S)

        return move

    async def _go_above(self, values: Values) -> None:
        (place, *_) = cells(values.get("cell", ""), self._desk.words)
        body = HandCommand(move="above_cell", cell=Cell(*place))
        sentence = self._desk.words.say("sure.above_cell", cell=list(place))
        await self._desk.asking_first("above_cell", self._moving(body), lambda: sentence)()

    def _board_panel(self) -> None:
        desk, say = self._desk, self._desk.words.say
        with box("section", "panel", aria_labelledby="board"):
            Text("h2", say("hand.board"), "panel__title").props["id"] = "board"
            Text("p", say("hand.board_what"), "small")
            with box("div", "row"):
                self._asks = [
                    Button(say("hand.board_show"), desk.ordering(GripperCommand(do="show"))),
                    Button(
                        say("hand.board_test"),
                        desk.asking_first("board_test", desk.ordering(GripperCommand(do="test"))),
                    ),
                ]
                self._changes = [
                    Button(
                        say(f"hand.board_{do}"),
                        desk.asking_first(f"board_{do}", desk.ordering(GripperCommand(do=do))),
                    )
                    for do in ("keep", "clear")
                ]
            self._calibration = Form(
                desk.words,
                (
                    Field("latch_pulse_us", say("hand.latch_pulse"), least=500, most=2500),
                    Field("unlatch_pulse_us", say("hand.unlatch_pulse"), least=500, most=2500),
                    Field("travel_ms", say("hand.travel"), least=0, most=5000),
                ),
                say("hand.board_set"),
                self._set,
            )

    async def _set(self, values: Values) -> None:
        words = self._desk.words
        given = {name: int(number(values, name, words)) for name, text in values.items() if text}
        await self._desk.order(GripperCommand.model_validate({"do": "set", **given}))

    def show(self) -> None:
        """Show what can be moved now."""
        desk, words, snapshot = self._desk, self._desk.words, self._desk.snapshot
        possible = desk.takes("hand")
        self._why.show("" if possible else words.say("hand.only_paused"))
        for button in self._buttons:
            button.enable(possible)
        self._above.enable(possible)
        board = snapshot is not None and snapshot.gripper.board is not None
        at_rest = desk.takes("gripper")
        self._asks[0].enable(board)
        for button in (self._asks[1], *self._changes):
            button.enable(board and at_rest)
        self._calibration.enable(board and at_rest)
        holding = snapshot.gripper.holding if snapshot is not None else "nothing"
        self._holding.say(words.say(f"holding.{holding}"))
        pose = snapshot.arm.tcp_pose if snapshot is not None else ()
        told = {axis: f"{pose[i] * 1000:.1f}" for i, axis in enumerate("xyz")} if pose else {}
        self._pose.show(words.say("hand.pose", **told) if told else "")
