"""Tables 1 to 4 of the paper, and naive against connectivity order."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from cellctl.validating.paper import printed
from cellctl.validating.paper.counting import within_count
from cellctl.validating.paper.policy import Module
from cellctl.validating.paper.report import Figure, Quantity, Row, Table, compared
from cellctl.validating.paper.scaling import Rescaled
from cellctl.validating.paper.sequencing import Order, naive_order
from cellctl.validating.paper.steadying import longest_overhang, within_overhang, within_stack
from cellctl.validating.paper.workbench import Outcome, Workbench, Worked
from cellctl.validating.rules import size_of
from cellctl.validating.words import times


def count_table(bench: Workbench) -> Table:
    """Table 2."""
    return _rescaling_table(
        bench,
        lambda found: within_count(found, printed.LIMITS.inventory_parts),
        printed.COUNT,
        name="count",
        title="Component count and rescaling",
        source="table 2",
    )


def overhang_table(bench: Workbench) -> Table:
    """Table 3."""
    return _rescaling_table(
        bench,
        lambda found: within_overhang(found, printed.LIMITS.overhang_cells),
        printed.OVERHANG,
        name="overhang",
        title="Overhang and rescaling",
        source="table 3",
    )


def stack_table(bench: Workbench) -> Table:
    """Table 4."""
    return _rescaling_table(
        bench,
        lambda found: within_stack(found, printed.LIMITS.stack_cells),
        printed.STACK,
        name="stack",
        title="Vertical stack and rescaling",
        source="table 4",
    )


def _rescaling_table(
    bench: Workbench,
    module: Callable[[Rescaled], Rescaled],
    figures: Mapping[str, printed.Rescaling],
    *,
    name: str,
    title: str,
    source: str,
) -> Table:
    rows = []
    for work in bench.works:
        before = work.baseline
        after = module(before)
        told = figures[work.subject.name]
        check = "pass" if after is before else "fail"
        why = (
            f"{after.changes[0].why} It becomes {_size(after)}."
            if after.changes
            else f"It is {_size(after)} parts large, and within the limit."
        )
        of = partial(_figure, name, work, why=why)
        baseline = of("baseline", told.baseline_parts, len(before.cells), unit="parts")
        rescaled = of("rescaled", told.rescaled_parts, len(after.cells), unit="parts")
        checked = of("check", told.check, check)
        rows.append(Row(name=work.subject.title, figures=(baseline, checked, rescaled)))
    return Table(
        name=name,
        title=title,
        source=source,
        of="object",
        columns=("baseline", "check", "rescaled"),
        rows=tuple(rows),
        note="Each module alone, on the baseline.",
    )


def ablation_table(bench: Workbench) -> Table:
    """Table 1."""
    left_out: tuple[Module | None, ...] = (*Module, None)
    keys = (*Module, "complete")
    rows = []
    for work in bench.works:
        told = printed.ABLATION[work.subject.name]
        figures = []
        for module, key, value in zip(left_out, keys, told, strict=True):
            outcome = work.without(module)
            why = _why(outcome)
            figures.append(_figure("ablation", work, key, value, outcome.verdict, why=why))
        rows.append(Row(name=work.subject.title, figures=tuple(figures)))
    return Table(
        name="ablation",
        title="Feasible without a module",
        source="table 1",
        of="object",
        columns=("no count", "no overhang", "no stack", "no connectivity", "complete"),
        rows=tuple(rows),
        note="The other modules run, in the paper's order; all rules judge the outcome.",
    )


def order_table(bench: Workbench) -> Table:
    """Section 4.2.4 and the fourth column of table 1."""
    rows = []
    for work in bench.works:
        name, complete = work.subject.name, work.complete
        naive = naive_order(complete.found.cells)
        of = partial(_figure, "order", work, own=_verdict(naive), why=_mid_air(naive))
        connected = _figure(
            "order",
            work,
            "connectivity",
            printed.CONNECTED_TEXT,
            _verdict(complete.order),
            why=_mid_air(complete.order),
        )
        by_table = of("table 1", printed.ABLATION[name][3])
        by_text = of("text", printed.NAIVE_TEXT[name])
        rows.append(Row(name=work.subject.title, figures=(by_table, by_text, connected)))
    return Table(
        name="order",
        title="Naive against connectivity-aware order",
        source="table 1 and section 4.2.4",
        of="object",
        columns=("naive, table 1", "naive, text", "connectivity, text"),
        rows=tuple(rows),
        note="Whether every part is joined to the floor when it is placed, at the size that is "
        "built.",
    )


def _figure(
    table: str,
    work: Worked,
    column: str,
    told: Quantity,
    own: Quantity,
    *,
    why: str,
    unit: str = "",
) -> Figure:
    contradiction = printed.CONTRADICTED.get((table, work.subject.name, column), "")
    return compared(told, own, why, unit=unit, contradiction=contradiction)


def _why(outcome: Outcome) -> str:
    """What decides the outcome of a pipeline, in a sentence."""
    if outcome.failed is not None:
        return outcome.failed.message
    found = outcome.found
    return (
        f"The modules that run make it {_size(found)}: {len(found.cells)} parts, which hang out by "
        f"{longest_overhang(found.cells)} at most; every rule is met."
    )


def _verdict(order: Order) -> str:
    return "fail" if order.mid_air else "pass"


def _mid_air(order: Order) -> str:
    if not order.mid_air:
        return "Every part is joined to the floor when it is placed."
    return f"{len(order.mid_air)} of {len(order.cells)} parts would be put into the air."


def _size(found: Rescaled) -> str:
    return times(size_of(found.cells))
