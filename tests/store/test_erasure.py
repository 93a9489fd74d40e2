"""Data that is erased is in no file of the data folder; a partner's part stays, and all is whole."""

import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.loop.topics import PROMPT, TRIAL
from sar_tui.replay.replay import replay
from sar_tui.store import messages, participants, people_events, sessions, sites
from sar_tui.store.database import FILE, StoreError, connect
from sar_tui.store.erasure import Done, de_identify, erase
from sar_tui.store.integrity import flaws
from sar_tui.store.locks import hold
from sar_tui.store.merge.merge import merge
from sar_tui.store.rescue import bring_back
from sar_tui.store.tables import FIRST_VERSION, TABLES
from tests.played import catalogue, simulated
from tests.recorded import score
from tests.store.by_hand import sql, value
from tests.store.persons import CANARY, copies, fill, holding, played

PAIRS = {"attempts": 2, "prompts_per_attempt": 4}


def erased(folder: Path, code: str = "P07") -> Done:
    return erase(folder, code, author="ana", reason="asked for it")


def found(folder: Path) -> list[str]:
    with closing(connect(folder)) as database:
        return [f"{flaw.where}: {flaw.what}" for flaw in flaws(database)]


def contents(folder: Path) -> dict[str, bytes]:
    """Return the bytes of all databases and logs; not of what SQLite shares in memory."""
    paths = [*folder.rglob("*.db"), *folder.rglob("*.db-wal")]
    return {str(path): path.read_bytes() for path in paths}


def test_nothing_of_a_person_is_left_in_any_file(data: Path) -> None:
    ids = fill(data)
    fill(data, "P08", "KEPT")
    made = copies(data)
    page = data / "progress-P07-keyboard-1.html"
    others = [data / f"progress-{who}-keyboard.html" for who in ("P07-X", "P070", "P07-2", "P0")]
    for path in (page, *others):
        path.write_bytes(CANARY if path == page else b"KEPT")
    assert {FILE, *(path.relative_to(data).as_posix() for path in made)} <= set(holding(data))
    done = erased(data)
    assert holding(data) == []
    assert done.deleted == [str(page)]
    assert all(path.exists() for path in others)
    assert done.refused == []
    assert sorted(done.rewritten) == sorted(map(str, made))
    assert sorted(done.event.details.sessions) == sorted(ids)
    assert set(holding(data, b"KEPT-NOTE")) == {
        FILE, *(path.relative_to(data).as_posix() for path in made)
    }  # fmt: skip
    assert found(data) == []
    for path in made:
        with closing(sqlite3.connect(path)) as backup:
            assert backup.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
            assert backup.execute(
                "SELECT event FROM people_events WHERE participant='P07'"
            ).fetchall()
    again = erased(data)
    assert again.event.id == done.event.id
    assert again.sessions == 0


READER = """
import sqlite3, sys
database = sqlite3.connect(sys.argv[1], isolation_level=None)
database.execute("BEGIN")
database.execute("SELECT count(*) FROM sessions").fetchone()
print("reads", flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize("idle", [False, True])
def test_it_is_refused_while_another_program_reads(data: Path, idle: bool) -> None:
    fill(data)
    copies(data)
    code = READER.replace('database.execute("BEGIN")\n', "") if idle else READER
    reader = subprocess.Popen(
        [sys.executable, "-c", code, str(data / FILE)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert reader.stdout
    assert reader.stdout.readline()
    with closing(connect(data)) as database:
        participants.add(database, "P09")  # so that something is in the log
    before = contents(data)
    with pytest.raises(StoreError, match=r"Another program has .* open"):
        erased(data)
    assert contents(data) == before
    assert len(holding(data)) >= 5
    reader.communicate("")
    erased(data)
    assert holding(data) == []


def test_it_is_refused_while_a_session_of_the_person_runs(data: Path) -> None:
    fill(data)
    with (
        hold(data, "participant", "P07"),
        pytest.raises(StoreError, match="P07 is in a live session"),
    ):
        erased(data)
    assert holding(data)


def test_the_part_of_the_partner_stays_and_all_is_whole(data: Path) -> None:
    for code in ("P07", "P08"):
        with closing(connect(data)) as database:
            participants.add(database, code)
    for codes in (("P07", "P08"), ("P08", "P07")):
        session = played(data, "pairs", *codes, word="CANARY", **PAIRS)
        seat = "AB"[codes.index("P07")]
        with closing(connect(data)) as database:
            other = "AB"[codes.index("P08")]
            before = kept(database, session, other)
            assert kept(database, session, seat)
            assert before
    done = erased(data)
    assert (done.sessions, done.shared) == (2, 2)
    assert found(data) == []
    assert holding(data) == []
    with closing(connect(data)) as database:
        assert kept(database, session, other) == before
        assert kept(database, session, seat) == {"trials": [], "attempts": [], "answers": []}
        code = sessions.rows(database, "seats", session)
        assert {row["participant"] for row in code} == {"P08", done.event.replaced_by}
        row = sessions.find(database, data, session)
        listed = sessions.listing(database, data, participant="P08")
        assert listed[0]["id"] == row["id"]
        stored = list(messages.read(database, session))
        assert {one.message.seat for one in stored if one.topic in (TRIAL, PROMPT)} == {other}
        with pytest.raises(StoreError, match="was erased: what is left cannot be run again"):
            replay(database, data, catalogue(), row)
    assert erase(data, "P08", author="ana", reason="").sessions == 2
    with closing(connect(data)) as database:
        assert value(database, "SELECT count(*) FROM sessions") == 0
    assert found(data) == []


@pytest.mark.parametrize("code", ["P07", "P08"])
def test_samples_of_one_sensor_go_and_those_of_the_other_stay(data: Path, code: str) -> None:
    settings = {"respond_with": "reaches", "attempts": 1, "prompts_per_attempt": 4}
    simulated(data, "pairs", "P07", "P08", **settings)
    seats = "SELECT DISTINCT seat FROM imu_streams JOIN imu_chunks USING (session, stream)"
    assert len(sql(data, seats)) == 2
    erased(data, code)
    assert sql(data, seats) == [("B" if code == "P07" else "A",)]
    assert found(data) == []
    assert de_identify(data, "P08" if code == "P07" else "P07", author="", reason="").sessions == 1
    assert found(data) == []


def kept(database: sqlite3.Connection, session: str, seat: str) -> dict[str, list[object]]:
    return {
        table: sql(database, f"SELECT * FROM {table} WHERE session=? AND seat=?", session, seat)
        for table in ("trials", "attempts", "answers")
    }


def test_a_change_of_what_is_left_shows(data: Path) -> None:
    for code in ("P07", "P08"):
        with closing(connect(data)) as database:
            participants.add(database, code)
    session = played(data, "pairs", "P07", "P08", **PAIRS)
    erased(data)
    assert found(data) == []
    with closing(connect(data)) as database:
        last = "SELECT max(seq) FROM messages WHERE message='[]'"
        database.execute(f"UPDATE messages SET at_ns=at_ns+1 WHERE seq=({last})")
        assert [flaw.where for flaw in flaws(database)] == [session]


def test_a_rescue_file_does_not_bring_the_person_back(data: Path) -> None:
    fill(data)
    rescue = copies(data)[1]
    kept_elsewhere = data.with_name("elsewhere.db")
    shutil.copyfile(rescue, kept_elsewhere)
    erased(data)
    session = min(session_ids(kept_elsewhere))
    shutil.copyfile(kept_elsewhere, data / f"sar-tui-rescue-{session}.db")
    brought = bring_back(data)
    assert {each.problem[:14] for each in brought} == {"P07 was erased"}
    assert value(data, "SELECT count(*) FROM sessions") == 0
    assert holding(data) == [f"sar-tui-rescue-{session}.db"]
    erased(data)
    assert holding(data) == []
    assert bring_back(data) == []


def test_records_in_a_rescue_file_do_not_bring_the_person_back(data: Path) -> None:
    with closing(connect(data)) as database:
        participants.add(database, "P07")
        score(database, "P07", "FMA-UE", "2026-03-01", 42, note="CANARY " * 250)
    with closing(connect(data)) as database:
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
    kept_elsewhere = data.with_name("elsewhere.db")
    shutil.copyfile(data / FILE, kept_elsewhere)
    erased(data)
    shutil.copyfile(kept_elsewhere, data / "sar-tui-rescue-abc.db")
    assert bring_back(data) == []
    assert value(data, "SELECT count(*) FROM records") == 0
    assert holding(data) == ["sar-tui-rescued-abc.db"]


def test_rights_are_kept_if_a_part_of_a_rescue_file_waits(data: Path) -> None:
    fill(data)
    fill(data, "P08", "KEPT")
    rescue = copies(data)[1]
    kept_elsewhere = data.with_name("elsewhere.db")
    shutil.copyfile(rescue, kept_elsewhere)
    de_identify(data, "P07", author="ana", reason="")
    erased(data, "P08")
    sql(data, "DELETE FROM sessions")
    shutil.copyfile(kept_elsewhere, data / "sar-tui-rescue-abc.db")
    assert {each.problem[:14] for each in bring_back(data)} == {"", "P08 was erased"}
    assert value(data, "SELECT count(*) FROM sessions") == 2
    assert holding(data) == ["sar-tui-rescue-abc.db"]
    assert sql(data, "SELECT 1 FROM seats WHERE participant='P07'") == []


def test_one_of_two_who_were_erased_is_not_brought_back_by_the_other(data: Path) -> None:
    session = played(data, "pairs", "P07", "P08", **PAIRS)
    erased(data, "P07")
    file = data / f"sar-tui-rescue-{session}.db"
    with closing(connect(data)) as database:
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
    shutil.copyfile(data / FILE, data.with_name("elsewhere.db"))
    erased(data, "P08")
    shutil.copyfile(data.with_name("elsewhere.db"), file)
    (brought,) = bring_back(data)
    assert brought.problem.startswith("P08 was erased")
    assert value(data, "SELECT count(*) FROM sessions") == 0


def test_a_backup_of_before_the_codes_of_a_person_were_known_is_rewritten(data: Path) -> None:
    with closing(connect(data)) as database:
        sites.set_own(database, "MUC")
        participants.add(database, "P07")
        score(database, "P07", "FMA-UE", "2026-03-01", 42, note="CANARY")
        theirs = {"participant": "P01@BERN", "site": "BERN"}
        database.execute(
            "UPDATE records SET id='R1@BERN', participant=:participant, site=:site", theirs
        )
        database.execute("INSERT INTO participants VALUES (:participant, '2026', :site)", theirs)
    (made, *rest) = copies(data)
    for path in rest:
        path.unlink()
    merge(data, None, ["P01@BERN=P07"], start=lambda name: lambda done, whole: None)
    done = erased(data)
    assert str(made) in done.rewritten
    assert holding(data) == []


def test_a_backup_of_an_earlier_version_is_rewritten(data: Path) -> None:
    fill(data)
    made = copies(data)[0]
    with closing(sqlite3.connect(made)) as backup:
        views = backup.execute("SELECT name FROM sqlite_master WHERE type='view'").fetchall()
        for (view,) in views:
            backup.execute(f"DROP VIEW {view}")
        for table in TABLES.values():
            if table.since > FIRST_VERSION:
                backup.execute(f"DROP TABLE {table.name}")
                continue
            for column in table.columns:
                if column.since > FIRST_VERSION:
                    backup.execute(f"ALTER TABLE {table.name} DROP COLUMN {column.name}")
        backup.execute(f"PRAGMA user_version={FIRST_VERSION}")
    done = erased(data)
    assert done.refused == []
    assert holding(data) == []
    with closing(sqlite3.connect(made)) as backup:
        assert backup.execute("SELECT event, participant FROM people_events").fetchall() == [
            ("erased", "P07")
        ]


def test_an_export_with_an_empty_manifest_stops_nothing(data: Path) -> None:
    fill(data)
    (data / "exports" / "csv").mkdir(parents=True)
    (data / "exports" / "csv" / "sar-tui-export.json").touch()
    assert erased(data).folders == []


def session_ids(path: Path) -> set[str]:
    with closing(sqlite3.connect(path)) as database:
        return {id for (id,) in database.execute("SELECT id FROM sessions")}


def test_a_backup_that_cannot_be_rewritten_is_named(data: Path) -> None:
    fill(data)
    made = copies(data)[0]
    damaged = made.with_name("damaged.db")
    content = bytearray(made.read_bytes())
    content[100:3000] = b"\xff" * 2900
    damaged.write_bytes(content)
    done = erased(data)
    assert [each.file for each in done.refused] == [str(damaged)]
    damaged.unlink()
    assert erased(data).refused == []


def test_the_code_is_not_given_again(data: Path) -> None:
    fill(data)
    erased(data)
    with (
        closing(connect(data)) as database,
        pytest.raises(StoreError, match="The data of P07 was erased on 20"),
    ):
        participants.add(database, "P07")


KILLED = """
import os, sys
from pathlib import Path
from sar_tui.store import erasure
place, number = sys.argv[2], int(sys.argv[3])
real, calls = getattr(erasure, place), 0
def killing(*given):
    global calls
    calls += 1
    if calls > number:
        os.kill(os.getpid(), 9)
    return real(*given)
setattr(erasure, place, killing)
getattr(erasure, sys.argv[4])(Path(sys.argv[1]), "P07", author="ana", reason="")
"""


@pytest.mark.parametrize(
    ("place", "number"),
    [("_apply", 0), ("_clean", 0), ("_other_files", 0), ("_rewrite", 1), ("_clean", 2)],
)
def test_erasing_again_completes_what_was_killed(data: Path, place: str, number: int) -> None:
    fill(data)
    fill(data, "P08", "KEPT")
    copies(data)
    command = [sys.executable, "-c", KILLED, str(data), place, str(number), "erase"]
    assert subprocess.run(command, check=False).returncode == -9
    assert holding(data)
    with closing(connect(data)) as database:
        is_before = people_events.erasure(database, "P07") is None
        assert is_before == (place == "_apply")
        if not is_before:
            assert sql(database, "SELECT 1 FROM seats WHERE participant='P07'") == []
    erased(data)
    assert holding(data) == []
    assert value(data, "SELECT count(*) FROM seats WHERE participant='P08'") == 2


# --- de-identified


def test_texts_and_code_go_and_results_stay(data: Path) -> None:
    fill(data)
    assert found(data) == []
    session = value(data, "SELECT id FROM sessions WHERE mode='live'")
    with closing(connect(data)) as database:
        trials = sessions.rows(database, "trials", session)
        participants.add(database, "P08")
    made = copies(data)
    done = de_identify(data, "P07", author="ana", reason="end of the study")
    new = done.event.participant
    assert holding(data) == []
    assert holding(data, b'"P07"') == []
    assert found(data) == []
    assert done.sessions == 2
    assert done.refused == []
    with closing(connect(data)) as database:
        assert sessions.rows(database, "trials", session) == trials
        assert participants.codes(database) == sorted(["P08", new])
        with pytest.raises(StoreError, match="There is no participant P07"):
            participants.check_known(database, "P07")
        answer = sql(database, "SELECT answer FROM answers WHERE kind='text'")
        assert {text for (text,) in answer} <= {'""', None, "null"}
        assert value(database, "SELECT count(*) FROM records WHERE participant=?", new) >= 3
        assert sql(database, "SELECT author, reason FROM programmes") == [("", "")]
    for path in made:
        with closing(sqlite3.connect(path)) as backup:
            codes = {code for (code,) in backup.execute("SELECT participant FROM seats")}
            assert codes == {new}
    # and again, and then erased
    assert de_identify(data, new, author="ana", reason="").sessions == 2
    assert found(data) == []
    (last,) = {code for (code,) in sql(data, "SELECT participant FROM seats")}
    assert erase(data, last, author="ana", reason="").sessions == 2
    assert value(data, "SELECT count(*) FROM sessions") == 0


@pytest.mark.parametrize(("place", "number"), [("_rewrite", 1), ("_clean", 1), ("_apply", 4)])
def test_de_identifying_again_completes_what_was_killed(
    data: Path, place: str, number: int
) -> None:
    fill(data)
    made = copies(data)
    (data / "progress-P07-keyboard.html").write_bytes(CANARY)
    command = [sys.executable, "-c", KILLED, str(data), place, str(number), "de_identify"]
    assert subprocess.run(command, check=False).returncode == -9
    assert holding(data)
    new = de_identify(data, "P07", author="ana", reason="").event.participant
    assert holding(data) == []
    assert holding(data, b'"P07"') == []
    assert found(data) == []
    for path in (data / FILE, *made):
        with closing(sqlite3.connect(path)) as database:
            held = database.execute(
                "SELECT participant FROM seats UNION SELECT participant FROM records"
                " UNION SELECT participant FROM programmes UNION SELECT code FROM participants"
            ).fetchall()
            assert held == [(new,)], path


def test_keys_of_a_typed_answer_go(data: Path) -> None:
    fill(data)
    session = value(data, "SELECT id FROM sessions WHERE mode='live'")
    steps = "SELECT shown_ns, answered_ns FROM answers WHERE session=? AND kind='text'"
    spans = sql(data, steps, session)
    assert spans
    typed = (
        "SELECT json_extract(message, '$.key') FROM events WHERE session=? AND topic='input/key'"
        " AND json_extract(message, '$.at') BETWEEN ? AND ?"
    )
    assert any(sql(data, typed, session, *span) for span in spans)
    de_identify(data, "P07", author="ana", reason="")
    keys = {key for span in spans for (key,) in sql(data, typed, session, *span)}
    assert keys == {""}
    other = (
        "SELECT count(*) FROM events WHERE topic='input/key' AND json_extract(message, '$.key')<>''"
    )
    assert value(data, other) > 0


def test_a_person_of_a_session_for_two_is_de_identified(data: Path) -> None:
    for code in ("P07", "P08"):
        with closing(connect(data)) as database:
            participants.add(database, code)
    played(data, "pairs", "P07", "P08", word="CANARY", **PAIRS)
    first = de_identify(data, "P08", author="ana", reason="").event.participant
    assert found(data) == []
    assert holding(data) == []
    second = de_identify(data, "P07", author="ana", reason="").event.participant
    assert found(data) == []
    assert {code for (code,) in sql(data, "SELECT participant FROM seats")} == {first, second}
