"""The Social-Behavioral Base: the agent's look, movements and speech, as data."""

import re
from typing import Annotated

import msgspec
from msgspec import Meta

from sar_tui.model.contrast import contrast, is_color
from sar_tui.model.gesture import Gesture

FACES = ("neutral", "listening", "happy", "encouraging", "thinking", "speaking", "sleeping")
"""Expressions of every theme."""
GROUNDS = ("background", "surface")
"""Background colours of text."""
GAZES = ("ahead", "left", "right", "up", "down")
TONES = ("go", "success", "end")
"""Short tones: at a prompt, with praise, at the end of an attempt."""
ENGLISH = "en"
"""The language of every theme, used for phrases that another lacks."""


class ThemeError(ValueError):
    """A theme cannot be used; the message is one clear sentence."""


class Colors(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Colours of the screen, as #rrggbb."""

    background: str
    surface: str
    text: str
    muted: str
    accent: str
    positive: str
    neutral: str
    negative: str

    def contrasts(self) -> dict[tuple[str, str], float]:
        """Return the WCAG ratio of each valid text colour on each background, by their names."""
        colors = {
            name: value for name, value in msgspec.structs.asdict(self).items() if is_color(value)
        }
        return {
            (name, ground): contrast(colors[name], colors[ground])
            for name in colors
            for ground in GROUNDS
            if name not in GROUNDS and ground in colors
        }


class Voice(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The agent's voice: words per minute, loudness from 0 to 1.

    ``rates`` and ``names`` (of the speech engine's voices) are by language.
    """

    rate: Annotated[int, Meta(ge=80, le=400)] = 165
    volume: Annotated[float, Meta(ge=0, le=1)] = 1.0
    rates: dict[str, Annotated[int, Meta(ge=80, le=400)]] = {}
    names: dict[str, str] = {}

    def rate_in(self, language: str) -> int:
        """Return the words per minute in a language."""
        return self.rates.get(language, self.rate)


class Manner(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The expression, gesture, gaze and tone that go with a text; empty for none."""

    face: str = "speaking"
    gesture: str = ""
    gaze: str = "ahead"
    tone: str = ""


MANNERS: dict[str, Manner] = {
    "greeting": Manner("happy", "wave"),
    "instruction": Manner("speaking", "", "up"),
    "encouragement": Manner("encouraging", "lean_in"),
    "rest": Manner("sleeping", "rest"),
    "rested": Manner("happy"),
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
"""Default manners by kind and degree; a theme may set its own."""


class Note(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A part of a tone: frequency (Hz, 0 is silence) and duration (ms)."""

    hz: Annotated[float, Meta(ge=0, le=8000)]
    ms: Annotated[int, Meta(ge=10, le=1000)]


_TONES = {
    "go": (Note(880, 120),),
    "success": (Note(660, 110), Note(880, 170)),
    "end": (Note(520, 160),),
}


class Theme(msgspec.Struct, frozen=True):
    """A persona in one language: colours, faces, voice, manners, gestures, and wordings for each
    situation.

    Attributes:
        minimum_contrast: the least WCAG ratio of text on the background and the surface.
        languages: those that the theme's folder has phrases in. A phrase that ``language`` lacks is
            English.
        mouth_line: the line of a face, from 0, that moves when it speaks.
        units: spoken forms of units, one or two: ``second | seconds``.
        images: files shown instead of faces.
        texts: the theme's own wordings of texts on the screens, by their English.
        repairs: one sentence for each part that was missing or wrong in the folder and replaced
            from another theme.
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
        """Return the manner of a kind or degree."""
        return self.manners.get(name) or MANNERS.get(name) or Manner()

    def notes(self, tone: str) -> tuple[Note, ...]:
        """Return the notes of a tone; none for an unknown one."""
        return self.tones.get(tone) or _TONES.get(tone, ())

    def spoken(self, text: str) -> str:
        """Return a text as spoken: units after a number in full, in the singular after 1."""
        if not self.units:
            return text
        units = "|".join(re.escape(unit) for unit in sorted(self.units, key=len, reverse=True))
        # a unit that begins with a digit, such as 1/s, is separated from its number by a space
        spelled = rf"(\d(?:[\d.,]*\d)?)(?:\s+|(?!\d))({units})(?!\w)"
        return re.sub(spelled, lambda found: f"{found[1]} {self._unit(found[2], found[1])}", text)

    def _unit(self, unit: str, number: str) -> str:
        """Return a unit in full, in the form for a number."""
        singular, _, plural = map(str.strip, self.units[unit].partition("|"))
        return singular if number == "1" or not plural else plural
