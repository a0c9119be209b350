"""What the paper says in words: the requests of section 4.1, and what it says in two ways."""

from __future__ import annotations

from typing import NamedTuple

from cellctl.validating.paper import printed
from cellctl.validating.paper.report import Figure, Mark, Row, Table, compared
from cellctl.validating.paper.sequencing import naive_order
from cellctl.validating.paper.workbench import Workbench


def request_table(bench: Workbench) -> Table:
    """Which phrase names the object of a sentence."""
    rows = tuple(
        Row(
            name=sentence,
            figures=(
                compared(phrase, bench.phrase_of(sentence), "The cell understands by rules."),
            ),
        )
        for sentence, phrase in printed.REQUESTS
    )
    return Table(
        name="requests",
        title="Requests understood",
        source="sections 3.1 and 4.1",
        of="sentence",
        columns=("object",),
        rows=rows,
    )


class _Claim(NamedTuple):
    """Something that the paper says twice, differently."""

    about: str
    printed: str
    elsewhere: str
    here: str


def claim_table(bench: Workbench) -> Table:
    """Where the paper's words disagree, and what this project does or finds."""
    rows = tuple(
        Row(
            name=claim.about,
            figures=(
                Figure(
                    printed=claim.printed,
                    computed=claim.here,
                    mark=Mark.CONTRADICTED,
                    reason=claim.elsewhere,
                ),
            ),
        )
        for claim in _claims(bench)
    )
    return Table(
        name="claims",
        title="Said in two ways",
        source="text",
        of="about",
        columns=("paper and here",),
        rows=rows,
    )


def _claims(bench: Workbench) -> tuple[_Claim, ...]:
    failing = [
        work.subject.title[0].lower() + work.subject.title[1:]
        for work in bench.works
        if naive_order(work.complete.found.cells).mid_air
    ]
    volumes = sorted(round(work.volume_cm3) for work in bench.works)
    times = [work.routes.seconds for work in bench.works]
    longest = max((seconds for seconds in times if seconds is not None), default=None)
    return (
        _Claim(
            "gripper where a part is placed",
            "closes",
            "Section 3.4; algorithm 5 opens it.",
            "opens",
        ),
        _Claim(
            "robot",
            "UR10",
            "Section 3.6, with a reference for the UR10e.",
            bench.config.robot.model.replace("ur", "UR"),
        ),
        _Claim(
            "velocity to acceleration",
            "1:1 or 1:2",
            "Section 4.2.5; table 5 has 1:1 and 2:1. Used: 2 and 1.",
            "2:1",
        ),
        _Claim(
            "needs the connectivity search",
            "stool, shelf, table",
            "Section 4.2; section 4.2.4: only the shelf succeeds without it.",
            ", ".join(failing),
        ),
        _Claim(
            "longest assembly",
            "5 min",
            "Abstract; table 6: 5 min 12 s. Here by the routes of this cell.",
            "none can be built" if longest is None else f"{longest / 60:.1f} min",
        ),
        _Claim(
            "volumes",
            "4279 to 7356 cm³",
            "Section 4.3; table 6: up to 11831 cm³. Here of the stand-ins.",
            f"{volumes[0]} to {volumes[-1]} cm³",
        ),
    )
