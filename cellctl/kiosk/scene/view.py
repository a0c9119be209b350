"""The 3D view as an element of a page."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from nicegui.element import Element
from nicegui.elements.scene import Scene

from cellctl.arm_form import FORE_ASIDE_M, LINK_LENGTHS, UPPER_ASIDE_M
from cellctl.config import CellConfig
from cellctl.kiosk.components import attribute
from cellctl.kiosk.scene.pictures import Picture

_LIBRARY: Final = Scene
"""Registers the 3D library that ``cell_view.js`` takes from the page library."""
_FOLDER: Final = Path(__file__).parent


def geometry(config: CellConfig) -> dict[str, Any]:
    """Where everything stands, in metres, for ``cell_view.js``."""
    model = config.robot.model
    return {
        "grid": config.grid,
        "pitch_m": config.voxel.pitch_m,
        "workspace": config.workspace.frame,
        "base": config.base.frame,
        "pedestal": config.pedestal.frame,
        "pedestal_size": config.pedestal.size_m,
        "feeder": config.feeder.frame,
        "belt_width_m": config.feeder.width_m,
        "tool": config.tool.frame,
        "tool_width_m": config.tool.width_m,
        "tool_height_m": config.tool.height_m,
        "arm": LINK_LENGTHS[model]._asdict()
        | {"upper_aside": UPPER_ASIDE_M[model], "fore_aside": FORE_ASIDE_M[model]},
    }


class CellView(
    Element,
    component=_FOLDER / "cell_view.js",
    esm={"cellctl-scene": str(_FOLDER / "modules")},
):
    """The cell, or an object on a turntable.

    Args:
        config: where everything stands.
        label: what it is, for those who do not see it.
    """

    def __init__(self, config: CellConfig, label: str) -> None:
        super().__init__()
        self.classes("stage__view")
        self.props["geometry"] = geometry(config)
        self.props["label"] = label
        self._picture: Picture | None = None
        self._joints: tuple[float, ...] = ()
        self.on("ready", self._begin)

    def show(self, picture: Picture, label: str) -> None:
        """Show this; nothing goes to the browser when it does so already."""
        attribute(self, "label", label)
        if picture != self._picture:
            self._picture = picture
            self.run_method("show", picture.as_json())

    def pose(self, joints_rad: tuple[float, ...]) -> None:
        """Show the arm like this; without joints it is not shown."""
        if joints_rad != self._joints:
            self._joints = joints_rad
            self.run_method("pose", joints_rad)

    def _begin(self) -> None:
        """The browser's side is there: what was said before it was is said again."""
        if self._picture is not None:
            self.run_method("show", self._picture.as_json())
        self.run_method("pose", self._joints)
