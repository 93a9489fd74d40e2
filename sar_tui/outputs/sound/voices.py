"""Choice among the speech engine's voices, and clean descriptions of them."""

import re
from collections.abc import Iterable, Sequence

from sar_tui.outputs.sound.protocol import FoundVoice

_TAG = re.compile(r"[a-z]{2,3}(-[a-z0-9]{1,8})*")
_REGIONS = {"en": ("us", "gb")}
"""Preferred regions of languages that have voices of many."""


def found_voice(identifier: object, name: object, languages: object) -> FoundVoice:
    """Clean up pyttsx3's description: languages may be missing, None, bytes with a leading count,
    or ``en_US``.
    """
    given = languages if isinstance(languages, list | tuple) else (languages,)
    tags = [tag for each in given if (tag := _tag(each))]
    if not tags and (tag := _tag(_text(identifier).rpartition("/")[2])):
        tags = [tag]
    return FoundVoice(_text(identifier), _text(name).strip(), tuple(tags))


def choose(
    voices: Sequence[FoundVoice], language: str, name: str, default: str
) -> FoundVoice | None:
    """Choose a voice; None if no voice speaks the language.

    A voice named by its id or a part of its name comes first. Otherwise, of those that speak the
    language: the engine's ``default``, by id; then one without a region; then one of the most
    expected region.
    """
    if name:
        wanted = name.casefold()
        exact = [voice for voice in voices if voice.id.casefold() == wanted]
        partly = [voice for voice in voices if wanted in voice.name.casefold()]
        if named := exact or partly:
            return named[0]
    fit = [voice for voice in voices if voice.speaks(language)]
    if not fit and "-" in language:
        return choose(voices, language.rpartition("-")[0], "", default)
    return min(
        fit, key=lambda voice: (voice.id != default, _rank(voice.languages, language)), default=None
    )


def _rank(languages: Iterable[str], language: str) -> int:
    regions = _REGIONS.get(language, (language,))
    order = [language, *(f"{language}-{region}" for region in regions)]
    return min((order.index(each) for each in languages if each in order), default=len(order))


def _text(value: object) -> str:
    return (
        value.decode(errors="ignore")
        if isinstance(value, bytes)
        else ""
        if value is None
        else str(value)
    )


def _tag(value: object) -> str:
    """Return a language in lower case with hyphens; empty if it is none."""
    tag = (
        "".join(each for each in _text(value) if each.isprintable())
        .strip()
        .lower()
        .replace("_", "-")
    )
    return tag if _TAG.fullmatch(tag) else ""
