"""Scores are checked, kept, and replaced for a day by the one entered last."""

import sqlite3

import pytest

from sar_tui.progress.instruments import Score
from sar_tui.store import participants
from sar_tui.store.database import StoreError
from sar_tui.store.instrument_scores import add, remove, scores_of


@pytest.fixture(autouse=True)
def a_participant(database: sqlite3.Connection) -> None:
    participants.add(database, "P01")


def test_a_score_is_kept_with_who_entered_it(database: sqlite3.Connection) -> None:
    stored = add(database, "P01", Score("arat", "2026-03-01", 30, " seated "), author="ana")
    assert stored == Score("ARAT", "2026-03-01", 30.0, "seated")
    assert scores_of(database, "P01") == [stored]
    assert scores_of(database, "P02") == []
    assert database.execute("SELECT recorded_by FROM instrument_scores").fetchone() == ("ana",)


def test_the_last_entry_for_a_day_counts_and_the_first_is_kept(
    database: sqlite3.Connection,
) -> None:
    for score in (30, 31):
        add(database, "P01", Score("ARAT", "2026-03-01", score), author="ana")
    assert [each.score for each in scores_of(database, "P01")] == [31]
    assert database.execute("SELECT count(*) FROM instrument_scores").fetchone() == (2,)


def test_a_score_entered_by_mistake_is_removed_kept_and_can_be_entered_anew(
    database: sqlite3.Connection,
) -> None:
    for day in ("2026-03-01", "2026-04-01"):
        add(database, "P01", Score("ARAT", day, 30), author="ana")
    removed = remove(database, "P01", "arat", "2026-03-01", author="ben")
    assert removed == Score("ARAT", "2026-03-01", 30.0)
    assert [each.date for each in scores_of(database, "P01")] == ["2026-04-01"]
    log = database.execute(
        "SELECT recorded_by, removed FROM instrument_scores WHERE date='2026-03-01'"
    ).fetchall()
    assert log == [("ana", 0), ("ben", 1)]
    with pytest.raises(StoreError, match="P01 has no score of ARAT on 2026-03-01") as refused:
        remove(database, "P01", "ARAT", "2026-03-01", author="ben")
    assert refused.value.bad_input
    add(database, "P01", Score("ARAT", "2026-03-01", 31), author="ana")
    assert [each.score for each in scores_of(database, "P01")] == [31, 30]


@pytest.mark.parametrize(
    ("score", "says"),
    [
        (Score("FIM", "2026-03-01", 1), "There is no instrument FIM. Choose one of: FMA-UE, ARAT,"),
        (Score("ARAT", "2026-03-01", 58), "A score of ARAT lies between 0 and 57, not at 58."),
        (Score("GAS", "2026-03-01", float("nan")), "lies between -2 and 2"),
        (Score("ARAT", "1 March", 5), "The date must be one such as 2026-03-01, not '1 March'."),
        (Score("ARAT", "9999-01-01", 5), "The date 9999-01-01 is in the future."),
        (
            Score("ARAT", "2026-03-01", 5, "x" * 2001),
            "The note is too long: at most 2000 characters.",
        ),
        (Score("ARAT", "2026-03-01", 5, "\x1b[2J"), "The note has control characters"),
    ],
)
def test_what_cannot_be_is_refused(database: sqlite3.Connection, score: Score, says: str) -> None:
    with pytest.raises(StoreError, match=says.replace("'", ".").replace("[", ".")) as refused:
        add(database, "P01", score, author="ana")
    assert refused.value.bad_input
    assert scores_of(database, "P01") == []
