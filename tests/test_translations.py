"""Every text has a translation in each bundled language, and what lacks one is named."""

import shutil
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from tests import translations
from tests.translations import OTHERS, Room


@pytest.mark.slow
def test_no_bundled_language_lacks_a_text() -> None:
    assert translations.problems() == []


@pytest.mark.parametrize(
    ("file", "found"),
    [
        ('"Press {key}." = "{key} drücken."', []),
        ("", ["no translation of 'Press {key}.'"]),
        ('"Press {key}." = "Drücken."', ["lacks {key}: 'Press {key}.'"]),
        ('"Press {key}." = 3', ["not a text: 'Press {key}.'"]),
        (
            '"Press {key}." = "{key} drücken."\n"Wait." = "Warten."',
            ["no text any more: 'Wait.'"],
        ),
        ('"Press {key}." = ', ["cannot be read: "]),
    ],
)
def test_what_a_file_lacks_is_named(tmp_path: Path, file: str, found: list[str]) -> None:
    first, *others = OTHERS
    for code in others:
        (tmp_path / f"words.{code}.toml").write_text('"Press {key}." = "{key}."')
    path = tmp_path / f"words.{first}.toml"
    path.write_text(file, encoding="utf-8")
    texts = {"Press {key}."}
    problems = list(translations.room_problems(Room(tmp_path, texts, texts)))
    assert len(problems) == len(found)
    for problem, says in zip(problems, found, strict=True):
        assert problem.startswith(f"{path}: {says}")


def test_a_text_that_one_language_translates_is_missing_in_the_others(tmp_path: Path) -> None:
    first, *others = OTHERS
    for code in OTHERS:
        (tmp_path / f"words.{code}.toml").touch()
    (tmp_path / f"words.{first}.toml").write_text('"Pause" = "Pause"')
    problems = list(translations.room_problems(Room(tmp_path, set(), {"Pause"})))
    assert problems == [
        f"{tmp_path / f'words.{code}.toml'}: no translation of 'Pause'" for code in others
    ]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("\nfiller = ", "\nfiler = ", "no phrases for 'filler'"),
        ("\nfiller = ", "\nfiler = ", "no situation any more: 'filer'"),
        ("\ncm = ", "\nkm = ", "units differs from English in 'cm'"),
        ('"{value}', '"{time}', "uses the unknown slot {time}"),
    ],
)
def test_what_a_theme_lacks_is_named(tmp_path: Path, old: str, new: str, says: str) -> None:
    folder = tmp_path / "calm"
    shutil.copytree(Catalogue().theme_folder("calm"), folder)
    assert list(translations.theme_problems(folder, set())) == []
    path = folder / f"phrases.{OTHERS[0]}.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    problems = list(translations.theme_problems(folder, set()))
    assert [problem for problem in problems if says in problem and problem.startswith(str(path))]


def test_a_theme_whose_file_is_missing_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "calm"
    shutil.copytree(Catalogue().theme_folder("calm"), folder)
    path = folder / f"phrases.{OTHERS[0]}.toml"
    path.unlink()
    (problem,) = translations.theme_problems(folder, set())
    assert problem.startswith(f"{path}: cannot be read: ")
