"""Texts that a voice of a language can and cannot read."""

import pytest

from sar_tui.outputs.sound.engine import why_unreadable

IN_ITS_SCRIPT = {
    "en": ("Well done.", "523", "Well done 😀", "The word 好 means good"),
    "es": ("¡Muy bien! Tu tiempo fue de 523 milisegundos.",),
    "ru": ("Молодец",),
    "zh": ("做得好",),
    "ja": ("よくできました",),
    "ka": ("კარგია",),
    "en-gb": ("Hello",),
}


def test_a_text_in_its_own_script_can_be_read() -> None:
    for language, texts in IN_ITS_SCRIPT.items():
        for text in texts:
            assert why_unreadable(text, language) == "", text


@pytest.mark.parametrize(
    ("text", "language"),
    [("做得好", "en"), ("Молодец, 523", "es"), ("Well done", "ru"), ("好", "en-gb")],
)
def test_a_text_in_another_script_cannot_be_read(text: str, language: str) -> None:
    assert f'a script that the language "{language}" does not' in why_unreadable(text, language)


@pytest.mark.parametrize("text", ["😀", "...", "¡!", " "])
def test_a_text_without_letters_or_digits_cannot_be_read(text: str) -> None:
    assert "neither letters nor digits" in why_unreadable(text, "en")
