"""What feeling costs: seconds a part of a column at real speed, with and without it.

python -m benchmarks.touch
"""

from __future__ import annotations

import sys
from statistics import median

from tests.cell.harness import bar, running_cell

_PARTS = 4


def main() -> None:
    """Build a column both ways."""
    for depth_m in (0.0007, 0.0):
        with running_cell(speed=1.0, patience_s=300.0, robot={"touch_depth_m": depth_m}) as cell:
            cell.client.build("bar.json", bar(1, 1, _PARTS))
            assert cell.finish().outcome == "built"
            seconds = [part.seconds for part in cell.client.snapshot().parts[1:]]
        sys.stdout.write(f"touch_depth_m {depth_m:g}: {median(seconds):.2f} s a part\n")


if __name__ == "__main__":
    main()
