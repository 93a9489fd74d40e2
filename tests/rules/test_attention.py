"""The rules of the therapist's day: who needs a look, and why; who is away."""

from collections.abc import Sequence
from datetime import date, timedelta

import pytest

from sar_tui.rules.attention import (
    AWAY_DAYS,
    COURSE_DAYS,
    LOOK_BACK_DAYS,
    Course,
    Event,
    PastSession,
    Rated,
    Reason,
    Section,
    reasons,
    section,
    stuck_level,
    urgency,
    worst_pain,
)
from sar_tui.rules.wellbeing import PainLimits, SessionRatings

TODAY = date(2026, 11, 25)


def ago(days: int) -> date:
    return TODAY - timedelta(days=days)


def told(days: int, pain: int, **others: object) -> Rated:
    return Rated(ago(days), SessionRatings(pain_after=pain, **others))  # type: ignore[arg-type]


def played(days: int, *levels: int, **others: object) -> PastSession:
    return PastSession(ago(days), "keyboard", levels=levels, **others)  # type: ignore[arg-type]


def kinds(course: Course) -> list[str]:
    return [reason.kind for reason in reasons(course, TODAY)]


def test_the_worst_pain_above_the_limit_this_week_needs_a_look() -> None:
    course = Course(rated=[told(6, 8), told(2, 6), told(0, 1)])
    assert reasons(course, TODAY) == (Reason("pain", ago(6), 8, 5),)
    assert worst_pain(course.rated, TODAY) == 8


@pytest.mark.parametrize(
    ("rated", "found"),
    [
        (told(0, 5), []),
        (told(0, 6), ["pain"]),
        (told(LOOK_BACK_DAYS - 1, 6), ["pain"]),
        (told(LOOK_BACK_DAYS, 6), []),
        (told(0, 6, limits=PainLimits(7, 2)), []),
        (told(0, 8, limits=PainLimits(7, 2)), ["pain"]),
        (told(0, 3, pain_before=1), ["pain rose"]),
        (told(0, 3, pain_before=2), []),
        (told(0, 7, pain_before=6), ["pain"]),
        (told(0, 6, began=False), ["pain"]),
        (Rated(TODAY, SessionRatings(told_pain=True)), []),
    ],
)
def test_pain_is_judged_by_the_limits_of_its_session(rated: Rated, found: list[str]) -> None:
    assert kinds(Course(rated=[rated])) == found


def test_pain_that_rose_names_the_pain_before() -> None:
    assert reasons(Course(rated=[told(1, 4, pain_before=1)]), TODAY) == (
        Reason("pain rose", ago(1), 4, 1),
    )


@pytest.mark.parametrize(
    ("days", "has_outcome", "found"),
    [
        (0, True, ["event"]),
        (LOOK_BACK_DAYS - 1, True, ["event"]),
        (LOOK_BACK_DAYS, True, []),
        (0, False, ["event without outcome"]),
        (300, False, ["event without outcome"]),
    ],
)
def test_an_adverse_event_needs_a_look_for_a_week_and_until_its_outcome_is_known(
    days: int, has_outcome: bool, found: list[str]
) -> None:
    assert kinds(Course(events=[Event(ago(days), "mild", has_outcome)])) == found


def test_the_newest_of_several_events_is_told_with_their_number() -> None:
    events = [Event(ago(days), word, False) for days, word in ((9, "mild"), (5, "severe"))]
    assert reasons(Course(events=events), TODAY) == (
        Reason("event without outcome", ago(5), 2, word="severe"),
    )


def test_what_several_sessions_tell_needs_a_look_while_they_go_on() -> None:
    def tired(last: int) -> Course:
        return Course(
            rated=[Rated(ago(last + days), SessionRatings(fatigue_after=8)) for days in (2, 0)]
        )

    assert kinds(tired(0)) == ["tired"]
    assert kinds(tired(LOOK_BACK_DAYS)) == []
    new = [told(days, pain) for days, pain in ((5, 0), (4, 1), (3, 1), (2, 1), (1, 2))]
    assert kinds(Course(rated=new)) == ["new pain"]


@pytest.mark.parametrize(
    ("sessions", "level"),
    [
        ([played(0, 6), played(1, 6), played(2, 6)], 6),
        ([played(0, 6, 7, 6, 5), played(1, 5, 6, 7), played(2, 6, 6, 9)], 6),
        ([played(0, 6), played(1, 6), played(2, 5)], None),
        ([played(0, 6), played(1, 6)], None),
        ([played(0, 7), played(1, 6), played(2, 6), played(3, 6)], None),
        ([played(0), played(1, 6), played(2, 6), played(3, 6)], 6),
        ([played(0, 9, counts=False), played(1, 6), played(2, 6), played(3, 6)], 6),
        ([played(0, 6, programme=2), played(1, 6, programme=1), played(2, 6, programme=1)], None),
    ],
)
def test_a_level_is_stuck_if_the_median_stays_for_three_sessions(
    sessions: Sequence[PastSession], level: int | None
) -> None:
    assert stuck_level(sessions, sessions[0].programme) == level


def test_a_changed_programme_answers_a_stuck_level() -> None:
    sessions = [played(days, 6, programme=1) for days in (0, 1, 2)]
    assert kinds(Course(sessions, programmes={"keyboard": 1})) == ["stuck"]
    assert kinds(Course(sessions, programmes={"keyboard": 2})) == []


def test_a_stuck_level_is_of_one_task_and_of_a_course_that_goes_on() -> None:
    others = [PastSession(ago(days), "pairs", levels=(6,)) for days in (1, 3)]
    sessions = [played(0, 6), others[0], played(2, 6), others[1], played(4, 6)]
    assert reasons(Course(sessions), TODAY) == (Reason("stuck", value=6, word="keyboard"),)
    assert kinds(Course([played(days, 6) for days in (COURSE_DAYS, 30, 33)])) == []


@pytest.mark.parametrize(
    ("status", "days", "found"),
    [
        ("discarded", 0, ["mistake"]),
        ("discarded", LOOK_BACK_DAYS, []),
        ("interrupted", 2, ["interrupted"]),
        ("dismissed", 0, []),
        ("completed", 0, []),
    ],
)
def test_a_session_that_was_no_session_needs_a_look_until_the_next_one(
    status: str, days: int, found: list[str]
) -> None:
    unfinished = played(days, status=status, counts=status != "discarded")
    assert kinds(Course([unfinished])) == found
    assert kinds(Course([played(days), unfinished])) == []


def test_the_most_urgent_reason_comes_first() -> None:
    course = Course(
        sessions=[played(0, 6, status="interrupted"), played(1, 6), played(2, 6)],
        rated=[told(0, 6)],
        events=[Event(ago(1), "mild", has_outcome=True)],
    )
    assert kinds(course) == ["pain", "event", "stuck", "interrupted"]
    found = [Reason("stuck", value=9), Reason("pain", ago(0), 6), Reason("pain", ago(5), 8)]
    assert [reason.value for reason in sorted(found, key=urgency)] == [8, 6, 9]


@pytest.mark.parametrize(
    ("course", "found"),
    [
        (Course(), "new"),
        (Course([played(0, 1)]), "today"),
        (Course([played(1, 1)]), "others"),
        (Course([played(AWAY_DAYS - 1, 1)]), "others"),
        (Course([played(AWAY_DAYS, 1)]), "away"),
        (Course([played(COURSE_DAYS - 1, 1)]), "away"),
        (Course([played(COURSE_DAYS, 1)]), "others"),
        (Course([played(9, 1)], due=ago(2)), "due"),
        (Course([played(0, 1)], due=TODAY, rated=[told(0, 6)]), "look"),
        (Course([played(0, 1, counts=False), played(8, 1)]), "away"),
    ],
)
def test_everybody_stands_in_one_section(course: Course, found: Section) -> None:
    assert section(course, reasons(course, TODAY), TODAY) == found
