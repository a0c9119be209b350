"""A daemon speaks the language that its configuration names, be it from a file of one's own."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from cellctl.assembly import Change, Role
from cellctl.config import HearingSection
from cellctl.control.daemon import Daemon
from cellctl.control.dialogue.naming import Naming
from cellctl.control.dialogue.table import Input
from cellctl.errors import CATALOGUE, CellFault, ConfigError, HearingError
from cellctl.listening.models import find_model
from cellctl.listening.request import read_request
from cellctl.messages import FaultData, JobData
from cellctl.wording import load_wording
from tests.cell.harness import cell_config


@contextmanager
def daemon(folder: Path, **dialogue: Any) -> Iterator[Daemon]:
    """A daemon that is put together and does not run."""
    journal = {"path": str(folder / "journal.db")}
    made = Daemon(cell_config(dialogue=dialogue, journal=journal))
    try:
        yield made
    finally:
        made.bus.close()


def test_a_third_language_is_a_folder_of_files(tmp_path: Path) -> None:
    """Copied from a packaged one, and translated a file at a time."""
    dutch_files = tmp_path / "nl"
    shutil.copytree(str(resources.files("cellctl.wording") / "en"), dutch_files)
    about = {"language": "nl", "name": "Nederlands", "plural": "n != 1"}
    talk = tomllib.loads((dutch_files / "talk.toml").read_text(encoding="utf-8"))
    talk["state"]["starting"] = "Ik maak me klaar."
    hearing = {
        "commands": {"yes": ["ja", "ja graag"], "stop": ["stop maar"]},
        "questions": {"can_make": ["wat kun je maken"]},
        "words": {"ik wil": "i want", "een": "a", "krukje": "stool"},
        "things": {"stool": "een krukje"},
    }
    for name, document in (("about", about), ("talk", talk), ("hearing", {"hearing": hearing})):
        content = tomli_w.dumps(document)
        (dutch_files / f"{name}.toml").write_text(content, encoding="utf-8")
    with daemon(tmp_path, language="nl", messages_folder=str(tmp_path)) as dutch:
        assert dutch.cell.line.text == "Ik maak me klaar."
        assert dutch.cell.line.language == "nl"
        book = dutch.conversation.phrasebook
    assert book.read("Ja graag!").said is Input.YES
    assert book.read("stop maar").said is Input.STOP
    assert book.read("Wat kun je maken?").topic == "can_make"
    assert book.read("what can you make?").topic == "can_make"
    with daemon(tmp_path, language="de") as german:
        assert german.cell.line.text == "Ich mache mich bereit."
        assert german.cell.sentences.wording.translated("Nothing stands in the workspace.") == (
            "Auf der Baufläche steht nichts."
        )
        fault = CellFault("belt_jam", "The belt ran and no part came to the sensor.")
        ledger = german.builder.ledger
        told = german.cell.sentences.describe("fault_held", None, fault, None, ledger)
        assert told.text == (
            "An der Aufnahme kam kein Teil an, obwohl noch welche auf dem Band sein müssten. "
            "Das Band lief, und kein Teil kam an den Sensor. Mache die Teile auf dem Band frei, "
            "oder lege welche darauf; lösche dann die Störung und mache weiter."
        )


def test_what_the_bus_shows_is_in_the_cells_language(tmp_path: Path) -> None:
    change = Change(what="One leg became thicker.", why="It would come apart while built.")
    wish = read_request("a table with three legs")
    job = JobData(job_id="1", role=Role.VISITOR, request=wish, title="table", changes=(change,))
    fault = FaultData(entry=CATALOGUE["belt_jam"], detail="After 10 s the belt is still moving.")
    with daemon(tmp_path, language="de") as german:
        told = german.cell.sentences.shown(job)
        shown = german.cell.sentences.shown(fault)
    assert told.title == "ein Tisch mit drei Beinen"
    assert told.changes == (
        Change(what="Ein Bein: dicker geworden.", why="Es würde beim Bauen auseinanderfallen."),
    )
    assert shown.entry is not None
    assert shown.entry.code == "belt_jam"
    assert shown.entry.title.startswith("An der Aufnahme kam kein Teil an")
    assert shown.detail == "Nach 10 s: das Band läuft noch."
    with daemon(tmp_path, language="en") as english:
        assert english.cell.sentences.shown(fault) is fault


def test_a_wish_for_the_letter_i_is_read_back_as_one() -> None:
    assert Naming(load_wording("en")).wish(read_request("the letter I")) == "a letter I"


def test_a_daemon_without_words_does_not_begin(tmp_path: Path) -> None:
    with (
        pytest.raises(ConfigError, match="no messages in that language"),
        daemon(tmp_path, language="xx"),
    ):
        pass


def test_a_language_without_a_packaged_recogniser_needs_a_model(tmp_path: Path) -> None:
    with pytest.raises(HearingError, match="'nl'") as refused:
        find_model(HearingSection(language="nl", model_folder=str(tmp_path)))
    assert "hearing.model_path" in refused.value.hint
