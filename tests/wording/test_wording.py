"""Message files: every language says everything, and a wrong file is refused with its lines."""

from __future__ import annotations

import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from cellctl.errors import ConfigError
from cellctl.wording import REFERENCE_LANGUAGE, languages, load_wording

PACKAGED = Path(str(resources.files("cellctl.wording")))
ENGLISH = {
    key: value
    for file in sorted((PACKAGED / "en").glob("*.toml"))
    for key, value in tomllib.loads(file.read_text(encoding="utf-8")).items()
}
"""All tables of all files: each table of English stands in one of them."""


def written(folder: Path, **changes: Any) -> str:
    """A folder with a file of messages in a language of its own; returns the folder."""
    document = {**ENGLISH, "language": "xx", "name": "Test", **changes}
    (folder / "xx.toml").write_text(tomli_w.dumps(document), encoding="utf-8")
    return str(folder)


@pytest.mark.parametrize("language", languages())
def test_every_packaged_language_says_everything(language: str) -> None:
    wording = load_wording(language)
    assert wording.messages.keys() == load_wording(REFERENCE_LANGUAGE).messages.keys()
    assert all(form.strip() for forms in wording.messages.values() for form in forms)


def test_a_count_picks_the_form() -> None:
    english = load_wording("en")
    assert english.text("count.parts", count=1) == "1 part"
    assert english.text("count.parts", count=0) == "0 parts"
    assert english.line("count.parts", count=30).text == "30 parts"


def test_a_language_with_other_plurals_is_a_file_in_a_folder(tmp_path: Path) -> None:
    forms = ["{count} a", "{count} b", "{count} c"]

    def stretched(table: dict[str, Any]) -> dict[str, Any]:
        return {
            key: stretched(value)
            if isinstance(value, dict)
            else [*value, value[-1]]
            if isinstance(value, list)
            else value
            for key, value in table.items()
        }

    rule = "n%10==1 && n%100!=11 ? 0 : n%10>=2 && n%10<=4 && (n%100<10 || n%100>=20) ? 1 : 2"
    changes = stretched({key: value for key, value in ENGLISH.items() if isinstance(value, dict)})
    changes["count"]["parts"] = forms
    folder = written(tmp_path, plural=rule, **changes)
    assert languages(folder) == sorted([*languages(), "xx"])
    polish = load_wording("xx", folder)
    assert [polish.text("count.parts", count=n) for n in (1, 3, 5, 22)] == [
        *("1 a", "3 b", "5 c", "22 b")
    ]


def test_an_own_file_comes_before_the_packaged_one(tmp_path: Path) -> None:
    state = {**ENGLISH["state"], "idle": "At your service."}
    folder = written(tmp_path, language="en", state=state)
    (tmp_path / "xx.toml").rename(tmp_path / "en.toml")
    assert load_wording("en", folder).text("state.idle") == "At your service."
    assert load_wording("en").text("state.idle") == "What shall I build?"


def test_a_language_is_a_file_or_a_folder_of_files(tmp_path: Path) -> None:
    folder = written(tmp_path)
    (tmp_path / "yy").mkdir()
    for number, (table, value) in enumerate(ENGLISH.items()):
        one = {table: {"language": "yy", "name": "Other"}.get(table, value)}
        content = tomli_w.dumps(one)
        (tmp_path / "yy" / f"{number}.toml").write_text(content, encoding="utf-8")
    assert {"de", "en", "xx", "yy"} <= set(languages(folder))
    assert load_wording("xx", folder).messages == load_wording("yy", folder).messages
    twice = tmp_path / "yy" / "more.toml"
    twice.write_text('[state]\nidle = "Again?"\n', encoding="utf-8")
    with pytest.raises(ConfigError, match=r"more\.toml: state\.idle stands in another file"):
        load_wording("yy", folder)


def test_an_unknown_language_is_refused_with_those_that_there_are(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="xx") as refused:
        load_wording("xx", str(tmp_path))
    assert "There are: " in refused.value.hint
    assert "en" in refused.value.hint


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"state": {}}, "state.idle: is missing"),
        ({"more": {"than": "needed"}}, "more.than: is no message"),
        ({"place": {**ENGLISH["place"], "cell": "at {where}"}}, "place.cell: has the fields {wh"),
        ({"place": {**ENGLISH["place"], "cell": "at {0}"}}, "fields must have names"),
        ({"place": {**ENGLISH["place"], "cell": "at {cell"}}, "place.cell: "),
        ({"place": {**ENGLISH["place"], "cell": ["a"]}}, "a list of 2 texts"),
        ({"place": {**ENGLISH["place"], "cell": 3}}, "must be a text"),
        ({"plural": "n !! 1"}, "is no rule"),
        ({"plural": 1}, "plural must be a text"),
        ({"language": "zz"}, "says language = 'zz'"),
        ({"hearing": {"yes": ["ja"]}}, "must hold tables"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    folder = written(tmp_path, **changes)
    with pytest.raises(ConfigError) as refused:
        load_wording("xx", folder)
    assert said in str(refused.value)
    assert "xx" in str(refused.value)


@pytest.mark.parametrize(
    ("content", "said"), [(b"\xff", "UTF-8"), (b"= 3", "TOML"), (b"#" * 1_000_001, "larger")]
)
def test_a_file_that_is_none_is_refused(tmp_path: Path, content: bytes, said: str) -> None:
    (tmp_path / "xx.toml").write_bytes(content)
    with pytest.raises(ConfigError, match=said):
        load_wording("xx", str(tmp_path))
