"""``sar-tui site``: the code of the site, shown and set."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tests.program import Call


def test_a_site_gets_a_code_in_capitals(call: Call, simulated: str) -> None:
    assert "no code" in call("site").out
    assert "belongs to the site BERN" in call("site", " bern ").out
    assert call("site --json").json == {"site": "BERN"}
    assert call("site BASEL-1").out.splitlines()[1].startswith("It was BERN")


@pytest.mark.parametrize("code", ["", "two words", "P@B", "-A", "A" * 17])
def test_a_code_that_is_none_is_refused(call: Call, code: str) -> None:
    call("site --", code).refused("A site's code has 1 to 16 letters")


def test_a_code_that_others_may_know_stays(call: Call, simulated: str, data: Path) -> None:
    call("site BERN")
    with closing(sqlite3.connect(data / "sar-tui.db", isolation_level=None)) as database:
        names = "exported_at, exported_by, recipient, format, sessions, options, manifest"
        row = ("", "", "", "parquet", "[]", "{}", "")
        database.execute(f"INSERT INTO exports ({names}) VALUES (?, ?, ?, ?, ?, ?, ?)", row)
    call("site BASEL").refused("data was exported under this code")
    assert call("site bern").code == 0


def test_sessions_are_exported_with_their_site(call: Call, simulated: str, tmp_path: Path) -> None:
    call("site BERN")
    assert call("export", simulated, "--simulated", "--to", tmp_path / "out").code == 0
    head, row = (tmp_path / "out" / "sessions.csv").read_text(encoding="utf-8").splitlines()
    assert dict(zip(head.split(","), row.split(","), strict=False))["site"] == "BERN"
