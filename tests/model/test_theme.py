"""The bundled themes are complete, legible, kind and consistent."""

import re
from itertools import combinations, product

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len
from text_to_num import alpha2digit

from sar_tui.loop.phrase_keys import FIGURES, PHRASE_KEYS, QUANTITATIVE, holds_number
from sar_tui.model.gesture import GESTURES
from sar_tui.model.language import BUNDLED
from sar_tui.model.theme import FACES, MANNERS, Manner, Note, Theme
from sar_tui.plugins import Catalogue
from sar_tui.rules.repetition import repeated
from sar_tui.theme_folder import languages, read_theme
from tests.examples import examples

NAMES = ("calm", "high-contrast", "playful")
LANGUAGES = tuple(BUNDLED)
DEGREES = tuple(
    f"{valence}{degree}"
    for valence in ("positive", "negative")
    for degree in ("_slight", "", "_strong")
)
BREATH = 115
"""Maximum number of characters of an utterance, so that it can be said in one breath."""

UNKIND = {
    "en": r"""wrong wrongly fail fails failed failing failure bad badly poor poorly lazy mistakes? errors? faults? blame
        stupid silly weak worse worst useless sad shame pity disappoint\w* unfortunately careless clumsy sloppy never
        must should slowly""",
    "es": r"""mal malo mala malos malas fallos? fallad\w+ fallar falló errores error equivoc\w+ culpas? torpes? vag[oa]
        perezos[oa] tont[oa] débil peor inútil triste vergüenza lástima pena decepci\w+ fracas\w+ desgraciadamente
        descuid\w+ nunca debe debes debería deberías lento lenta""",
    "de": r"""falsch\w* fehler\w* schlecht\w* versag\w* misslung\w* faul\w* dumm\w* schwach\w* schlimm\w* nutzlos
        traurig schade leider enttäusch\w* ungeschickt\w* unachtsam\w* nachlässig\w* schuld\w* nie niemals muss musst
        müssen soll sollst sollen sollte\w* langsam\w* schäm\w*""",
}
"""Pattern of words that blame, belittle or mock."""
UNTRUE = {
    "en": r"""perfect\w* amazing incredible unbelievable genius champion always guarantee\w* promise\w* heal\w* cure\w*
        recover\w* therapy doctor medicine pain hurts? exercises?""",
    "es": r"""perfect[oa]\w* increíble asombros[oa] genio campe\w+ siempre garantiz\w+ promet\w+ cur[aeo]r?\w* sana\w*
        recupera\w* terapia médic[oa] medicina dolor duele ejercicios?""",
    "de": r"""perfekt\w* unglaublich\w* erstaunlich\w* fantastisch\w* genial\w* meister\w* immer garantier\w*
        verspr[eio]ch\w* heil\w* geheilt gesund\w* genes\w* therap\w* arzt ärztin medizin\w* schmerz\w* weh
        übung\w*""",
}
"""Pattern of words that exaggerate, give medical advice or promise recovery."""

CHANGES = {
    "en": ("faster", "slower", "smoother"),
    "es": ("más rápido", "más lento", "más suave"),
    "de": ("schneller", "langsamer", "fließender"),
}
AIMS = {
    "en": ("as smoothly as you can", "with a steady hand"),
    "es": ("lo más suavemente posible", "con pulso firme"),
    "de": ("so fließend wie möglich", "mit ruhiger Hand"),
}
COUNTS = ("correct", "trials", "reached", "attempts")
UNITS = ("ms", "s", "cm", "%", "taps/s", "")
ADVICE = {
    "en": "Press the key as soon as you see it.",
    "es": "Pulse la tecla en cuanto la vea.",
    "de": "Drücken Sie die Taste, sobald Sie sie sehen.",
}
SLOW = {
    "en": r"slow(?:er|ly|down)?|your time|all the time|no hurry|no need to rush|calmer|calmly|a "
    r"moment",
    "es": r"despaci\w+|lent[oa]s?|tiempo|sin prisa|no hay prisa|con (?:más )?calma|un momento",
    "de": r"langsam\w*|zeit|ohne eile|eilt nicht|gemach|in ruhe|einen moment",
}
"""Pattern of words that ask somebody to be slower."""
MORE = {
    "en": r"again|another (?:go|round|attempt)|have a go|more tries|on to the next",
    "es": r"otra|de nuevo|repetimos|más intentos|inténtal[oa]",
    "de": r"noch (?:ein)?mal|erneut|nächste[nrs]?|weiterer|mehr anläufe|versuch(?:en|t|e)? (?:sie )?es",
}
"""Pattern of words that announce another attempt."""


@pytest.fixture(params=[(name, language) for name in NAMES for language in LANGUAGES], ids="-".join)
def theme(request: pytest.FixtureRequest, catalogue: Catalogue) -> Theme:
    """Each theme in each language, without texts inherited from other themes."""
    name, language = request.param
    return read_theme(catalogue.theme_folder(name), language)


def said(theme: Theme, situation: str) -> list[str]:
    """Return the wordings for a situation with all slots filled."""
    slots = dict.fromkeys(FIGURES, "1.25 seconds") | dict.fromkeys(COUNTS, "20")
    slots |= {"percent": "100 %", "change": CHANGES[theme.language][0]}
    slots |= {"aim": AIMS[theme.language][0], "advice": ADVICE[theme.language]}
    slots["reference"] = max(theme.vocabulary.values(), key=len)
    return [wording.format(**slots) for wording in theme.phrases[situation]]


def words_of(theme: Theme) -> str:
    """Return all wordings and words of a theme in lower case."""
    wordings = [wording for wordings in theme.phrases.values() for wording in wordings]
    return " ".join([*wordings, *theme.vocabulary.values()]).lower()


def combined() -> list[tuple[str, str]]:
    """Return the situations of results in words, with those of the figures beside them."""
    together: list[tuple[str, str]] = []
    for valence in ("positive", "neutral", "negative"):
        graded = [name for name in ("neutral", *DEGREES) if name.split("_")[0] == valence]
        figures = [f"{valence}_{change}" for change in ("first", "improved", "worsened", "same")]
        together += [*product(graded, figures), (f"summary_{valence}", "summary_figures")]
    return together


# --- complete


def test_every_shipped_theme_is_complete_in_every_language(
    theme: Theme, catalogue: Catalogue
) -> None:
    assert tuple(catalogue.theme_names()) == NAMES
    assert theme.repairs == ()
    assert set(theme.phrases) == set(PHRASE_KEYS)
    assert set(theme.faces) == set(FACES)
    assert set(theme.gestures) == set(GESTURES)
    assert theme.units
    assert languages(catalogue.theme_folder(theme.name)) == LANGUAGES


# --- words


def test_every_situation_has_wordings_of_its_own(theme: Theme) -> None:
    for situation, wordings in theme.phrases.items():
        least = 3 if situation.startswith(("positive", "negative")) else 2
        assert len(set(wordings)) == len(wordings) >= least
    for one, other in combinations((*DEGREES, "neutral"), 2):
        assert not set(theme.phrases[one]) & set(theme.phrases[other])
    assert all("{advice}" in wording for wording in theme.phrases["unanswered"])


def test_no_wording_blames_exaggerates_or_speaks_of_healing(theme: Theme) -> None:
    words = UNKIND[theme.language].split() + UNTRUE[theme.language].split()
    assert re.findall(rf"\b(?:{'|'.join(words)})\b", words_of(theme)) == []


HEARTENING = (
    "encouragement encouragement_both performance_worsened performance_worsened_figures".split()
)
CONSOLING = (
    "negative_slight negative negative_strong accuracy unanswered empty summary_negative".split()
)
NEVER_SAID = {
    "slow down, where an attempt is short of its goal": ((*CONSOLING, *HEARTENING), SLOW),
    "another attempt after a consolation, which may follow the last": (CONSOLING, MORE),
}


@pytest.mark.parametrize("what", NEVER_SAID)
def test_something_is_never_said(theme: Theme, what: str) -> None:
    situations, words = NEVER_SAID[what]
    pattern = re.compile(rf"\b(?:{words[theme.language]})\b", re.IGNORECASE)
    wordings = [wording for situation in situations for wording in theme.phrases[situation]]
    assert [text for text in wordings if pattern.search(text)] == []


def test_each_result_in_words_has_a_wording_that_does_not_repeat_the_figures_beside_it(
    theme: Theme,
) -> None:
    slots = dict.fromkeys(("value", "difference", "reached"), "1")
    slots |= {"goal": "2", "attempts": "3", "change": "x"}
    for words, figures in combined():
        if words == "summary_negative":
            continue
        for other, reference in product(theme.phrases[figures], (theme.vocabulary["goal"], "x")):
            said = other.format(reference=reference, **slots)
            free = [one for one in theme.phrases[words] if not repeated(one, said)]
            assert free, (words, said)


def test_the_face_fits_the_words(theme: Theme) -> None:
    faces = {situation: theme.manner(situation).face for situation in MANNERS}
    assert {faces[situation] for situation in (*DEGREES[:3], "greeting", "goodbye")} == {"happy"}
    consoling = (*DEGREES[3:], "encouragement", "goodbye_early")
    assert {faces[situation] for situation in consoling} == {"encouraging"}
    assert faces["rest"] == "sleeping"


def test_every_wording_is_whole_sentences_short_enough_for_one_breath(theme: Theme) -> None:
    for situation in PHRASE_KEYS:
        for text in said(theme, situation):
            assert len(text) <= BREATH, text
            assert re.match(r"[¡¿]?[A-ZÁÉÍÓÚÄÖÜ\d]", text), text
            assert text[-1] in ".!?", text
            assert text.count("¡") == (text.count("!") if theme.language == "es" else 0), text
            assert text.count("¿") == (text.count("?") if theme.language == "es" else 0), text


FORMAL = {
    "es": ({"su", "sus", "usted", "le", "pruebe", "tómese"}, {"tu", "tus", "te", "ti", "contigo", "prueba"}),
    "de": ({"Sie", "Ihre", "Ihrem", "Ihnen"}, {"du", "dir", "dich", "dein", "deine"}),
}  # fmt: skip
"""Words that address adults, and those that address children."""


@pytest.mark.parametrize("language", FORMAL)
@pytest.mark.parametrize("name", NAMES)
def test_adults_are_addressed_formally_and_children_familiarly(
    name: str, language: str, catalogue: Catalogue
) -> None:
    theme = read_theme(catalogue.theme_folder(name), language)
    wordings = [wording for wordings in theme.phrases.values() for wording in wordings]
    words = {
        word
        for text in (*wordings, *theme.vocabulary.values())
        for word in re.findall(r"\w+", text if language == "de" else text.lower())
    }
    formal, familiar = FORMAL[language]
    assert not words & (formal if name == "playful" else familiar)
    assert words & (familiar if name == "playful" else formal)


@st.composite
def fillings(draw: st.DrawFn, language: str) -> dict[str, str]:
    """Generate values of the slots except the reference: results of any task."""
    decimals = draw(st.integers(0, 3))
    unit = draw(st.sampled_from(UNITS))
    numbers = st.floats(0, 99_999).map(lambda number: f"{number:.{decimals}f} {unit}".rstrip())
    if language != "en":
        numbers = numbers.map(lambda text: text.replace(".", ","))
    counts = st.integers(0, 100).map(str)
    return {
        **{slot: draw(numbers) for slot in ("value", "goal", "difference")},
        **{slot: draw(counts) for slot in COUNTS},
        "percent": f"{draw(st.integers(0, 500))} %",
        "change": draw(st.sampled_from(CHANGES[language])),
        "aim": draw(st.sampled_from(AIMS[language])),
        "advice": ADVICE[language],
    }


def spells_a_number(text: str, language: str) -> bool:
    """Return True if an independent parser finds a number. It takes Spanish un, una and German ein,
    eine for one: they are articles.
    """
    articles = {"es": r"\b[Uu]na?\b", "de": r"\b[Ee]in(?:e[mnrs]?)?\b"}
    if language in articles:
        text = re.sub(articles[language], "·", text)
    return any(character.isdigit() for character in alpha2digit(text, language, 0))


@pytest.mark.parametrize(
    ("name", "language"), [(name, language) for name in NAMES for language in LANGUAGES]
)
@given(data=st.data())
@examples(25)
def test_verbal_wordings_contain_no_number_and_numeric_ones_always_do(
    name: str, language: str, data: st.DataObject, catalogue: Catalogue
) -> None:
    theme = read_theme(catalogue.theme_folder(name), language)
    slots = data.draw(fillings(language))
    for reference in theme.vocabulary.values():
        for situation, wordings in theme.phrases.items():
            for wording in wordings:
                text = wording.format(**slots, reference=reference)
                numeric = situation in QUANTITATIVE
                assert holds_number(text, language) == numeric, text
                assert re.search(r"\d", text) or not numeric, text
                assert numeric or not spells_a_number(text, language), text


@pytest.mark.parametrize(
    ("language", "text", "spoken"),
    [
        ("en", "412 ms, 30 ms faster.", "412 milliseconds, 30 milliseconds faster."),
        ("en", "0.25 s; 12 % smoother", "0.25 seconds; 12 percent smoother"),
        ("en", "2.0 taps/s", "2.0 taps per second"),
        ("es", "0,25 s, un 12 % más suave", "0,25 segundos, un 12 por ciento más suave"),
        ("de", "0,25 s, 12 % fließender", "0,25 Sekunden, 12 Prozent fließender"),
        ("de", "1 s, 1 ms, 1 cm, 2 cm", "1 Sekunde, 1 Millisekunde, 1 Zentimeter, 2 Zentimeter"),
        ("en", "3 sheep, 4 msec, ms", "3 sheep, 4 msec, ms"),
        ("en", "15cm.", "15 centimetres."),
        ("en", "1 s, 3.5 s, 1.1 s, 0.1 s", "1 second, 3.5 seconds, 1.1 seconds, 0.1 seconds"),
        ("en", "11 s; 1,001 ms; 1.0 s", "11 seconds; 1,001 milliseconds; 1.0 seconds"),
        ("en", "1 taps/s, 1 %", "1 tap per second, 1 percent"),
        ("es", "1 s, 3,5 s, 1,1 s, 0,1 s", "1 segundo, 3,5 segundos, 1,1 segundos, 0,1 segundos"),
        ("es", "1 Hz, 21 ms, 1 toque", "1 hercio, 21 milisegundos, 1 toque"),
        ("en", "3 1/s, but 31/s", "3 per second, but 31/s"),
    ],
)
def test_units_after_numbers_are_spoken_in_full(
    catalogue: Catalogue, language: str, text: str, spoken: str
) -> None:
    assert catalogue.theme("calm", language).spoken(text) == spoken


# --- looks


@pytest.mark.parametrize(
    ("name", "ratio"), [("calm", 4.5), ("high-contrast", 7.0), ("playful", 4.5)]
)
def test_every_text_colour_has_enough_contrast(
    catalogue: Catalogue, name: str, ratio: float
) -> None:
    theme = catalogue.theme(name)
    contrasts = theme.colors.contrasts()
    assert theme.minimum_contrast == ratio
    assert len(contrasts) == 6 * 2
    assert min(contrasts.values()) >= ratio


def test_all_faces_have_the_same_size(theme: Theme) -> None:
    lines = [face.split("\n") for face in theme.faces.values()]
    assert {len(face) for face in lines} == {4}
    assert {cell_len(line) for face in lines for line in face} == {11}

    assert len(set(theme.faces.values())) == len(FACES)
    mouths = [face[theme.mouth_line] for face in lines]
    assert mouths.count(theme.faces["speaking"].split("\n")[theme.mouth_line]) == 1
    assert len({(face[0], face[-1]) for face in lines}) == 1, "they differ in eyes or mouth"


# --- manner, tones


def test_a_theme_inherits_manners_and_tones_that_it_does_not_set(catalogue: Catalogue) -> None:
    calm, playful = catalogue.theme("calm"), catalogue.theme("playful")
    assert calm.manner("positive") == MANNERS["positive"] == Manner("happy", "nod", tone="success")
    assert playful.manner("positive") == Manner("happy", "cheer", tone="success")
    assert calm.manner("there is no such kind") == Manner()
    assert calm.notes("go") == (Note(880, 120),)
    assert playful.notes("go") == (Note(784, 80), Note(1047, 120))
    assert calm.notes("there is no such tone") == ()
