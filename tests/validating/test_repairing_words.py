"""What a repair says of itself."""

from __future__ import annotations

import pytest

from cellctl.generating.boxes import Box
from cellctl.validating.repairing.collapse import Collapses
from cellctl.validating.repairing.reasons import Reason, reasons, unstable
from cellctl.validating.repairing.score import Wanted
from cellctl.validating.repairing.words import describe
from cellctl.validating.rules import Cells
from tests.validating.shapes import cells_of

COUNT = Reason("count", "Too many.", ())
STABILITY = Reason("stability", "Too weak.", ())


def table(
    width: int = 5, height: int = 3, left: int = 0, depth: int = 3, top: int | None = None
) -> Cells:
    """Two panels of legs, the left one so far from the edge, and a top."""
    return cells_of(
        Box(0, 0, height - 1, top or width, depth, 1),
        *(Box(x, y, 0, 1, 1, height - 1) for x in (left, width - 1) for y in (0, depth - 1)),
    )


def said(wanted: Cells, built: Cells, *why: Reason) -> list[str]:
    return [change.what for change in describe(Wanted(wanted), built, why or (COUNT,))]


def test_nothing_changed_nothing_said() -> None:
    assert said(table(), table()) == []


@pytest.mark.parametrize(
    ("built", "first"),
    [
        (
            table(width=4),
            "It is one part narrower: 4 x 3 x 3 parts (wide, deep, high) instead of 5 x 3 x 3.",
        ),
        (
            table(width=3, height=2),
            "It is two parts narrower and one part lower: 3 x 3 x 2 parts (wide, deep, high) "
            "instead of 5 x 3 x 3.",
        ),
        (table(left=1), "Two legs moved in."),
        (table(top=4), "Its top is one part narrower."),
        (table() - cells_of(Box(0, 0, 0, 1, 1, 2)), "It stands on three legs instead of four."),
        (table() | cells_of(Box(1, 0, 0, 1, 1, 1)), "One leg became thicker."),
        (table() | cells_of(Box(2, 1, 0, 1, 1, 1)), "It stands on five legs instead of four."),
        (table() | cells_of(Box(1, 0, 1, 1, 1, 1)), "One part is added to the legs."),
    ],
)
def test_what_changed_is_named(built: Cells, first: str) -> None:
    assert said(table(), built)[0] == first


def test_a_tier_less_is_named() -> None:
    def shelf(*tiers: int) -> Cells:
        return cells_of(
            Box(0, 0, 0, 1, 2, 6), Box(4, 0, 0, 1, 2, 6), *(Box(0, 0, z, 5, 2, 1) for z in tiers)
        )

    assert said(shelf(1, 3, 5), shelf(1, 5))[0] == "It has two tiers instead of three."


def test_losses_and_gains_have_their_reasons() -> None:
    built = table(width=4) | cells_of(Box(1, 0, 0, 1, 1, 1))
    changes = describe(Wanted(table()), built, (COUNT, STABILITY))
    why = {change.what: change.why for change in changes}
    assert why["One leg became thicker."] == "Too weak."
    assert {w for what, w in why.items() if "narrower" in what} == {"Too many."}


def test_what_became_of_the_legs_is_said_once() -> None:
    assert said(table(), table() | cells_of(Box(1, 0, 0, 1, 1, 1))) == ["One leg became thicker."]


@pytest.mark.parametrize(
    ("margin", "words"),
    [
        (0.9, "would come apart: the magnets have 90% of the strength that it takes."),
        (
            1.92,
            "could come apart: the magnets have 1.92 times the strength that it takes, and 2 "
            "times is asked for.",
        ),
    ],
)
def test_a_margin_is_told_by_what_is_asked_for(margin: float, words: str) -> None:
    cells = cells_of(Box(0, 0, 0, 1, 1, 2))
    collapse = Collapses(moving=cells, state=cells, placed=None, margin=margin, joint="")
    found = unstable(collapse, 2.0)
    assert found.words == f"It {words}"
    # To a visitor it is told without figures.
    assert found.plainly == f"It {words.partition(':')[0]}."


def test_a_change_is_always_told() -> None:
    one, other = cells_of(Box(0, 0, 0, 2, 2, 2)), cells_of(Box(0, 0, 0, 2, 2, 2))
    for cell in sorted(other):
        assert said(one, other - {cell})


def test_broken_rules_are_found_with_their_cells() -> None:
    cells = cells_of(Box(0, 0, 0, 1, 1, 3), Box(2, 0, 2, 1, 1, 1))
    found = {r.rule: r.cells for r in reasons(cells, (3, 1, 3), parts=3, grid=(2, 5, 6))}
    hung = tuple(cells_of(Box(2, 0, 2, 1, 1, 1)))
    assert list(found) == ["workspace", "count", "connectivity", "access"]
    assert found["workspace"] == found["connectivity"] == found["access"] == hung
    assert len(found["count"]) == 4
