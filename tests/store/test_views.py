"""The views of attempts, trials and reaches have what the tables have, a row each."""

import json
import re
from datetime import datetime, timedelta
from pathlib import Path
from sqlite3 import Connection
from typing import Any

import pytest

from sar_tui.store import sites
from tests.played import simulated
from tests.store.by_hand import sql, value

PAGE = (Path(__file__).parents[2] / "docs" / "data-dictionary.md").read_text(encoding="utf-8")


def rows(database: Connection, query: str, *values: object) -> list[dict[str, Any]]:
    found = database.execute(query, values)
    names = [name for name, *_ in found.description]
    return [dict(zip(names, row, strict=True)) for row in found]


def common(row: dict[str, Any], other: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return of two rows the columns that both have."""
    both = row.keys() & other.keys()
    return {name: row[name] for name in both}, {name: other[name] for name in both}


@pytest.fixture
def keyboard_session(data: Path) -> str:
    return simulated(data, user="poor", attempts=3, practice_attempts=1, prompts_per_attempt=4)


def test_each_attempt_and_trial_is_a_row_of_views(
    database: Connection, keyboard_session: str
) -> None:
    attempts = {row["attempt"]: row for row in rows(database, "SELECT * FROM attempts")}
    seen = rows(database, "SELECT * FROM v_attempts")
    assert [row["practice"] for row in seen] == [1, 0, 0, 0]
    for row in seen:
        shown, stored = common(row, attempts[row["attempt"]])
        assert shown == stored
        assert shown.keys() >= {"session", "seat", "level", "goal", "metric", "outcome"}
        assert (row["participant"], row["task"], row["mode"]) == ("P01", "keyboard", "simulated")
    trials = rows(database, "SELECT * FROM trials ORDER BY rowid")
    for row, trial in zip(rows(database, "SELECT * FROM v_trials"), trials, strict=True):
        shown, stored = common(row, trial)
        assert shown == stored
        assert shown.keys() >= {"session", "trial", "stimulus", "response", "reaction_time_ms"}
        for name in ("practice", "level", "goal", "outcome"):
            assert row[name] == attempts[row["attempt"]][name]


def test_times_are_those_of_the_day(database: Connection, keyboard_session: str) -> None:
    noon = datetime.fromisoformat("2026-03-01T12:00:00.5+00:00")
    first = value(database, "SELECT min(onset_ns) FROM trials")
    anchor = json.dumps({"clock_ns": first + 10**10, "utc": noon.isoformat()})
    sql(database, "UPDATE runs SET clock_anchor=?", anchor)
    onsets = sql(database, "SELECT onset_ns FROM trials ORDER BY rowid")
    for row, (onset,) in zip(rows(database, "SELECT * FROM v_trials"), onsets, strict=True):
        real = noon + timedelta(microseconds=(onset - first - 10**10) / 1000)
        assert abs(datetime.fromisoformat(row["started_at"]) - real) <= timedelta(milliseconds=1)


def test_the_site_is_the_rows_or_the_databases(database: Connection, keyboard_session: str) -> None:
    assert sql(database, "SELECT DISTINCT site FROM v_trials") == [("",)]
    sites.set_own(database, "bern")
    assert sql(database, "SELECT DISTINCT site FROM v_attempts") == [("BERN",)]
    sql(database, "UPDATE sessions SET site='BASEL'")
    assert sql(database, "SELECT DISTINCT site FROM v_trials") == [("BASEL",)]
    assert sites.of_session(database, keyboard_session) == "BASEL"


@pytest.mark.usefixtures("fewer_blocks")
def test_each_reach_is_a_row(database: Connection, data: Path) -> None:
    simulated(data, "reaching", attempts=1, practice_attempts=0, reaches_per_attempt=3)
    seen = rows(database, "SELECT * FROM v_reaches ORDER BY trial")
    stored = rows(database, "SELECT trial, details FROM trials WHERE correct ORDER BY trial")
    assert [row["trial"] for row in seen] == [row["trial"] for row in stored]
    assert len(seen) >= 2
    for row, trial in zip(seen, stored, strict=True):
        shown, details = common(row, json.loads(trial["details"]))
        assert shown == details
        measures = "reach_time_ms sparc excursion_deg tremor_action_rad_s hand"
        assert shown.keys() >= set(measures.split())


def test_the_data_dictionary_names_every_column(database: Connection) -> None:
    named = set(re.findall(r"`(\w+)`", PAGE.partition("## Views")[2].partition("\n## ")[0]))
    for view in ("v_attempts", "v_trials", "v_reaches"):
        columns = {name for _, name, *_ in sql(database, f"PRAGMA table_info({view})")}
        assert columns - named == set()
