"""docs/reference says what the code says."""

from __future__ import annotations

import pytest

from cellctl import config
from cellctl.cli.reference import PAGES, attribute_docs, options_page
from cellctl.config import dialogue, generating, kiosk, machines, place, services, understanding
from cellctl.errors import CATALOGUE
from cellctl.notices import NOTICES
from tests.leaks import REPOSITORY

FOLDER = REPOSITORY / "docs" / "reference"


@pytest.mark.parametrize("name", PAGES)
def test_a_page_on_disk_is_what_the_code_generates(name: str) -> None:
    assert (FOLDER / name).read_text(encoding="utf-8") == PAGES[name](), "run `make docs`"


def test_every_generated_page_is_known() -> None:
    assert {path.name for path in FOLDER.iterdir()} == set(PAGES)


def test_every_option_stands_there() -> None:
    page = options_page()
    meanings = attribute_docs(dialogue, generating, kiosk, machines, place, services, understanding)
    for table, section in config.CellConfig.model_fields.items():
        _, _, body = page.partition(f"## [{table}]\n")
        body = body.partition("\n## ")[0]
        annotation = section.annotation
        assert annotation is not None
        names = [name for owner, name in meanings if owner in str(annotation)]
        assert names
        assert all(f"| `{name}` |" in body for name in names)


def test_every_fault_stands_there() -> None:
    page = (FOLDER / "faults.md").read_text(encoding="utf-8")
    assert all(f"\n## {code}\n" in page for code in [*CATALOGUE, *NOTICES])


def test_what_a_generated_line_looks_like() -> None:
    assert (
        "| `pitch_m` | number, in metres, at least 0.02, at most 0.25 | required | Edge of a cell:"
    ) in options_page()
    assert "| `host` | text, at least 1 long | required |" in options_page()
    assert '| `confirmation` | `"ask"` or `"waived"` | `"ask"` |' in options_page()
