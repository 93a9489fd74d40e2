"""The check of a task names each character that is not drawn large."""

import msgspec
import pytest

from sar_tui.checks.task_prompts import size_warning
from sar_tui.framework.messages import Prompt
from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from tests.widgets.test_big_prompt import prompt


@pytest.mark.parametrize("glyph", ["f", "←←→←←", "HOUSE", "Äpfel", "●"])
def test_large_characters_are_not_warned_of(glyph: str, keyboard: type[Task]) -> None:
    assert size_warning(keyboard, [prompt(glyph, "Press: f")]) == ""


def test_each_character_without_a_large_shape_is_named_once(keyboard: type[Task]) -> None:
    prompts = [prompt(glyph, "Say it") for glyph in ("語", "a語", "🍎", "f")]
    found = size_warning(keyboard, prompts)
    assert found.endswith("as there are no large ones: 語 (U+8A9E), 🍎 (U+1F34E).")


def test_what_is_too_long_is_named(keyboard: type[Task]) -> None:
    assert "encyclopaedia" in size_warning(keyboard, [prompt("encyclopaedia", "Say it")])
    wide = prompt("f", "word " * 20)
    assert "wider than a terminal of 80 columns" in size_warning(keyboard, [wide])


def test_halves_are_checked_for_the_room_they_have(keyboard: type[Task]) -> None:
    def halves(*texts: str) -> Prompt:
        return msgspec.structs.replace(prompt("", "Go"), halves=texts)

    assert size_warning(keyboard, [halves("", "X")]) == ""
    assert "HOUSE" in size_warning(keyboard, [halves("HOUSE", "")])


def test_a_task_that_draws_its_prompts_itself_is_not_warned(catalogue: Catalogue) -> None:
    assert size_warning(catalogue.task("pairs"), [prompt("語", "Say it")]) == ""
