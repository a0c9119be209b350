"""What signs visitors' cookies outlives the process, and is nobody else's."""

from __future__ import annotations

from pathlib import Path

import pytest

from cellctl.kiosk.cookies import cookie_secret


def test_a_page_that_starts_anew_knows_its_visitors(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path))
    first = cookie_secret()
    assert cookie_secret() == first
    (file,) = tmp_path.iterdir()
    assert file.stat().st_mode & 0o077 == 0
    file.write_text("cut")
    assert len(cookie_secret()) >= 32
    assert cookie_secret() != first


def test_without_a_folder_each_process_has_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("RUNTIME_DIRECTORY", raising=False)
    assert cookie_secret() != cookie_secret()
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path / "gone"))
    assert cookie_secret() != cookie_secret()
