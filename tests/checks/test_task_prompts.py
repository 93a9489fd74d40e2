"""The check of a task names each character that is not drawn large, and tells of colours and
pictures.
"""

from pathlib import Path

import msgspec
import pytest
from PIL import Image

from sar_tui.app.prompt_needs import NO_COLOR
from sar_tui.checks.check import Check
from sar_tui.checks.task_prompts import checks, size_warning
from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from tests.widgets.test_big_prompt import prompt


def test_each_character_without_a_large_shape_is_named_once(keyboard: type[Task]) -> None:
    large = [prompt(glyph, "Press: f") for glyph in ("f", "←←→←←", "HOUSE", "Äpfel", "●")]
    assert size_warning(keyboard, large) == ""
    prompts = [prompt(glyph, "Say it") for glyph in ("語", "a語", "🍎", "f")]
    found = size_warning(keyboard, prompts)
    assert found.endswith("as there are no large ones: 語 (U+8A9E), 🍎 (U+1F34E).")


def test_what_is_too_long_is_named(keyboard: type[Task], catalogue: Catalogue) -> None:
    assert "encyclopaedia" in size_warning(keyboard, [prompt("encyclopaedia", "Say it")])
    wide = prompt("f", "word " * 20)
    assert "wider than a terminal of 80 columns" in size_warning(keyboard, [wide])
    halves = msgspec.structs.replace(prompt("", "Go"), halves=("", "X"))
    assert size_warning(keyboard, [halves]) == "", "each half has room for a letter"
    halves = msgspec.structs.replace(halves, halves=("HOUSE", ""))
    assert "HOUSE" in size_warning(keyboard, [halves])
    drawn_by_the_task = catalogue.task("pairs")
    assert size_warning(drawn_by_the_task, [prompt("語", "Say it")]) == ""


def checked(kind: type[Task], catalogue: Catalogue, **changes: str) -> dict[str, Check]:
    shown = msgspec.structs.replace(prompt("f", "Press: f"), **changes)
    themes = [catalogue.theme(name) for name in ("calm", "playful")]
    return {each.check: each for each in checks(kind, [shown], themes)}


def test_contrasts_of_colours_are_told_for_each_theme(
    keyboard: type[Task], catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    def of(colour: str) -> Check:
        found = checked(keyboard, catalogue, colour=colour)
        return found["has colours of the colour-blind-safe set"]

    monkeypatch.delenv("NO_COLOR", raising=False)
    assert (of("blue").ok, of("blue").found) == (True, "least contrast: calm 3.48, playful 4.73")
    themes = "With the theme playful, these are darker or lighter: yellow."
    assert of("yellow").warning == themes
    assert of("pink").problems[0].startswith("There is no colour 'pink'.")
    monkeypatch.setenv("NO_COLOR", "1")
    assert NO_COLOR in of("blue").warning
    assert list(checked(keyboard, catalogue)) == ["draws its prompts large"]


def test_missing_and_large_pictures_are_named(
    tmp_path: Path, keyboard: type[Task], catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.checks.task_prompts.task_folder", lambda _: tmp_path)
    name = "has the pictures of its prompts"
    missing = checked(keyboard, catalogue, picture="cat.png")[name]
    assert missing.problems == (f"There is no picture cat.png in {tmp_path}.",)
    Image.new("L", (2000, 2001)).save(tmp_path / "cat.png")
    large = checked(keyboard, catalogue, picture="cat.png")[name]
    assert large.ok
    assert "cat.png (2000×2001)" in large.warning
