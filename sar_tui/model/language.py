"""Translates texts: the English is in the code, the translations in ``words.<language>.toml``."""

import functools
import re
import string
from collections.abc import Iterable, Mapping
from pathlib import Path

import msgspec

BUNDLED = {"en": "English", "de": "German", "es": "Spanish"}
"""The languages that are included, by code. ``python -m tests.translations`` finds what one lacks."""
OWN_NAMES = {"en": "English", "de": "Deutsch", "es": "Español"}
"""The bundled languages in their own words, by code."""
_DECIMAL_POINT = frozenset(
    "en zh ja ko he th es-mx es-us es-pr es-do es-gt es-hn es-ni es-pa es-sv".split()
)
"""Languages with a decimal point, not a comma."""
_SPACED_PERCENT = frozenset("cs da de es fi fr nb ru sk sv".split())
"""Languages with a space before the percent sign."""
_DECIMAL = re.compile(r"(?<![^\W\d]-)(?<!\d\.)(?<![/\\])\b(\d+)\.(\d+)(?![/\\]|\.\w)")
"""A decimal number, but no part of a path, an address or a version."""


class Language:
    """Translates texts. A text without a translation stays English.

    A translation whose slots differ from those of its English is ignored.

    Args:
        code: ``en``, ``es``, ``es-mx``.
        texts: translations by their English text. Both have slots like ``{goal}``.
    """

    def __init__(self, code: str = "en", texts: Mapping[str, str] | None = None) -> None:
        self.code = code
        self._has_decimal_point = not _DECIMAL_POINT.isdisjoint((code, code.partition("-")[0]))
        self._spaces_percent = code.partition("-")[0] in _SPACED_PERCENT
        self.texts = {
            english: own for english, own in (texts or {}).items() if not slot_problem(english, own)
        }

    def __call__(self, text: str, /, **slots: object) -> str:
        """Return a text in this language, with its slots filled; without ``slots``, braces are
        kept.

        Numbers in the values of slots get the decimal sign of this language, and its space before
        the percent sign.
        """
        translated = self.texts.get(text, text)
        if not slots:
            return translated
        slots = {
            name: self._filling(value) if isinstance(value, str) else value
            for name, value in slots.items()
        }
        return translated.format(**slots)

    def _filling(self, value: str) -> str:
        if self._spaces_percent:
            value = re.sub(r"(\d)%", r"\1 %", value)
        return self.figures(value)

    def figures(self, text: str) -> str:
        """Return a text with this language's decimal sign in its numbers: 0,5 for 0.5 in Spanish.
        Paths, addresses and versions stay as they are.
        """
        if self._has_decimal_point:
            return text
        return _DECIMAL.sub(r"\1,\2", text)

    def including(self, texts: Mapping[str, str]) -> "Language":
        """Return this language with more translations, which take precedence."""
        return Language(self.code, {**self.texts, **texts})


ENGLISH = Language()
"""The language that all texts are written in."""


class Sentence(str):
    """A text in English that can be said in another language later, such as that of an error.

    It is a ``str``, but for msgspec: there, pass ``str(sentence)``.

    Args:
        english: with slots like ``{goal}``.
        slots: their values, which may be sentences themselves, or a tuple of them.
    """

    english: str
    slots: dict[str, object]

    def __new__(cls, english: str, /, **slots: object) -> "Sentence":
        made = super().__new__(cls, _said(english, slots, ENGLISH))
        made.english, made.slots = english, slots
        return made


def in_language(text: object, tr: Language) -> str:
    """Return a sentence in a language, or that of an error; other texts as they are translated."""
    if isinstance(text, Exception):
        text = error_text(text)
    if isinstance(text, Sentence):
        return _said(text.english, text.slots, tr)
    return tr(str(text))


def error_text(error: Exception) -> str:
    """Return the text of an error: as a sentence, if it was raised with one."""
    first = error.args[0] if error.args else None
    return first if isinstance(first, Sentence) else str(error)


def joined(sentences: Iterable[str]) -> Sentence:
    """Return several sentences as one."""
    parts = {f"part{number}": each for number, each in enumerate(sentences)}
    return Sentence(" ".join(f"{{{name}}}" for name in parts), **parts)


def _said(english: str, slots: Mapping[str, object], tr: Language) -> str:
    return tr(english, **{name: _value(value, tr) for name, value in slots.items()})


def _value(value: object, tr: Language) -> object:
    if isinstance(value, tuple):
        return ", ".join(str(_value(each, tr)) for each in value)
    return in_language(value, tr) if isinstance(value, Sentence) else value


def language(code: str, *folders: Path) -> Language:
    """Return a language with the translations in some folders; later folders take precedence."""
    texts: dict[str, str] = {}
    for folder in folders:
        for path in words_files(folder, code):
            texts.update(read_words(path))
    return Language(code, texts)


def words_files(folder: Path, code: str) -> tuple[Path, ...]:
    """Return the files of translations of a language in a folder: for ``es-mx`` that of ``es``
    first, then its own.
    """
    return tuple(
        folder / f"words.{name}.toml" for name in dict.fromkeys((code.partition("-")[0], code))
    )


@functools.cache
def read_words(path: Path) -> dict[str, str]:
    """Return the translations in a file; none if it is missing or unreadable."""
    try:
        found = msgspec.toml.decode(path.read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError):
        return {}
    return {english: own for english, own in found.items() if isinstance(own, str)}


def slots(text: str) -> frozenset[str]:
    """Return the slots of a text as written: ``{goal}``, ``{share:.0%}``. Raises ValueError for a
    single brace.
    """
    found = set()
    for _, name, form, conversion in string.Formatter().parse(text):
        if name is not None:
            converted = f"!{conversion}" if conversion else ""
            formatted = f":{form}" if form else ""
            found.add(f"{{{name}{converted}{formatted}}}")
    return frozenset(found)


@functools.cache
def slot_problem(english: str, own: str) -> str:
    """Return how the slots of a translation differ from those of its English, as a phrase; empty if
    they agree.
    """
    try:
        wanted = slots(english)
    except ValueError:  # a text with a brace of its own, which is never filled
        wanted = frozenset()
    try:
        given = slots(own)
    except ValueError as error:
        return f"has broken slots ({error})"
    if missing := sorted(wanted - given):
        return f"lacks {', '.join(missing)}"
    if more := sorted(given - wanted):
        return f"has {', '.join(more)}, which the English does not have"
    return ""
