"""Phrases for an operator to have said: their own, with slots, and the theme's."""

import re
import string
from typing import NamedTuple

import msgspec

from sar_tui.framework.messages import Remark, Valence
from sar_tui.framework.theme import Theme
from sar_tui.operator.session_state import SessionState

LONGEST = 400
"""Characters of what an operator has the agent say."""
SLOTS = ("participant", "level", "attempt", "result", "goal")
_THEMES: dict[str, tuple[str, ...]] = {
    "Encourage": ("encouragement",),
    "Praise": ("positive_slight", "positive", "positive_strong"),
    "Neutral": ("neutral",),
    "Comfort": ("negative_slight", "negative", "negative_strong"),
    "Rest, come and go": ("rest", "greeting", "welcome_back", "goodbye", "goodbye_early"),
}
"""The situations whose wordings hold no result, under the headings of the palette."""


class Phrase(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Something the agent can be made to say. ``text`` may hold `SLOTS`."""

    text: str
    valence: Valence | None = None
    gesture: str = ""
    face: str = ""
    gaze: str = ""

    def remark(self, text: str) -> Remark:
        """It, said with its slots filled."""
        return Remark(text=text, valence=self.valence, gesture=self.gesture, face=self.face, gaze=self.gaze)


class Filled(NamedTuple):
    """A phrase, and its text as it would be said now; or its text as it is, and what has no value yet."""

    phrase: Phrase
    text: str
    missing: str = ""


def phrase_problem(text: str) -> str:
    """What is wrong with a phrase and its slots; empty where nothing is."""
    if not text.strip() or len(text) > LONGEST or not text.isprintable():
        return f"the phrase {text[:40]!r} is not one line of at most {LONGEST} characters"
    try:
        parts = [part[1:] for part in string.Formatter().parse(text) if part[1] is not None]
    except ValueError as error:
        return f"the phrase {text!r} has broken slots ({error})"
    for name, form, conversion in parts:
        if name not in SLOTS or form or conversion:
            return f"the phrase {text!r} has a slot that is none of {{{'}, {'.join(SLOTS)}}}"
    return ""


def fill(phrase: Phrase, values: dict[str, str]) -> Filled:
    """A phrase as it would be said now."""
    wanted = [part[1] for part in string.Formatter().parse(phrase.text) if part[1]]
    if missing := [name for name in wanted if name not in values]:
        return Filled(phrase, phrase.text, missing[0])
    return Filled(phrase, phrase.text.format_map(values))


def fill_slots(text: str, values: dict[str, str]) -> tuple[str, str]:
    """Typed words with their slots filled, and a slot that has no value yet; other braces are braces."""
    missing = [name for name in SLOTS if f"{{{name}}}" in text and name not in values]
    filled = re.sub(rf"{{({'|'.join(SLOTS)})}}", lambda found: values.get(found[1], found[0]), text)
    return filled, missing[0] if missing else ""


def slot_values(state: SessionState, seat: str) -> dict[str, str]:
    """What the slots hold for a participant; what is not known is left out."""
    values: dict[str, str] = {}
    welcome, ended = state.welcome, state.seat(seat).attempt
    if welcome is None:
        return values
    if seat in welcome.participants:
        values["participant"] = welcome.participants[seat]
    if state.level is not None:
        values["level"] = str(state.level)
    if state.waiting and state.waiting.attempt:
        values["attempt"] = str(state.waiting.attempt)
    if ended and ended.metric is not None:
        values["result"] = figure(ended.metric, state)
    if ended and ended.goal is not None:
        values["goal"] = figure(ended.goal, state)
    return values


def addressee(state: SessionState, seat: str) -> str:
    """To whom, of several: `` to P02``; nothing where there is one participant."""
    people = state.welcome.participants if state.welcome else {}
    return f" to {people.get(seat, seat)}" if len(people) > 1 else ""


def addressed(state: SessionState, seat: str, text: str) -> str:
    """PhraseBook as the agent says them to one of several: it calls them first."""
    called = state.welcome.spoken_names.get(seat, "") if state.welcome else ""
    return f"{called}: {text}" if called else text


def figure(value: float, state: SessionState) -> str:
    """A value of the metric, with its unit."""
    decimals, unit = (state.welcome.decimals, state.welcome.unit) if state.welcome else (0, "")
    return f"{value:.{decimals}f} {unit}".rstrip()


def theme_phrases(theme: Theme) -> dict[str, list[Phrase]]:
    """What a theme has to say without a result in it, by heading."""
    return {
        heading: [
            _phrase(theme, situation, text) for situation in situations for text in theme.phrases.get(situation, ())
        ]
        for heading, situations in _THEMES.items()
    }


def _phrase(theme: Theme, situation: str, text: str) -> Phrase:
    """With the face and gesture that the theme gives it; those of a result go with its valence."""
    manner = theme.manner(situation)
    named = next((valence for valence in ("positive", "neutral", "negative") if situation.startswith(valence)), None)
    plain = text.replace("{", "{{").replace("}", "}}")
    return Phrase(plain, named, manner.gesture, manner.face, "" if manner.gaze == "ahead" else manner.gaze)  # type: ignore[arg-type]
