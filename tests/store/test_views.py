"""The views of attempts, trials and reaches have what the tables have, a row each."""

import json
import re
import sqlite3
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import schema, sites

ATTEMPT = ("practice", "level", "goal", "outcome")
PAGE = (Path(__file__).parents[2] / "docs" / "data-dictionary.md").read_text(encoding="utf-8")


def rows(database: sqlite3.Connection, query: str, *values: object) -> list[dict[str, Any]]:
    found = database.execute(query, values)
    names = [name for name, *_ in found.description]
    return [dict(zip(names, row, strict=True)) for row in found]


def common(row: dict[str, Any], other: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return of two rows the columns that both have."""
    both = row.keys() & other.keys()
    return {name: row[name] for name in both}, {name: other[name] for name in both}


@pytest.fixture
def keyboard_session(database: sqlite3.Connection, data: Path, catalogue: Catalogue) -> str:
    settings = {"attempts": 3, "practice_attempts": 1, "prompts_per_attempt": 4}
    plan = make_plan(catalogue, "keyboard", ["P01"], settings, seed=3, mode="simulated")
    return simulate(plan, PEOPLE["poor"], data, catalogue)


def test_each_attempt_and_trial_is_a_row_with_what_the_tables_hold(
    database: sqlite3.Connection, keyboard_session: str
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
        assert [row[name] for name in ATTEMPT] == [
            attempts[row["attempt"]][name] for name in ATTEMPT
        ]


def test_times_are_those_of_the_day(database: sqlite3.Connection, keyboard_session: str) -> None:
    noon = datetime.fromisoformat("2026-03-01T12:00:00.5+00:00")
    (first,) = database.execute("SELECT min(onset_ns) FROM trials").fetchone()
    anchor = json.dumps({"clock_ns": first + 10**10, "utc": noon.isoformat()})
    database.execute("UPDATE runs SET clock_anchor=?", (anchor,))
    onsets = database.execute("SELECT onset_ns FROM trials ORDER BY rowid").fetchall()
    for row, (onset,) in zip(rows(database, "SELECT * FROM v_trials"), onsets, strict=True):
        real = noon + timedelta(microseconds=(onset - first - 10**10) / 1000)
        assert abs(datetime.fromisoformat(row["started_at"]) - real) <= timedelta(milliseconds=1)


def test_the_site_is_the_rows_own_or_that_of_the_database(
    database: sqlite3.Connection, keyboard_session: str
) -> None:
    assert database.execute("SELECT DISTINCT site FROM v_trials").fetchall() == [("",)]
    sites.set_own(database, "bern")
    assert database.execute("SELECT DISTINCT site FROM v_attempts").fetchall() == [("BERN",)]
    database.execute("UPDATE sessions SET site='BASEL'")
    assert database.execute("SELECT DISTINCT site FROM v_trials").fetchall() == [("BASEL",)]
    assert sites.of_session(database, keyboard_session) == "BASEL"


@pytest.mark.usefixtures("fewer_blocks")
def test_each_reach_is_a_row_with_its_measures(
    database: sqlite3.Connection, data: Path, catalogue: Catalogue
) -> None:
    plan = make_plan(
        catalogue, "reaching", ["P01"],
        {"attempts": 1, "practice_attempts": 0, "reaches_per_attempt": 3}, seed=3, mode="simulated",
    )  # fmt: skip
    simulate(plan, PEOPLE["average"], data, catalogue)
    seen = rows(database, "SELECT * FROM v_reaches ORDER BY trial")
    stored = rows(database, "SELECT trial, details FROM trials WHERE correct ORDER BY trial")
    assert [row["trial"] for row in seen] == [row["trial"] for row in stored]
    assert len(seen) >= 2
    for row, trial in zip(seen, stored, strict=True):
        shown, details = common(row, json.loads(trial["details"]))
        assert shown == details
        assert shown.keys() >= {
            "reach_time_ms",
            "sparc",
            "excursion_deg",
            "tremor_action_rad_s",
            "hand",
        }


def test_the_data_dictionary_names_every_column(database: sqlite3.Connection) -> None:
    named = set(re.findall(r"`(\w+)`", PAGE.partition("## Views")[2].partition("\n## ")[0]))
    for view in ("v_attempts", "v_trials", "v_reaches"):
        assert {
            name for _, name, *_ in database.execute(f"PRAGMA table_info({view})")
        } - named == set()


def test_old_versions_of_sqlite_can_read_them() -> None:
    assert "->" not in " ".join(schema.VIEWS.values())
