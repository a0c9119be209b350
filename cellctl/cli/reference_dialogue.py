"""The page of docs/reference that draws the conversation from its table."""

from __future__ import annotations

from collections import defaultdict

from cellctl.control.dialogue.table import STRANGERS, Act, Input, Place, decide

_CELL = "cell_"


def diagram() -> str:
    """The conversation as a Mermaid state diagram; where the machine leads it is drawn once."""
    edges: dict[tuple[Place, Place], list[str]] = defaultdict(list)
    for place in Place:
        for said in Input:
            decision = decide(place, said)
            if decision.place is not place and not said.value.startswith(_CELL):
                edges[place, decision.place].append(said.value)
    lines = ["stateDiagram-v2", "    [*] --> starting"]
    for said in Input:
        if said.value.startswith(_CELL):
            target = decide(Place.FAULT, said).place
            target = decide(Place.STARTING, said).place if target is Place.FAULT else target
            lines.append(f"    the_machine --> {target}: {said}")
    for (source, target), names in edges.items():
        lines.append(f"    {source} --> {target}: {'<br/>'.join(names)}")
    return "\n".join(lines) + "\n"


def _acts() -> list[str]:
    rows = []
    for said in Input:
        if said.value.startswith(_CELL):
            continue
        places: dict[Act, list[str]] = defaultdict(list)
        for place in Place:
            places[decide(place, said).act].append(place.value)
        acts = [
            f"`{act}` {'everywhere' if len(where) == len(Place) else 'in ' + ', '.join(where)}"
            for act, where in places.items()
        ]
        rows.append(f"| `{said}` | {'; '.join(acts)} |")
    return rows


def dialogue_page(note: str) -> str:
    """The whole page."""
    strangers = [f"| `{row.said}` | `{row.act}` in {', '.join(row.places)} |" for row in STRANGERS]
    return "\n".join(
        [
            note,
            "# The conversation\n",
            "Drawn from the table in `cellctl/control/dialogue/table.py`. Of the machine it drives "
            "the question of `validating.confirming` alone, and only `confirm` lets the arm move; "
            "words of command go on to the machine, which knows when they count and from whom. "
            "Wherever the machine goes, the conversation follows it; the hand-over is asked "
            "about while the machine is idle.\n",
            "```mermaid\n" + diagram() + "```\n",
            "## What follows from what is said\n",
            "| said | what is done |\n| --- | --- |\n" + "\n".join(_acts()) + "\n",
            "## While another visitor's job is asked about\n",
            "Its owner answers, or an operator. From anybody else:\n",
            "| said | what is done |\n| --- | --- |\n" + "\n".join(strangers) + "\n",
        ]
    )
