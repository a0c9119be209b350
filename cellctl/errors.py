"""What can go wrong: errors that refuse an input, and the catalogue of faults that stop the cell.

An error is for the one who asked: it names what is wrong, where, and what to do about it, and the
cell carries on. A fault stops the cell: it has a code, a cause, and a documented way out that needs
no restart. The catalogue is data, so that the bus, the command line and the docs show the same.
"""

from __future__ import annotations

from enum import IntEnum, StrEnum

from cellctl.assembly import Cell, Role, Value


class ExitStatus(IntEnum):
    """Exit status of every command."""

    DONE = 0
    """Done as asked."""
    INTERNAL = 1
    """Something failed inside cellctl (the log has the details), or no cell answers."""
    USAGE = 2
    """A command, option, file or configuration cannot be used as given, or is refused now."""
    NO_OBJECT = 3
    """The sentence asks for no physical object."""
    CANNOT_PLAN = 4
    """The object cannot be designed, or not be built in this cell."""
    FAULT = 5
    """The cell ended in a fault."""
    DIFFERS = 6
    """The object stands, but differs from the plan."""
    UNFIT = 7
    """``doctor`` found a problem, or a step of ``commission`` failed."""


class CellctlError(Exception):
    """Base of every error that cellctl raises on purpose.

    Args:
        message: what is wrong and where.
        hint: what to do about it.
    """

    exit_status = ExitStatus.INTERNAL

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.message} {self.hint}".strip()

    def __reduce__(self) -> tuple[object, ...]:
        return (type(self), (self.message, self.hint))


class UsageError(CellctlError):
    """A command, file or option that cannot be used as given."""

    exit_status = ExitStatus.USAGE


class ConfigError(CellctlError):
    """A configuration file that is missing, unreadable or wrong."""

    exit_status = ExitStatus.USAGE


class HearingError(CellctlError):
    """Speech that cannot be heard: no model, no device, an unreadable file."""

    exit_status = ExitStatus.USAGE


class NoObjectError(CellctlError):
    """The sentence asks for nothing that can be built."""

    exit_status = ExitStatus.NO_OBJECT


class DesignError(CellctlError):
    """No generator can design what was asked for."""

    exit_status = ExitStatus.CANNOT_PLAN


class UnknownObjectError(DesignError):
    """A generator does not know the object, so that the next one may; other refusals are final."""


class Nearest(Value):
    """What could be built instead of what is refused."""

    what: str
    """In words for the visitor."""
    cells: tuple[Cell, ...] = ()
    """What it would consist of; empty where only words are known."""


class PlanError(CellctlError):
    """The shape cannot be built in this cell.

    Args:
        message: what is wrong and where.
        hint: what to do about it.
        rule: name of the check that it fails; empty where no single one is to blame.
        cells: the cells that fail it.
        nearest: the nearest thing that could be built.
    """

    exit_status = ExitStatus.CANNOT_PLAN

    def __init__(
        self,
        message: str,
        hint: str = "",
        rule: str = "",
        cells: tuple[Cell, ...] = (),
        nearest: Nearest | None = None,
    ) -> None:
        super().__init__(message, hint)
        self.rule = rule
        self.cells = cells
        self.nearest = nearest

    def __str__(self) -> str:
        could = f"What could be built: {self.nearest.what}" if self.nearest is not None else ""
        return " ".join(part for part in (self.message, could, self.hint) if part)

    def __reduce__(self) -> tuple[object, ...]:
        return (type(self), (self.message, self.hint, self.rule, self.cells, self.nearest))


class RefusedError(CellctlError):
    """A command that the present state or role does not allow."""

    exit_status = ExitStatus.USAGE


class Severity(StrEnum):
    """Which fault state a fault leads to; each is a substate of ``fault``."""

    HELD = "held"
    """The arm is at rest under power; the program may be started again after a reset."""
    STOPPED = "stopped"
    """The robot's controller stopped the arm (protective or safeguard stop, lost link)."""
    EMERGENCY = "emergency"
    """Emergency stop: power is off the arm; it needs release, power and brakes again."""


class Policy(StrEnum):
    """What the cell does about a fault before a person comes."""

    RETRY = "retry"
    """It tries again by itself, as often as the configuration says, and then holds."""
    WAIT = "wait"
    """It waits for what is needed, for a limited time, and goes on when a person has seen to it."""
    HOLD = "hold"
    """It comes to rest at once, keeps what it holds, and waits for the operator."""
    STOP = "stop"
    """The robot has stopped by itself; the cell keeps still and waits for the operator."""


class FaultEntry(Value):
    """One row of the catalogue."""

    code: str
    severity: Severity
    policy: Policy
    title: str
    """What happened, in a line for the visitor and the operator."""
    causes: tuple[str, ...]
    remedy: str
    """What to do before ``reset``."""
    cleared_by: Role = Role.OPERATOR

    @property
    def leads_to(self) -> str:
        """The state that it leads to; a reset leads from there to ``paused``."""
        return f"fault_{self.severity.value}"


def _catalogue(*entries: FaultEntry) -> dict[str, FaultEntry]:
    return {entry.code: entry for entry in entries}


CATALOGUE: dict[str, FaultEntry] = _catalogue(
    FaultEntry(
        code="belt_empty",
        severity=Severity.HELD,
        policy=Policy.WAIT,
        title="The conveyor has no part to give.",
        causes=("The feedstock is used up.", "The part sensor at the pick station is blocked."),
        remedy="Lay parts on the belt, tell it with `cellctl refill`, then reset and resume.",
    ),
    FaultEntry(
        code="belt_jam",
        severity=Severity.HELD,
        policy=Policy.RETRY,
        title="No part came to the pick station, although there should be some on the belt.",
        causes=(
            "A part is wedged.",
            "The belt slips.",
            "Somebody took parts off the belt.",
            "The part sensor does not see the part.",
        ),
        remedy="Free the parts on the belt, or put some on it, then reset and resume.",
    ),
    FaultEntry(
        code="belt_lost",
        severity=Severity.HELD,
        policy=Policy.RETRY,
        title="The conveyor's board does not answer.",
        causes=("Its USB cable is out.", "Its board has no power."),
        remedy="Check the conveyor's cable and power, then reset and resume.",
    ),
    FaultEntry(
        code="belt_mismatch",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The board on the conveyor's port is not a conveyor that this cellctl can run.",
        causes=("Two serial ports are swapped.", "The board's firmware is of another version."),
        remedy="Correct feeder.port or install the matching firmware, then reset and resume.",
    ),
    FaultEntry(
        code="gripper_silent",
        severity=Severity.HELD,
        policy=Policy.RETRY,
        title="The gripper does not report that its latch has moved.",
        causes=("The status line is broken.", "The gripper has no power.", "The latch is stuck."),
        remedy="Check the gripper's cable, power and latch, then reset and resume.",
    ),
    FaultEntry(
        code="gripper_fault",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The gripper reports a fault of its own (its status line toggles).",
        causes=("The latch servo stalled.", "The gripper's calibration is damaged."),
        remedy=(
            "Look at the latch, and whether a part is in it. Reset; if the part is elsewhere than "
            "the cell then says, tell it with `cellctl recover`; resume."
        ),
    ),
    FaultEntry(
        code="gripper_reset",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The gripper's board was reset, and nobody has confirmed its latch since.",
        causes=(
            "Its supply failed for a moment: a loose plug, or a servo that draws too much.",
            "Its program hung, and its watchdog started it anew.",
        ),
        remedy=(
            "Look whether the part is in the gripper; reset, and resume if it is, or say where it "
            "is with `cellctl recover`, then resume."
        ),
    ),
    FaultEntry(
        code="gripper_mismatch",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The board on the gripper's port is not a gripper that this cellctl can run.",
        causes=("Two serial ports are swapped.", "The board's firmware is of another version."),
        remedy=(
            "Correct gripper.port, install the matching firmware, or leave the port out: the "
            "gripper works without it. Then reset and resume."
        ),
    ),
    FaultEntry(
        code="pick_missed",
        severity=Severity.HELD,
        policy=Policy.RETRY,
        title="The gripper closed but the part is still at the pick station.",
        causes=("The part is yawed or shifted.", "The part sticks to its neighbour."),
        remedy="Straighten the part at the pick station, then reset and resume.",
    ),
    FaultEntry(
        code="not_seated",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="Nothing is felt under the part that was to be let go; it is still in the gripper.",
        causes=(
            "A part below it is missing, or stands lower than it should.",
            "The workspace's frame, or the part in the gripper, is off in height.",
        ),
        remedy=(
            "Look what is under the part. Reset; name what is missing with `cellctl missing`, or "
            "correct the frame; then resume."
        ),
    ),
    FaultEntry(
        code="contact_early",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The part in the gripper met something above its seat; it is still in the gripper.",
        causes=(
            "Something lies or stands on the cell that nobody told of.",
            "A part below stands higher than it should, or the workspace's frame is off in height.",
        ),
        remedy=(
            "Reset, move up with `cellctl hand rise`, and look. Take away what is in the way, or "
            "correct the frame; then resume."
        ),
    ),
    FaultEntry(
        code="part_stuck",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="A part that was let go does not come off the gripper; it still stands at its cell.",
        causes=("The part jams in the gripper.", "The latch says that it is open and is not."),
        remedy="Free the part from the gripper, holding what it stands on; then reset and resume.",
    ),
    FaultEntry(
        code="part_fell",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="A part that was let go in a trial of speed does not stand where it should.",
        causes=("It was set down too hard.", "Its magnets do not hold.", "Somebody took it away."),
        remedy=(
            "Take away what fell, lay it with the stock and say so with `cellctl inventory set`. "
            "Reset; cancel ends the trial, resume places another part there."
        ),
    ),
    FaultEntry(
        code="gripper_holds",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The gripper is latched at the start and may hold a part that nobody knows of.",
        causes=("The cell was switched off, or its daemon ended, with a part in the gripper.",),
        remedy=(
            "Reset; hold the part and open the latch with `cellctl hand open --part-held`, or on "
            "the pendant; then resume."
        ),
    ),
    FaultEntry(
        code="arm_moved",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The arm is not where it was left, and its gripper may hold a part.",
        causes=("The arm was moved by hand while its gripper was opening or closing.",),
        remedy=(
            "Reset, then bring the arm back with `cellctl hand` or the pendant and resume, or "
            "cancel. If a part that stood came along: `cellctl missing` for its cell, then hold "
            "the part and `cellctl hand open --part-held`."
        ),
    ),
    FaultEntry(
        code="no_route",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="There is no safe way from where the arm is.",
        causes=("The arm was moved by hand.", "Something stands where it must pass."),
        remedy=(
            "Reset, then move the arm clear with `cellctl hand rise` or the pendant and resume, or "
            "cancel."
        ),
    ),
    FaultEntry(
        code="protective_stop",
        severity=Severity.STOPPED,
        policy=Policy.STOP,
        title="The robot made a protective stop.",
        causes=("The arm touched something.", "A joint's limit was exceeded."),
        remedy="Look for the cause; reset after 5 s at the earliest, then resume.",
    ),
    FaultEntry(
        code="safeguard_stop",
        severity=Severity.STOPPED,
        policy=Policy.STOP,
        title="A safeguard stopped the robot.",
        causes=("Somebody entered the guarded space.",),
        remedy="Leave the guarded space and release the safeguard, then reset and resume.",
    ),
    FaultEntry(
        code="emergency_stop",
        severity=Severity.EMERGENCY,
        policy=Policy.STOP,
        title="An emergency stop was pressed.",
        causes=("A person pressed an emergency stop button.",),
        remedy="Make the cell safe, release the button, then reset and resume.",
    ),
    FaultEntry(
        code="local_control",
        severity=Severity.STOPPED,
        policy=Policy.STOP,
        title="The robot is in local control and takes no commands from here.",
        causes=("Somebody switched the teach pendant to local.",),
        remedy="Switch the pendant to remote control, then reset and resume.",
    ),
    FaultEntry(
        code="robot_lost",
        severity=Severity.STOPPED,
        policy=Policy.STOP,
        title="The robot's controller does not answer.",
        causes=("It is switched off or starting.", "The network cable is out."),
        remedy="Check that the robot is on and reachable, then reset and resume.",
    ),
    FaultEntry(
        code="program_stopped",
        severity=Severity.STOPPED,
        policy=Policy.STOP,
        title="The robot's program ended although nobody asked it to.",
        causes=("Somebody stopped it on the pendant.", "The robot did not hear its host in time."),
        remedy="Look that the way is free, then reset and resume.",
    ),
    FaultEntry(
        code="motion_timeout",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="A movement took much longer than planned.",
        causes=("The speed slider on the pendant is down.", "The controller is overloaded."),
        remedy="Check the speed slider, then reset and resume.",
    ),
    FaultEntry(
        code="robot_mismatch",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The robot is not the one that the configuration describes.",
        causes=(
            "Model, TCP or payload read back differently from what was set.",
            "Somebody changed the tool's supply or switched an output on the pendant.",
        ),
        remedy="Correct the configuration or the robot's installation, then reset and resume.",
    ),
    FaultEntry(
        code="journal_failed",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="What the cell does cannot be written down, so nothing may move.",
        causes=(
            "The disk is full.",
            "The disk cannot be written, or does not answer.",
            "Somebody moved or replaced the file.",
        ),
        remedy=(
            "Make room on the disk that journal.path names, make it writable, or put the file "
            "back; then reset and resume. Nothing that happened is forgotten meanwhile."
        ),
    ),
    FaultEntry(
        code="journal_damaged",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="The journal is damaged, so nobody knows where the parts are.",
        causes=("The disk is failing.", "Something other than cellctl wrote to the file."),
        remedy=(
            "`cellctl restore FILE` with a backup, or `cellctl journal new` to save what can be "
            "read; then reset and resume, count the parts and tell it with `cellctl inventory set`."
        ),
    ),
    FaultEntry(
        code="internal",
        severity=Severity.HELD,
        policy=Policy.HOLD,
        title="Something failed inside cellctl.",
        causes=("A defect in the software; the log has the details.",),
        remedy="Keep the log for the maintainers, then reset and resume or cancel.",
    ),
)


class CellFault(CellctlError):  # noqa: N818 - a fault is the field's word
    """A fault of the catalogue, raised where it is noticed.

    Args:
        code: a code of ``CATALOGUE``.
        detail: what exactly was seen, in words for the operator.
    """

    exit_status = ExitStatus.FAULT

    def __init__(self, code: str, detail: str = "") -> None:
        self.entry = CATALOGUE[code]
        self.code = code
        self.detail = detail
        super().__init__(f"{self.entry.title} {detail}".strip(), self.entry.remedy)

    def __reduce__(self) -> tuple[object, ...]:
        return (type(self), (self.code, self.detail))
