"""Choice of a voice, by name or by language, and the texts that one of a language can read."""

import pytest

from sar_tui.outputs.sound.engine import choose, found_voice, why_unreadable
from sar_tui.outputs.sound.protocol import FoundVoice

ESPEAK = [
    found_voice(identifier, name, [language])
    for identifier, name, language in (
        ("gmw/de", "German", "de"),
        ("gmw/en-029", "English (Caribbean)", "en-029"),
        ("gmw/en", "English (Great Britain)", "en-gb"),
        ("gmw/en-us", "English (America)", "en-us"),
        ("roa/es-419", "Spanish (Latin America)", "es-419"),
        ("roa/es", "Spanish (Spain)", "es"),
        ("roa/pt-br", "Portuguese (Brazil)", "pt-br"),
    )
]


@pytest.mark.parametrize(
    ("language", "name", "default", "chosen"),
    [
        ("en", "", "gmw/en", "gmw/en"),
        ("en", "", "gmw/de", "gmw/en-us"),
        ("es", "", "gmw/en", "roa/es"),
        ("es", "roa/es-419", "gmw/en", "roa/es-419"),
        ("es", "latin america", "gmw/en", "roa/es-419"),
        ("es", "nobody", "gmw/en", "roa/es"),
        ("es-mx", "", "gmw/en", "roa/es"),
        ("de", "", "gmw/en", "gmw/de"),
        ("de-at", "", "gmw/en", "gmw/de"),
        ("pt", "", "gmw/en", "roa/pt-br"),
        ("fi", "", "gmw/en", None),
        ("e", "", "gmw/en", None),
    ],
)
def test_the_voice_fits(language: str, name: str, default: str, chosen: str | None) -> None:
    voice = choose(ESPEAK, language, name, default)
    assert (voice.id if voice else None) == chosen


def test_languages_are_read_in_any_form_that_an_engine_gives() -> None:
    for tags, languages in (
        (["en_US"], ("en-us",)),
        ([b"\x05en-gb"], ("en-gb",)),
        ("es_ES", ("es-es",)),
        (("es-MX",), ("es-mx",)),
        *((none, ()) for none in ([None], None, ["Unknown Locale: 4096"], [])),
    ):
        assert found_voice("com.apple.voice.Someone", "Someone", tags).languages == languages, tags


def test_a_voice_without_languages_may_tell_them_by_its_id() -> None:
    assert found_voice("roa/es-419", None, None) == FoundVoice("roa/es-419", "", ("es-419",))


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
