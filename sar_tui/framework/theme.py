"""The Social-Behavioral Base: how the agent looks and what it says, as data in a folder."""

import re
import string
from typing import Literal

import msgspec

FACES = ("neutral", "listening", "happy", "encouraging", "thinking", "speaking", "sleeping")
"""The expressions every theme draws."""

_FIGURES = {"value", "goal", "difference", "correct", "trials"}
SITUATIONS: dict[str, set[str]] = {
    "greeting": set(),
    "goodbye": set(),
    "positive": set(),
    "neutral": set(),
    "negative": set(),
    "accuracy": set(),
    "empty": set(),
    **{f"{valence}_first": {"value", "goal"} for valence in ("positive", "neutral", "negative")},
    **{
        f"{valence}_{change}": {"value", "goal", "difference", "change"}
        for valence in ("positive", "neutral", "negative")
        for change in ("improved", "worsened")
    },
    **{f"{valence}_same": {"value", "goal"} for valence in ("positive", "neutral", "negative")},
    "performance_first": {"aim"},
    "performance_improved": {"change"},
    "performance_worsened": {"aim"},
    "performance_same": {"aim"},
    "accuracy_figures": {"correct", "trials"},
    "empty_figures": {"correct", "trials"},
}
"""What the agent can be asked to say, and the slots its words may use."""

PERFORMANCE = tuple(name for name in SITUATIONS if name.startswith("performance_"))
QUALITATIVE = ("positive", "neutral", "negative", "accuracy", "empty", *PERFORMANCE)
QUANTITATIVE = tuple(name for name, slots in SITUATIONS.items() if slots & _FIGURES)

NUMBER_WORDS = frozenset(
    [
        "zero",
        "one",
        "two",
        "three",
        "four",
        "five",
        "six",
        "seven",
        "eight",
        "nine",
        "ten",
        "eleven",
        "twelve",
        "thirteen",
        "fourteen",
        "fifteen",
        "sixteen",
        "seventeen",
        "eighteen",
        "nineteen",
        "twenty",
        "thirty",
        "forty",
        "fifty",
        "sixty",
        "seventy",
        "eighty",
        "ninety",
        "hundred",
        "thousand",
        "million",
        "half",
        "quarter",
        "once",
        "twice",
        "thrice",
        "first",
        "second",
        "third",
        "fourth",
        "fifth",
        "dozen",
        "couple",
        "pair",
        "double",
        "percent",
    ]
)


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


class Theme(msgspec.Struct, frozen=True):
    """A persona: its colours, its drawn faces, its wordings for each situation.

    ``minimum_contrast`` is the WCAG ratio that all text keeps against the background and the surface.
    """

    name: str
    title: str
    summary: str
    dark: bool
    minimum_contrast: float
    colors: Colors
    faces: dict[str, str]
    phrases: dict[str, tuple[str, ...]]

    def problems(self) -> list[str]:
        """What is missing or wrong, a sentence each."""
        found = [f"There is no face for {face}." for face in FACES if not self.faces.get(face)]
        for situation, slots in SITUATIONS.items():
            wordings = self.phrases.get(situation, ())
            if not wordings:
                found.append(f"There is no wording for {situation}.")
            for wording in wordings:
                found += _wording_problems(situation, wording, slots)
        found += [f"{name} is not a situation." for name in self.phrases if name not in SITUATIONS]
        return found + self._contrast_problems()

    def _contrast_problems(self) -> list[str]:
        colors = msgspec.structs.asdict(self.colors)
        bad = [
            f"{name} is not a colour like #a0b1c2: {value}." for name, value in colors.items() if not _is_color(value)
        ]
        if bad:
            return bad
        return [
            f"{name} on {ground} has a contrast of {ratio:.1f}, less than {self.minimum_contrast:g}."
            for name in colors
            if name not in ("background", "surface")
            for ground in ("background", "surface")
            if (ratio := contrast(colors[name], colors[ground])) < self.minimum_contrast
        ]


def holds_number(text: str) -> bool:
    """Whether a text holds a number, in digits or in words."""
    return bool(re.search(r"\d", text)) or not NUMBER_WORDS.isdisjoint(re.findall(r"[a-z]+", text.lower()))


def _wording_problems(situation: str, wording: str, slots: set[str]) -> list[str]:
    try:
        used = {name for _, name, _, _ in string.Formatter().parse(wording) if name is not None}
    except ValueError as error:
        return [f"A wording for {situation} has broken slots ({error}): {wording!r}."]
    found = [
        f"A wording for {situation} uses the slot {name}, which it does not have." for name in sorted(used - slots)
    ]
    if not found:
        try:
            wording.format(**dict.fromkeys(slots, "figure"))
        except (ValueError, LookupError) as error:
            found.append(f"A wording for {situation} has broken slots ({error}): {wording!r}.")
    if situation in QUALITATIVE and holds_number(wording):
        found.append(f"A wording for {situation} holds a number: {wording!r}.")
    if situation in QUANTITATIVE and not used & _FIGURES:
        found.append(f"A wording for {situation} gives no figure: {wording!r}.")
    return found


def _is_color(value: str) -> bool:
    return bool(re.fullmatch(r"#[0-9a-fA-F]{6}", value))


def contrast(one: str, other: str) -> float:
    """The contrast ratio of two #rrggbb colours, 1 to 21 (WCAG 2.2, "contrast ratio")."""
    lighter, darker = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def _luminance(color: str) -> float:
    """Relative luminance of an sRGB colour (WCAG 2.2, "relative luminance")."""
    channels = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def face_for(valence: Literal["positive", "neutral", "negative"] | None) -> str:
    """The expression that goes with a valence."""
    return {"positive": "happy", "neutral": "neutral", "negative": "encouraging"}.get(valence or "", "speaking")
