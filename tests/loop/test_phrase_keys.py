"""A wording for a situation is valid, or its problem is reported."""

import re
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from text_to_num import alpha2digit

from sar_tui.loop.phrase_keys import (
    FIGURES,
    PHRASE_KEYS,
    QUANTITATIVE,
    holds_number,
    wording_problems,
)
from sar_tui.model.language import BUNDLED


def test_the_page_on_themes_lists_every_phrase_key_with_its_slots() -> None:
    page = (Path(__file__).parents[2] / "docs" / "themes-and-words.md").read_text(encoding="utf-8")
    rows = [line.strip("|").split("|") for line in page.splitlines() if line.count("|") == 4]
    listed = {
        situation: set(re.findall(r"`(\w+)`", slots))
        for situations, _, slots in rows
        for situation in re.findall(r"`(\w+)`", situations)
        if situation in PHRASE_KEYS
    }
    assert listed == PHRASE_KEYS


@pytest.mark.parametrize(
    ("situation", "wording"),
    [
        ("goodbye", "Bye."),
        ("positive_first", "{value}"),
        ("negative_improved", "{{ {difference} {change} than {reference} }}"),
        ("performance_worsened", "Next time: {aim}."),
    ],
)
def test_a_valid_wording_has_no_problems(situation: str, wording: str) -> None:
    assert wording_problems(situation, wording, "en") == []


@pytest.mark.parametrize(
    ("situation", "wording", "problem"),
    [
        ("goodbye", "Bye, {name}.", " uses the unknown slot {name}."),
        ("goodbye", "  ", " is empty."),
        ("positive_first", "{value}, {difference}", " uses the unknown slot {difference}."),
        ("neutral", "Three quarters there.", " holds a number: 'Three quarters there.'."),
        ("accuracy", "Get 8 right.", " holds a number: 'Get 8 right.'."),
        ("performance_worsened", "Do it twice {aim}.", " holds a number: 'Do it twice {aim}.'."),
        ("negative_same", "As {reference}.", " has no slot for a figure: 'As {reference}.'."),
        ("positive_improved", "It is {change}.", " has no slot for a figure"),
        ("neutral_first", "At {value", " has broken slots (expected '}' before end of string)"),
        ("neutral_first", "At {value:.1f}", " has a slot with more than a name: 'At {value:.1f}'."),
        ("neutral_first", "At {value!x}", " has a slot with more than a name"),
        ("neutral_first", "At {value:{width}}", " has a slot with more than a name"),
        ("neutral_first", "At {}", " uses the unknown slot {}."),
        ("neutral_first", "At {value.real}", " uses the unknown slot {value.real}."),
    ],
)
def test_an_invalid_wording_is_reported_in_one_sentence(
    situation: str, wording: str, problem: str
) -> None:
    problem_found, *_ = wording_problems(situation, wording, "en")
    assert problem_found.startswith(f"A wording for {situation} (en){problem}")


def test_number_words_are_those_of_the_language() -> None:
    (problem,) = wording_problems("positive", "Ya once veces.", "es")
    assert "(es) holds a number" in problem
    assert wording_problems("positive", "Ocho, ocho!", "en") == []


@given(st.text(max_size=60), st.sampled_from(sorted(PHRASE_KEYS)), st.sampled_from(list(BUNDLED)))
def test_a_wording_without_problems_can_be_formatted(
    wording: str, situation: str, language: str
) -> None:
    if not wording_problems(situation, wording, language):
        slots = PHRASE_KEYS[situation]
        said = wording.format(**{slot: "12 ms" if slot in FIGURES else "faster" for slot in slots})
        assert holds_number(said, language) == (situation in QUANTITATIVE)


BRACES = ["{", "}", "{{", "}}", "value", "goal", "!", ":", "r", "12", "[0]", ".x", " "]


@given(st.lists(st.sampled_from(BRACES)))
def test_wordings_with_any_braces_are_refused_or_can_be_formatted(parts: list[str]) -> None:
    wording = "".join(parts)
    if not wording_problems("neutral_first", wording, "en"):
        assert wording.format(value="12 ms", goal="12 ms")


# --- numbers in a text

SMALL = {
    "en": """zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen
        seventeen eighteen nineteen""",
    "es": """cero uno dos tres cuatro cinco seis siete ocho nueve diez once doce trece catorce quince dieciséis
        diecisiete dieciocho diecinueve veinte veintiuno veintidós veintitrés veinticuatro veinticinco veintiséis
        veintisiete veintiocho veintinueve""",
    "de": """null eins zwei drei vier fünf sechs sieben acht neun zehn elf zwölf dreizehn vierzehn fünfzehn sechzehn
        siebzehn achtzehn neunzehn""",
}
TENS = {
    "en": "twenty thirty forty fifty sixty seventy eighty ninety",
    "es": "veinte treinta cuarenta cincuenta sesenta setenta ochenta noventa",
    "de": "zwanzig dreißig vierzig fünfzig sechzig siebzig achtzig neunzig",
}
HUNDREDS = (
    "ciento doscientos trescientos cuatrocientos quinientos seiscientos setecientos "
    "ochocientos novecientos"
).split()


def german(number: int) -> str:
    """Return a number from 20 to 1000 in German: one word."""
    small, tens = SMALL["de"].split(), TENS["de"].split()
    ones = ["", "ein", *small[2:]]
    if number == 1000:
        return "eintausend"
    if number < 100:
        return (f"{ones[number % 10]}und" if number % 10 else "") + tens[number // 10 - 2]
    rest = number % 100
    return f"{ones[number // 100]}hundert{spelled(rest, 'de') if rest else ''}"


def spelled(number: int, language: str) -> str:
    """Return a number from 0 to 1000 in words."""
    small = SMALL[language].split()
    if number < len(small):
        return small[number]
    if language == "de":
        return german(number)
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


@pytest.mark.parametrize("language", BUNDLED)
def test_every_number_to_a_thousand_is_found_in_words(language: str) -> None:
    for number in range(1001):
        words = spelled(number, language)
        assert alpha2digit(words, language, 0) == str(number)
        for said in (f"Nearly {words}!", words.upper(), words.capitalize()):
            assert holds_number(said, language), said


@pytest.mark.parametrize("language", BUNDLED)
def test_every_single_word_of_a_number_is_found_alone(language: str) -> None:
    for word in {
        word
        for number in range(1001)
        for word in spelled(number, language).replace("-", " ").split()
    } - {"y"}:
        assert holds_number(word, language), word


FOUND = {
    "en": ("32 ms", "Two more.", "One-handed", "a hundred", "TWICE as good", "half of it"),
    "es": ("Doscientas veces", "a la mitad", "el doble", "VEINTIDÓS", "veintidos", "primera vez"),
    "de": ("Zwei mehr.", "ein Drittel", "EINUNDZWANZIG", "doppelt so gut", "dreißig", "dreissig"),
    "fr": ("7 fois", "٣ times", "x2", "½", "Ⅳ", "x²"),
    "es-MX": ("once",),
    "en-GB": ("a one-off",),
}
NOT_FOUND = {
    "en": ("Everyone is often at tension.", "Well done.", "Attend to the phone", "", "ocho"),
    "es": ("Un poco más, una vez más.", "Muy bien, sonríe.", "Familia, oncología", "seven"),
    "de": ("Noch einmal, ein wenig mehr.", "Achten Sie darauf.", "Zweifellos, keiner", "seven"),
    "fr": ("sept fois",),
}


def test_numbers_are_found_in_digits_and_words_of_the_language_and_nowhere_else() -> None:
    """Accents may be composed or not; articles, parts of words and other languages are none."""
    for texts, is_found in ((FOUND, True), (NOT_FOUND, False)):
        for language, text in [(name, text) for name, many in texts.items() for text in many]:
            for form in ("NFC", "NFD"):
                normal = unicodedata.normalize(form, text)
                assert holds_number(normal, language) is is_found, text
