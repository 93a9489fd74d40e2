"""Edited themes are applied while the app runs, but never in a trial."""

import os
import shutil
from collections.abc import AsyncIterator
from pathlib import Path
from unittest.mock import Mock

import pytest
from textual.widgets import OptionList

from sar_tui.app.app import SarTui
from sar_tui.app.themes import ThemeWatch
from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from tests.app.app_driver import AppDriver, known, open_app, plan

HAPPY_EYES = "│  ◠   ◠  │"


@pytest.fixture
def folder(tmp_path: Path, catalogue: Catalogue) -> Path:
    """A copy of the calm theme."""
    own = tmp_path / "themes" / "mine"
    shutil.copytree(catalogue.theme_folder("calm"), own)
    return own


@pytest.fixture
def themes(folder: Path) -> Catalogue:
    return Catalogue(themes=(folder.parent,))


@pytest.fixture
async def mine(data: Path, themes: Catalogue, keyboard: type[Task]) -> AsyncIterator[AppDriver]:
    """A session in the copy, with feedback in words."""
    planned = plan(themes, keyboard, theme="mine", feedback_form="qualitative")
    async with open_app(data, themes, planned) as driver:
        yield driver


@pytest.fixture
async def at_home(data: Path, themes: Catalogue) -> AsyncIterator[AppDriver]:
    """The home screen in the copy."""
    known(data, theme="mine")
    async with open_app(data, themes) as driver:
        yield driver


def edit(folder: Path, old: str, new: str, file: str = "theme.toml") -> None:
    """Change a file and its modification time, however fast the test is."""
    path = folder / file
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    then = path.stat().st_mtime_ns + 1_000_000_000
    os.utime(path, ns=(then, then))


async def look(driver: AppDriver) -> None:
    """Check twice, as the app does by its timer."""
    driver.app.themes.watch.look()
    driver.app.themes.watch.look()
    await driver.settle()


class Editor:
    """Records the themes and reports of a watch."""

    def __init__(self, themes: Catalogue) -> None:
        self.applied: list[Theme] = []
        self.notices: list[str] = []
        self.watch = ThemeWatch(themes, self.applied.append, self.notices.append)
        self.watch.follow("mine")

    def look(self, times: int = 1) -> None:
        for _ in range(times):
            self.watch.look()


@pytest.fixture
def editor(themes: Catalogue) -> Editor:
    return Editor(themes)


# --- the watch


def test_an_edited_theme_is_applied_once(folder: Path, editor: Editor) -> None:
    editor.look()
    assert editor.applied == []
    edit(folder, "#7cc4e8", "#7cc4e9")
    editor.look()
    edit(folder, "#7cc4e9", "#7cc4ea")
    editor.look()
    assert editor.applied == []
    editor.look(3)
    assert [theme.colors.accent for theme in editor.applied] == ["#7cc4ea"]
    assert editor.notices == []


def test_added_phrases_are_an_edit_and_the_language_stays(folder: Path, editor: Editor) -> None:
    spanish = (folder / "phrases.es.toml").read_text(encoding="utf-8")
    (folder / "phrases.es.toml").unlink()
    editor.watch.follow("mine", "es")
    (folder / "phrases.es.toml").write_text(spanish, encoding="utf-8")
    editor.look(2)
    assert [theme.language for theme in editor.applied] == ["es"]


def test_an_unreadable_theme_is_told_once(folder: Path, editor: Editor) -> None:
    edit(folder, "[colors]", "[colors")
    editor.look(4)
    assert editor.applied == []
    (notice,) = editor.notices
    assert notice.startswith("The theme mine cannot be read: ")
    assert notice.endswith("The previous version stays in use.")
    edit(folder, "[colors\n", "[colors]\n")
    editor.look(2)
    assert len(editor.applied) == 1
    assert len(editor.notices) == 1


@pytest.mark.parametrize(
    ("problems", "notices"),
    [
        (1, "Theme edited. One thing to fix: "),
        (2, "Theme edited. 2 things to fix: "),
        (4, " And 2 more: see sar-tui themes check."),
    ],
)
def test_a_theme_with_problems_is_applied_and_the_problems_reported(
    problems: int, notices: str, folder: Path, editor: Editor
) -> None:
    for color in ("#7cc4e8", "#8fd6a4", "#d9c98a", "#e8b08a")[:problems]:
        edit(folder, f'"{color}"', '"blueish"')
    editor.look(2)
    assert len(editor.applied) == 1
    assert notices in editor.notices[0]


@pytest.mark.parametrize("fault", [OSError("gone"), ValueError("embedded null byte")])
def test_a_folder_that_cannot_be_accessed_is_told_and_the_theme_stays_applied(
    editor: Editor, themes: Catalogue, monkeypatch: pytest.MonkeyPatch, fault: Exception
) -> None:
    monkeypatch.setattr(themes, "theme_folder", Mock(side_effect=fault))
    editor.look(3)
    assert editor.applied == []
    assert editor.notices == [
        f"The theme mine cannot be read: {fault}. The previous version stays in use."
    ]


# --- the app


async def test_home_reads_all_themes_and_applies_an_edit_or_reports_its_fault_at_once(
    at_home: AppDriver, folder: Path
) -> None:
    assert list(at_home.app.themes.known) == ["calm", "high-contrast", "mine", "playful"]
    options = at_home.app.screen.query_one("#theme", OptionList).options
    assert [option.id for option in options] == list(at_home.app.themes.known)
    edit(folder, "#10171e", "#30171e")
    await look(at_home)
    assert at_home.app.screen.styles.background.hex.lower() == "#30171e"
    edit(folder, "[colors]", "[colors")
    await look(at_home)
    at_home.see("The theme mine cannot be read")
    assert at_home.app.theme == "sar-mine"


async def test_in_a_session_face_colours_and_later_utterances_change(
    mine: AppDriver, folder: Path
) -> None:
    words = mine.said
    assert HAPPY_EYES in mine.text
    edit(folder, HAPPY_EYES, "│  Q   Q  │")
    edit(folder, "#10171e", "#30171e")
    phrases = (folder / "phrases.en.toml").read_text(encoding="utf-8")
    start = phrases.index("positive_strong = [")
    wordings = phrases[start : phrases.index("]", start) + 1]
    edit(folder, wordings, 'positive_strong = ["Splendid."]', "phrases.en.toml")
    await look(mine)
    assert "│  Q   Q  │" in mine.text
    assert HAPPY_EYES not in mine.text
    assert mine.said == words
    assert mine.app.screen.styles.background.hex.lower() == "#30171e"
    timer = mine.app.themes._looks._active  # type: ignore[union-attr]
    prompt = await mine.to_first_prompt()
    assert not timer.is_set(), "no file is looked at in a trial"
    await mine.answer(prompt)
    assert not timer.is_set()
    await mine.answer(await mine.to_prompt())
    assert timer.is_set()
    assert "Splendid." in mine.said
    applied = mine.messages("theme/applied")
    assert applied[-1]["theme"]["colors"]["background"] == "#30171e"


async def test_a_fault_is_told_after_the_session_unless_it_was_fixed(
    at_home: AppDriver, folder: Path
) -> None:
    await at_home.press("enter", "enter", "enter", "enter")
    edit(folder, '"#7cc4e8"', '"blueish"')
    await look(at_home)
    assert at_home.app.themes.pending_notice.startswith("Theme edited. One thing to fix: ")
    edit(folder, '"blueish"', '"#7cc4e8"')
    await look(at_home)
    assert at_home.app.themes.pending_notice == ""
    edit(folder, "[colors]", "[colors")
    await look(at_home)
    at_home.lacks("Theme edited", "cannot be read")
    assert HAPPY_EYES in at_home.text
    await at_home.do_attempt(await at_home.to_first_prompt())
    at_home.lacks("cannot be read")
    at_home.app.screen.dismiss()
    await at_home.settle()
    at_home.see("The theme mine cannot be read")
    assert at_home.app.themes.pending_notice == ""


# --- the beginning


def test_only_the_first_theme_is_read_before_the_app_runs(data: Path, themes: Catalogue) -> None:
    assert list(SarTui(data, themes).themes.known) == ["calm"]


async def test_a_faulty_calm_is_replaced(data: Path, folder: Path, themes: Catalogue) -> None:
    edit(folder, "[colors]", "[colors")
    folder.rename(folder.parent / "calm")
    async with open_app(data, themes) as driver:
        assert driver.app.theme == "sar-high-contrast"
        driver.see("The theme calm cannot be read")
