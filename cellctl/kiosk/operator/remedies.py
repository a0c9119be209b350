"""What the operator can do about each fault, as buttons: the catalogue's remedies without a shell.

A remedy is words for what a person has to see to in the room, and these actions in their order.
What only a shell on the cell's computer can do (a backup, another configuration) stays words.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from cellctl.errors import CATALOGUE
from cellctl.messages import Snapshot

_TABLE: Final = """
belt_empty        refill reset resume
belt_jam          reset refill count resume
gripper_fault     reset recover resume
gripper_reset     reset recover resume
contact_early     reset rise missing count resume cancel
not_seated        reset missing resume
part_stuck        reset resume
part_fell         count reset cancel resume
gripper_holds     reset open_held resume
arm_moved         reset missing open_held hand resume cancel
no_route          reset rise resume cancel
journal_damaged   reset count resume
internal          reset resume cancel
"""
_ELSE: Final = ("reset", "resume")
"""Of all others: a person sees to the cause, and the cell goes on."""

REMEDIES: Final[dict[str, tuple[str, ...]]] = dict.fromkeys(CATALOGUE, _ELSE) | {
    code: tuple(actions) for code, *actions in map(str.split, _TABLE.strip().splitlines())
}
"""Code of the catalogue -> actions, in the order in which they are done."""

COMMANDS: Final[dict[str, str]] = {
    "open_held": "hand",
    "rise": "hand",
}
"""Action -> the command that it gives, where that has another name."""

IN_A_SHELL: Final = frozenset({"restore", "journal"})
"""Commands in the catalogue's remedies that need the cell's own computer."""


@dataclass(frozen=True)
class Step:
    """One action of a remedy."""

    action: str
    possible: bool
    """Whether the machine would take its command now."""


def steps(snapshot: Snapshot, code: str) -> tuple[Step, ...]:
    """The actions against a fault, and which of them the cell would take now."""
    taken = snapshot.state.commands
    return tuple(Step(action, COMMANDS.get(action, action) in taken) for action in REMEDIES[code])
