"""Table 6 and section 4.3: volumes, times, the FDM reference; and the speeds of section 4.2.5."""

from __future__ import annotations

from cellctl.validating.paper import printed
from cellctl.validating.paper.report import Figure, Row, Table, compared
from cellctl.validating.paper.workbench import Workbench, Worked

TIME_TOLERANCE = 0.10
"""Times of a model of somebody else's cell are equal within this part."""

_VOLUME_TOLERANCE = 0.01


def volume_table(bench: Workbench) -> Table:
    """Volumes of the meshes, and what they come to for one part."""
    parts = {work.subject.name: len(work.complete.order.cells) for work in bench.works}
    shares = {name: told / parts[name] for name, told in printed.VOLUME_CM3.items()}
    unpublished = "No mesh is published; a stand-in has the paper's cells, not its volume."
    unfilled = (
        f"A mesh need not fill its cells: the paper's come to {min(shares.values()):.0f} to "
        f"{max(shares.values()):.0f} cm³ for a part of 1000."
    )
    rows = []
    for work in bench.works:
        name = work.subject.name
        whole = compared(
            printed.VOLUME_CM3[name],
            round(work.volume_cm3),
            unpublished,
            unit="cm3",
            contradiction=_contradiction("volume", work, "volume"),
            tolerance=_VOLUME_TOLERANCE,
        )
        share = compared(
            round(shares[name]),
            round(work.volume_cm3 / parts[name]),
            unfilled,
            unit="cm3",
            tolerance=_VOLUME_TOLERANCE,
        )
        rows.append(Row(name=work.subject.title, figures=(whole, share)))
    return Table(
        name="volume",
        title="Object volume",
        source="table 6",
        of="object",
        columns=("volume", "volume a part"),
        rows=tuple(rows),
        note="Of the mesh at the size that is built; the paper does not print the second column. "
        f"Equal is within {_VOLUME_TOLERANCE:.0%}.",
    )


def time_table(bench: Workbench) -> Table:
    """Times by the paper's own path, and by this cell's routes."""
    robot = bench.config.robot
    rates = [
        printed.TIME_S[work.subject.name] / len(work.complete.order.cells) for work in bench.works
    ]
    model = (
        f"The paper's own times run from {min(rates):.1f} to {max(rates):.1f} s a part, which one "
        "path for all does not explain."
    )
    routes = (
        "This cell crosses no higher than it must, blends its corners, and travels at "
        f"{robot.travel_speed_m_s:g} m/s and {robot.travel_acceleration_m_s2:g} m/s²."
    )
    rows = []
    for work in bench.works:
        told_s = printed.TIME_S[work.subject.name]
        contradiction = _contradiction("time", work, "time")
        rows.append(
            Row(
                name=work.subject.title,
                figures=(
                    _time(told_s, work.square_path_s, model, contradiction),
                    _routed(told_s, work, routes, contradiction),
                ),
            )
        )
    return Table(
        name="time",
        title="Assembly time",
        source="table 6",
        of="object",
        columns=("algorithm 5, 2 m/s, 1 m/s²", "routes of this cell"),
        rows=tuple(rows),
        note="Parts of 10 cm in the paper's order, the latch's time included. "
        f"Equal is within {TIME_TOLERANCE:.0%}.",
    )


def fdm_table(bench: Workbench) -> Table:
    """How many times longer a printer would take for the stool."""
    stool = next(work for work in bench.works if work.subject.name == "stool")
    told_s, routes_s = printed.TIME_S["stool"], stool.routes.seconds
    fdm_s = printed.FDM_H * 3600.0
    why = stool.routes.reason or "The same reference, divided by this cell's time."
    row = Row(
        name="Stool",
        figures=(
            _routed(told_s, stool, "By the routes of this cell.", ""),
            compared(
                round(fdm_s / told_s),
                None if routes_s is None else round(fdm_s / routes_s),
                why,
                unit="times",
                tolerance=TIME_TOLERANCE,
            ),
        ),
    )
    return Table(
        name="fdm",
        title="Against an FDM printer",
        source="section 4.3",
        of="object",
        columns=("assembled in", "faster than FDM"),
        rows=(row,),
        note=f"The reference is the paper's own simulation of a print, {printed.FDM_H} h "
        "(3 d 1 h 45 min), taken as it is; the paper does not print the quotient.",
    )


def speed_table(bench: Workbench) -> Table:
    """The times that the speed and acceleration would take in the units in which they stand."""
    rows = []
    for work in bench.works:
        told_s = printed.TIME_S[work.subject.name]
        contradiction = _contradiction("speed", work, "time")
        rows.append(
            Row(
                name=work.subject.title,
                figures=(_time(told_s, work.millimetres_s, "", contradiction),),
            )
        )
    return Table(
        name="speed",
        title="Speed and acceleration as printed",
        source="tables 5 and 6, section 4.2.5",
        of="object",
        columns=("algorithm 5, 2 mm/s, 1 mm/s²",),
        rows=tuple(rows),
        note="Passed and failed in table 5 are trials with a robot; nothing here repeats them.",
    )


def _time(told_s: int, own_s: float, why: str, contradiction: str) -> Figure:
    return compared(
        told_s,
        round(own_s, 1),
        why,
        unit="s",
        contradiction=contradiction,
        tolerance=TIME_TOLERANCE,
    )


def _routed(told_s: int, work: Worked, why: str, contradiction: str) -> Figure:
    timed = work.routes
    if timed.seconds is None:
        return compared(told_s, None, timed.reason, unit="s", contradiction=contradiction)
    return _time(told_s, timed.seconds, why, contradiction)


def _contradiction(table: str, work: Worked, column: str) -> str:
    return printed.CONTRADICTED.get((table, work.subject.name, column), "")
