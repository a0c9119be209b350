"""``cellctl design``: a wish becomes files, a file is changed, nonsense is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from cellctl.cli.app import command_line
from cellctl.errors import DesignError, UsageError
from cellctl.validating.files import load_mesh

CONFIG = Path(__file__).parents[2] / "config" / "sim.toml"
Design = Callable[..., Result]


@pytest.fixture
def design(monkeypatch: pytest.MonkeyPatch) -> Design:
    monkeypatch.setenv("CELLCTL_CONFIG", str(CONFIG))
    return lambda *arguments: CliRunner().invoke(command_line(), ["design", *map(str, arguments)])


def test_a_sentence_becomes_a_description_and_a_shape(design: Design, tmp_path: Path) -> None:
    file, mesh = tmp_path / "stool.json", tmp_path / "stool.glb"
    done = design("a stool with four legs", "--description", file, "--mesh", mesh)
    assert done.exit_code == 0, done.output
    assert "designed     stool with four legs" in done.output
    written = json.loads(file.read_text())
    assert (written["family"], written["attributes"]) == ("stool", {"legs": 4})
    # The shape is in metres and y up, as glTF has it.
    assert np.allclose(np.ptp(load_mesh(mesh).vertices, axis=0), [0.4, 0.4, 0.5])


def test_a_description_is_changed_and_written_again(design: Design, tmp_path: Path) -> None:
    file = tmp_path / "stool.json"
    file.write_text('{"family": "stool", "attributes": {"legs": 4}, "size_m": {"height": 0.4}}')
    done = design(file, "--edit", "make it taller", "--description", file)
    assert done.exit_code == 0, done.output
    written = json.loads(file.read_text())
    assert written["attributes"] == {"legs": 4}
    assert written["size_m"]["height"] == pytest.approx(0.5)


def test_a_picture_is_drawn(design: Design, tmp_path: Path) -> None:
    picture = tmp_path / "cross.png"
    assert design("a cross", "--picture", picture).exit_code == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "kind", "said"),
    [
        ((), UsageError, "Name a sentence"),
        (("a stool", "--all", "a.png"), UsageError, "Name a sentence"),
        (("a stool", "--mesh", "a.obj"), UsageError, "GLB files only"),
        (("a stool", "--edit", "what is the time"), UsageError, "no change"),
        (("a violin",), DesignError, "no violin|cannot design"),
        (("missing.json",), UsageError, "missing.json"),
    ],
)
def test_what_makes_no_sense_is_refused(
    design: Design, arguments: tuple[str, ...], kind: type[Exception], said: str
) -> None:
    done = design(*arguments)
    assert isinstance(done.exception, kind)
    assert any(text in str(done.exception) for text in said.split("|"))
