"""Phrases that an operator can have the agent say: their own, with slots, and the theme's."""

import re
import string
from pathlib import Path
from typing import NamedTuple, get_args

import msgspec

import sar_tui.loop
from sar_tui.model.language import ENGLISH, Language, language
from sar_tui.model.messages import Remark, Valence
from sar_tui.model.results_for_people import goal_text, result_text
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Metric
from sar_tui.operator.session_state import SessionState

_FRAMEWORK = Path(sar_tui.loop.__file__).parent
"""Folder with the translations of the framework's own texts."""
MAX_TEXT = 400
"""Characters of a phrase or a typed text."""
SLOTS = ("participant", "level", "attempt", "result", "goal")
_HEADINGS = {
    "encouragement": "Encourage",
    "positive_slight": "Praise",
    "positive": "Praise",
    "positive_strong": "Praise",
    "neutral": "Neutral",
    "negative_slight": "Comfort",
    "negative": "Comfort",
    "negative_strong": "Comfort",
    "rest": "Rest, hello, goodbye",
    "greeting": "Rest, hello, goodbye",
    "welcome_back": "Rest, hello, goodbye",
    "goodbye": "Rest, hello, goodbye",
    "goodbye_early": "Rest, hello, goodbye",
}
"""Headings of the palette by phrase key: those whose texts hold no result."""
PHRASE_KEYS = tuple(_HEADINGS)
"""Keys of the phrases that an operator can have said as they are."""


class Phrase(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Phrase for the agent to say. ``text`` may hold `SLOTS`."""

    text: str
    valence: Valence | None = None
    gesture: str = ""
    face: str = ""
    gaze: str = ""

    def remark(self, text: str) -> Remark:
        """Return the remark that says this phrase. ``text``: with the slots filled."""
        return Remark(
            text=text, valence=self.valence, gesture=self.gesture, face=self.face, gaze=self.gaze
        )


class Filled(NamedTuple):
    """Phrase with its text as said now; or with its text as written and the slot that has no value
    yet.
    """

    phrase: Phrase
    text: str
    missing: str = ""


def phrase_problem(text: str, tr: Language = ENGLISH) -> str:
    """Return what is wrong with a phrase or its slots, in the language of the panel; empty if
    nothing is.
    """
    if not text.strip() or len(text) > MAX_TEXT or not text.isprintable():
        problem = tr("the phrase {phrase!r} is not one line of at most {most} characters")
        return problem.format(phrase=text[:40], most=MAX_TEXT)
    try:
        parts = [part[1:] for part in string.Formatter().parse(text) if part[1] is not None]
    except ValueError as error:
        problem = tr("the phrase {phrase!r} has broken slots ({why})")
        return problem.format(phrase=text, why=error)
    for name, form, conversion in parts:
        if name not in SLOTS or form or conversion:
            problem = tr("the phrase {phrase!r} has an unknown slot; known are {known}")
            return problem.format(phrase=text, known=f"{{{'}, {'.join(SLOTS)}}}")
    return ""


def fill(phrase: Phrase, values: dict[str, str]) -> Filled:
    """Fill the slots of a phrase."""
    wanted = [part[1] for part in string.Formatter().parse(phrase.text) if part[1]]
    if missing := [name for name in wanted if name not in values]:
        return Filled(phrase, phrase.text, missing[0])
    return Filled(phrase, phrase.text.format_map(values))


def fill_slots(text: str, values: dict[str, str]) -> tuple[str, str]:
    """Fill the slots of a typed text. Return it with a slot that has no value yet, if any; other
    braces stay.
    """
    missing = [name for name in SLOTS if f"{{{name}}}" in text and name not in values]
    filled = re.sub(rf"{{({'|'.join(SLOTS)})}}", lambda found: values.get(found[1], found[0]), text)
    return filled, missing[0] if missing else ""


def not_known(slot: str, tr: Language) -> str:
    """Return that a slot has no value yet, without a full stop."""
    return tr("{slot} is not known yet", slot=f"{{{slot}}}")


def slot_values(state: SessionState, seat: str) -> dict[str, str]:
    """Return the known values of the slots for a participant, as participants read them: times in
    seconds.
    """
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
    metric = Metric("", welcome.unit, "lower", decimals=welcome.decimals)
    tr = language(str(welcome.parameters.get("language", "en")), _FRAMEWORK)
    if ended and ended.metric is not None:
        values["result"] = result_text(metric, ended.metric, tr)
    if ended and ended.goal is not None:
        values["goal"] = goal_text(metric, ended.goal, tr)
    return values


def addressee_code(state: SessionState, seat: str) -> str:
    """Return the code of the addressee if there are several participants; else empty."""
    people = state.welcome.participants if state.welcome else {}
    return people.get(seat, seat) if len(people) > 1 else ""


def addressee(state: SessionState, seat: str) -> str:
    """Return the addressee for a heading, if there are several: `` to P02``; empty for one
    participant.
    """
    code = addressee_code(state, seat)
    return state.tr(" to {who}").format(who=code) if code else ""


def addressed(state: SessionState, seat: str, text: str) -> str:
    """Return a text as the agent says it: with the name first if there are several participants."""
    name = state.welcome.spoken_names.get(seat, "") if state.welcome else ""
    return f"{name}: {text}" if name else text


def metric_text(value: float, state: SessionState) -> str:
    """Return a value of the metric with its unit, for the panel."""
    decimals, unit = (state.welcome.decimals, state.welcome.unit) if state.welcome else (0, "")
    return f"{value:.{decimals}f} {unit}".rstrip()


def theme_phrases(theme: Theme, tr: Language = ENGLISH) -> dict[str, list[Phrase]]:
    """Return a theme's phrases without a result, by heading in the language of the panel."""
    found: dict[str, list[Phrase]] = {}
    for key in PHRASE_KEYS:
        found.setdefault(tr(_HEADINGS[key]), []).extend(phrases_of_key(theme, key))
    return found


def phrases_of_key(theme: Theme, key: str) -> list[Phrase]:
    """Return a theme's phrases of a key, if their texts hold no result."""
    texts = theme.phrases.get(key, ()) if key in PHRASE_KEYS else ()
    return [_phrase(theme, key, text) for text in texts]


def _phrase(theme: Theme, key: str, text: str) -> Phrase:
    """Return a phrase with the face and gesture that the theme gives its key, and the valence of
    its name.
    """
    manner = theme.manner(key)
    named = next((valence for valence in get_args(Valence) if key.startswith(valence)), None)
    gaze = "" if manner.gaze == "ahead" else manner.gaze
    plain = text.replace("{", "{{").replace("}", "}}")
    return Phrase(plain, named, manner.gesture, manner.face, gaze)
