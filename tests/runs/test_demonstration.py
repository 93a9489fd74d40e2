"""A demonstration folder is whole, says what it is, and its reports tell the stories of its people."""

from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.reports.progress import Progress, progress
from sar_tui.runs import demonstration
from sar_tui.runs.demonstration import NOTE, make_demonstration
from sar_tui.store import participants, records, sessions, training_days, wellbeing
from sar_tui.store.database import StoreError, connect
from sar_tui.store.integrity import flaws, interrupted
from sar_tui.store.results import sessions_of

NOW = datetime(2026, 3, 20, 14, 30).astimezone()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("demonstration") / "data"
    make_demonstration(made, NOW)
    return made


@pytest.fixture
def database(folder: Path) -> Iterator[Connection]:
    with closing(connect(folder)) as opened:
        yield opened


def told(database: Connection, folder: Path, code: str) -> Progress:
    """Return the progress of a participant as the program computes it."""
    return progress(
        code,
        sessions_of(database, code, folder=folder),
        Catalogue().task,
        records.listing(database, participant=code),
        NOW.date(),
        wellbeing.history(database, code),
    )


@pytest.mark.slow
def test_the_folder_is_whole_and_says_in_each_session_that_people_are_invented(
    database: Connection, folder: Path
) -> None:
    assert list(flaws(database)) == []
    assert {row["mode"] for row in sessions.listing(database, folder)} == {"demonstration"}
    assert sessions.is_demonstration(database)
    assert "invented" in (folder / NOTE).read_text(encoding="utf-8")
    assert folder.stat().st_mode & 0o077 == 0
    assert participants.codes(database) == ["P01", "P02", "P03", "P04", "P05", "P06"]


def test_eight_weeks_of_sessions_end_on_the_last_day_in_the_order_in_which_they_were_played(
    database: Connection, folder: Path
) -> None:
    began = [
        datetime.fromisoformat(row["started_at"])
        for row in reversed(sessions.listing(database, folder))
    ]
    assert began == sorted(began)
    assert timedelta(days=55) < began[-1] - began[0] < timedelta(days=57)
    assert began[-1].astimezone().date() == NOW.date()
    assert began[-1] < NOW
    (left,) = interrupted(database, folder)
    assert sessions.find(database, folder, left)["status"] == "interrupted"


@pytest.mark.parametrize(("code", "verdict"), [("P01", "more"), ("P02", "noise")])
def test_one_gets_better_than_noise_and_practice_and_one_stays(
    database: Connection, folder: Path, code: str, verdict: str
) -> None:
    (line,) = told(database, folder, code).lines
    assert line.verdict == verdict
    assert line.mode == "demonstration"


def test_the_pain_of_one_is_told_and_sessions_become_fewer(
    database: Connection, folder: Path
) -> None:
    found = told(database, folder, "P03")
    assert found.tell[:2] == ("stop", "stopped")
    assert [event.content["severity"] for event in found.events] == ["moderate"]
    weeks = [day.date > (NOW.date() - timedelta(days=28)).isoformat() for day in found.days]
    assert sum(weeks) < len(weeks) / 2


def test_one_has_not_come_for_twelve_days_and_is_due(database: Connection, folder: Path) -> None:
    last = told(database, folder, "P04").days[-1].date
    assert NOW.date() - date.fromisoformat(last) == timedelta(days=12)
    assert "P04" in training_days.visits_due(database, NOW.date())
    assert "P01" not in training_days.visits_due(database, NOW.date())


def test_two_play_together_and_an_operator_led_one(database: Connection, folder: Path) -> None:
    pairs = [row for row in sessions.listing(database, folder) if row["task"] == "pairs"]
    assert {sessions.codes(row) for row in pairs} == {("P05", "P06")}
    led = [sessions.find(database, folder, id) for id in sessions.operators(database)]
    assert {row["participant"] for row in led} == {"P06"}
    notes = database.execute("SELECT count(*) FROM notes").fetchone()[0]
    assert notes > 0


def test_programmes_have_versions_with_reasons_before_their_sessions(
    database: Connection, folder: Path
) -> None:
    saved = database.execute(
        "SELECT version, reason, created_at FROM programmes WHERE participant='P03'"
        " ORDER BY version"
    ).fetchall()
    assert [version for version, *_ in saved] == [1, 2]
    assert all(reason for _, reason, _ in saved)
    first = sessions.listing(database, folder, participant="P03")[-1]
    assert saved[0][2] < first["started_at"]
    assert first["programme"] == 1


def test_before_noon_the_last_session_was_yesterday(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    early = datetime(2026, 3, 20, 0, 5, tzinfo=UTC).astimezone()
    monkeypatch.setattr(demonstration, "_STORIES", (demonstration._misses,))
    make_demonstration(tmp_path / "data", early)
    with closing(connect(tmp_path / "data")) as database:
        last = told(database, tmp_path / "data", "P04").days[-1].date
    assert date.fromisoformat(last) <= early.date() - timedelta(days=1 + 12)


@pytest.mark.parametrize("name", ["data", "data/letter.txt"])
def test_a_folder_that_holds_anything_is_refused_and_stays_as_it_is(
    tmp_path: Path, name: str
) -> None:
    (tmp_path / "data").mkdir(mode=0o755)
    (tmp_path / "data/letter.txt").write_text("Dear")
    with pytest.raises(StoreError, match="a folder of its own"):
        make_demonstration(tmp_path / name)
    assert [path.name for path in (tmp_path / "data").iterdir()] == ["letter.txt"]
    assert (tmp_path / "data").stat().st_mode & 0o777 == 0o755
