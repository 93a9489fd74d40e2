"""Participants are stored as codes, with their saved settings."""

import re
from pathlib import Path
from sqlite3 import Connection

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.store import programmes, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.participants import add, check_code, codes, last_task, last_used
from sar_tui.store.programmes import Programme
from tests.store.test_sessions import enter


@pytest.mark.parametrize(
    ("typed", "kept"),
    [
        ("P01", "P01"),
        ("p01", "P01"),
        (" p-1_x ", "P-1_X"),
        (" p01@bern-2 ", "P01@BERN-2"),
        ("7", "7"),
        ("a" * 32, "A" * 32),
    ],
)
def test_a_code_is_stored_in_capitals(typed: str, kept: str) -> None:
    assert check_code(typed) == kept


@pytest.mark.parametrize("code", ["", " ", "Anna Berg", "-1", "_x", "a" * 33, "p/1", "../p", "P01\n2",
                                  "é1", "P.1", "ß1", "ı1", "ﬁ",
                                  "P01@", "@BERN", "P01@BERN@X", "P01@" + "B" * 17, "P01@-"])  # fmt: skip
def test_an_invalid_code_is_refused_with_a_warning_against_names(code: str) -> None:
    with pytest.raises(StoreError, match="Never use a name") as caught:
        check_code(code)
    assert caught.value.bad_input


@given(st.text(max_size=40))
def test_a_code_that_is_unsafe_as_a_file_name_is_refused(code: str) -> None:
    try:
        kept = check_code(code)
    except StoreError:
        return
    assert re.fullmatch("[A-Z0-9][A-Z0-9_-]{0,31}(@[A-Z0-9][A-Z0-9-]{0,15})?", kept)
    assert check_code(kept) == kept


def test_someone_entered_twice_is_one_participant(database: Connection, data: Path) -> None:
    assert [add(database, code) for code in ("p02", "P02", "P01")] == ["P02", "P02", "P01"]
    assert codes(database) == codes(connect(data)) == ["P01", "P02"]


def test_a_disk_that_refuses_someone_is_reported(database: Connection) -> None:
    database.execute("PRAGMA query_only=1")
    with pytest.raises(StoreError, match="is read-only"):
        add(database, "P01")
    assert codes(database) == []


def test_the_one_used_last_is_of_the_last_live_run(database: Connection) -> None:
    assert last_used(database) is None
    first, second = enter(database, "P01"), enter(database, "P02", partner="P09")
    simulated = enter(database, "P03", mode="simulated")
    for session, expected in ((first, "P01"), (second, "P02"), (simulated, "P02"), (first, "P01")):
        sessions.begin_run(database, session, software={}, machine={})
        assert last_used(database) == expected


def test_the_last_task_is_of_the_newest_live_session_or_programme(database: Connection) -> None:
    add(database, "P01")
    assert last_task(database, "P01") is None
    programmes.save(database, "P01", "reaching", Programme(), after=0)
    assert last_task(database, "P01") == "reaching"
    for task, mode in (("pairs", "live"), ("keyboard", "live"), ("reaching", "simulated")):
        enter(database, "P01", task=task, mode=mode)
    assert last_task(database, "P01") == "keyboard"
