"""Given a text, when it is looked through for numbers, then digits and number words are found, and nothing else."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st
from text_to_num import alpha2digit

from sar_tui.framework.number_words import holds_number

SMALL = {
    "en": """zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen
        seventeen eighteen nineteen""",
    "es": """cero uno dos tres cuatro cinco seis siete ocho nueve diez once doce trece catorce quince dieciséis
        diecisiete dieciocho diecinueve veinte veintiuno veintidós veintitrés veinticuatro veinticinco veintiséis
        veintisiete veintiocho veintinueve""",
}
TENS = {
    "en": "twenty thirty forty fifty sixty seventy eighty ninety",
    "es": "veinte treinta cuarenta cincuenta sesenta setenta ochenta noventa",
}
HUNDREDS = (
    "ciento doscientos trescientos cuatrocientos quinientos seiscientos setecientos ochocientos novecientos".split()
)


def spelled(number: int, language: str) -> str:
    """A number from 0 to 1000 in words."""
    small = SMALL[language].split()
    if number < len(small):
        return small[number]
    if number < 100:
        tens, rest = divmod(number, 10)
        joined = {"en": "-", "es": " y "}[language]
        return TENS[language].split()[tens - 2] + (f"{joined}{small[rest]}" if rest else "")
    hundreds, rest = divmod(number, 100)
    more = f" {spelled(rest, language)}" if rest else ""
    if language == "en":
        return "one thousand" if number == 1000 else f"{small[hundreds]} hundred{more}"
    if number in (100, 1000):
        return "cien" if number == 100 else "mil"
    return HUNDREDS[hundreds - 1] + more


@pytest.mark.parametrize("language", ["en", "es"])
def test_every_number_to_a_thousand_is_found_in_words(language: str) -> None:
    for number in range(1001):
        words = spelled(number, language)
        assert alpha2digit(words, language, 0) == str(number)
        for said in (f"Nearly {words}!", words.upper(), words.capitalize()):
            assert holds_number(said, language), said


@pytest.mark.parametrize("language", ["en", "es"])
def test_every_single_word_of_a_number_is_found_alone(language: str) -> None:
    for word in {word for number in range(1001) for word in spelled(number, language).replace("-", " ").split()} - {
        "y"
    }:
        assert holds_number(word, language), word


@pytest.mark.parametrize(
    "text",
    ["32 ms", "Two more.", "One-handed", "a hundred", "TWICE as good", "٣ times", "x2", "½", "Ⅳ", "x²", "half of it"],
)
def test_numbers_are_found_in_digits_and_words(text: str) -> None:
    assert holds_number(text)


@pytest.mark.parametrize(
    "text", ["Doscientas veces", "a la mitad", "el doble", "VEINTIDÓS", "veintidos", "la primera vez"]
)
def test_spanish_numbers_are_found_with_and_without_accents(text: str) -> None:
    for form in ("NFC", "NFD"):
        assert holds_number(unicodedata.normalize(form, text), "es")


@pytest.mark.parametrize("text", ["Everyone is often at tension.", "Well done.", "Attend to the phone", ""])
def test_a_number_word_inside_another_word_is_none(text: str) -> None:
    assert not holds_number(text)


@pytest.mark.parametrize("text", ["Un poco más, una vez más.", "Muy bien, sonríe.", "Familia, oncología, parada"])
def test_the_spanish_article_and_parts_of_words_are_no_numbers(text: str) -> None:
    assert not holds_number(text, "es")


def test_each_language_has_its_own_numbers() -> None:
    assert holds_number("once", "es-MX")
    assert holds_number("a one-off", "en-GB")
    assert not holds_number("ocho", "en")
    assert not holds_number("seven", "es")


def test_of_an_unknown_language_digits_are_found() -> None:
    assert holds_number("7 fois", "fr")
    assert not holds_number("sept fois", "fr")


@given(st.text(), st.sampled_from(["0", "7", "٣", "½"]), st.text(), st.sampled_from(["en", "es", "fr"]))
def test_a_digit_is_found_wherever_it_stands(before: str, digit: str, after: str, language: str) -> None:
    assert holds_number(before + digit + after, language)
