"""The therapist's day: why a person needs a look, and where they stand in the list of people. Pure.

These rules point a therapist to a person, and decide nothing.
"""

import statistics
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import date
from typing import Literal, get_args

import msgspec

from sar_tui.rules.wellbeing import SessionRatings, tell_therapist

LOOK_BACK_DAYS = 7
"""Days, today included, that are "this week": what happened on them may need a look."""
STUCK_SESSIONS = 3
"""The level is stuck if it stays the same in so many sessions."""
AWAY_DAYS = 7
"""Somebody who has not trained for so many days is away."""
COURSE_DAYS = 28
"""After so many days without a session a course of training counts as over: nobody is away, and no
level is stuck.
"""

ReasonKind = Literal[
    "pain", "pain rose", "event without outcome", "event", "new pain", "worse pain", "tired",
    "letter refused", "letters missing", "not heard", "stuck", "mistake", "interrupted",
]  # fmt: skip
"""Reasons why a person needs a look, the most urgent first."""
_URGENCY = {kind: place for place, kind in enumerate(get_args(ReasonKind))}

Section = Literal["look", "due", "today", "new", "away", "others"]
"""Parts of the list of people, first to last."""


class Reason(msgspec.Struct, frozen=True):
    """A reason why a person needs a look.

    Attributes:
        kind: of the reason.
        day: of what happened; None if it is of several sessions.
        value: the pain, the level, or the number of events, of letters, or of days.
        limit: the limit that the pain is above, or the pain before the session that it rose from.
        word: the severity of an event, or the task whose level is stuck.
    """

    kind: ReasonKind
    day: date | None = None
    value: int = 0
    limit: int = 0
    word: str = ""


class PastSession(msgspec.Struct, frozen=True):
    """A session of a person.

    Attributes:
        day: where it was played.
        task: its name.
        status: what became of it.
        counts: False if it was started by mistake, or refused.
        programme: the version with whose settings it was played; None without one.
        levels: of its attempts; empty if there are none, or if the level does not follow the
            person.
    """

    day: date
    task: str = ""
    status: str = "completed"
    counts: bool = True
    programme: int | None = None
    levels: Sequence[int] = ()


class Rated(msgspec.Struct, frozen=True):
    """The ratings of a session, or of answers before one that never began."""

    day: date
    ratings: SessionRatings


class Event(msgspec.Struct, frozen=True):
    """An adverse event. ``has_outcome``: it is recorded how it ended."""

    day: date
    severity: str
    has_outcome: bool


class AtHome(msgspec.Struct, frozen=True):
    """The state of a person's computer at home, by its letters.

    Attributes:
        heard: the day of the last letter from it; None before the first.
        missing: number of letters that it has written and that have not arrived.
        refused: the day on which a letter from it was refused; None if none was.
    """

    heard: date | None = None
    missing: int = 0
    refused: date | None = None


class Course(msgspec.Struct, frozen=True):
    """All of a person's course that these rules look at.

    Attributes:
        sessions: the newest ones, newest first.
        rated: the newest ratings, oldest first.
        events: adverse events.
        programmes: the newest version of each task's programme, by the name of the task.
        due: the day from which a visit is due; None if none is planned, or it is later.
        at_home: of who trains at home; None of all others.
    """

    sessions: Sequence[PastSession] = ()
    rated: Sequence[Rated] = ()
    events: Sequence[Event] = ()
    programmes: Mapping[str, int] = {}
    due: date | None = None
    at_home: AtHome | None = None

    @property
    def last(self) -> date | None:
        """The day of the newest session that counts."""
        return max((each.day for each in self.sessions if each.counts), default=None)


def is_this_week(day: date, today: date) -> bool:
    """Return True for today and the days before it that `LOOK_BACK_DAYS` names."""
    return (today - day).days < LOOK_BACK_DAYS


def reasons(course: Course, today: date) -> tuple[Reason, ...]:
    """Return why a person needs a look, the most urgent reason first.

    - Pain above the limit, or that rose as much as the limits forbid, this week: the worst of it.
    - An adverse event this week, or earlier without an outcome.
    - What `tell_therapist` tells of several sessions, if the last of them was this week.
    - A letter from home that was refused this week, letters that are missing, and that none has
      come for a week.
    - A level that is stuck: see `stuck_level`.
    - A session by mistake, or one that was interrupted, this week, and no later session.
    """
    found = [
        *_pains(course.rated, today),
        *_events(course.events, today),
        *_symptoms(course.rated, today),
        *_letters(course.at_home, today),
        *_stuck(course, today),
        *_unfinished(course.sessions, today),
    ]
    return tuple(sorted(found, key=lambda reason: _URGENCY[reason.kind]))


def urgency(reason: Reason) -> tuple[int, ...]:
    """Return the key by which people who need a look are ordered: the most urgent kind, then the
    worst pain, then the newest day.
    """
    day = reason.day.toordinal() if reason.day else 0
    return (_URGENCY[reason.kind], -reason.value if reason.kind == "pain" else 0, -day)


def section(course: Course, why: Sequence[Reason], today: date) -> Section:
    """Return the part of the list in which a person stands today; ``why``: their `reasons`."""
    if why:
        return "look"
    if course.due is not None:
        return "due"
    if course.last is None:
        return "new"
    days = (today - course.last).days
    if days <= 0:
        return "today"
    return "away" if AWAY_DAYS <= days < COURSE_DAYS else "others"


def worst_pain(rated: Iterable[Rated], today: date) -> int:
    """Return the worst pain that was told this week; 0 if none was."""
    return max(
        (each.ratings.pain or 0 for each in rated if is_this_week(each.day, today)), default=0
    )


def stuck_level(sessions: Sequence[PastSession], programme: int | None = None) -> int | None:
    """Return the level at which a person has stayed in the last sessions of a task; None if it
    moved, or there are too few.

    The level of a session is the median of its attempts. A new version of the programme starts a
    new count: a therapist has looked, and changed something.

    Args:
        sessions: of one task, newest first. Those without attempts, or whose level does not follow
            the person, are left out.
        programme: the newest version of its programme; None without one.
    """
    counted = [each for each in sessions if each.counts and each.levels][:STUCK_SESSIONS]
    if len(counted) < STUCK_SESSIONS or any(each.programme != programme for each in counted):
        return None
    levels = {statistics.median_low(each.levels) for each in counted}
    return levels.pop() if len(levels) == 1 else None


def _pains(rated: Sequence[Rated], today: date) -> Iterator[Reason]:
    """Yield the worst pain of this week that was above its limit; else one that rose too much."""
    stops = [
        each for each in rated if is_this_week(each.day, today) and each.ratings.is_reason_to_stop
    ]
    if not stops:
        return
    worst = max(stops, key=lambda each: (each.ratings.pain or 0, each.day))
    pain, limits = worst.ratings.pain or 0, worst.ratings.limits
    if pain > limits.highest:
        yield Reason("pain", worst.day, pain, limits.highest)
    else:
        yield Reason("pain rose", worst.day, pain, worst.ratings.pain_before or 0)


def _events(events: Iterable[Event], today: date) -> Iterator[Reason]:
    """Yield the newest event without an outcome, and the newest other one of this week, each with
    the number of those like it.
    """
    is_open = [each for each in events if not each.has_outcome]
    ended = [each for each in events if each.has_outcome and is_this_week(each.day, today)]
    kinds: tuple[tuple[ReasonKind, list[Event]], ...] = (
        ("event without outcome", is_open),
        ("event", ended),
    )
    for kind, found in kinds:
        if found:
            newest = max(found, key=lambda each: each.day)
            yield Reason(kind, newest.day, value=len(found), word=newest.severity)


def _symptoms(rated: Sequence[Rated], today: date) -> Iterator[Reason]:
    if not rated or not is_this_week(rated[-1].day, today):
        return
    told = tell_therapist([each.ratings for each in rated])
    kinds: tuple[ReasonKind, ...] = ("new pain", "worse pain", "tired")
    yield from (Reason(kind) for kind in kinds if kind in told)


def _letters(home: AtHome | None, today: date) -> Iterator[Reason]:
    if home is None:
        return
    if home.refused is not None and is_this_week(home.refused, today):
        yield Reason("letter refused", home.refused)
    if home.missing:
        yield Reason("letters missing", value=home.missing)
    if home.heard is not None and not is_this_week(home.heard, today):
        yield Reason("not heard", home.heard, value=(today - home.heard).days)


def _stuck(course: Course, today: date) -> Iterator[Reason]:
    for task in dict.fromkeys(each.task for each in course.sessions):
        of_task = [each for each in course.sessions if each.task == task]
        level = stuck_level(of_task, course.programmes.get(task))
        if level is not None and (today - of_task[0].day).days < COURSE_DAYS:
            yield Reason("stuck", value=level, word=task)


def _unfinished(sessions: Sequence[PastSession], today: date) -> Iterator[Reason]:
    """Yield that the newest session, if it is of this week, was a mistake, or interrupted."""
    if sessions and is_this_week(sessions[0].day, today):
        newest = sessions[0]
        if newest.status == "discarded":
            yield Reason("mistake", newest.day)
        if newest.status == "interrupted":
            yield Reason("interrupted", newest.day)
