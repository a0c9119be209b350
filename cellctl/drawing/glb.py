"""Binary glTF: arrays and their accessors, the container's two chunks, and a mesh as a file.

After the glTF 2.0 specification: metres, y up, so that a point ``(x, y, z)`` of the cell's
workspace is ``(x, z, -y)`` there.
"""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from cellctl.mesh import GeneratedMesh

MEDIA_TYPE: Final = "model/gltf-binary"
VERTICES: Final = 34962
"""Buffer target of what belongs to corners."""
TRIANGLES: Final = 34963
"""Buffer target of indices."""

_COMPONENTS = {"<f4": 5126, "<u2": 5123, "<u4": 5125}
_MATT_GREY: Final = (0.42, 0.44, 0.46)
"""Linear red, green and blue of a mesh that has no colour of its own."""


class Buffer:
    """The binary chunk, and the accessors that say what lies where in it."""

    def __init__(self) -> None:
        self.content = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: npt.NDArray[Any], kind: str, target: int | None = None) -> int:
        """Store an array, rows of ``kind``; returns the index of its accessor."""
        stored = "<f4" if values.dtype.kind != "u" else "<u2" if values.itemsize == 2 else "<u4"
        data = np.ascontiguousarray(values, dtype=stored)
        view = {"buffer": 0, "byteOffset": len(self.content), "byteLength": data.nbytes}
        self.views.append(view if target is None else view | {"target": target})
        self.content += data.tobytes()
        self.content += bytes(-len(self.content) % 4)
        rows = data.reshape(len(data), -1)
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": _COMPONENTS[stored],
                "count": len(data),
                "type": kind,
                "min": rows.min(axis=0).tolist(),
                "max": rows.max(axis=0).tolist(),
            }
        )
        return len(self.accessors) - 1


def material(linear: tuple[float, ...]) -> dict[str, Any]:
    """A matt surface of a colour; glTF wants linear colours, not those of a screen."""
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*(round(c, 5) for c in linear), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.75,
        }
    }


def packed(tree: dict[str, Any], buffer: Buffer) -> bytes:
    """The content of a GLB file: the tree, completed, and what its accessors point into."""
    binary = bytes(buffer.content)
    whole = {
        "asset": {"version": "2.0", "generator": "cellctl"},
        **tree,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(whole, separators=(",", ":")).encode("utf-8")
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary)
    return b"".join(
        (
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(binary), b"BIN\x00"),
            binary,
        )
    )


def mesh_glb(mesh: GeneratedMesh) -> bytes:
    """A mesh as the content of a GLB file, one node; viewers shade its faces flat.

    The scene's ``extras`` have ``metric`` (whether its unit is the metre) and ``provenance``. It
    is as its generator made it: nothing has fitted it to the cell yet.
    """
    buffer = Buffer()
    upright = mesh.vertices[:, [0, 2, 1]] * np.array([1.0, 1.0, -1.0])
    primitive = {
        "attributes": {"POSITION": buffer.add(upright, "VEC3", VERTICES)},
        "indices": buffer.add(mesh.faces.reshape(-1).astype(np.uint32), "SCALAR", TRIANGLES),
        "material": 0,
    }
    about = {"metric": mesh.metric, "provenance": mesh.provenance}
    tree = {
        "scene": 0,
        "scenes": [{"name": mesh.title, "nodes": [0], "extras": about}],
        "nodes": [{"name": mesh.title, "mesh": 0}],
        "meshes": [{"name": mesh.title, "primitives": [primitive]}],
        "materials": [{**material(_MATT_GREY), "doubleSided": True}],
    }
    return packed(tree, buffer)
