from __future__ import annotations

from pathlib import Path

import pytest

from cellctl.credentials import find_credential
from cellctl.errors import ConfigError


def test_systemd_comes_before_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CREDENTIALS_DIRECTORY", raising=False)
    monkeypatch.delenv("CELLCTL_LLM_KEY", raising=False)
    assert find_credential("llm-key") is None
    monkeypatch.setenv("CELLCTL_LLM_KEY", "from-environment")
    found = find_credential("llm-key")
    assert found is not None
    assert (found.secret, found.source) == ("from-environment", "$CELLCTL_LLM_KEY")
    (tmp_path / "llm-key").write_text("from-systemd\n")
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(tmp_path))
    found = find_credential("llm-key")
    assert found is not None
    assert (found.secret, found.source) == ("from-systemd", str(tmp_path / "llm-key"))
    assert "from-systemd" not in repr(found)


@pytest.mark.parametrize("content", [b"", b"two\nlines", b"\xff\xfe", b"x" * 5000])
def test_what_is_no_key_is_refused_with_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: bytes
) -> None:
    (tmp_path / "llm-key").write_bytes(content)
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(tmp_path))
    with pytest.raises(ConfigError, match="llm-key"):
        find_credential("llm-key")
