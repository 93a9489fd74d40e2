"""A change by hand of results, of the log, of samples or of a session's facts is found, and names
the session.
"""

import shutil
import sqlite3
import zlib
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.model.messages import RecordChanged
from sar_tui.runs.run import resume
from sar_tui.store.backup import back_up, rehearse
from sar_tui.store.database import FILE, connect, transaction
from sar_tui.store.integrity import Flaw, flaws
from sar_tui.store.log_examination import DERIVED
from sar_tui.store.record_changes import change_status, log
from sar_tui.store.repair import repair
from sar_tui.store.rescue import copy_session
from sar_tui.store.tables import TABLES
from tests.examples import first
from tests.played import catalogue, play, simulated
from tests.program import Call
from tests.runs.test_resume import interrupted
from tests.store.by_hand import sql, value
from tests.store.make_golden import operated, play_interrupted


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, str]:
    """A data folder with two sessions: a live one of two runs at keys, and one with a sensor."""
    folder = tmp_path_factory.mktemp("altered")
    keyboard = play_interrupted(folder)
    clock = VirtualClock(10**14)
    play(resume(keyboard, folder, catalogue(), clock, operated), clock)
    return folder, keyboard, simulated(folder, "reaching", attempts=2, reaches_per_attempt=2)


@pytest.fixture
def recorded(played: tuple[Path, str, str], data: Path) -> tuple[str, str]:
    """The two sessions, in a copy of their own."""
    folder, keyboard, reaching = played
    data.mkdir(parents=True)
    shutil.copyfile(folder / FILE, data / FILE)
    return keyboard, reaching


def found(data: Path) -> list[Flaw]:
    with closing(connect(data)) as database:
        return list(flaws(database))


def alter(data: Path, statement: str, session: str) -> None:
    with closing(sqlite3.connect(data / FILE, isolation_level=None)) as database:
        database.create_function("crc32", 1, zlib.crc32)
        for part in statement.split(";"):
            assert database.execute(part, {"s": session} if ":s" in part else {}).rowcount > 0, part


KEYS, SENSOR = 0, 1
_LOG = "(SELECT number FROM session_numbers WHERE id=:s)"
OF_A_SESSION = {
    "sessions": "", "seats": "", "log_hashes": "", "runs": "run", "imu_streams": "stream", "imu_chunks": "seq",
    "messages": "seq", "trials": "trial", "attempts": "attempt", "actions": "id", "answers": "number", "notes": "at_ns",
}  # fmt: skip
"""Tables with rows of a session; the column by which a row is added to those that may get more."""
NOT_RECORDED = ("sessions.id", "sessions.site")
OTHER_VALUES = {
    "json": "json_array(7)",
    "blob": "zeroblob(length({0}))",
    "string": "coalesce({0}, '') || 'x'",
}


def alterations(table: str) -> dict[str, str]:
    """Return statements that change each column of the last rows, remove these, and add others."""
    owner = {"sessions": "id=:s", "messages": f"session_number={_LOG}"}.get(table, "session=:s")
    key, names, found = OF_A_SESSION[table], TABLES[table].names, {}
    last = f"{key}=(SELECT max({key}) FROM {table} WHERE {owner}) AND {owner}" if key else owner
    for column in TABLES[table].columns:
        other = OTHER_VALUES.get(column.type, "coalesce({0}, 0) + 90").format(column.name)
        found[f"{table}.{column.name}"] = f"UPDATE {table} SET {column.name}={other} WHERE {last}"
    if key:
        added = ", ".join(f"{key} || 9" if name == key else name for name in names)
        found["removed"] = f"DELETE FROM {table} WHERE {last}"
        found["added"] = f"INSERT INTO {table} SELECT {added} FROM {table} WHERE {last}"
    return {change: statement for change, statement in found.items() if change not in NOT_RECORDED}


@pytest.mark.slow
@pytest.mark.parametrize("table", OF_A_SESSION)
def test_any_value_that_is_changed_and_any_row_that_is_added_or_removed_is_found(
    table: str, played: tuple[Path, str, str], recorded: tuple[str, str], data: Path
) -> None:
    which = SENSOR if table.startswith("imu") else KEYS
    for change, statement in alterations(table).items():
        shutil.copyfile(played[0] / FILE, data / FILE)
        alter(data, statement, recorded[which])
        assert_named(found(data), recorded[which], recorded[1 - which], change)


def assert_named(told: list[Flaw], session: str, other: str, change: str) -> None:
    """Assert that a change of the log or the rows of a session was found, and none of the other."""
    where = {flaw.where for flaw in told if flaw.kind in ("log", "rows")}
    assert session in where, (change, told)
    assert other not in {flaw.where for flaw in told}, (change, told)


def exchanged(table: str, key: str, one: int, other: int, of: str) -> str:
    """Return statements that exchange two rows."""
    steps = ((-1, one), (one, other), (other, -1))
    return ";".join(
        f"UPDATE {table} SET {key}={new} WHERE {key}={old} AND {of}" for new, old in steps
    )


_LAST_HASH = "rowid=(SELECT max(rowid) FROM log_hashes WHERE session=:s)"
_SAMPLES = "UPDATE imu_chunks SET {} WHERE session=:s AND seq=2"
ALTERATIONS: dict[str, tuple[int, str]] = {
    "a name that stands twice in JSON": (SENSOR, "UPDATE trials SET details='{\"reach_time_ms\": 5,' ||"
                                         " substr(details, 2) WHERE session=:s"),
    "trials that were exchanged": (KEYS, exchanged("trials", "trial", 1, 2, "session=:s AND attempt=1")),
    "messages that were exchanged": (KEYS, exchanged("messages", "seq", 40, 41, f"session_number={_LOG}")),
    "the last attempt with its trials": (KEYS, "DELETE FROM attempts WHERE session=:s AND attempt=3;"
                                         "DELETE FROM trials WHERE session=:s AND attempt=3"),
    "a pause for pain": (KEYS, "DELETE FROM records WHERE session=:s AND moment='pause'"),
    "samples with their checksum": (SENSOR, _SAMPLES.format("data=zeroblob(length(data))") + ";"
                                    + _SAMPLES.format("crc32=crc32(data)")),
    "a last hash of more messages": (KEYS, f"UPDATE log_hashes SET seq=seq + 9 WHERE {_LAST_HASH}"),
    "hashes removed": (KEYS, "DELETE FROM log_hashes WHERE session=:s"),
    "all hashes removed": (KEYS, "DELETE FROM log_hashes WHERE session=:s;"
                           "UPDATE sessions SET log_hash='' WHERE id=:s"),
    "the last hash and its message removed": (KEYS, f"DELETE FROM messages WHERE session_number={_LOG} AND seq="
                                              f"(SELECT max(seq) FROM messages WHERE session_number={_LOG});"
                                              f"DELETE FROM log_hashes WHERE {_LAST_HASH}"),
}  # fmt: skip


def test_sessions_as_they_were_recorded_are_whole(recorded: tuple[str, str], data: Path) -> None:
    assert found(data) == []
    for table in "trials attempts actions answers notes records imu_chunks runs".split():
        assert value(data, f"SELECT count(*) FROM {table}") > 0, table


@pytest.mark.parametrize("name", ALTERATIONS)
def test_an_alteration_is_found_and_named(name: str, recorded: tuple[str, str], data: Path) -> None:
    which, statement = ALTERATIONS[name]
    alter(data, statement, recorded[which])
    assert_named(found(data), recorded[which], recorded[1 - which], name)


def test_a_repair_makes_altered_results_again_from_the_log(
    recorded: tuple[str, str], data: Path
) -> None:
    before, altered = contents(data), recorded[KEYS]
    for table in DERIVED:
        alter(data, alterations(table)["removed"], altered)
    alter(data, "UPDATE trials SET response='x', correct=1-correct WHERE session=:s", altered)
    alter(data, "UPDATE sessions SET status='aborted', ended_at='' WHERE id=:s", altered)
    changed = contents(data)
    assert [table for table in before if changed[table] == before[table]] == []
    done = repair(data)
    assert (done.rebuilt, done.flaws) == ([altered], [])
    assert done.backup
    assert done.aside
    assert contents(data) == before
    assert found(data) == []


def contents(data: Path) -> dict[str, list[Any]]:
    tables = {"sessions": "id"} | dict.fromkeys(DERIVED, "session")
    return {
        table: sorted(map(repr, sql(data, f"SELECT * FROM {table} ORDER BY {of}")))
        for table, of in tables.items()
    }


@pytest.mark.parametrize(
    "text",
    first(3, ["{", "[]", "[7, 7, 7, 7, 7, 7]", "7", '["x"]', "null", "", '[{"a": [[["b"]]]}]']),
)
@pytest.mark.parametrize(
    "topic", ["event_handler/session_ended", "record/status", "event_handler/trial", "store/stored"]
)
def test_no_text_of_a_message_stops_the_check(
    topic: str, text: str, recorded: tuple[str, str], data: Path, call: Call
) -> None:
    with closing(connect(data)) as database:
        change_status(database, data, recorded[KEYS], "discarded", actor="ana")
    of = f"session_number={_LOG} AND topic IN (SELECT id FROM topics WHERE name='{topic}')"
    alter(data, f"UPDATE messages SET message='{text}' WHERE {of}", recorded[KEYS])
    told = found(data)
    assert [flaw for flaw in told if flaw.where == recorded[KEYS] and flaw.kind == "log"]
    assert call("check").code == 1
    assert call("sessions").code == 0


@pytest.mark.parametrize(
    "statement",
    [
        *(f"UPDATE log_hashes SET beside='{text}' WHERE session=:s AND number=2"
          for text in ("{", "[7]", '[["chunk"]]', '[["run", "x", []]]', '[[["a"]]]', "[[]]", '[["facts", 1]]')),
        *(f"UPDATE log_hashes SET {odd} WHERE session=:s AND number=2"
          for odd in ("seq='x'", "number='x'", "hash=x'ff'", "beside=x'ff'")),
        "UPDATE sessions SET log_hash=x'ff' WHERE id=:s",
        "UPDATE seats SET participant=NULL WHERE session=:s",
        "UPDATE imu_streams SET rate_hz=9e999 WHERE session=:s",
        "UPDATE trials SET reaction_time_ms=9e999, trial=x'00' WHERE session=:s AND trial=1 AND attempt=1",
        "UPDATE attempts SET metric='fast', started_ns=NULL WHERE session=:s AND attempt=1",
    ],
)  # fmt: skip
def test_no_text_of_a_hash_and_no_value_of_another_type_stops_the_check(
    statement: str, recorded: tuple[str, str], data: Path
) -> None:
    alter(data, statement, recorded[SENSOR])
    assert recorded[SENSOR] in {flaw.where for flaw in found(data)}


def test_a_repair_leaves_sessions_of_altered_logs_as_is(
    recorded: tuple[str, str], data: Path
) -> None:
    alter(data, "UPDATE sessions SET seed=seed+1 WHERE id=:s", recorded[KEYS])
    alter(data, "UPDATE notes SET text='sits badly' WHERE session=:s", recorded[KEYS])
    before = contents(data)
    done = repair(data)
    assert (done.rebuilt, [flaw.kind for flaw in done.flaws]) == ([], ["log", "rows"])
    assert contents(data) == before


def test_a_backup_is_verified_by_the_hashes(recorded: tuple[str, str], data: Path) -> None:
    alter(data, ALTERATIONS["samples with their checksum"][1], recorded[SENSOR])
    told = rehearse(back_up(data).path)
    assert {(flaw.kind, flaw.where) for flaw in told} == {("log", recorded[SENSOR])}
    assert "blocks of samples" in told[0].what


def test_an_altered_database_is_not_merged(
    call: Call, recorded: tuple[str, str], data: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (data / FILE).rename(other / FILE)
    assert call("site BERN --data", data).code == 0
    called = call("merge", other, "--site", "BASEL", "--data", data)
    assert called.code == 0, called.err
    assert sql(data, "SELECT participant FROM seats") == [("P01@BASEL",)] * 2
    assert found(data) == [], "the hashes were made with the code P01"
    assert call("merge --same P01@BASEL=P07 --data", data).code == 0
    assert found(data) == []
    response = "UPDATE trials SET response='x' WHERE session=:s AND trial=1"
    alter(other, response, recorded[KEYS])
    called = call("merge", other, "--site", "BASEL", "--data", data)
    assert called.code == 2
    assert "Rows of trials are not as its log has them: 3 changed." in called.err


def test_a_session_moved_to_another_person_is_whole(recorded: tuple[str, str], data: Path) -> None:
    with closing(connect(data)) as database, transaction(database):
        sql(database, "INSERT INTO participants (code, created_at) VALUES ('P02', '')")
        sql(database, "UPDATE seats SET participant='P02' WHERE session=?", recorded[KEYS])
        details = {"before": "P01", "after": "P02"}
        move = RecordChanged(change="moved", actor="ana", at="", details=details)
        log(database, recorded[KEYS], move)
    assert found(data) == []
    alter(data, "UPDATE seats SET participant='P01' WHERE session=:s", recorded[KEYS])
    assert [flaw.where for flaw in found(data)] == [recorded[KEYS]]


def test_equal_messages_have_equal_hashes_whatever_their_topics(data: Path, tmp_path: Path) -> None:
    """A rescue file, or a database that was merged, has other numbers of sessions and topics."""
    session = interrupted(data)
    other = tmp_path / "other"
    with closing(connect(data)) as database, closing(connect(other)) as target:
        target.execute("INSERT INTO session_numbers VALUES (77, 'another')")
        target.execute("INSERT INTO sessions (id, status) VALUES ('another', 'completed')")
        target.execute("INSERT INTO topics (name, fields) VALUES ('x', '')")
        copy_session(database, target, session)
        assert [flaw for flaw in flaws(target) if flaw.where == session] == []


_ENDLESS = "WITH RECURSIVE more (x) AS (SELECT 1 UNION ALL SELECT x+1 FROM more)"
OF_SCHEMA = {
    "view v_attempts": "DROP VIEW v_attempts;"
                       "CREATE VIEW v_attempts AS SELECT session, metric*0.9 AS m FROM attempts",
    "view events": f"DROP VIEW events;CREATE VIEW events AS {_ENDLESS} SELECT x AS session, 0 AS seq, 0 AS run,"
                   " 0 AS at_ns, '' AS topic, '' AS message FROM more",
    "view v_reaches": "DROP VIEW v_reaches",
    "trigger better": "CREATE TRIGGER better AFTER INSERT ON records BEGIN DELETE FROM notes; END",
}  # fmt: skip


@pytest.mark.parametrize("name", OF_SCHEMA)
def test_a_view_or_trigger_that_is_not_the_programs_is_found_and_repaired(
    name: str, recorded: tuple[str, str], data: Path, call: Call
) -> None:
    before = contents(data)
    with closing(sqlite3.connect(data / FILE, isolation_level=None)) as database:
        database.executescript(OF_SCHEMA[name])
    told = found(data)  # with a view its triggers are gone, too
    assert {flaw.kind for flaw in told} == {"file"}
    assert f"The {name} is not as sar-tui makes it." in [flaw.what for flaw in told]
    assert "check --repair" in call("check").out
    assert repair(data).flaws == []
    assert contents(data) == before
    assert found(data) == []
