"""The files that ``cellctl plan`` writes: report, plan, picture and steps."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from cellctl.assembly import BuildPlan
from cellctl.cli.plan_report import PlanReport
from cellctl.cli.plan_screen import summary
from cellctl.config import CellConfig
from cellctl.drawing.scene import Side
from cellctl.errors import UsageError

STDOUT: Final = "-"


@dataclass(frozen=True)
class Outputs:
    """Where to write what; None is not written."""

    json: str | None
    """The report; ``-`` is standard output."""
    plan: Path | None
    """The build plan, as ``cellctl build`` takes it."""
    picture: Path | None
    """A PNG of the steps."""
    steps: Path | None
    """A GLB of the steps."""

    @property
    def prints_json(self) -> bool:
        """Whether standard output belongs to programs."""
        return self.json == STDOUT

    def check(self) -> None:
        """See before the long work that what is wanted can be written after it.

        Raises:
            UsageError: a folder is missing, a suffix is wrong, or there is no matplotlib.
        """
        report = None if self.json is None or self.prints_json else Path(self.json)
        for path in (report, self.plan, self.picture, self.steps):
            if path is not None and not path.absolute().parent.is_dir():
                raise UsageError(f"{path}: there is no folder {path.absolute().parent}.")
            if path is not None and path.is_dir():
                raise UsageError(f"{path}: is a folder.", "Name a file.")
        for option, path, suffix in (
            ("--picture", self.picture, ".png"),
            ("--steps", self.steps, ".glb"),
        ):
            if path is not None and path.suffix.lower() != suffix:
                raise UsageError(f"{option} {path}: writes {suffix[1:].upper()} files only.")
        if self.picture is not None and find_spec("matplotlib") is None:
            raise UsageError(
                "A picture needs matplotlib, which is not installed.",
                "Install cellctl with its extra: cellctl[picture].",
            )

    def write_report(self, report: PlanReport) -> None:
        """Write or print the report, of a plan or of a refusal.

        Raises:
            UsageError: it cannot be written.
        """
        text = report.model_dump_json(indent=2) + "\n"
        if self.prints_json:
            sys.stdout.write(text)
        elif self.json is not None:
            _write(Path(self.json), text.encode("utf-8"))

    def write_plan(self, plan: BuildPlan, report: PlanReport, config: CellConfig) -> Iterator[str]:
        """Write everything else; yields a line for each file that is written, the report too.

        Raises:
            UsageError: one cannot be written.
        """
        if self.json is not None and not self.prints_json:
            yield f"report   {self.json}"
        if self.plan is not None:
            _write(self.plan, (plan.model_dump_json(indent=2) + "\n").encode("utf-8"))
            yield f"plan     {self.plan}"
        if self.picture is not None:
            from cellctl.cli.plan_picture import draw_steps  # noqa: PLC0415 - optional part

            draw_steps(
                plan,
                config.grid,
                self.picture,
                caption=summary(report),
                robot_side=robot_side(config),
            )
            yield f"picture  {self.picture}"
        if self.steps is not None:
            from cellctl.drawing.plan_glb import steps_glb  # noqa: PLC0415 - few want it

            _write(self.steps, steps_glb(plan))
            yield f"steps    {self.steps}"


def robot_side(config: CellConfig) -> Side:
    """The edge of the workspace that is nearest to the robot."""
    from cellctl.assembling.poses import inverse, to_matrix  # noqa: PLC0415 - only for pictures

    base = inverse(to_matrix(config.workspace.frame)) @ to_matrix(config.base.frame)
    x, y = (float(v) for v in base[:2, 3])
    width, depth, _ = config.workspace.size_m
    beyond: dict[Side, float] = {"-x": -x, "+x": x - width, "-y": -y, "+y": y - depth}
    return max(beyond, key=lambda side: beyond[side])


def _write(path: Path, content: bytes) -> None:
    try:
        path.write_bytes(content)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}.") from error
