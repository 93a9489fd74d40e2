"""``sar-tui merge``: sessions of another site are shown, replayed and exported here, and changed
only there.
"""

import csv
import os
import sqlite3
import stat
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store import locks
from sar_tui.store.database import connect
from tests.program import Call
from tests.recorded import event
from tests.store.merge.sites import copy, play, site


@pytest.fixture
def zurich(call: Call, tmp_path: Path) -> Path:
    """The data folder that ``call`` uses, with a simulated session of P01."""
    call("simulate keyboard --user average --seed 2 --attempts 3 -p P01")
    call("site ZURICH")
    return tmp_path / "data"


@pytest.fixture
def bern(call: Call, tmp_path: Path, zurich: Path) -> Path:
    """Another folder, with two simulated sessions of its own P01, one of pairs who are called by
    their codes.
    """
    folder = tmp_path / "bern"
    call("simulate keyboard --user poor --attempts 4 -p P01 --seed 1 --data", folder)
    call("simulate pairs --user average --attempts 1 -p P01 -p P02 --data", folder,
         "--set", "address=code")  # fmt: skip
    call("site BERN --data", folder)
    return folder


def test_sessions_of_both_are_listed_and_those_of_a_code_stay_apart(
    call: Call, zurich: Path, bern: Path
) -> None:
    call("merge", bern / "sar-tui.db").shows("From BERN: 2 new sessions.\nAs it was before: ")
    rows = call("sessions --json").json["sessions"]
    codes = sorted((row["participant"], row["site"]) for row in rows)
    assert codes == [("P01", "ZURICH"), ("P01@BERN", "BERN"), ("P01@BERN", "BERN")]
    assert len(call("sessions -p P01 --json").json["sessions"]) == 1
    assert call("check").code == 0
    call("merge", bern).shows("From BERN: nothing that this database did not have.")
    if os.name == "posix":
        kept = [zurich / "sar-tui.db", *(zurich / "backups").iterdir()]
        assert [stat.S_IMODE(path.stat().st_mode) for path in kept] == [0o600] * 2


def test_a_session_that_was_merged_is_shown_replayed_and_exported(
    call: Call, bern: Path, tmp_path: Path
) -> None:
    there = {row["id"] for row in call("sessions --data", bern, "--json").json["sessions"]}
    call("merge", bern)
    for session in there:
        here = call("show", session, "--json").json
        original = call("show", session, "--json", "--data", bern).json
        assert all(here[name] == original[name] for name in ("attempts", "trials"))
        call("show", session).shows("P01@BERN")
        assert call("replay", session, "--json").json["identical"]
    assert call("progress p01@bern").out.startswith("P01@BERN · ")
    to, recoded = tmp_path / "out", tmp_path / "recoded"
    assert call("export -p P01@BERN --simulated --to", to).code == 0
    with (to / "sessions.csv").open(encoding="utf-8", newline="") as file:
        exported = {(row["participant"], row["site"]) for row in csv.DictReader(file)}
    assert exported == {("P01@BERN", "BERN")}
    assert call("export --all --mixed --recode", tmp_path / "map.csv", "--to", recoded).code == 0
    assert not [path for path in recoded.glob("*.csv") if "P01" in path.read_text("utf-8")]


def test_what_another_site_recorded_is_changed_only_there(
    call: Call, zurich: Path, bern: Path
) -> None:
    play(bern, "abcdef0123", status="interrupted")
    with closing(connect(bern)) as database:
        entered = event(database, "P01", "2026-01-01", what="fell", severity="mild").id
    assert call("merge", bern).code == 0
    for command in (
        "run keyboard -p P01@BERN",
        "resume abcdef0123",
        "programme import P01@BERN keyboard --preset mild --reason rested",
        "record add adverse-event P01@BERN what=fell severity=mild",
        "record add FMA-UE P01@BERN score=34 --on 2026-01-01",
        f"record correct {entered}@BERN outcome=well",
        "simulate keyboard --user average -p P01@BERN",
    ):
        call(command).refused("BERN", "only there")
    assert "no interrupted session" in call("resume last").err
    call("record list").shows(f"{entered}@BERN")


def test_what_is_left_out_is_named(call: Call, zurich: Path, bern: Path) -> None:
    """A session that runs, a rescue file, and a record that only this site could have written."""
    play(bern, "abcdef0123", status="running")
    file = bern / "sar-tui-rescue-abcdef0123.db"
    file.touch()
    with closing(connect(bern)) as database:
        database.execute(
            "INSERT INTO programmes (participant, task, version, created_at, author, reason, "
            "parameters, theme, site) VALUES ('P01@ZURICH', 'keyboard', 1, '2026-01-01', '', '', "
            "'{\"attempts\":99}', 'calm', 'ZURICH')"
        )
    held = locks.hold(bern, "session", "abcdef0123")
    called = call("merge", bern)
    held.release()
    said = "The version 1 of the programme of P01 for keyboard is ZURICH's by what BERN has"
    called.shows("! Session abcdef0123 is running there", f"! {file} holds data", code=1)
    called.shows(
        "From BERN: 2 new sessions, 1 participant.", f"! {said}", "It is left out.", code=1
    )
    assert len(call("sessions --json").json["sessions"]) == 3
    with closing(connect(zurich)) as database:
        assert database.execute("SELECT * FROM programmes").fetchall() == []
    assert call("check").code == 0
    again = call("merge", bern, "--json").json
    assert again["refused"][0].startswith(said)
    assert len(call("sessions --json").json["sessions"]) == 4


def test_a_database_that_cannot_be_merged_is_refused_in_a_sentence(
    call: Call, zurich: Path, bern: Path, tmp_path: Path
) -> None:
    text, other = tmp_path / "text.db", tmp_path / "other.db"
    text.write_text("no database\n" * 100)
    sqlite3.connect(other).execute("CREATE TABLE t (x)").connection.close()
    play(tmp_path / "nameless", "abcdef0123")
    damaged = copy(bern, tmp_path / "damaged")
    with closing(connect(damaged)) as database:
        database.execute("UPDATE trials SET details='{' WHERE rowid=1")
    laptop, basel = site(tmp_path / "laptop", "ZURICH"), site(tmp_path / "basel", "BASEL")
    play(laptop, "abcdef0123")
    before = (zurich / "sar-tui.db").read_bytes()
    for words, said in (
        ((text,), "is no database of sar-tui"),
        ((other,), "is no database of sar-tui"),
        ((tmp_path / "none.db",), "There is no database"),
        ((tmp_path / "nameless",), "has no code of its site"),
        ((damaged,), "is damaged"),
        ((zurich,), "is this database itself"),
        ((laptop,), "add --one-site"),
        ((basel, "--one-site"), "leave out --one-site"),
        ((basel, "--data", tmp_path / "nameless"), "Set it first, such as: sar-tui site BERN"),
        ((bern, "--same", "P01=P02"), "are of one site"),
        ((bern, "--same", "P01"), "takes two codes"),
        ((bern, "--same", "P01@BERN=P01", "--same", "P02@BERN=P01"), "would be the same person"),
    ):
        called = call("merge", *words)
        called.refused(said)
        assert called.err.count("\n") == 1
    assert (zurich / "sar-tui.db").read_bytes() == before
    play(zurich, "0123abcdef", status="running")
    held = locks.hold(zurich, "session", "0123abcdef")
    call("merge", bern).refused("Session 0123abcdef is running here", code=1)
    held.release()
    assert len(call("sessions --json").json["sessions"]) == 2
    assert not list(zurich.glob(".merge-*"))
    assert call("merge", laptop, "--one-site").code == 0
    assert len(call("sessions -p P01 --json").json["sessions"]) == 3


@pytest.mark.usefixtures("zurich")
def test_the_other_database_is_only_read(call: Call, bern: Path) -> None:
    def files() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in bern.iterdir() if path.is_file()}

    before = files()
    call("merge", bern)
    assert files() == before
    call("site GENF").refused("data of other sites was merged")


@pytest.mark.usefixtures("zurich")
def test_a_person_with_two_codes_is_listed_and_the_other_code_told(
    call: Call, bern: Path, tmp_path: Path
) -> None:
    call("merge").shows("Nothing contradicts, and nobody has two codes.")
    assert call("merge --same p01@bern=P01").out.splitlines()[-1] == "P01@BERN is P01@ZURICH."
    call("merge", bern)
    assert len(call("sessions -p P01 --json").json["sessions"]) == 3
    assert call("merge --json").json["same"] == [["P01@BERN", "P01@ZURICH"]]
    call("sessions -p P01@BERN").shows("P01@BERN is P01 here: sar-tui sessions -p P01\n")
    refused = call("export -p P01@BERN --simulated --to", tmp_path / "out")
    refused.refused("P01@BERN is P01 here: ask for the sessions of P01.")


def test_a_site_gets_a_code_in_capitals(call: Call, simulated: str) -> None:
    assert "no code" in call("site").out
    assert "belongs to the site BERN" in call("site", " bern ").out
    assert call("site --json").json == {"site": "BERN"}
    assert call("site BASEL-1").out.splitlines()[1].startswith("It was BERN")
    for code in ("", "two words", "P@B", "-A", "A" * 17):
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
