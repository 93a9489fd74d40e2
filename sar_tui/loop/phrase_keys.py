"""The phrases of a theme: their keys, the slots each may use, and the rule that phrases in words
hold no number.
"""

import re
import string
import unicodedata
from collections.abc import Iterator
from functools import cache

from sar_tui.model.visible_text import control_problem

FIGURES = frozenset(
    {"value", "goal", "difference", "percent", "correct", "trials", "reached", "attempts"}
)
"""Slots that hold a number."""
_VALENCES = ("positive", "neutral", "negative")

PHRASE_KEYS: dict[str, set[str]] = {
    # without a result
    "greeting": set(),
    "welcome_back": set(),
    "encouragement": set(),
    "encouragement_new_level": set(),
    "rest": set(),
    "filler": set(),
    "goodbye": set(),
    "goodbye_early": set(),
    # the same, to two people at once
    "greeting_both": set(),
    "welcome_back_both": set(),
    "encouragement_both": set(),
    "encouragement_new_level_both": set(),
    "rest_both": set(),
    "goodbye_both": set(),
    "goodbye_early_both": set(),
    # the result of a race
    "won": set(),
    "lost": set(),
    "drawn": set(),
    "race_figures": {"reached", "trials"},
    # knowledge of results, in words; the distance from the goal sets the degree
    "positive_slight": set(),
    "positive": set(),
    "positive_strong": set(),
    "neutral": set(),
    "negative_slight": set(),
    "negative": set(),
    "negative_strong": set(),
    "accuracy": set(),
    "unanswered": {"advice"},
    "empty": set(),
    **{f"summary_{valence}": set() for valence in _VALENCES},
    # knowledge of results, in numbers
    **{f"{valence}_first": {"value", "goal"} for valence in _VALENCES},
    **{
        f"{valence}_{change}": {"value", "goal", "difference", "change", "reference"}
        for valence in _VALENCES
        for change in ("improved", "worsened")
    },
    **{f"{valence}_same": {"value", "goal", "reference"} for valence in _VALENCES},
    "accuracy_figures": {"correct", "trials"},
    "empty_figures": {"correct", "trials"},
    "summary_figures": {"reached", "attempts", "value", "goal"},
    "summary_empty_figures": {"reached", "attempts"},
    # knowledge of performance, in words and in numbers
    "performance_improved": {"change", "reference"},
    "performance_worsened": {"aim", "reference"},
    "performance_improved_figures": {"change", "percent", "reference"},
    "performance_worsened_figures": {"aim", "percent", "reference"},
}
"""Slots that a wording may use, by the key of its phrase."""

SPOKEN_BY = {
    "encouragement_new_level": "encouragement",
    "encouragement_new_level_both": "encouragement_both",
}
"""Situations for which a theme need not have its own wordings, with those whose wordings are used
then.
"""

PERFORMANCE = tuple(name for name in PHRASE_KEYS if name.startswith("performance_"))
QUANTITATIVE = tuple(name for name, slots in PHRASE_KEYS.items() if slots & FIGURES)
QUALITATIVE = tuple(name for name in PHRASE_KEYS if name not in QUANTITATIVE)

VOCABULARY = ("last_attempt", "last_at_level", "best_attempt", "session_mean", "goal")
"""Words for the slot ``reference``."""


# --- numbers in a text

_SPELLED = {
    "en": """zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen
        seventeen eighteen nineteen twenty thirty forty fifty sixty seventy eighty ninety hundred hundreds thousand
        thousands million millions half halves quarter quarters once twice thrice first second third thirds fourth fifth
        sixth seventh eighth ninth tenth dozen dozens couple pair double triple percent""",
    "es": """cero uno dos tres cuatro cinco seis siete ocho nueve diez once doce trece catorce quince dieciséis
        diecisiete dieciocho diecinueve veinte veintiuno veintiuna veintiún veintidós veintitrés veinticuatro
        veinticinco veintiséis veintisiete veintiocho veintinueve treinta cuarenta cincuenta sesenta setenta ochenta
        noventa cien ciento cientos doscientos trescientos cuatrocientos quinientos seiscientos setecientos ochocientos
        novecientos doscientas trescientas cuatrocientas quinientas seiscientas setecientas ochocientas novecientas mil
        miles millón millones mitad medio media tercio tercios cuarto cuarta cuartos primer primero primera segundo
        segunda tercer tercero tercera quinto quinta sexto sexta séptimo séptima octavo octava noveno novena décimo
        décima docena docenas par doble triple""",
    "de": """null hunderte tausend eintausend tausende million millionen halb halbe halben halber halbes hälfte drittel
        viertel fünftel zehntel zweimal dreimal viermal erste ersten erster erstes zweite zweiten zweiter zweites dritte
        dritten dritter drittes vierte vierten fünfte fünften sechste sechsten siebte siebten neunte neunten zehnte
        zehnten dutzend doppelt doppelte doppelten dreifach prozent""",
}
"""Number words by language. Spanish un and una and German ein are left out, as they are articles,
too; German paar (some), einmal (noch einmal: again) and achte (mind).
"""


def _folded(text: str) -> str:
    """Return a text in lower case, without accents, and with ss for ß."""
    parts = unicodedata.normalize("NFKD", text.casefold())
    return "".join(character for character in parts if not unicodedata.combining(character))


_GERMAN_SMALL = """eins zwei drei vier fünf sechs sieben acht neun zehn elf zwölf dreizehn vierzehn fünfzehn sechzehn
siebzehn achtzehn neunzehn""".split()
_GERMAN_TENS = "zwanzig dreißig vierzig fünfzig sechzig siebzig achtzig neunzig".split()


def _german() -> Iterator[str]:
    """Yield the German numbers from 1 to 999, each of which is one word."""
    ones = ["ein", *_GERMAN_SMALL[1:9]]
    small = [
        *_GERMAN_SMALL,
        *_GERMAN_TENS,
        *(f"{one}und{tens}" for tens in _GERMAN_TENS for one in ones),
    ]
    yield from small
    for hundred in ("hundert", *(f"{one}hundert" for one in ones)):
        yield hundred
        yield from (f"{hundred}{rest}" for rest in small)


@cache
def _number_words(language: str) -> frozenset[str]:
    """Return the number words of a language in the form that `holds_number` compares."""
    spelled = _SPELLED.get(language, "").split()
    if language == "de":
        spelled += _german()
    return frozenset(map(_folded, spelled))


def holds_number(text: str, language: str = "en") -> bool:
    """Return True if a text holds a number, in digits or, for the bundled languages, in words."""
    if any(unicodedata.category(character).startswith("N") for character in text):
        return True
    known = _number_words(language.partition("-")[0])
    return not known.isdisjoint(re.findall(r"[^\W\d_]+", _folded(text)))


# --- one wording


def wording_problems(situation: str, wording: str, language: str) -> list[str]:
    """Return what is wrong with a wording for a situation, one sentence each."""
    slots = PHRASE_KEYS[situation]
    where = f"A wording for {situation} ({language})"
    try:
        parts = [part[1:] for part in string.Formatter().parse(wording) if part[1] is not None]
    except ValueError as error:
        return [f"{where} has broken slots ({error}): {wording!r}."]
    if problem := control_problem(where, wording):
        return [problem]
    used = {name or "" for name, _, _ in parts}
    found = [f"{where} uses the unknown slot {{{name}}}." for name in sorted(used - slots)]
    if any(form or conversion for _, form, conversion in parts):
        found.append(f"{where} has a slot with more than a name: {wording!r}.")
    if not wording.strip():
        found.append(f"{where} is empty.")
    if situation in QUALITATIVE and holds_number(wording, language):
        found.append(f"{where} holds a number: {wording!r}.")
    if situation in QUANTITATIVE and not used & FIGURES:
        found.append(f"{where} has no slot for a figure: {wording!r}.")
    return found
