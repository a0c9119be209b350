"""What becomes of the catalogue: ``python -m benchmarks.catalogue [--budget-s 3] [--every 1]``.

Plans every object of the catalogue at its real size, and prints how many are planned as they are,
how many are changed, and why the others are refused.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections import Counter
from pathlib import Path

from cellctl.config import load_config
from cellctl.errors import PlanError
from cellctl.generating.catalogue import load_catalogue, shape_of
from cellctl.mesh import GeneratedMesh
from cellctl.validating.plan import plan_build

CONFIG = load_config(Path(__file__).parents[1] / "config" / "sim.toml")


def main() -> int:
    """Plan and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--budget-s", type=float, default=3.0)
    parser.add_argument("--every", type=int, default=1, help="only every so many of them")
    options = parser.parse_args()
    planning = CONFIG.planning.model_copy(update={"budget_s": options.budget_s})
    config = CONFIG.model_copy(update={"planning": planning})
    catalogue = load_catalogue()
    as_is, changed, refused = 0, 0, Counter[str]()
    took_s, margins = [], []
    for entry in catalogue.entries[:: options.every]:
        vertices, faces = shape_of(entry, catalogue.resolution_m)
        mesh = GeneratedMesh(
            vertices=vertices,
            faces=faces,
            metric=True,
            title=entry.name,
            provenance=entry.entry_id,
            stated_dimensions_m={},
        )
        began_s = time.monotonic()
        try:
            plan = plan_build(mesh, config)
        except PlanError as refusal:
            refused[refusal.rule or "other"] += 1
            sys.stdout.write(f"refused  {entry.name} ({entry.parts}): {refusal.message}\n")
        else:
            changed += bool(plan.changes)
            as_is += not plan.changes
            if plan.weakest is not None:
                margins.append(plan.weakest.margin)
            sys.stdout.write(f"planned  {entry.name} ({entry.parts}): {plan.parts} parts\n")
        took_s.append(time.monotonic() - began_s)
        sys.stdout.flush()
    sys.stdout.write(
        f"{len(took_s)} objects: {as_is} planned as they are, {changed} changed, "
        f"{sum(refused.values())} refused {dict(refused)}; least margin "
        f"{min(margins, default=0.0):.2f}; {statistics.median(took_s):.1f} s each in the median, "
        f"{max(took_s):.1f} s at most\n"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
