"""Typed text, key by key."""

import pytest

from sar_tui.loop.trial import stimulus_problem
from sar_tui.model.trial_types import Frame, Performance, Stimulus
from sar_tui.rules.typed_text import LONGEST_TEXT, TypedText, typing


def typed(*keys: str, expects: str = "text") -> TypedText:
    """The text after these keys, a nanosecond after each other."""
    text = TypedText()
    for at, key in enumerate(keys, 1):
        text = text.pressed(key, at, expects)
    return text


def test_letters_spaces_and_corrections_make_a_text() -> None:
    text = typed("left", "ñ", "o", "space", "7", "backspace", "x")
    assert (text.text, text.began, text.keys, text.corrections) == ("ño x", 2, 6, 1)


def test_with_digits_nothing_else_can_be_typed() -> None:
    assert typed("a", "4", "space", "-", "7", "enter", expects="digits").text == "47"


def test_a_text_fits_on_a_line() -> None:
    full = typed(*"a" * (LONGEST_TEXT + 9))
    assert len(full.text) == LONGEST_TEXT
    assert full.keys == LONGEST_TEXT


def test_backspace_on_nothing_is_no_first_key() -> None:
    assert typed("backspace") == TypedText()


def test_a_simulated_person_types_the_text_and_sends_it() -> None:
    assert [key for _, key in typing("a b", Performance(500.0))] == ["a", "space", "b", "enter"]
    assert [key for _, key in typing("47", Performance(500.0, slips=True))] == ["4", "enter"]


@pytest.mark.parametrize(
    "stimulus",
    [
        Stimulus("a", "a", "a", expects="words"),  # type: ignore[arg-type]
        Stimulus("a", "a", "a", expects="text", halves=("l", "r")),
        Stimulus("a", "a", "a", expects="text", frames=(Frame("1", 100, awaited=True), Frame("2"))),
    ],
)
def test_a_prompt_that_cannot_be_answered_by_typing_is_a_sentence(stimulus: Stimulus) -> None:
    assert stimulus_problem(stimulus).endswith(".")
    assert stimulus_problem(Stimulus("a", "a", "a", expects="text")) == ""
