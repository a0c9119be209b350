"""The steps by which an operator takes a new cell into use, each seen and confirmed by a person.

Every movement is one of the cell's own hand moves, so it goes through the same route checker as
any other, and its latch and belt are journalled like any other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple, Protocol

from cellctl.assembly import Cell
from cellctl.cli.commissioning import StepRecord
from cellctl.client import CellClient
from cellctl.config import CellConfig
from cellctl.errors import CellctlError
from cellctl.messages import HandCommand, HandMove

FRAMES_SPEED = 0.25
"""Share of a build's speed with which places are approached to be looked at."""
DRY_RUN_SPEED = 0.1
_MOVE_PATIENCE_S = 130.0
"""For the slowest movement (wall time)."""

Answer = Literal["yes", "no", "skip"]


class Operator(Protocol):
    """The person at the cell."""

    def tell(self, text: str) -> None:
        """Show a line."""
        ...

    def ask(self, question: str) -> Answer:
        """Wait for an answer."""
        ...


class StepFailedError(Exception):
    """A step did not pass; the message says why and what to change."""


class StepSkippedError(Exception):
    """The operator left a step out."""


class Step(NamedTuple):
    """One step."""

    name: str
    intro: str
    """What will happen, told before anything does."""
    run: Callable[[], None]


class Walk:
    """All steps of one cell.

    Args:
        config: the cell.
        cell: its operator's door; the cell must be paused, with nothing in it.
        operator: who looks and answers.
    """

    def __init__(self, config: CellConfig, cell: CellClient, operator: Operator) -> None:
        self._config = config
        self._cell = cell
        self._operator = operator
        nx, ny, _ = config.grid
        self._corners = tuple(
            dict.fromkeys([Cell(0, 0, 0), Cell(nx - 1, 0, 0), Cell(0, ny - 1, 0)])
        )

    def steps(self) -> tuple[Step, ...]:
        """In the order in which each can rely on those before it."""
        percent = f"{DRY_RUN_SPEED * 100:.0f} %"
        return (
            Step(
                "lines",
                "The latch opens, closes and opens, to prove the gripper's two lines. "
                "Nothing may be in it.",
                self._lines,
            ),
            Step(
                "latch",
                "The latch opens, closes on a part that you hold into it, and opens again. "
                "The arm stays where it is.",
                self._latch,
            ),
            Step("belt", "The belt brings one part to the pick station.", self._belt),
            Step(
                "frames",
                "The arm goes slowly above the pick station and above three corner cells, "
                f"{self._pitch_cm:g} cm over where it would grip, for you to look.",
                self._frames,
            ),
            Step(
                "dry run",
                f"The arm goes through a small plan at {percent} of its speed, without parts.",
                self._dry_run,
            ),
        )

    def run(self) -> Iterator[StepRecord]:
        """Go through the steps; what came of each, as it ends.

        After a fault, or a movement that was stopped, the rest is skipped.
        """
        able = True
        for step in self.steps():
            if not able:
                note = "the cell was no longer ready for it"
                yield StepRecord(name=step.name, outcome="skipped", note=note)
                continue
            record = self._one(step)
            self._operator.tell(f"{step.name}: {record.outcome} {record.note}".rstrip())
            yield record
            able = self._cell.snapshot().state.state == "paused_resting"

    def _one(self, step: Step) -> StepRecord:
        self._operator.tell(f"\n== {step.name} ==\n{step.intro}")
        try:
            self._confirmed("Go on? Keep the emergency stop in reach.", refused="")
            step.run()
        except StepSkippedError:
            return StepRecord(name=step.name, outcome="skipped", note="by the operator")
        except StepFailedError as failure:
            return StepRecord(name=step.name, outcome="failed", note=str(failure))
        except CellctlError as error:
            return StepRecord(name=step.name, outcome="failed", note=str(error))
        return StepRecord(name=step.name, outcome="passed")

    # --- the steps ----------------------------------------------------------------------------

    def _lines(self) -> None:
        self._move("check_lines")
        gripper = self._config.gripper
        self._confirmed(
            "Did the latch open, close and open?",
            f"Output {gripper.command_output} and input {gripper.status_input} answer, but not by "
            "this latch: look which wires they are, and correct [gripper].",
        )

    def _latch(self) -> None:
        self._move("open")
        self._confirmed("Hold a part up into the gripper, its top face flush. Is it there?")
        self._move("close")
        held = self._operator.ask("Pull it gently. Does the latch hold it?")
        # Nothing goes on with a part in the latch that the cell does not know of.
        while self._operator.ask("Hold the part well: the latch opens. Have you got it?") != "yes":
            self._operator.tell("   The latch stays closed until you have it.")
        self._order(HandCommand(move="open", part_held=True))
        if held != "yes":
            raise StepFailedError(
                "The latch closed and does not hold a part: adjust its travel, or look at the part."
            )

    def _belt(self) -> None:
        self._move("index")
        self._confirmed(
            "Does one part lie straight against the stop at the pick station?",
            "Adjust the part sensor and the stop, so that a part rests straight where it is seen.",
        )

    def _frames(self) -> None:
        self._move("rise", FRAMES_SPEED)
        self._move("above_station", FRAMES_SPEED)
        wrong = []
        over = (
            f"Is the middle of the gripper's lower face {self._pitch_cm:g} cm straight above the "
            "middle of "
        )
        if self._answer(f"{over}the part's top face, and turned like it?") == "no":
            wrong.append(
                "above the pick station: measure by how much it is off, and correct feeder.frame"
            )
        for cell in self._corners:
            self._move("above_cell", FRAMES_SPEED, cell)
            place = f"[{cell.x}, {cell.y}, {cell.z}]"
            where = f"where the top face of a part in cell {place} would be"
            if self._answer(f"{over}{where}?") == "no":
                wrong.append(
                    f"above cell {place}: measure by how much, and correct workspace.frame"
                )
        self._move("home", FRAMES_SPEED)
        if len(wrong) > 1:
            wrong.append("where all are off alike, base.frame or tool.frame is wrong instead")
        if wrong:
            raise StepFailedError(f"The arm was off {'; '.join(wrong)}.")

    def _dry_run(self) -> None:
        for cell in self._corners:
            self._move("above_station", DRY_RUN_SPEED)
            self._move("above_cell", DRY_RUN_SPEED, cell)
        self._move("home", DRY_RUN_SPEED)
        self._confirmed(
            "Did the arm, its cables and its elbow keep clear of everything all the way?",
            "Something of this cell is not in its configuration: move it, or raise "
            "robot.clearance_m, and correct the frames.",
        )

    # --- inside -------------------------------------------------------------------------------

    @property
    def _pitch_cm(self) -> float:
        return self._config.voxel.pitch_m * 100.0

    def _move(self, move: HandMove, speed_fraction: float = 1.0, cell: Cell | None = None) -> None:
        self._order(HandCommand(move=move, speed_fraction=speed_fraction, cell=cell))

    def _order(self, command: HandCommand) -> None:
        reply = self._cell.request(command, timeout_s=_MOVE_PATIENCE_S)
        self._operator.tell(f"   {reply.message}")

    def _answer(self, question: str) -> Answer:
        answer = self._operator.ask(question)
        if answer == "skip":
            raise StepSkippedError
        return answer

    def _confirmed(self, question: str, refused: str = "The operator said no.") -> None:
        if self._answer(question) == "no":
            if not refused:
                raise StepSkippedError
            raise StepFailedError(refused)
