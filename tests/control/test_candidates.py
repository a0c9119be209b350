"""Several shapes for one wish: their order, what stays of the wish, and which one is chosen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cellctl.assembly import Intent, Request
from cellctl.config import CellConfig, load_config
from cellctl.control.candidates import choose, design_another, fingerprint
from cellctl.control.proposals import Proposals
from cellctl.description import FamilyDescription
from cellctl.errors import DesignError
from cellctl.generating.boxes import Box, mesh_of
from cellctl.generating.design import design
from cellctl.mesh import GeneratedMesh
from cellctl.wording import load_wording

CONFIG = load_config(Path(__file__).parents[2] / "config" / "sim.toml")


def wish(phrase: str, **more: object) -> Request:
    noun = phrase.rsplit(maxsplit=1)[-1]
    return Request.model_validate(
        {"text": phrase, "intent": Intent.DESIGN, "phrase": phrase, "objects": (noun,), **more}
    )


def all_shown(request: Request, config: CellConfig = CONFIG) -> list[GeneratedMesh]:
    """What is shown when another one is asked for again and again, until there is none."""
    asked = design(request, config)
    shown, present, seen = [asked], asked, frozenset[str]()
    while True:
        seen |= {fingerprint(present, config)}
        try:
            present = design_another(present, Proposals(request, asked, seen), config)
        except DesignError:
            return shown
        shown.append(present)


def test_others_come_in_one_order_each_once_and_end() -> None:
    first, again = all_shown(wish("stool")), all_shown(wish("stool"))
    assert [mesh.provenance for mesh in first] == [mesh.provenance for mesh in again]
    assert len({fingerprint(mesh, CONFIG) for mesh in first}) == len(first) >= 6
    sources = [mesh.provenance.split(",")[0].split(":")[0] for mesh in first]
    assert sources[:2] == ["from a description"] * 2
    assert "from the catalogue" in sources
    assert sources[-1] == "from a description"


def test_what_was_stated_stays() -> None:
    stated = wish("chair", attributes={"legs": 4}, dimensions_m={"height": 0.5})
    described = [m.description for m in all_shown(stated) if m.description is not None]
    assert len(described) >= 3
    for description in described:
        assert isinstance(description, FamilyDescription)
        assert description.attributes["legs"] == 4
        assert description.size_m["height"] == 0.5


def test_a_generator_that_is_not_in_the_chain_is_not_asked() -> None:
    generating = CONFIG.generating.model_copy(update={"chain": ("description",)})
    shown = all_shown(wish("stool"), CONFIG.model_copy(update={"generating": generating}))
    assert all(mesh.provenance.startswith("from a description") for mesh in shown)


def with_budgets(budget_s: float, others_budget_s: float) -> CellConfig:
    budgets = {"budget_s": budget_s, "others_budget_s": others_budget_s}
    planning = CONFIG.planning.model_copy(update=budgets)
    return CONFIG.model_copy(update={"planning": planning})


def unbuildable() -> GeneratedMesh:
    """Two blocks that do not touch."""
    vertices, faces = mesh_of((Box(0, 0, 0, 1, 1, 1), Box(3, 3, 3, 1, 1, 1)), 0.1)
    return GeneratedMesh(vertices, faces, True, "riddle", "from a test", {})


def test_where_the_first_cannot_be_built_another_is_and_says_so() -> None:
    config = with_budgets(0.3, 30.0)
    request = wish("ladder")
    proposals = Proposals(request, design(request, config))
    chosen = choose(unbuildable(), proposals, config, 40, lambda _: None)
    assert chosen.plan is not None
    assert chosen.mesh is not None
    assert chosen.plan.title.startswith("ladder")
    assert "another one than I thought of first" in chosen.plan.changes[0].what
    assert chosen.refusal is not None
    assert chosen.plan.changes[0].why == "It would be several things that do not touch."
    assert len(chosen.tried) == 2


def test_without_time_for_others_the_first_refusal_counts() -> None:
    config = with_budgets(0.3, 0.01)
    chosen = choose(unbuildable(), Proposals(wish("stool")), config, 40, lambda _: None)
    assert chosen.plan is None
    assert chosen.refusal is not None


def test_what_has_no_description_is_shown_in_other_sizes() -> None:
    shown = all_shown(wish("fire extinguisher"))
    heights = [float(np.ptp(mesh.vertices[:, 2])) for mesh in shown]
    assert {round(height / heights[0], 3) for height in heights} >= {0.75, 1.0}


@pytest.mark.parametrize(("noun", "stays"), [("lamp", True), ("bench", False)])
def test_what_would_not_come_apart_is_asked_about(noun: str, stays: bool) -> None:
    chosen = choose(
        design(wish(noun), CONFIG), Proposals(wish(noun), None, frozenset()), CONFIG, 40, print
    )
    assert chosen.plan is not None
    asked = [load_wording("de").translated(question) for question in chosen.plan.questions]
    assert (
        asked
        == ["Allein könnte ich es nicht wieder zerlegen; jemand müsste es festhalten."] * stays
    )
