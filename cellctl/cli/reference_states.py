"""The page of docs/reference that draws the state machine from its table."""

from __future__ import annotations

from collections import defaultdict

from cellctl.control.states import (
    COMMANDS,
    FAULTS,
    LEAVES,
    STATES,
    TRANSITIONS,
    Event,
    decide,
    leaves_of,
    top_of,
)


def _collapsed(sources: tuple[str, ...]) -> list[str]:
    """Sources with every complete set of substates drawn as its top-level state."""
    tops = list(dict.fromkeys(top_of(source) for source in sources))
    drawn: list[str] = []
    for top in tops:
        mine = [source for source in sources if top_of(source) == top]
        drawn += [top] if set(mine) == set(leaves_of(top)) else mine
    return drawn


def _edges() -> dict[tuple[str, str], list[str]]:
    edges: dict[tuple[str, str], list[str]] = defaultdict(list)
    for row in TRANSITIONS:
        if row.target is None:
            continue
        name = row.event.value
        if row.event in FAULTS:
            edges["working", row.target].append(name)
            continue
        for source in _collapsed(row.sources):
            edges[source, row.target].append(name)
    return edges


def diagram() -> str:
    """The machine as a Mermaid state diagram."""
    lines = ["stateDiagram-v2", "    [*] --> starting", '    state "no fault" as working {']
    for top, subs in STATES.items():
        indent = "    " if top == "fault" else "        "
        if top == "fault":
            lines.append("    }")
        if not subs:
            lines.append(f"{indent}{top}")
            continue
        lines.append(f"{indent}state {top} {{")
        lines += [f'{indent}    state "{sub}" as {top}_{sub}' for sub in subs]
        lines.append(f"{indent}}}")
    for (source, target), events in _edges().items():
        lines.append(f"    {source} --> {target}: {'<br/>'.join(dict.fromkeys(events))}")
    return "\n".join(lines) + "\n"


def _kept() -> list[str]:
    return [
        f"| `{row.event.value}` | {', '.join(_collapsed(row.sources))} |"
        for row in TRANSITIONS
        if row.target is None
    ]


def states_page(note: str) -> str:
    """The whole page."""
    commands = [event for event in Event if event in COMMANDS]
    matrix = []
    for state in LEAVES:
        accepted = [event.value for event in commands if decide(state, event).verdict == "accepted"]
        names = dict.fromkeys("resume" if name.startswith("resume_") else name for name in accepted)
        matrix.append(f"| `{state}` | {', '.join(names)} |")
    return "\n".join(
        [
            note,
            "# The state machine\n",
            "Drawn from the table in `cellctl/control/states.py`. `resume` is one command; which "
            "of its events it becomes depends on how far the job has come. An edge from a state "
            "with substates holds for all of them; one from *no fault* holds for every state "
            "that is no fault, and a worse fault also replaces a lesser one.\n",
            "```mermaid\n" + diagram() + "```\n",
            "## Accepted without a change of state\n",
            "`pause` and `cancel` take effect at the next safe point; the others have nothing "
            "left to do.\n",
            "| event | in |\n| --- | --- |\n" + "\n".join(_kept()) + "\n",
            "## Commands that each state accepts\n",
            "Every other command is refused with a reason. Results that come too late are "
            "ignored.\n",
            "| state | commands |\n| --- | --- |\n" + "\n".join(matrix) + "\n",
        ]
    )
