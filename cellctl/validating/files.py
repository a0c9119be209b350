"""Shapes and plans from files."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import ValidationError

from cellctl.assembly import Assembly, BuildPlan
from cellctl.errors import UsageError
from cellctl.mesh import GeneratedMesh

Up = Literal["auto", "y", "z"]

MESH_SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".stl")

_Y_UP_BY_STANDARD = (".glb", ".gltf")


def load_mesh(path: Path, *, up: Up = "auto", height_m: float | None = None) -> GeneratedMesh:
    """Read a mesh file; it has no unit, whatever its format promises, unless a height is given.

    Args:
        path: .glb, .gltf, .obj, .ply or .stl.
        up: which axis of the file points up; ``auto`` is y for glTF, by its standard, else z.
        height_m: how high the object shall be.

    Raises:
        UsageError: it cannot be read as a mesh.
    """
    return read_mesh(path.name, _read(path), up=up, height_m=height_m)


def read_mesh(
    name: str, content: bytes, *, up: Up = "auto", height_m: float | None = None
) -> GeneratedMesh:
    """As ``load_mesh``, from the bytes of a file of that name."""
    suffix = Path(name).suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise UsageError(
            f"{name}: not a kind of mesh file that can be read.",
            f"Use one of {', '.join(MESH_SUFFIXES)}.",
        )
    import trimesh  # noqa: PLC0415 - takes a second to load, and only files need it

    try:
        scene = trimesh.load_scene(io.BytesIO(content), file_type=suffix[1:], process=False)
        mesh = scene.to_mesh()
    # The readers of five formats raise whatever their parsing runs into.
    except Exception as error:
        reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise UsageError(
            f"{name}: cannot be read as {suffix[1:].upper()} ({reason}).", "Export it again."
        ) from error
    vertices = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(mesh.faces, dtype=np.int64).reshape(-1, 3)
    if len(faces) == 0:
        raise UsageError(f"{name}: holds no triangles.", "Export it again, with its faces.")
    if up == "y" or (up == "auto" and suffix in _Y_UP_BY_STANDARD):
        vertices = vertices[:, [0, 2, 1]] * np.array([1.0, -1.0, 1.0])
    return GeneratedMesh(
        vertices=vertices,
        faces=faces,
        metric=False,
        title=Path(name).stem.replace("_", " "),
        provenance=f"from the file {name}",
        stated_dimensions_m={} if height_m is None else {"height": height_m},
    )


def load_plan(path: Path) -> BuildPlan:
    """Read a build plan as it was written; whoever runs it must check it first.

    Raises:
        UsageError: it is no build plan.
    """
    found = read_json_plan(path.name, _read(path))
    if not isinstance(found, BuildPlan):
        raise UsageError(f"{path.name}: holds cells, not a build plan.")
    return found


def read_json_plan(name: str, content: bytes) -> BuildPlan | Assembly:
    """A build plan, or ``{"cells": [[x, y, z], ...], "pitch_m": 0.1}``, from a file's bytes.

    Raises:
        UsageError: it is neither; the message says where.
    """
    try:
        data = json.loads(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise UsageError(f"{name}: is not UTF-8 text.") from error
    except json.JSONDecodeError as error:
        raise UsageError(
            f"{name}: is not valid JSON: {error.msg} in line {error.lineno}."
        ) from error
    except (ValueError, RecursionError) as error:  # a number or a nesting beyond all measure
        raise UsageError(f"{name}: is not JSON that can be read: {error}.") from error
    if isinstance(data, dict) and "placements" in data:
        raise UsageError(
            f"{name}: is the report of a plan, which tells of it; it is not the plan itself.",
            "Write the plan with `cellctl plan ... --plan FILE`.",
        )
    if not isinstance(data, dict) or not {"steps", "cells"} & data.keys():
        raise UsageError(
            f"{name}: holds neither a build plan, cells nor a description.",
            'Write a plan, or {"cells": [[0, 0, 0]], "pitch_m": 0.1}.',
        )
    try:
        # The text, not the parsed data: only in JSON are enumerations and tuples plain.
        if "steps" in data:
            return BuildPlan.model_validate_json(content)
        return Assembly.model_validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "(whole file)"
        raise UsageError(f"{name}: {where}: {first['msg']}.", "See the schema in docs.") from error


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}.") from error
