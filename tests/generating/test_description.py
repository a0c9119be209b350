"""Descriptions as files: read, refused, made, and simple solids."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import trimesh

from cellctl.config import load_config
from cellctl.description import PartsDescription, is_description, parse_description
from cellctl.errors import DesignError, UsageError
from cellctl.generating.describing import realise
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import fit
from cellctl.validating.rules import size_of

CONFIG = load_config(Path(__file__).parents[2] / "config" / "sim.toml")

SOLIDS: list[tuple[dict[str, object], tuple[float, float, float]]] = [
    ({"shape": "box", "size_m": [0.3, 0.2, 0.1]}, (0.3, 0.2, 0.1)),
    ({"shape": "sphere", "radius_m": 0.2}, (0.4, 0.4, 0.4)),
    ({"shape": "ellipsoid", "size_m": [0.4, 0.2, 0.3]}, (0.4, 0.2, 0.3)),
    ({"shape": "cylinder", "radius_m": 0.1, "height_m": 0.5}, (0.2, 0.2, 0.5)),
    ({"shape": "cone", "radius_m": 0.2, "height_m": 0.4}, (0.4, 0.4, 0.4)),
    ({"shape": "cone", "radius_m": 0.1, "top_radius_m": 0.2, "height_m": 0.4}, (0.4, 0.4, 0.4)),
    ({"shape": "capsule", "radius_m": 0.1, "height_m": 0.4}, (0.2, 0.2, 0.4)),
    ({"shape": "prism", "size_m": [0.4, 0.3, 0.2]}, (0.4, 0.3, 0.2)),
    ({"shape": "ring", "radius_m": 0.15, "thickness_m": 0.1}, (0.4, 0.4, 0.1)),
]


def parts(*solids: Mapping[str, object]) -> PartsDescription:
    read = parse_description(json.dumps({"title": "thing", "parts": solids}), "thing.json")
    assert isinstance(read, PartsDescription)
    return read


@pytest.mark.parametrize(("solid", "extent"), SOLIDS, ids=lambda v: str(v)[:40])
def test_a_solid_is_closed_outward_and_as_large_as_described(
    solid: dict[str, object], extent: tuple[float, float, float]
) -> None:
    found = realise(parts(solid | {"at_m": [1.0, -2.0, 0.5]}), CONFIG)
    mesh = trimesh.Trimesh(found.vertices, found.faces)
    assert mesh.is_watertight
    assert mesh.volume > 0.0
    assert np.allclose(mesh.extents, extent, atol=0.006)
    # Turned about the vertical, for visitors stand opposite the robot.
    assert np.allclose(mesh.bounds.mean(axis=0), [-1.0, 2.0, 0.5], atol=0.006)


def test_turns_are_about_fixed_axes_in_order() -> None:
    rod = {"shape": "box", "size_m": [0.1, 0.2, 0.6]}
    lying = realise(parts(rod | {"turned_deg": [0, 90, 0]}), CONFIG)
    assert np.allclose(np.ptp(lying.vertices, axis=0), [0.6, 0.2, 0.1])
    across = realise(parts(rod | {"turned_deg": [0, 90, 90]}), CONFIG)
    assert np.allclose(np.ptp(across.vertices, axis=0), [0.2, 0.6, 0.1])


def test_parts_become_one_object_in_cells() -> None:
    mushroom = parts(
        {"shape": "cylinder", "radius_m": 0.05, "height_m": 0.3, "at_m": [0, 0, 0.15]},
        {"shape": "box", "size_m": [0.3, 0.3, 0.1], "at_m": [0, 0, 0.35]},
    )
    cells = discretise(fit(realise(mushroom, CONFIG), CONFIG).shape)
    assert size_of(cells) == (3, 3, 4)
    assert len(cells) == 9 + 3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "not valid JSON"),
        ("[]", "(whole description)"),
        ('{"family": "stool", "leg": 3}', "leg"),
        ('{"family": "stool", "schema_version": 2}', "schema_version"),
        ('{"family": "stool", "size_m": {"hight": 0.5}}', "hight"),
        ('{"family": "stool", "size_m": {"height": -0.5}}', "greater than 0"),
        ('{"title": "x", "parts": []}', "parts"),
        ('{"title": "x", "parts": [{"shape": "blob"}]}', "blob"),
        ('{"title": "x", "parts": [{"shape": "sphere", "radius_m": 1e9}]}', "radius_m"),
        ('{"title": "x", "parts": [{"shape": "sphere", "radius_m": NaN}]}', "radius_m"),
    ],
)
def test_what_is_no_description_is_refused_by_name(text: str, said: str) -> None:
    with pytest.raises(UsageError) as refusal:
        parse_description(text, "wish.json")
    assert said in refusal.value.message
    assert "wish.json" in refusal.value.message


@pytest.mark.parametrize(
    ("family", "attributes", "said"),
    [
        ("gazebo", {}, "no family 'gazebo'"),
        ("stool", {"arms": True}, "no attribute 'arms'"),
        ("stool", {"legs": True}, "whole number"),
        ("chair", {"back": 2}, "true or false"),
        ("stool", {"legs": 44}, "at most 9"),
    ],
)
def test_a_family_says_what_it_does_not_have(
    family: str, attributes: dict[str, object], said: str
) -> None:
    read = parse_description(json.dumps({"family": family, "attributes": attributes}), "a.json")
    with pytest.raises(DesignError) as refusal:
        realise(read, CONFIG)
    assert said in str(refusal.value)


def test_a_description_is_told_from_a_plan_and_from_cells() -> None:
    assert is_description('{"family": "stool"}')
    assert is_description(b'{"parts": []}')
    for other in ('{"cells": [], "pitch_m": 0.1}', '{"steps": []}', "[1]", "no json", ""):
        assert not is_description(other)


def test_a_design_keeps_its_description_complete() -> None:
    found = realise(parse_description('{"family": "chair"}', "a.json"), CONFIG)
    assert found.description is not None
    again = parse_description(found.description.model_dump_json(), "b.json")
    assert again == found.description
    assert found.provenance.startswith("from a description: chair, ")
    assert "legs 4" in found.provenance
