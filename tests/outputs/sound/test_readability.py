"""Texts that a voice of a language can and cannot read."""

import pytest

from sar_tui.outputs.sound.engine import why_unreadable


@pytest.mark.parametrize(
    ("text", "language"),
    [
        ("Well done.", "en"),
        ("¡Muy bien! Tu tiempo fue de 523 milisegundos.", "es"),
        ("523", "en"),
        ("Well done 😀", "en"),
        ("The word 好 means good", "en"),
        ("Молодец", "ru"),
        ("做得好", "zh"),
        ("よくできました", "ja"),
        ("კარგია", "ka"),
        ("Hello", "en-gb"),
    ],
)
def test_a_text_in_its_own_script_can_be_read(text: str, language: str) -> None:
    assert why_unreadable(text, language) == ""


@pytest.mark.parametrize(
    ("text", "language"),
    [("做得好", "en"), ("Молодец, 523", "es"), ("Well done", "ru"), ("好", "en-gb")],
)
def test_a_text_in_another_script_cannot_be_read(text: str, language: str) -> None:
    assert why_unreadable(text, language) == (
        f'The voice cannot read this text: it is in a script that the language "{language}" does '
        "not use."
    )


@pytest.mark.parametrize("text", ["😀", "...", "¡!", " "])
def test_a_text_without_letters_or_digits_cannot_be_read(text: str) -> None:
    assert (
        why_unreadable(text, "en")
        == "The voice cannot read this text: it has neither letters nor digits."
    )
