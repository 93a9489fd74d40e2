"""What people read, in their language: English stands in the code, its translations in ``words.<language>.toml``."""

import functools
import re
import string
from collections.abc import Mapping
from pathlib import Path

import msgspec

_DECIMAL_POINT = frozenset("en zh ja ko he th es-mx es-us es-pr es-do es-gt es-hn es-ni es-pa es-sv".split())
"""Languages that write 0.5, not 0,5."""


class Language:
    """Translates, text by text; what it has no translation for stays English.

    So does what has a translation whose slots are not those of its English: nobody should read "{gaol}".

    Args:
        code: ``en``, ``es``, ``es-mx``.
        texts: translations by their English text. Slots like ``{goal}`` stand in both.
    """

    def __init__(self, code: str = "en", texts: Mapping[str, str] | None = None) -> None:
        self.code = code
        self.texts = {english: own for english, own in (texts or {}).items() if not slot_problem(english, own)}

    def __call__(self, text: str, **slots: object) -> str:
        """A text in this language, its slots filled; without any it is left as it stands.

        Words that fill a slot have their figures written as this language writes them.
        """
        own = self.texts.get(text, text)
        if not slots:
            return own
        return own.format(**{name: self.figures(it) if isinstance(it, str) else it for name, it in slots.items()})

    def figures(self, text: str) -> str:
        """A text with its figures written as this language writes them: 0,5 where English has 0.5."""
        if not _DECIMAL_POINT.isdisjoint((self.code, self.code.partition("-")[0])):
            return text
        return re.sub(r"(\d)\.(\d)", r"\1,\2", text)

    def including(self, texts: Mapping[str, str]) -> "Language":
        """This language with more translations, which go before its own."""
        return Language(self.code, {**self.texts, **texts})


def language(code: str, *folders: Path) -> Language:
    """A language, with the translations that folders have for it; a later one goes before an earlier one."""
    texts: dict[str, str] = {}
    for folder in folders:
        for path in words_files(folder, code):
            texts.update(read_words(path))
    return Language(code, texts)


def words_files(folder: Path, code: str) -> tuple[Path, ...]:
    """Where a folder has the translations of a language: for ``es-mx`` those of ``es``, and then its own."""
    return tuple(folder / f"words.{name}.toml" for name in dict.fromkeys((code.partition("-")[0], code)))


@functools.cache
def read_words(path: Path) -> dict[str, str]:
    """The translations of a file; none where it is missing or cannot be read."""
    try:
        found = msgspec.toml.decode(path.read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError):
        return {}
    return {english: own for english, own in found.items() if isinstance(own, str)}


def slots(text: str) -> frozenset[str]:
    """The slots of a text, as they stand in it: ``{goal}``, ``{share:.0%}``. Raises ValueError: a lone brace."""
    found = set()
    for _, name, form, conversion in string.Formatter().parse(text):
        if name is not None:
            found.add(f"{{{name}{'!' if conversion else ''}{conversion or ''}{':' if form else ''}{form}}}")
    return frozenset(found)


@functools.cache
def slot_problem(english: str, own: str) -> str:
    """Why a translation cannot be used, in a few words: it has other slots than its English. Empty where it can."""
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
        return f"has {', '.join(more)}, which the English has not"
    return ""
