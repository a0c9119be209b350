"""The pitch is configuration: parts of 5 cm are planned and built like parts of 10."""

from __future__ import annotations

import pytest

from cellctl.assembly import Assembly
from tests.cell.harness import running_cell

pytestmark = [pytest.mark.wire]


def test_parts_of_five_centimetres_are_built_as_planned() -> None:
    arch = [(x, 0, z) for x in (0, 3) for z in range(3)] + [(x, 0, 3) for x in range(4)]
    content = Assembly.of(arch, pitch_m=0.05).model_dump_json().encode()
    with running_cell(
        speed=10.0,
        voxel={"pitch_m": 0.05, "mass_kg": 0.02},
        tool={"width_m": 0.045},
    ) as cell:
        cell.begin_test()
        cell.client.build("arch.json", content)
        assert cell.finish().outcome == "built"
        cell.assert_as_planned()
        assert len(cell.truth().built) == len(arch)
