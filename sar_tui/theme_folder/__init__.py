"""Reads a theme's folder: ``theme.toml``, ``phrases.<language>.toml``, and ``words.<language>.toml`` if there is one.

What is missing or wrong in it is taken from another theme, and told in ``Theme.repairs``: a participant hears a coach
even while its words are being edited.
"""

from pathlib import Path

import msgspec

from sar_tui.framework.theme import ENGLISH, Theme, ThemeError
from sar_tui.theme_folder.appearance import read_look
from sar_tui.theme_folder.phrases import read_words
from sar_tui.theme_folder.screens import screen_texts

Told = dict[str, list[str]]


class Reading(msgspec.Struct, frozen=True):
    """A theme as read, and what was missing or wrong in its folder.

    ``told`` holds a sentence each, by part: ``settings``, ``colors``, ``faces``, ``gestures``, ``manner``,
    ``wordings``, ``vocabulary``, ``texts``. ``english`` names the situations whose wordings are English for want
    of any in the language.
    """

    theme: Theme
    told: Told
    english: tuple[str, ...]


def languages(folder: Path) -> tuple[str, ...]:
    """The languages that a theme's folder has phrases in, English first."""
    found = sorted(path.name.split(".")[1] for path in folder.glob("phrases.*.toml"))
    return tuple(sorted(found, key=lambda language: language != ENGLISH))


def files(folder: Path) -> tuple[Path, ...]:
    """The files that a theme is made of."""
    return tuple(sorted(path for path in folder.glob("*.toml")))


def read_theme(folder: Path, language: str = ENGLISH, base: Theme | None = None) -> Theme:
    """A theme in a language.

    Args:
        folder: its folder; its name is the theme's.
        language: which; phrases that it lacks are English. For ``es-mx`` those of ``es`` will do.
        base: what is missing or wrong is taken from there; without it, it stays missing.

    Raises:
        ThemeError: a file is missing, or is no TOML.
    """
    reading = read(folder, language, base)
    repairs = [sentence for part in reading.told.values() for sentence in part]
    return msgspec.structs.replace(reading.theme, repairs=tuple(repairs))


def read(folder: Path, language: str = ENGLISH, base: Theme | None = None) -> Reading:
    """The same, with what is wrong by part. Raises ThemeError, and nothing else, whatever is in the folder."""
    try:
        return _read(folder, language, base)
    except ThemeError:
        raise
    except (OSError, ValueError, ArithmeticError, RuntimeError) as error:
        raise ThemeError(f"{type(error).__name__}: {error}.") from error


def may_have_images(folder: Path) -> bool:
    """Whether a theme may have images for faces. It costs far less than to read the theme."""
    try:
        return b"images" in (folder / "theme.toml").read_bytes()
    except OSError:
        return False


def _read(folder: Path, language: str, base: Theme | None) -> Reading:
    look = read_look(folder, base)
    words = read_words(folder, language, base)
    texts, told = screen_texts(folder, language)
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
    return Reading(theme, {**look.told, **words.told, "texts": told}, words.english)
