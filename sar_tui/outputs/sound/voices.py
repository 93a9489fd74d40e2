"""Which of the speech engine's voices speaks a language; and what the engines tell of their voices, put in order."""

import re
from collections.abc import Iterable, Sequence

from sar_tui.outputs.sound.protocol import FoundVoice

_TAG = re.compile(r"[a-z]{2,3}(-[a-z0-9]{1,8})*")
_REGIONS = {"en": ("us", "gb")}
"""The regions to prefer, where a language has voices of many."""


def found_voice(identifier: object, name: object, languages: object) -> FoundVoice:
    """A voice as pyttsx3 tells of it: languages may be missing, None, bytes with a leading count, or ``en_US``."""
    told = languages if isinstance(languages, list | tuple) else (languages,)
    tags = [tag for each in told if (tag := _tag(each))]
    if not tags and (tag := _tag(_text(identifier).rpartition("/")[2])):
        tags = [tag]
    return FoundVoice(_text(identifier), _text(name).strip(), tuple(tags))


def choose(voices: Sequence[FoundVoice], language: str, name: str, default: str) -> FoundVoice | None:
    """The voice to speak with; None where no voice speaks the language.

    First the one that is named, by its id or a part of its name. Else, of those that speak the language: the engine's
    own ``default``, by id; then one of no special region; then one of the region that most would expect.
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
    return min(fit, key=lambda voice: (voice.id != default, _rank(voice.languages, language)), default=None)


def _rank(languages: Iterable[str], language: str) -> int:
    regions = _REGIONS.get(language, (language,))
    order = [language, *(f"{language}-{region}" for region in regions)]
    return min((order.index(each) for each in languages if each in order), default=len(order))


def _text(value: object) -> str:
    return value.decode(errors="ignore") if isinstance(value, bytes) else "" if value is None else str(value)


def _tag(value: object) -> str:
    """A language in lower case with hyphens; empty where it is none."""
    tag = "".join(each for each in _text(value) if each.isprintable()).strip().lower().replace("_", "-")
    return tag if _TAG.fullmatch(tag) else ""
