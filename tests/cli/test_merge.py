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
    called = call("merge", bern / "sar-tui.db")
    assert (called.code, called.err) == (0, "")
    assert called.out.startswith("From BERN: 2 new sessions.\nAs it was before: ")
    rows = call("sessions --json").json["sessions"]
    assert sorted((row["participant"], row["site"]) for row in rows) == [
        ("P01", "ZURICH"), ("P01@BERN", "BERN"), ("P01@BERN", "BERN"),
    ]  # fmt: skip
    assert len(call("sessions -p P01 --json").json["sessions"]) == 1
    assert call("check").code == 0
    assert call("merge", bern).out == "From BERN: nothing that this database did not have.\n"
    if os.name == "posix":
        backups = list((zurich / "backups").iterdir())
        assert [
            stat.S_IMODE(path.stat().st_mode) for path in (zurich / "sar-tui.db", *backups)
        ] == [0o600] * 2


def test_a_session_that_was_merged_is_shown_replayed_and_exported(
    call: Call, bern: Path, tmp_path: Path
) -> None:
    there = {row["id"] for row in call("sessions --data", bern, "--json").json["sessions"]}
    call("merge", bern)
    for session in there:
        here = call("show", session, "--json").json
        original = call("show", session, "--json", "--data", bern).json
        assert [here[name] for name in ("attempts", "trials")] == [
            original[name] for name in ("attempts", "trials")
        ]
        assert "P01@BERN" in call("show", session).out
        assert call("replay", session, "--json").json["identical"]
    assert call("progress p01@bern").out.startswith("P01@BERN · ")
    to = tmp_path / "out"
    assert call("export -p P01@BERN --simulated --to", to).code == 0
    with (to / "sessions.csv").open(encoding="utf-8", newline="") as file:
        assert {(row["participant"], row["site"]) for row in csv.DictReader(file)} == {
            ("P01@BERN", "BERN")
        }
    recoded = tmp_path / "recoded"
    assert call("export --all --mixed --recode", tmp_path / "map.csv", "--to", recoded).code == 0
    texts = [path.read_text(encoding="utf-8") for path in recoded.glob("*.csv")]
    assert not any("P01" in text for text in texts)


def test_what_another_site_recorded_is_changed_only_there(
    call: Call, zurich: Path, bern: Path
) -> None:
    play(bern, "abcdef0123", status="interrupted")
    with closing(connect(bern)) as database:
        entered = event(database, "P01", "2026-01-01", what="fell", severity="mild").id
    assert call("merge", bern).code == 0
    for command in (
        ("run", "keyboard", "-p", "P01@BERN"),
        ("resume", "abcdef0123"),
        ("programme", "import", "P01@BERN", "keyboard", "--preset", "mild", "--reason", "rested"),
        ("record", "add", "adverse-event", "P01@BERN", "what=fell", "severity=mild"),
        ("record", "add", "FMA-UE", "P01@BERN", "score=34", "--on", "2026-01-01"),
        ("record", "correct", f"{entered}@BERN", "outcome=well"),
        ("simulate", "keyboard", "--user", "average", "-p", "P01@BERN"),
    ):
        called = call(*command)
        assert (called.code, called.out) == (2, ""), command
        assert "BERN" in called.err, command
        assert "only there" in called.err, command
    assert "no interrupted session" in call("resume", "last").err
    assert f"{entered}@BERN" in call("record", "list").out


def test_a_session_that_runs_is_left_out_and_named(call: Call, zurich: Path, bern: Path) -> None:
    play(bern, "abcdef0123", status="running")
    held = locks.hold(bern, "session", "abcdef0123")
    called = call("merge", bern)
    held.release()
    assert called.code == 1
    assert "! Session abcdef0123 is running there" in called.out
    assert len(call("sessions --json").json["sessions"]) == 3
    assert call("check").code == 0
    assert call("merge", bern).out.startswith("From BERN: 1 new session")


def test_a_record_that_only_this_site_could_have_written_is_named_and_left_out(
    call: Call, zurich: Path, bern: Path
) -> None:
    with closing(connect(bern)) as database:
        database.execute(
            "INSERT INTO programmes (participant, task, version, created_at, author, reason, "
            "parameters, theme, site)"
            " VALUES "
            "('P01@ZURICH','keyboard',1,'2026-01-01','','','{\"attempts\":99}','calm',"
            "'ZURICH')"
        )
    called = call("merge", bern)
    assert called.code == 1
    said = (
        "The version 1 of the programme of P01 for keyboard is ZURICH's by what BERN has, and "
        "is not so here."
    )
    assert f"! {said} It is left out.\n" in called.out
    assert called.out.startswith("From BERN: 2 new sessions.")
    with closing(connect(zurich)) as database:
        assert database.execute("SELECT * FROM programmes").fetchall() == []
    assert call("merge", bern, "--json").json["refused"] == [f"{said} It is left out."]


def test_nothing_is_merged_while_a_session_runs_here(call: Call, zurich: Path, bern: Path) -> None:
    play(zurich, "abcdef0123", status="running")
    held = locks.hold(zurich, "session", "abcdef0123")
    called = call("merge", bern)
    held.release()
    assert (called.code, called.out) == (1, "")
    assert "Session abcdef0123 is running here" in called.err


def test_rescue_files_of_the_other_folder_are_named(call: Call, zurich: Path, bern: Path) -> None:
    (bern / "sar-tui-rescue-abcdef0123.db").touch()
    called = call("merge", bern)
    assert called.code == 1
    assert f"! {bern / 'sar-tui-rescue-abcdef0123.db'} holds data" in called.out


def test_a_database_that_cannot_be_merged_is_refused_in_a_sentence(
    call: Call, zurich: Path, bern: Path, tmp_path: Path
) -> None:
    text = tmp_path / "text.db"
    text.write_text("no database\n" * 100)
    nameless = tmp_path / "nameless"
    play(nameless, "abcdef0123")
    other = tmp_path / "other.db"
    sqlite3.connect(other).execute("CREATE TABLE t (x)").connection.close()
    damaged = copy(bern, tmp_path / "damaged")
    with closing(connect(damaged)) as database:
        database.execute("UPDATE trials SET details='{' WHERE rowid=1")
    before = (zurich / "sar-tui.db").read_bytes()
    for path, said in (
        (text, "is no database of sar-tui"),
        (other, "is no database of sar-tui"),
        (tmp_path / "none.db", "There is no database"),
        (nameless, "has no code of its site"),
        (damaged, "is damaged"),
        (zurich, "is this database itself"),
    ):
        called = call("merge", path)
        assert (called.code, called.out) == (2, ""), path
        assert said in called.err
        assert called.err.count("\n") == 1
    assert "are of one site" in call("merge", bern, "--same", "P01=P02").err
    assert "takes two codes" in call("merge", bern, "--same", "P01").err
    assert (
        "would be the same person"
        in call("merge", bern, "--same", "P01@BERN=P01", "--same", "P02@BERN=P01").err
    )
    assert (zurich / "sar-tui.db").read_bytes() == before
    assert not list(zurich.glob(".merge-*"))


def test_a_site_without_a_code_is_asked_for_one(call: Call, tmp_path: Path) -> None:
    call("sessions")
    called = call("merge", site(tmp_path / "bern", "BERN"))
    assert (called.code, called.out) == (2, "")
    assert "sar-tui site BERN" in called.err


def test_two_databases_of_one_site_are_merged_only_if_that_is_said(
    call: Call, zurich: Path, tmp_path: Path
) -> None:
    laptop = site(tmp_path / "laptop", "ZURICH")
    play(laptop, "abcdef0123")
    assert "add --one-site" in call("merge", laptop).err
    assert call("merge", laptop, "--one-site").code == 0
    assert len(call("sessions -p P01 --json").json["sessions"]) == 2
    assert (
        "leave out --one-site" in call("merge", site(tmp_path / "basel", "BASEL"), "--one-site").err
    )


def test_the_other_database_is_only_read(call: Call, zurich: Path, bern: Path) -> None:
    def files() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in bern.iterdir() if path.is_file()}

    before = files()
    call("merge", bern)
    assert files() == before


def test_the_code_of_a_site_stays_once_data_was_merged(
    call: Call, zurich: Path, bern: Path
) -> None:
    call("merge", bern)
    called = call("site GENF")
    assert called.code == 2
    assert "data of other sites was merged" in called.err


def test_a_person_with_two_codes_is_listed(call: Call, zurich: Path, bern: Path) -> None:
    assert call("merge --same p01@bern=P01").out.splitlines()[-1] == "P01@BERN is P01@ZURICH."
    call("merge", bern)
    assert len(call("sessions -p P01 --json").json["sessions"]) == 3
    assert call("merge --json").json["same"] == [["P01@BERN", "P01@ZURICH"]]


def test_without_another_database_it_says_so_if_there_is_nothing_to_list(
    call: Call, zurich: Path
) -> None:
    assert call("merge") == (0, "Nothing contradicts, and nobody has two codes.\n", "")


def test_of_a_person_with_two_codes_the_other_one_is_told(
    call: Call, bern: Path, tmp_path: Path
) -> None:
    call("merge", bern, "--same", "P01@BERN=P01")
    assert len(call("sessions -p P01 --json").json["sessions"]) == 3
    assert call("sessions -p P01@BERN").out == "P01@BERN is P01 here: sar-tui sessions -p P01\n"
    refused = call("export -p P01@BERN --simulated --to", tmp_path / "out")
    assert (refused.code, refused.err) == (
        2,
        "P01@BERN is P01 here: ask for the sessions of P01.\n",
    )
