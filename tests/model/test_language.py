"""Translated texts: complete, with the right slots, and in English where a translation is
missing.
"""

from pathlib import Path

import pytest

from sar_tui.checks.task_translations import texts_in
from sar_tui.loop.task import Task
from sar_tui.model import language as module
from sar_tui.model.language import (
    Language,
    Sentence,
    in_language,
    joined,
    language,
    read_words,
    slot_problem,
)
from sar_tui.model.step import BORG_WORDS
from sar_tui.model.trial_types import Metric
from sar_tui.rules.questions import QUESTIONS

ROOT = Path(module.__file__).parents[1]


def words(folder: Path, code: str, text: str) -> Path:
    """Write the translations of a language into a folder, and return the folder."""
    folder.mkdir(exist_ok=True)
    (folder / f"words.{code}.toml").write_text(text, encoding="utf-8")
    return folder


# --- the framework's translations


def test_every_text_of_the_framework_is_translated_and_no_translation_is_obsolete() -> None:
    code = (
        path.read_text("utf-8")
        for room in ("loop", "rules", "model")
        for path in (ROOT / room).rglob("*.py")
    )
    usual = Metric("x", unit="", better="lower")
    texts = {Task.trials, usual.improved, usual.worsened}.union(*map(texts_in, code))
    texts |= {text for step in QUESTIONS.values() for text in (step.text, *step.labels)}
    translations = read_words(ROOT / "loop" / "words.es.toml")
    assert set(translations) == texts | set(BORG_WORDS.values())
    assert {slot_problem(text, own) for text, own in translations.items()} == {""}


# --- missing translations


def test_only_untranslated_texts_are_in_english(tmp_path: Path) -> None:
    folder = words(tmp_path / "task", "es", '"Press {key}." = "Pulse {key}."')
    tr = language("es", folder)
    assert tr("Press {key}.", key="f") == "Pulse f."
    assert tr("Well done, {name}.", name="P1") == "Well done, P1."
    assert language("de", folder)("Press {key}.", key="f") == "Press f.", "it has no file"


@pytest.mark.parametrize(
    ("english", "own", "problem"),
    [
        ("Less than {goal}.", "Menos de {gaol}.", "lacks {goal}"),
        ("Less than {goal}.", "Menos.", "lacks {goal}"),
        ("Less than {goal}.", "Menos de {goal}, {nombre}.", "has {nombre}, which the English"),
        *(
            ("Less than {goal}.", f"Menos de {slot}.", "lacks {goal}")
            for slot in ("{goal:d}", "{goal!r}", "{goal.real}", "{goal[0]}", "{}")
        ),
        ("Less than {goal}.", "Menos de {goal.", "has broken slots"),
        ("Less than {goal}.", "Menos de goal}.", "has broken slots"),
        ("Ready?", "¿Listo, {goal}?", "has {goal}, which the English does not have"),
    ],
)
def test_a_translation_with_other_slots_is_reported_and_not_used(
    english: str, own: str, problem: str
) -> None:
    assert slot_problem(english, own).startswith(problem)
    filled = {"goal": "5 s"} if "{goal}" in english else {}
    assert Language("es", {english: own})(english, **filled) == english.format(**filled)
    assert Language("es").including({english: own})(english, **filled) == english.format(**filled)


@pytest.mark.parametrize(
    ("english", "own", "said"),
    [
        ("{share:.0%} right", "aciertos: {share:.0%}", "aciertos: 50%"),
        ("{share!s} right", "aciertos: {share!s}", "aciertos: 0.5"),
        ("{{{share}}}", "({{{share}}})", "({0.5})"),
    ],
)
def test_slots_may_have_format_specifications_if_both_texts_agree(
    english: str, own: str, said: str
) -> None:
    assert slot_problem(english, own) == ""
    assert Language("es", {english: own})(english, share=0.5) == said
    assert Language("es", {"Press {": "Pulse la llave"})("Press {") == "Pulse la llave"
    assert Language("es")("Press {") == "Press {"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        *((text, "Ready?") for text in ("no = = toml", '"Ready?" = "\\ud800"', "= 1")),
        ('\ufeff"Ready?" = "¿Todo listo?"\n"Go on" = 5', "¿Todo listo?"),
    ],
)
def test_what_cannot_be_read_of_a_file_is_in_english(tmp_path: Path, text: str, said: str) -> None:
    tr = language("es", words(tmp_path / "task", "es", text))
    assert (tr("Ready?"), tr("Go on")) == (said, "Go on")


# --- precedence of translations


def test_texts_of_a_theme_precede_those_of_the_task_and_the_framework(tmp_path: Path) -> None:
    framework = words(tmp_path / "framework", "es", '"a" = "a1"\n"b" = "b1"\n"c" = "c1"')
    task = words(tmp_path / "task", "es", '"b" = "b2"\n"c" = "c2"')
    tr = language("es", framework, task).including({"c": "c3"})
    assert [tr(text) for text in "abc"] == ["a1", "b2", "c3"]


def test_regional_texts_precede_those_of_the_language(tmp_path: Path) -> None:
    folder = words(tmp_path / "task", "es", '"key" = "tecla"\n"computer" = "ordenador"')
    words(folder, "es-mx", '"computer" = "computadora"')
    tr = language("es-mx", folder)
    assert [tr(text) for text in ("key", "computer")] == ["tecla", "computadora"]
    assert language("es", folder)("computer") == "ordenador"


# --- numbers


@pytest.mark.parametrize(
    ("code", "figures"),
    [
        *((code, "0.85 s") for code in ("en", "en-gb", "es-mx")),
        *((code, "0,85 s") for code in ("es", "es-ar", "de")),
    ],
)
def test_numbers_are_formatted_for_the_language(code: str, figures: str) -> None:
    assert Language(code).figures("0.85 s") == figures
    assert Language(code)("It took {time}.", time="0.85 s") == f"It took {figures}."


@pytest.mark.parametrize(("code", "share"), [("en", "80%"), ("es-mx", "80 %"), ("de", "80 %")])
def test_a_percent_sign_has_the_space_of_the_language(code: str, share: str) -> None:
    assert Language(code)("At least {needed} right.", needed="80%") == f"At least {share} right."
    assert Language(code)("{share} done", share="80 %") == "80 % done"


def test_a_full_stop_is_not_a_decimal_point() -> None:
    tr = Language("es")
    assert tr("Press: {key}", key=".") == "Press: ."
    assert tr("{first} {next}", first="Marker 1.", next="Then 2.") == "Marker 1. Then 2."


@pytest.mark.parametrize(
    "name", ["/data/study-1.2/x.db", "/data/1.2/x", "C:\\1.2", "127.0.0.1:8000", "run 1.2.csv"]
)
def test_paths_and_addresses_have_no_decimal_numbers(name: str) -> None:
    assert Language("de").figures(f"{name} -0.5 s.") == f"{name} -0,5 s."


# --- sentences of errors


def test_a_sentence_is_english_and_can_be_said_in_another_language(tmp_path: Path) -> None:
    own = (
        '"{title} is one of {allowed}, not {shown}." = "{title}: {allowed}, nicht {shown}."\n'
        '"Hand" = "Hand"\n"left" = "links"\n"right" = "rechts"\n"empty" = "leer"'
    )
    tr = language("de", words(tmp_path, "de", own))
    sentence = Sentence(
        "{title} is one of {allowed}, not {shown}.",
        title=Sentence("Hand"),
        allowed=(Sentence("left"), Sentence("right")),
        shown=Sentence("empty"),
    )
    assert sentence == "Hand is one of left, right, not empty."
    assert in_language(sentence, tr) == "Hand: links, rechts, nicht leer."
    assert in_language(ValueError(sentence), tr) == "Hand: links, rechts, nicht leer."
    assert type(str(ValueError(sentence))) is str, "what is stored or sent is a plain text"


def test_what_was_typed_is_never_translated(tmp_path: Path) -> None:
    tr = language("de", words(tmp_path, "de", '"left" = "links"'))
    assert in_language(Sentence("Not {shown}.", shown="left"), tr) == "Not left."


def test_several_sentences_are_said_as_one(tmp_path: Path) -> None:
    tr = language("de", words(tmp_path, "de", '"It is {n}." = "Es ist {n}."'))
    both = joined([Sentence("It is {n}.", n=1), "A text of a {stranger}."])
    assert both == "It is 1. A text of a {stranger}."
    assert in_language(both, tr) == "Es ist 1. A text of a {stranger}."


def test_an_error_without_a_sentence_stays_as_it_is() -> None:
    assert in_language(ValueError(), Language("de")) == ""
    assert in_language(OSError(13, "no"), Language("de")) == "[Errno 13] no"
