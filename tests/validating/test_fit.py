"""Sizes: kept, scaled, shrunk, or asked about."""

from __future__ import annotations

import numpy as np
import pytest

from cellctl.errors import PlanError
from cellctl.generating.boxes import Box
from cellctl.validating.fit import TOLERANCE_M, fit, size_changes, size_questions
from tests.validating.shapes import CONFIG, generated, of_arrays


def test_a_metric_mesh_keeps_its_size_and_moves_to_the_corner() -> None:
    fitted = fit(generated(Box(7, -3, 2, 4, 3, 5)), CONFIG)
    assert np.allclose(fitted.shape.extent, [4, 3, 5])
    assert np.allclose(fitted.shape.surface.vertices.min(axis=0), 0.0)
    assert fitted.changes == ()


def test_a_metric_mesh_that_fills_the_workspace_exactly_is_not_too_large() -> None:
    assert fit(generated(Box(0, 0, 0, 6, 5, 6)), CONFIG).changes == ()


def test_half_a_millimetre_more_than_the_workspace_is_not_too_large() -> None:
    fitted = fit(generated(Box(0, 0, 0, 6.005, 5.005, 6.005)), CONFIG)
    assert np.allclose(fitted.shape.extent, [6.005, 5.005, 6.005])
    assert fitted.changes == ()


def test_the_tolerance_is_a_length_at_any_pitch_and_size() -> None:
    voxel = CONFIG.voxel.model_copy(update={"pitch_m": 0.05})
    shape = fit(generated(Box(0, 0, 0, 2, 2, 2)), CONFIG.model_copy(update={"voxel": voxel})).shape
    assert np.allclose(shape.extent, 4)
    assert shape.rescaled(np.full(3, 3.0)).tolerance == pytest.approx(TOLERANCE_M / 0.05)


def test_a_metric_mesh_that_is_too_large_shrinks_evenly_and_says_so() -> None:
    fitted = fit(generated(Box(0, 0, 0, 6, 5, 12)), CONFIG)
    assert np.allclose(fitted.shape.extent, [3, 2.5, 6])
    assert len(fitted.changes) == 1
    assert "60 cm high instead of 120 cm" in fitted.changes[0].what
    assert "60 x 50 x 60 cm" in fitted.changes[0].why


def test_a_mesh_without_a_unit_fills_the_workspace() -> None:
    fitted = fit(generated(Box(0, 0, 0, 1, 1, 2), unit_m=0.37, metric=False), CONFIG)
    assert np.allclose(fitted.shape.extent, [3, 3, 6])
    (change,) = fitted.changes
    assert change.what == "It is 60 cm high."
    assert "no unit" in change.why


def test_a_mesh_without_a_unit_takes_the_size_that_was_said() -> None:
    wanted = generated(Box(0, 0, 0, 1, 1, 2), metric=False, stated={"height": 0.4})
    assert np.allclose(fit(wanted, CONFIG).shape.extent, [2, 2, 4])


def test_a_mesh_without_any_size_is_refused_where_scaling_is_switched_off() -> None:
    planning = CONFIG.planning.model_copy(update={"scale_unitless_to_workspace": False})
    config = CONFIG.model_copy(update={"planning": planning})
    with pytest.raises(PlanError, match="has no size"):
        fit(generated(Box(0, 0, 0, 1, 1, 1), metric=False), config)


@pytest.mark.parametrize(
    ("box", "said"),
    [
        (Box(0, 0, 0, 4, 4, 0), "flat: it has no thickness along height"),
        (Box(0, 0, 0, 0.2, 0.2, 0.4), "4 cm across, less than half a part"),
        (Box(0, 0, 0, 4, 4, 1e6), "no size for an object"),
    ],
)
def test_what_is_no_object_is_refused(box: Box, said: str) -> None:
    with pytest.raises(PlanError, match=said):
        fit(generated(box), CONFIG)


def test_an_empty_mesh_is_refused() -> None:
    with pytest.raises(PlanError, match="empty"):
        fit(of_arrays(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)), CONFIG)


def test_a_size_is_asked_about_when_missed_and_told_when_rounded() -> None:
    stated = {"height": 0.45, "width": 1.0, "depth": 0.3}
    assert size_questions(stated, (6, 3, 5), 0.1) == (
        "You asked for a width of 100 cm; what I can build here has 60 cm.",
    )
    changes = size_changes(stated, (6, 3, 5), 0.1)
    assert [change.what for change in changes] == ["Its height is 50 cm instead of 45 cm."]
