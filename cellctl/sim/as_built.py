"""The emulated cell as it really stands, where that is not as it is configured."""

from __future__ import annotations

import numpy as np

from cellctl.config import CellConfig, Pose
from cellctl.sim.plant import Floats
from cellctl.sim.world_geometry import inverse, pose_matrix, rotation_vector


def as_built(config: CellConfig) -> CellConfig:
    """The configuration that would be right: each frame moved as ``[emulation]`` says."""
    emulation = config.emulation
    assert emulation is not None, "an emulated cell has an [emulation] table"
    base = _moved(config.base.frame, emulation.shifted_base)
    # The robot is bolted to its pedestal.
    together = pose_matrix(base) @ inverse(pose_matrix(config.base.frame))
    pedestal = _pose(together @ pose_matrix(config.pedestal.frame))
    tool = _moved(config.tool.frame, emulation.shifted_tool)
    feeder = _moved(config.feeder.frame, emulation.shifted_feeder)
    return config.model_copy(
        update={
            "base": config.base.model_copy(update={"frame": base}),
            "pedestal": config.pedestal.model_copy(update={"frame": pedestal}),
            "tool": config.tool.model_copy(update={"frame": tool}),
            "feeder": config.feeder.model_copy(update={"frame": feeder}),
        }
    )


def _moved(frame: Pose, by: Pose) -> Pose:
    return _pose(pose_matrix(frame) @ pose_matrix(by)) if any(by) else frame


def _pose(matrix: Floats) -> Pose:
    x, y, z = (float(value) for value in matrix[:3, 3])
    rx, ry, rz = (float(value) for value in np.asarray(rotation_vector(matrix[:3, :3])))
    return (x, y, z, rx, ry, rz)
