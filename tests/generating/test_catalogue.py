"""The catalogue: what comes with cellctl, what is found in it, and how another one is made."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from cellctl.assembly import Intent, Request
from cellctl.cli.app import command_line
from cellctl.cli.catalogue_build import build_catalogue
from cellctl.config import CellConfig, load_config
from cellctl.errors import ConfigError, PlanError, UnknownObjectError, UsageError
from cellctl.generating.catalogue import (
    CatalogueGenerator,
    load_catalogue,
    occupied,
    shape_of,
    write_catalogue,
)
from cellctl.mesh import GeneratedMesh
from cellctl.validating.clean import clean
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import Shape, fit
from cellctl.validating.plan import plan_build
from cellctl.validating.rules import pieces, size_of

CONFIG = load_config(Path(__file__).parents[2] / "config" / "sim.toml")


def wish(phrase: str, **more: object) -> Request:
    noun = phrase.rsplit(maxsplit=1)[-1]
    return Request.model_validate(
        {"text": phrase, "intent": Intent.DESIGN, "phrase": phrase, "objects": (noun,), **more}
    )


def found(phrase: str, config: CellConfig = CONFIG, **more: object) -> GeneratedMesh:
    return CatalogueGenerator().generate(wish(phrase, **more), config)


def test_every_object_has_an_author_a_licence_and_the_size_that_it_says() -> None:
    catalogue = load_catalogue()
    assert len(catalogue.entries) >= 300
    assert len({entry.entry_id for entry in catalogue.entries}) == len(catalogue.entries)
    for entry in catalogue.entries:
        assert entry.creator
        assert entry.licence in ("CC0 1.0", "CC BY 3.0", "CC BY 3.0 US")
        solid = occupied(entry)
        assert solid.sum() == entry.parts
        assert 8 <= entry.parts <= 200
        # Whole cells: never smaller than the object, nor larger by a cell.
        for cells, size_m in zip(entry.grid, entry.size_m, strict=True):
            assert -0.002 <= cells * catalogue.resolution_m - size_m < 0.1 + 1e-6


@pytest.mark.parametrize("number", range(0, 330, 30))
def test_the_shape_becomes_the_cells_again(number: int) -> None:
    catalogue = load_catalogue()
    entry = catalogue.entries[number]
    vertices, faces = shape_of(entry, catalogue.resolution_m)
    surface = clean(vertices, faces)
    scaled = surface._replace(vertices=surface.vertices / catalogue.resolution_m)
    cells = discretise(Shape(scaled))
    assert len(pieces(cells)) == 1
    assert sorted(map(tuple, cells)) == sorted(map(tuple, np.argwhere(occupied(entry)).tolist()))


def test_a_phrase_is_found_with_its_author() -> None:
    mesh = found("fire hydrant")
    assert mesh.title == "fire hydrant"
    assert mesh.provenance.startswith("from the catalogue, by Kator Legaz, CC BY 3.0 US")
    assert mesh.metric
    assert np.isclose(np.ptp(mesh.vertices[:, 2]), 0.8)


def test_of_several_one_that_needs_no_more_parts_than_there_are() -> None:
    parts: dict[str, dict[str, int]] = {}
    for entry in load_catalogue().entries:
        parts.setdefault(entry.name, {})[entry.entry_id] = entry.parts
    most = CONFIG.limits.inventory_parts
    mixed = {n: ids for n, ids in parts.items() if min(ids.values()) <= most < max(ids.values())}
    assert len(mixed) >= 3
    for name, ids in mixed.items():
        assert ids[found(name).provenance.partition("(")[2].rstrip(")")] <= most


def test_a_stated_size_is_kept_and_attributes_are_not_promised() -> None:
    mesh = found("radiator", dimensions_m={"height": 0.3}, attributes={"legs": 4})
    assert size_of(discretise(fit(mesh, CONFIG).shape))[2] == 3
    assert [change.what for change in mesh.changes] == ["Nobody counted its legs."]


def test_what_is_not_there_is_left_to_the_next() -> None:
    with pytest.raises(UnknownObjectError, match="no violin"):
        found("violin")


@pytest.mark.parametrize("content", [None, b"", b"not a catalogue", b"\x1f\x8b\x08broken"])
def test_a_catalogue_that_cannot_be_read_is_named(content: bytes | None, tmp_path: Path) -> None:
    path = tmp_path / "own.json.gz"
    if content is not None:
        path.write_bytes(content)
    generating = CONFIG.generating.model_copy(update={"catalogue": str(path)})
    with pytest.raises(ConfigError, match=r"own\.json\.gz"):
        found("lamp", CONFIG.model_copy(update={"generating": generating}))


def library(folder: Path, rows: Sequence[tuple[str, tuple[float, float, float], str]]) -> Path:
    """A furniture library with boxes: name, width, depth and height in cm, more properties."""
    lines = ["license=Creative Commons Attribution 3.0 license"]
    with zipfile.ZipFile(folder / "own.sh3f", "w") as archive:
        for number, (name, size_cm, more) in enumerate(rows, 1):
            lines += [
                f"id#{number}=Own#{number}",
                f"name#{number}={name}",
                f"creator#{number}=Somebody",
                f"model#{number}=/own/{number}.obj",
                *(
                    f"{axis}#{number}={cm}"
                    for axis, cm in zip(("width", "depth", "height"), size_cm, strict=True)
                ),
                *(f"{line.replace('=', f'#{number}=')}" for line in more.split(";") if line),
            ]
            archive.writestr(f"own/{number}.obj", trimesh.creation.box().export(file_type="obj"))
        archive.writestr("PluginFurnitureCatalog.properties", "\n".join(lines))
    return folder


def test_another_catalogue_is_made_of_a_folder_of_models(tmp_path: Path) -> None:
    library(
        tmp_path,
        [
            ("Gift box 2", (30, 20, 40), "tags=Present, Blend Swap"),
            ("Coin", (3, 3, 1), ""),
            ("Door", (90, 10, 200), "doorOrWindow=true"),
            ("Hall", (900, 900, 300), ""),
            ("Sword", (100, 20, 20), ""),
            ("Caf\\u00e9 table", (30, 30, 30), ""),
        ],
    )
    told: list[str] = []
    catalogue = build_catalogue(tmp_path, told.append)
    names = {entry.name: entry for entry in catalogue.entries}
    assert set(names) == {"gift box", "café table"}
    gift = names["gift box"]
    assert (gift.grid, gift.parts, gift.creator) == ((3, 2, 4), 24, "Somebody")
    assert (gift.licence, gift.tags) == ("CC BY 3.0", ("present",))
    assert len(told) == 4
    path = tmp_path / "own.json.gz"
    write_catalogue(catalogue, path)
    assert load_catalogue(str(path)) == catalogue


def test_the_command_makes_and_lists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CELLCTL_CONFIG", str(Path(__file__).parents[2] / "config" / "sim.toml"))
    library(tmp_path, [("Crate", (30, 30, 30), "")])
    made = CliRunner().invoke(
        command_line(),
        ["catalogue", "--build", str(tmp_path), "--output", str(tmp_path / "a.json.gz")],
    )
    assert made.exit_code == 0
    assert "1 objects" in made.output
    listed = CliRunner().invoke(command_line(), ["catalogue", "hydrant"])
    assert "by Kator Legaz, CC BY 3.0 US" in listed.output


def test_a_folder_without_models_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no \.sh3f"):
        build_catalogue(tmp_path, print)
    (tmp_path / "a.sh3f").write_bytes(b"no archive")
    with pytest.raises(UsageError, match=r"a\.sh3f"):
        build_catalogue(tmp_path, print)


def planned_or_refused(number: int, budget_s: float) -> str:
    """What planning says of one object: its parts, or a reason."""
    catalogue = load_catalogue()
    entry = catalogue.entries[number]
    vertices, faces = shape_of(entry, catalogue.resolution_m)
    mesh = GeneratedMesh(
        vertices=vertices,
        faces=faces,
        metric=True,
        title=entry.name,
        provenance="",
        stated_dimensions_m={},
    )
    planning = CONFIG.planning.model_copy(update={"budget_s": budget_s})
    try:
        plan = plan_build(mesh, CONFIG.model_copy(update={"planning": planning}))
    except PlanError as refusal:
        return refusal.message
    assert all(check.passed for check in plan.checks)
    assert 1 <= plan.parts <= CONFIG.limits.inventory_parts
    return f"{plan.parts} parts"


@pytest.mark.parametrize("number", [12])
def test_some_of_the_catalogue_are_planned_or_refused_with_a_reason(number: int) -> None:
    assert planned_or_refused(number, 1.0)


@pytest.mark.soak
@pytest.mark.parametrize("number", range(len(load_catalogue().entries)))
def test_all_of_the_catalogue_is_planned_or_refused_with_a_reason(number: int) -> None:
    assert planned_or_refused(number, 3.0)
