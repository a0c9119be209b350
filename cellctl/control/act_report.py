"""What an act of the arm came to, and what people call its part."""

from __future__ import annotations

from cellctl.assembly import Step
from cellctl.feeding.inventory import Move


class ActReport:
    """What an act came to, where it did not simply succeed."""

    def __init__(self) -> None:
        self.reason = ""
        self.moves: tuple[Move, ...] = ()
        self.belt_indexes: int | None = None

    def failed(self, reason: str, *moves: Move) -> None:
        """It did not do what it should, and that is no fault yet."""
        self.reason = reason
        self.moves = moves


def called(step: Step | None) -> str:
    """What people call the part of a step."""
    return f"Part {step.index + 1}" if step is not None else "The part"
