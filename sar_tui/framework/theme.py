"""The Social-Behavioral Base: how the agent looks, moves and speaks, as data in a folder."""

import re
from typing import Annotated

import msgspec
from msgspec import Meta

from sar_tui.framework.contrast import contrast, is_color
from sar_tui.framework.gesture import Gesture

FACES = ("neutral", "listening", "happy", "encouraging", "thinking", "speaking", "sleeping")
"""The expressions every theme draws."""
GROUNDS = ("background", "surface")
"""The colours that text stands on."""
GAZES = ("ahead", "left", "right", "up", "down")
TONES = ("go", "success", "end")
"""Short tones: a prompt is up, praise, an attempt is over."""
ENGLISH = "en"
"""The language every theme has, and every phrase falls back to."""


class ThemeError(ValueError):
    """A theme cannot be used; one clear sentence."""


class Colors(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The colours of the screen, as #rrggbb."""

    background: str
    surface: str
    text: str
    muted: str
    accent: str
    positive: str
    neutral: str
    negative: str

    def contrasts(self) -> dict[tuple[str, str], float]:
        """The WCAG ratio of each colour of text with each ground, by their names; those that are none are left out."""
        colors = {name: value for name, value in msgspec.structs.asdict(self).items() if is_color(value)}
        return {
            (name, ground): contrast(colors[name], colors[ground])
            for name in colors
            for ground in GROUNDS
            if name not in GROUNDS and ground in colors
        }


class Voice(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How the agent speaks: words a minute, loudness from 0 to 1.

    By language: ``rates`` where that differs, ``names`` of the speech engine's voices.
    """

    rate: Annotated[int, Meta(ge=80, le=400)] = 165
    volume: Annotated[float, Meta(ge=0, le=1)] = 1.0
    rates: dict[str, Annotated[int, Meta(ge=80, le=400)]] = {}
    names: dict[str, str] = {}

    def rate_in(self, language: str) -> int:
        """Words a minute in a language."""
        return self.rates.get(language, self.rate)


class Manner(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What goes with words: an expression, a gesture, a look, a tone; empty where there is none."""

    face: str = "speaking"
    gesture: str = ""
    gaze: str = "ahead"
    tone: str = ""


MANNERS: dict[str, Manner] = {
    "greeting": Manner("happy", "wave"),
    "instruction": Manner("speaking", "", "up"),
    "encouragement": Manner("encouraging", "lean_in"),
    "rest": Manner("sleeping", "rest"),
    "filler": Manner("thinking", "", "up"),
    "remark": Manner(),
    "goodbye": Manner("happy", "wave"),
    "goodbye_early": Manner("encouraging"),
    "positive_slight": Manner("happy", "nod", tone="success"),
    "positive": Manner("happy", "nod", tone="success"),
    "positive_strong": Manner("happy", "cheer", tone="success"),
    "neutral": Manner("neutral", "nod"),
    "negative_slight": Manner("encouraging"),
    "negative": Manner("encouraging", "lean_in"),
    "negative_strong": Manner("encouraging", "lean_in"),
}
"""What a theme may set by kind and degree, with what goes for those it does not set."""


class Note(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A part of a tone: its frequency (Hz, 0 is silence) and duration (ms)."""

    hz: Annotated[float, Meta(ge=0, le=8000)]
    ms: Annotated[int, Meta(ge=10, le=1000)]


_TONES = {
    "go": (Note(880, 120),),
    "success": (Note(660, 110), Note(880, 170)),
    "end": (Note(520, 160),),
}


class Theme(msgspec.Struct, frozen=True):
    """A persona in one language: its colours, faces, voice, manner and gestures, its wordings for each situation.

    ``minimum_contrast`` is the WCAG ratio that all text keeps against the background and the surface. ``languages``
    are those the theme's folder has phrases in; a phrase that ``language`` lacks is English. ``mouth_line`` is the
    line of a face, from 0, that moves when it speaks. ``units`` says how a unit is spoken, in one form or
    two, ``second | seconds``; ``images`` name files that
    may stand for faces; ``texts`` are the theme's own words for what the screens say in English. ``repairs`` tells what
    was missing or wrong in its folder, a sentence each, where another theme's part stands instead.
    """

    name: str
    title: str
    summary: str
    dark: bool
    minimum_contrast: float
    colors: Colors
    faces: dict[str, str]
    phrases: dict[str, tuple[str, ...]]
    language: str = ENGLISH
    languages: tuple[str, ...] = (ENGLISH,)
    vocabulary: dict[str, str] = {}
    units: dict[str, str] = {}
    texts: dict[str, str] = {}
    mouth_line: int = 2
    voice: Voice = Voice()
    manners: dict[str, Manner] = {}
    gestures: dict[str, Gesture] = {}
    tones: dict[str, tuple[Note, ...]] = {}
    images: dict[str, str] = {}
    repairs: tuple[str, ...] = ()

    def manner(self, name: str) -> Manner:
        """What goes with words of a kind or degree."""
        return self.manners.get(name) or MANNERS.get(name) or Manner()

    def notes(self, tone: str) -> tuple[Note, ...]:
        """The notes of a tone; none for one that there is not."""
        return self.tones.get(tone) or _TONES.get(tone, ())

    def spoken(self, text: str) -> str:
        """A text as it is to be spoken: units after a number in full, in the singular after 1 alone."""
        if not self.units:
            return text
        units = "|".join(re.escape(unit) for unit in sorted(self.units, key=len, reverse=True))
        # a unit that begins with a figure, such as 1/s, stands apart from its number
        spelled = rf"(\d(?:[\d.,]*\d)?)(?:\s+|(?!\d))({units})(?!\w)"
        return re.sub(spelled, lambda found: f"{found[1]} {self._unit(found[2], found[1])}", text)

    def _unit(self, unit: str, number: str) -> str:
        """A unit in full, in the form that a number asks for."""
        singular, _, plural = map(str.strip, self.units[unit].partition("|"))
        return singular if number == "1" or not plural else plural
