"""Reads a theme's folder: ``theme.toml``, ``phrases.<language>.toml``, and
``words.<language>.toml`` if there is one.

Parts that are missing or wrong are taken from another theme and listed in ``Theme.repairs``, so
that a session runs even while a theme is being edited.
"""

from pathlib import Path

import msgspec

from sar_tui.model.language import slot_problem, words_files
from sar_tui.model.theme import ENGLISH, Theme, ThemeError
from sar_tui.model.visible_text import control_problem
from sar_tui.theme_folder.appearance import read_look, read_toml
from sar_tui.theme_folder.phrases import read_phrases

Problems = dict[str, list[str]]


class Reading(msgspec.Struct, frozen=True):
    """A theme as read, and what was missing or wrong in its folder.

    ``problems`` holds sentences by part: ``settings``, ``colors``, ``faces``, ``gestures``,
    ``manner``, ``wordings``, ``vocabulary``, ``texts``. ``english`` names the situations whose
    wordings are English because the language has none.
    """

    theme: Theme
    problems: Problems
    english: tuple[str, ...]


def languages(folder: Path) -> tuple[str, ...]:
    """Return the languages that a theme's folder has phrases in, English first."""
    found = sorted(path.name.split(".")[1] for path in folder.glob("phrases.*.toml"))
    return tuple(sorted(found, key=lambda language: language != ENGLISH))


def files(folder: Path) -> tuple[Path, ...]:
    """Return the files of a theme."""
    return tuple(sorted(path for path in folder.glob("*.toml")))


def read_theme(folder: Path, language: str = ENGLISH, base: Theme | None = None) -> Theme:
    """Read a theme in a language.

    Args:
        folder: the theme's folder, with its name.
        language: of the phrases; those that it lacks are English. ``es-mx`` uses those of ``es``,
            too.
        base: theme that replaces what is missing or wrong; without it, that stays missing.

    Raises:
        ThemeError: a file is missing or not TOML.
    """
    reading = read(folder, language, base)
    repairs = [sentence for part in reading.problems.values() for sentence in part]
    return msgspec.structs.replace(reading.theme, repairs=tuple(repairs))


def read(folder: Path, language: str = ENGLISH, base: Theme | None = None) -> Reading:
    """Read a theme with its problems by part. Raises ThemeError and nothing else, whatever is in
    the folder.
    """
    try:
        return _read(folder, language, base)
    except ThemeError:
        raise
    except (OSError, ValueError, ArithmeticError, RuntimeError) as error:
        raise ThemeError(f"{type(error).__name__}: {error}.") from error


def may_have_images(folder: Path) -> bool:
    """Return whether a theme may have images for faces, without reading the whole theme."""
    try:
        return b"images" in (folder / "theme.toml").read_bytes()
    except OSError:
        return False


def _read(folder: Path, language: str, base: Theme | None) -> Reading:
    look = read_look(folder, base)
    words = read_phrases(folder, language, base)
    texts, problems = screen_texts(folder, language)
    theme = Theme(
        name=folder.name,
        language=words.language,
        languages=languages(folder),
        phrases=words.phrases,
        vocabulary=words.vocabulary,
        units=words.units,
        texts=texts,
        **look.parts,
    )
    return Reading(theme, {**look.problems, **words.problems, "texts": problems}, words.english)


def screen_texts(folder: Path, language: str) -> tuple[dict[str, str], list[str]]:
    """Return the usable wordings for a language by their English, and the problems of the others.

    Raises:
        ThemeError: a file is not TOML.
    """
    texts: dict[str, str] = {}
    problems: list[str] = []
    for path in words_files(folder, language):
        if path.is_file():
            own, wrong = read_texts(path)
            texts.update(own)
            problems += wrong
    return texts, problems


def read_texts(path: Path) -> tuple[dict[str, str], list[str]]:
    """Return the usable wordings in one file, and the problems of the others. Raises ThemeError."""
    texts: dict[str, str] = {}
    problems = []
    for english, own in read_toml(path).items():
        if not isinstance(own, str):
            problems.append(f"The wording of {english!r} in {path.name} is not a text.")
        elif problem := slot_problem(english, own):
            problems.append(f"The wording of {english!r} in {path.name} {problem}.")
        elif problem := control_problem(f"The wording of {english!r} in {path.name}", own):
            problems.append(problem)
        else:
            texts[english] = own
    return texts, problems
