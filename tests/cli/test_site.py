"""``sar-tui site``: the code of the site, shown and set."""

import sqlite3
from contextlib import closing
from pathlib import Path

from tests.program import Call


def test_a_site_gets_a_code_in_capitals(call: Call, simulated: str) -> None:
    assert "no code" in call("site").out
    assert "belongs to the site BERN" in call("site", " bern ").out
    assert call("site --json").json == {"site": "BERN"}
    assert call("site BASEL-1").out.splitlines()[1].startswith("It was BERN")


def test_a_code_that_is_none_is_refused(call: Call) -> None:
    for code in ("", "two words", "P@B", "-A", "A" * 17):
        called = call("site --", code)
        assert (called.code, called.out) == (2, "")
        assert called.err.startswith("A site's code has 1 to 16 letters")


def test_a_code_that_others_may_know_stays(call: Call, simulated: str, tmp_path: Path) -> None:
    call("site BERN")
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database:
        database.execute(
            "INSERT INTO exports (exported_at, exported_by, recipient, format, sessions, options, "
            "manifest)"
            " VALUES ('', '', '', 'parquet', '[]', '{}', '')"
        )
        database.commit()
    called = call("site BASEL")
    assert (called.code, called.out) == (2, "")
    assert "data was exported under this code" in called.err
    assert call("site bern").code == 0


def test_sessions_are_exported_with_their_site(call: Call, simulated: str, tmp_path: Path) -> None:
    call("site BERN")
    assert call("export", simulated, "--simulated", "--to", tmp_path / "out").code == 0
    head, row = (tmp_path / "out" / "sessions.csv").read_text(encoding="utf-8").splitlines()
    assert dict(zip(head.split(","), row.split(","), strict=False))["site"] == "BERN"
