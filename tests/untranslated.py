"""Finds untranslated English in shown texts: texts that have a translation, but are shown in
English.
"""

import re
import string
from collections.abc import Iterable, Iterator, Mapping

from sar_tui.model.theme import Theme


def english_in(shown: Iterable[str], translations: Mapping[str, str]) -> list[tuple[str, str]]:
    """Return the English texts found in shown texts, each with its first occurrence."""
    lines = [" ".join(line.split()) for line in dict.fromkeys(shown)]
    found = []
    for text, own in translations.items():
        if not any(words.strip() for words, *_ in string.Formatter().parse(text)):
            continue  # it has no words of its own
        pattern, literals = _pattern(text), _literals(text)
        likely = (line for line in lines if all(words in line for words in literals))
        where = next((line for line in likely if pattern.search(line)), None)
        if text != own and where:
            found.append((text, where))
    return found


def phrases(english: Theme, own: Theme) -> dict[str, str]:
    """Return the English wordings of a theme as a translation table."""
    return {
        wording: ""
        for name in english.phrases
        for wording in english.phrases[name]
        if wording not in own.phrases[name]
    }


def _pattern(text: str) -> re.Pattern[str]:
    """Return a pattern that matches a text as whole words, with anything in its slots."""
    return re.compile(rf"(?<!\w){''.join(_parts(text))}(?!\w)")


def _parts(text: str) -> Iterator[str]:
    for words, slot, _, _ in string.Formatter().parse(text):
        yield re.escape(re.sub(r"\s+", " ", words))
        if slot is not None:
            yield r"\S.*?"


def _literals(text: str) -> list[str]:
    """Return what stands between the slots of a text."""
    return [re.sub(r"\s+", " ", words) for words, *_ in string.Formatter().parse(text)]
