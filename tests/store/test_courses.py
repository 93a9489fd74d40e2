"""Facts of each participant that the day shows: the newest sessions, pain, events and visits."""

from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.rules.attention import Event, Rated
from sar_tui.rules.wellbeing import PainLimits
from sar_tui.store import records
from sar_tui.store.courses import _LOOKED_AT, Person, read_people
from sar_tui.store.locks import hold
from sar_tui.store.participants import add
from tests.recorded import event, told
from tests.store.by_hand import insert, sql
from tests.store.test_sessions import enter

NOW = datetime(2026, 11, 25, 15, tzinfo=UTC)
TODAY = NOW.date()


def played(
    database: Connection,
    code: str,
    days: int,
    levels: tuple[int, ...] = (),
    status: str = "completed",
    **facts: object,
) -> str:
    """Store a session of so many days ago, with an attempt at each level; every second one reaches
    its goal.
    """
    session = enter(database, code, **facts)
    began = (NOW - timedelta(days=days)).isoformat()
    sql(database, "UPDATE sessions SET started_at=?, status=? WHERE id=?", began, status, session)
    for number, level in enumerate(levels, 1):
        insert(
            database,
            "attempts",
            session=session,
            attempt=number,
            level=level,
            outcome="success" if number % 2 else "failure",
            started_ns=0,
            ended_ns=60_000_000_000,
        )
    return session


def person(database: Connection, data: Path, code: str = "P01", today: date = TODAY) -> Person:
    (found,) = (each for each in read_people(database, data, today) if each.code == code)
    return found


@pytest.fixture
def database(database: Connection) -> Connection:
    add(database, "P01")
    return database


def test_the_newest_session_or_addition_comes_first(database: Connection, data: Path) -> None:
    for code in ("P02", "P03"):
        add(database, code)
    enter(database, "P02")
    add(database, "P04")
    assert [each.code for each in read_people(database, data, TODAY)] == [
        "P04",
        "P02",
        "P03",
        "P01",
    ]


def test_a_running_session_is_interrupted_unless_a_program_holds_it(
    database: Connection, data: Path
) -> None:
    running = enter(database)
    enter(database, mode="simulated")
    with hold(data, "session", running):
        assert [each.status for each in person(database, data).course.sessions] == ["running"]
    assert [each.status for each in person(database, data).course.sessions] == ["interrupted"]


def test_the_newest_sessions_are_read_and_all_of_this_week(
    database: Connection, data: Path
) -> None:
    for days in (30, 20, *([8] * _LOOKED_AT)):
        played(database, "P01", days)
    assert len(person(database, data).course.sessions) == _LOOKED_AT
    for _ in range(_LOOKED_AT + 5):
        played(database, "P01", 1)
    found = person(database, data).course.sessions
    assert [each.day for each in found] == [TODAY - timedelta(days=1)] * (_LOOKED_AT + 5)


def test_levels_are_of_sessions_in_which_they_follow_the_person(
    database: Connection, data: Path
) -> None:
    for policy in ("one-up-one-down", "percentile", "gone"):
        played(database, "P01", 1, (4, 5), parameters={"difficulty_policy": policy})
    played(database, "P01", 1, (4, 5), parameters={"min_level": 4, "max_level": 4}, task="pairs")
    played(database, "P01", 1, (6,), parameters={}, task="pairs", programme=3)
    found = person(database, data).course.sessions
    assert [(list(each.levels), each.programme) for each in found] == [
        ([6], 3), ([], None), ([], None), ([], None), ([4, 5], None)
    ]  # fmt: skip


def test_the_sessions_of_today_are_added_up(database: Connection, data: Path) -> None:
    played(database, "P01", 1, (1, 1, 1))
    played(database, "P01", 0, (1, 1))
    played(database, "P01", 0, (1,))
    played(database, "P01", 0, (1, 1), status="discarded")
    total = person(database, data).today
    assert total is not None
    assert (total.attempts, total.minutes, total.reached, total.judged) == (3, 3, 2, 3)
    assert total.began.astimezone(UTC).hour == NOW.hour
    assert person(database, data, today=TODAY + timedelta(days=1)).today is None


def test_ratings_are_read_with_the_limits_of_their_session(
    database: Connection, data: Path
) -> None:
    old = played(database, "P01", 9)
    new = played(database, "P01", 2, parameters={"pain_limit": 7})
    told(database, "P01", "after", "pain", "3", session=old)
    told(database, "P01", "after", "pain", "6", session=new)
    rated = person(database, data).course.rated
    assert [(each.day, each.ratings.pain) for each in rated] == [
        (TODAY - timedelta(days=9), 3), (TODAY - timedelta(days=2), 6)
    ]  # fmt: skip
    assert [each.ratings.limits for each in rated] == [PainLimits(), PainLimits(7, 2)]
    assert person(database, data, today=TODAY + timedelta(days=9)).course.rated == ()


def test_pain_before_a_session_that_never_began_is_of_its_day(
    database: Connection, data: Path
) -> None:
    told(database, "P01", "before", "pain", "6")
    today = datetime.now().astimezone().date()
    (found,) = person(database, data, today=today).course.rated
    assert (found.day, found.ratings.pain, found.ratings.began) == (today, 6, False)
    later: list[Rated] = list(person(database, data, today=today + timedelta(7)).course.rated)
    assert later == []


def test_an_event_has_an_outcome_once_it_is_recorded(database: Connection, data: Path) -> None:
    kept = event(database, "P01", "2026-11-20", what="Dizzy", severity="mild")
    mistaken = event(database, "P01", "2026-11-21", what="Fell", severity="severe")
    records.correct(database, mistaken.id, {}, removed=True)
    assert person(database, data).course.events == [Event(date(2026, 11, 20), "mild", False)]
    records.correct(database, kept.id, {"outcome": "recovered"})
    assert person(database, data).course.events == [Event(date(2026, 11, 20), "mild", True)]
