"""The day as the therapist sees it: who needs a look, who is due, who has trained. Pure.

Each text is a whole sentence with slots, so that it can be translated.
"""

from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from typing import Literal

import msgspec

from sar_tui.app.home.words import day_words
from sar_tui.model.language import Language
from sar_tui.rules.attention import (
    COURSE_DAYS,
    Reason,
    ReasonKind,
    Section,
    reasons,
    section,
    urgency,
    worst_pain,
)
from sar_tui.store.courses import DayTotal, Person

Part = Section | Literal["last"]
"""A section of the list; ``last`` has the one who trained last, as they may well go on."""
HEADINGS: dict[Part, str] = {
    "look": "Need a look",
    "last": "Trained last",
    "due": "Due",
    "today": "Trained today",
    "new": "New",
    "away": "Not for a week or longer",
    "others": "Others",
}
"""The sections, in order."""
_REASONS: dict[ReasonKind, str] = {
    "pain": "pain {value}",
    "pain rose": "pain from {limit} to {value}",
    "event": "adverse event",
    "event without outcome": "open adverse event",
    "new pain": "new pain",
    "worse pain": "more pain",
    "tired": "very tired",
    "letter refused": "a letter was refused",
    "letters missing": "1 letter missing",
    "not heard": "not heard for {value} days",
    "stuck": "no change for 3 sessions",
    "mistake": "begun by mistake",
    "interrupted": "interrupted",
}
"""Each reason in the list; at 80 by 24 a line has room for 28 columns."""
_SEVERAL: dict[ReasonKind, str] = {
    "event": "{value} adverse events",
    "event without outcome": "{value} open adverse events",
    "letters missing": "{value} letters missing",
}
"""The reasons for more than one event or letter."""
_SENTENCES: dict[ReasonKind, str] = {
    "pain": "Pain {value} {day}, limit {limit}.",
    "pain rose": "Pain from {limit} to {value} {day}.",
    "event": "Adverse event {day}, {word}.",
    "event without outcome": "Adverse event {day}, {word}: no outcome yet.",
    "new pain": "Pain in the last 4 sessions, none before.",
    "worse pain": "More pain in the last 4 sessions than before.",
    "tired": "Very tired after the last 2 sessions.",
    "letter refused": "A letter from home was refused {day}: `sar-tui letterbox list` says why.",
    "letters missing": "1 letter from home is missing: it is asked for again.",
    "not heard": "Nothing was heard from home for {value} days.",
    "stuck": "No change for 3 sessions: level {value}.",
    "mistake": "Begun by mistake {day}.",
}
"""Each reason on the card, which says of its own if a session was interrupted."""
_SEVERAL_SENTENCES: dict[ReasonKind, str] = {
    "event": "{value} adverse events this week.",
    "event without outcome": "{value} adverse events without an outcome.",
    "letters missing": "{value} letters from home are missing: they are asked for again.",
}
"""The sentences for more than one event or letter."""
_OF_LETTERS = ("letter refused", "letters missing", "not heard")
_SEVERITIES = {
    "mild": "mild",
    "moderate": "moderate",
    "severe": "severe",
    "": "severity not recorded",
}


class Entry(msgspec.Struct, frozen=True):
    """A person in the list of the day.

    Attributes:
        code: of the participant.
        part: where they stand.
        why: why they stand there, in few words; empty if ``trained`` says it.
        trained: when they trained last, and today's goals.
        look: why they need a look, a sentence each, for the card.
    """

    code: str
    part: Part
    why: str
    trained: str
    look: Sequence[str] = ()

    @property
    def words(self) -> str:
        """All that is said, for a search."""
        return " ".join((self.why, *self.look, self.trained))


class Day(msgspec.Struct, frozen=True):
    """The list of the day, and the sentence above it."""

    sentence: str
    entries: Sequence[Entry]


def heading(part: Part, tr: Language) -> str:
    """Return the heading of a section."""
    return tr(HEADINGS[part])


def day_of(
    people: Sequence[Person],
    last: str | None,
    today: date,
    tr: Language,
    at_home: Mapping[str, str] = {},
) -> Day:
    """Return the day.

    Args:
        people: first who began a session, or was added, last.
        last: who trained last; they come before those who need no look and are not due, as they
            may well go on.
        today: the date.
        tr: the language.
        at_home: what is said of the computers of those who train at home, by participant.
    """
    found = []
    for place, person in enumerate(people):
        why = reasons(person.course, today)
        part: Part = section(person.course, why, today)
        if person.code == last and part not in ("look", "due"):
            part = "last"
        entry = _entry(person, part, why, today, tr, at_home.get(person.code, ""))
        found.append((_order(person, part, why), place, entry))
    entries = [entry for *_, entry in sorted(found, key=lambda one: one[:2])]
    return Day(_sentence(people, entries, tr), entries)


def _order(person: Person, part: Part, why: Sequence[Reason]) -> tuple[float, ...]:
    """Return the key of the order in the list; without more, the newest come first."""
    course, place = person.course, list(HEADINGS).index(part)
    if part == "look":
        return (place, *urgency(why[0]))
    if part == "due" and course.due:
        return (place, -course.due.toordinal())
    return (place,)


def _entry(
    person: Person, part: Part, why: Sequence[Reason], today: date, tr: Language, at_home: str
) -> Entry:
    course = person.course
    said, look = [], []
    for reason in why:
        slots = _slots(reason, today, tr)
        is_several = reason.kind in _SEVERAL and reason.value > 1
        said.append(tr(_SEVERAL[reason.kind] if is_several else _REASONS[reason.kind], **slots))
        sentences = _SEVERAL_SENTENCES if is_several else _SENTENCES
        if reason.kind in sentences:
            look.append(tr(sentences[reason.kind], **slots))
    if course.due and why:
        look.append(f"{_due(course.due, today, tr)}.")
    elif course.due:
        said.append(_due(course.due, today, tr))
    pain = worst_pain(course.rated, today)
    if pain and not why:
        said.append(tr("pain {pain}/10 this week", pain=pain))
    if at_home and not any(reason.kind in _OF_LETTERS for reason in why):
        said.append(at_home)
    text = " · ".join(said)
    return Entry(
        person.code, part, f"{text[:1].upper()}{text[1:]}", _trained(person, today, tr), look
    )


def _slots(reason: Reason, today: date, tr: Language) -> dict[str, object]:
    return {
        "day": day_words(reason.day, today, tr) if reason.day else "",
        "value": reason.value,
        "limit": reason.limit,
        "word": tr(_SEVERITIES.get(reason.word, reason.word)),
    }


def _due(due: date, today: date, tr: Language) -> str:
    if due == today:
        return tr("Due today")
    return tr("Due since {day}", day=day_words(due, today, tr))


def _trained(person: Person, today: date, tr: Language) -> str:
    """Return when a person trained last, and how it went if it was today."""
    if person.today:
        return _trained_today(person.today, tr)
    if person.course.last is None:
        return tr("No session yet")
    days = (today - person.course.last).days
    if days == 1:
        return tr("Trained yesterday")
    if days >= COURSE_DAYS:
        return tr("Trained last on {day}", day=day_words(person.course.last, today, tr))
    return tr("Trained {days} days ago", days=days)


def _trained_today(total: DayTotal, tr: Language) -> str:
    clock = f"{total.began:%H:%M}"
    if not total.attempts:
        return tr("Today {clock}, no attempt", clock=clock)
    if not total.judged:
        return tr("Today {clock}, {minutes} min", clock=clock, minutes=total.minutes)
    return tr(
        "Today {clock}, {reached} of {count} goals",
        clock=clock,
        reached=total.reached,
        count=total.judged,
    )


def _sentence(people: Sequence[Person], entries: Sequence[Entry], tr: Language) -> str:
    """Return the sentences above the list."""
    if not people:
        return tr("Welcome")
    parts = [entry.part for entry in entries]
    look, due = parts.count("look"), parts.count("due")
    trained = sum(bool(person.today and person.today.attempts) for person in people)
    if not (look or due or any(person.course.last for person in people)):
        return tr("Nobody has trained here yet.")
    return " ".join(_counts(look, due, trained, tr))


def _counts(look: int, due: int, trained: int, tr: Language) -> Iterator[str]:
    if not look:
        yield tr("Nobody needs a look today.")
    else:
        one, several = "1 person needs a look.", "{count} people need a look."
        yield tr(one if look == 1 else several, count=look)
    if due and look:
        one, several = "1 more visit is due.", "{count} more visits are due."
        yield tr(one if due == 1 else several, count=due)
    elif due:
        one, several = "1 visit is due.", "{count} visits are due."
        yield tr(one if due == 1 else several, count=due)
    if trained:
        one, several = "1 person has trained today.", "{count} people have trained today."
        yield tr(one if trained == 1 else several, count=trained)
