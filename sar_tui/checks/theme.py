"""Checks a theme's folder."""

from collections.abc import Callable, Collection, Iterator
from pathlib import Path

import msgspec

from sar_tui.checks.check import Check
from sar_tui.model.contrast import cut
from sar_tui.model.theme import ENGLISH, ThemeError
from sar_tui.theme_folder import Reading, languages, read, read_texts, screen_texts

_LOOKS = {
    "settings": "has a title, a summary, and dark = true or false",
    "faces": "has every expression, all of one size",
    "gestures": "has every gesture, each ending at rest",
    "manner": "has a valid voice, manner and tones",
}


class Contrast(msgspec.Struct, frozen=True):
    """Lowest contrast of a text colour, with the background that it has there."""

    color: str
    ground: str
    ratio: float


class Report(msgspec.Struct, frozen=True):
    """Results of checking a theme.

    ``english``: the situations in which English is spoken, by language. ``missing``: the texts of
    the screens that are shown in English, by language.
    """

    theme: str
    languages: tuple[str, ...]
    checks: tuple[Check, ...]
    contrasts: tuple[Contrast, ...] = ()
    english: dict[str, tuple[str, ...]] = {}
    missing: dict[str, tuple[str, ...]] = {}

    @property
    def passed(self) -> bool:
        return all(check.ok for check in self.checks)


def check(
    folder: Path, texts: Collection[str], translated: Callable[[str], Collection[str]] | None = None
) -> Report:
    """Check a theme's folder in each of its languages.

    Args:
        folder: of the theme.
        texts: the English texts of the screens and tasks, for which a theme may have its own
            wordings.
        translated: returns those that are in a language without the theme; None: all of them.
    """
    spoken = languages(folder) or (ENGLISH,)
    readings: dict[str, Reading] = {}
    errors: dict[str, None] = {}
    for language in spoken:
        try:
            readings[language] = read(folder, language)
        except ThemeError as error:
            errors[str(error)] = None
    can_be_read = Check("can be read", tuple(errors))
    if not readings:
        return Report(folder.name, spoken, (can_be_read,))
    some = next(iter(readings.values()))
    contrasts = _contrasts(some)
    return Report(
        folder.name,
        spoken,
        (can_be_read, *_look(some, contrasts), *_words(readings), *_screens(folder, texts)),
        contrasts,
        {language: reading.english for language, reading in readings.items() if reading.english},
        {} if translated is None else missing(folder, texts, translated),
    )


def missing(
    folder: Path, texts: Collection[str], translated: Callable[[str], Collection[str]]
) -> dict[str, tuple[str, ...]]:
    """Return the texts of the screens that a theme leaves in English, for each of its languages
    that leaves some.
    """
    found = {}
    for language in languages(folder):
        if language == ENGLISH:
            continue
        try:
            own, _ = screen_texts(folder, language)
        except ThemeError:  # reported by the check of that file
            own = {}
        if left := set(texts) - set(own) - set(translated(language)):
            found[language] = tuple(sorted(left))
    return found


def _contrasts(reading: Reading) -> tuple[Contrast, ...]:
    least: dict[str, Contrast] = {}
    for (color, ground), ratio in reading.theme.colors.contrasts().items():
        if color not in least or ratio < least[color].ratio:
            least[color] = Contrast(color, ground, cut(ratio))
    return tuple(least.values())


def _look(reading: Reading, contrasts: tuple[Contrast, ...]) -> Iterator[Check]:
    """Check ``theme.toml``, which is the same for all languages."""
    problems = reading.problems
    yield Check(_LOOKS["settings"], tuple(problems["settings"]))
    minimum = f"has a contrast of at least {reading.theme.minimum_contrast:g}"
    yield Check(
        minimum, tuple(problems["colors"]), ", ".join(f"{c.color} {c.ratio:.2f}" for c in contrasts)
    )
    for part in ("faces", "gestures", "manner"):
        yield Check(_LOOKS[part], tuple(problems[part]))


def _words(readings: dict[str, Reading]) -> Iterator[Check]:
    for language, reading in readings.items():
        own = [
            wordings
            for name, wordings in reading.theme.phrases.items()
            if name not in reading.english
        ]
        count = sum(map(len, own))
        yield Check(
            f"has every phrase in {language}",
            tuple(reading.problems["wordings"]),
            f"{count} wordings",
        )
        yield Check(f"has the vocabulary in {language}", tuple(reading.problems["vocabulary"]))


def _screens(folder: Path, texts: Collection[str]) -> Iterator[Check]:
    """Check the theme's own texts for the screens, if it has any."""
    for path in sorted(folder.glob("words.*.toml")):
        name = f"has valid texts for the screens in {path.name.split('.')[1]}"
        try:
            own, problems = read_texts(path)
        except ThemeError as error:
            yield Check(name, (str(error),))
            continue
        unknown = [
            f"No screen shows {english!r}, which {path.name} translates."
            for english in own.keys() - texts
        ]
        yield Check(name, (*problems, *sorted(unknown)), f"{len(own)} texts")
