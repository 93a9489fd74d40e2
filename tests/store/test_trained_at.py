"""A session belongs to the day of the place where it was played, wherever its database is looked
at.
"""

import time
from collections.abc import Iterator
from contextlib import closing
from datetime import date, datetime, timedelta, timezone
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.loop.task import Task
from sar_tui.reports.progress import progress
from sar_tui.rules.limits import Dose
from sar_tui.store import programmes, sessions, training_days
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from sar_tui.store.results import sessions_of
from sar_tui.store.training_days import done_on_day, trained_at, utc_offset_s
from tests.played import simulated
from tests.store.by_hand import sql

LATE = "2026-03-01T23:30:00+00:00"
TOKYO = 9 * 3600


@pytest.fixture(params=["Pacific/Auckland", "America/Los_Angeles"], autouse=True)
def _viewer(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Look at the sessions from elsewhere."""
    with monkeypatch.context() as context:
        context.setenv("TZ", request.param)
        time.tzset()
        yield
    time.tzset()


@pytest.fixture
def played(data: Path) -> Iterator[Connection]:
    """A live session that was played in Tokyo on 2 March, at 8:30 in the morning."""
    simulated(data, seed=1, attempts=2, prompts_per_attempt=2)
    with closing(connect(data)) as database:
        anchor = "json_set(clock_anchor, '$.utc', ?, '$.utc_offset_s', ?)"
        sql(database, f"UPDATE runs SET clock_anchor={anchor}", LATE, TOKYO)
        sql(database, "UPDATE sessions SET mode='live', started_at=?", LATE)
        yield database


def test_progress_and_dose_are_dated_where_the_person_trained(
    played: Connection, data: Path, keyboard: type[Task]
) -> None:
    found = progress("P01", sessions_of(played, "P01"), {"keyboard": keyboard}.get)
    assert found.lines[0].sessions[0].began == "2026-03-02T08:30:00+09:00"
    assert [day.date for day in found.days] == ["2026-03-02"]
    (row,) = sessions.listing(played, data)
    assert sessions.local_time(row["started_at"], row["utc_offset_s"]) == "2026-03-02 08:30"


def test_what_was_done_on_a_day_is_counted_where_it_was_done(played: Connection) -> None:
    noon = datetime(2026, 3, 2, 12, tzinfo=timezone(timedelta(hours=-8)))
    assert done_on_day(played, "P01", "keyboard", noon).attempts == 2
    assert done_on_day(played, "P01", "keyboard", noon - timedelta(days=1)) == Dose()


def test_a_visit_is_due_from_the_day_where_the_person_trained(played: Connection) -> None:
    programmes.save(played, "P01", "keyboard", Programme({"days_between_visits": 3}), after=0)
    assert training_days.visits_due(played, date(2026, 3, 4)) == {}
    assert training_days.visits_due(played, date(2026, 3, 8)) == {"P01": date(2026, 3, 5)}


@pytest.mark.parametrize(
    "stored", ["json_remove(clock_anchor, '$.utc_offset_s')", "'{'", "'{\"utc_offset_s\": 1e300}'"]
)
def test_without_an_offset_the_day_is_of_this_machine(played: Connection, stored: str) -> None:
    played.execute(f"UPDATE runs SET clock_anchor={stored}")
    (session,) = sessions_of(played, "P01")
    assert session.began.isoformat() == datetime.fromisoformat(LATE).astimezone().isoformat()


def test_the_offset_is_that_of_the_machine(played: Connection) -> None:
    now = datetime.now().astimezone()
    assert utc_offset_s() == now.utcoffset().total_seconds()  # type: ignore[union-attr]
    assert trained_at(LATE, 86_400).tzinfo == trained_at(LATE, None).tzinfo
