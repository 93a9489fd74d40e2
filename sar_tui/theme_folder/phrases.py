"""Reads ``phrases.<language>.toml``: the agent's wordings."""

from pathlib import Path
from typing import Any

import msgspec

from sar_tui.loop.phrase_keys import (
    PHRASE_KEYS,
    SPOKEN_BY,
    VOCABULARY,
    holds_number,
    wording_problems,
)
from sar_tui.model.theme import ENGLISH, Theme
from sar_tui.model.visible_text import control_problem
from sar_tui.theme_folder.appearance import read_toml

_TABLES = {"vocabulary": VOCABULARY, "units": ()}
"""Tables in a file of phrases, with the entries that each must have."""
MOST_FORMS = 2
"""Largest number of forms of a unit: singular | plural."""


class Phrases(msgspec.Struct, frozen=True):
    """The parts of a `Theme` in its phrases, and their problems by part.

    ``english`` names the situations whose wordings are English because ``language`` has none.
    """

    language: str
    phrases: dict[str, tuple[str, ...]]
    vocabulary: dict[str, str]
    units: dict[str, str]
    problems: dict[str, list[str]]
    english: tuple[str, ...]


def read_phrases(folder: Path, language: str, base: Theme | None) -> Phrases:
    """Read a folder's phrases in a language, else in English, else the base's. Raises
    ThemeError.
    """
    problems: dict[str, list[str]] = {"wordings": [], "vocabulary": []}
    sources = _sources(folder, language, problems["wordings"])
    spoken = sources[0][0]
    phrases, english = _phrases(sources, base, problems["wordings"])
    tables = {table: _table(table, sources, base, problems["vocabulary"]) for table in _TABLES}
    return Phrases(spoken, phrases, tables["vocabulary"], tables["units"], problems, english)


def _sources(folder: Path, language: str, problems: list[str]) -> list[tuple[str, dict[str, Any]]]:
    """Return the contents of the files to use, best first, each with its language."""
    wanted = [ENGLISH] if language == ENGLISH else [language, language.partition("-")[0]]
    own = next((code for code in wanted if (folder / f"phrases.{code}.toml").is_file()), ENGLISH)
    if own == ENGLISH != wanted[-1]:
        problems.append(f"There is no phrases.{language}.toml; the agent speaks English.")
    found = [(language if own in wanted else ENGLISH, read_toml(folder / f"phrases.{own}.toml"))]
    if own == ENGLISH:
        return found
    if (folder / f"phrases.{ENGLISH}.toml").is_file():
        return [*found, (ENGLISH, read_toml(folder / f"phrases.{ENGLISH}.toml"))]
    problems.append(f"There is no phrases.{ENGLISH}.toml, which every theme has.")
    return found


def _phrases(
    sources: list[tuple[str, dict[str, Any]]], base: Theme | None, problems: list[str]
) -> tuple[dict[str, tuple[str, ...]], tuple[str, ...]]:
    spoken, own = sources[0]
    problems += [
        f"{name} is not a situation ({spoken})."
        for name in own
        if name not in PHRASE_KEYS and name not in _TABLES
    ]
    found, english = {}, []
    for situation in PHRASE_KEYS:
        for language, source in sources:
            wordings = _wordings(situation, source.get(situation, ()), language, problems)
            if not wordings and (general := SPOKEN_BY.get(situation)):
                wordings = _wordings(general, source.get(general, ()), language, [])
            if not wordings:
                continue
            if language != spoken:
                problems.append(f"There is no wording for {situation} ({spoken}); English is used.")
                english.append(situation)
            found[situation] = wordings
            break
        else:
            problems.append(f"There is no wording for {situation} ({spoken}).")
            found[situation] = base.phrases[situation] if base else ()
    return found, tuple(english)


def _wordings(situation: str, given: object, language: str, problems: list[str]) -> tuple[str, ...]:
    """Return the wordings that can be used."""
    try:
        wordings = msgspec.convert(given, tuple[str, ...])
    except msgspec.ValidationError:
        problems.append(f"The wordings for {situation} ({language}) must be a list of texts.")
        return ()
    good = []
    for wording in wordings:
        wrong = wording_problems(situation, wording, language)
        problems += wrong
        if not wrong:
            good.append(wording)
    return tuple(good)


def _table(
    table: str, sources: list[tuple[str, dict[str, Any]]], base: Theme | None, problems: list[str]
) -> dict[str, str]:
    """Return a table of words: of the language, else English, else the base's."""
    found: dict[str, str] = {}
    spoken = sources[0][0]
    for language, source in reversed(sources):
        entries = source.get(table, {})
        if not isinstance(entries, dict):
            problems.append(f"{table} ({language}) must be a table.")
            continue
        good = {
            name: word for name, word in entries.items() if isinstance(word, str) and word.strip()
        }
        problems += [
            f"{name} in {table} ({language}) must be a text."
            for name in entries
            if name not in good
        ]
        wrong = (
            _units_problems(good, language)
            if table == "units"
            else _vocabulary_problems(good, language)
        )
        problems += wrong.values()
        if language == spoken:
            problems += [
                f"The {table} lacks {name} ({language})."
                for name in _TABLES[table]
                if name not in entries
            ]
        found.update({name: word for name, word in good.items() if name not in wrong})
    return {**(getattr(base, table) if base else {}), **found}


def _vocabulary_problems(words: dict[str, str], language: str) -> dict[str, str]:
    """Return why words of the vocabulary cannot be used, by name."""
    wrong = {}
    for name, word in words.items():
        if name not in VOCABULARY:
            wrong[name] = f"{name} is not a word of the vocabulary ({language})."
        elif problem := control_problem(f"{name} in vocabulary ({language})", word):
            wrong[name] = problem
        elif holds_number(word, language):
            wrong[name] = f"{name} in vocabulary ({language}) holds a number."
    return wrong


def _units_problems(words: dict[str, str], language: str) -> dict[str, str]:
    """Return why spoken units cannot be used, by name."""
    wrong = {}
    for name, word in words.items():
        forms = word.split("|")
        if not name.strip():
            wrong[name] = f"A unit in units ({language}) has an empty name."
        elif problem := control_problem(f"{name} in units ({language})", f"{name}{word}"):
            wrong[name] = problem
        elif len(forms) > MOST_FORMS or not all(form.strip() for form in forms):
            wrong[name] = (
                f"{name} in units ({language}) must be one text, or two: singular | plural."
            )
    return wrong
