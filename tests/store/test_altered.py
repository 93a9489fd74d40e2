"""A change by hand of results, of the log, of samples or of a session's facts is found, and names
the session.
"""

import shutil
import sqlite3
import zlib
from contextlib import closing
from pathlib import Path
from sqlite3 import Connection
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.topics import COMMAND, NOTE_ADDED
from sar_tui.model.messages import NoteAdded, RecordChanged, SessionCommand
from sar_tui.replay.replay import replay
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume, start
from sar_tui.runs.sensors import simulated_nodes
from sar_tui.simulation.operator import PROFILES, SimulatedOperator
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import messages, sessions
from sar_tui.store.backup import back_up, rehearse
from sar_tui.store.database import FILE, connect, transaction
from sar_tui.store.integrity import Flaw, flaws
from sar_tui.store.record_changes import change_status, erase_note, log
from sar_tui.store.repair import repair
from sar_tui.store.rescue import copy_session
from tests.played import catalogue, somebody
from tests.played import play as to_end
from tests.program import Call
from tests.runs.test_resume import interrupted
from tests.store.by_hand import sql, value

SETTINGS: dict[str, Any] = {
    "attempts": 3,
    "questions": ["effort", "remark"],
    "operator_feedback": "approve",
}


def nodes_of(name: str, clock: VirtualClock) -> Any:
    def make(task: Any, theme: Any, seed: int) -> list[Node]:
        person = PEOPLE["average"]
        hands = (
            simulated_nodes(person, task, seed, clock, person)
            if name == "reaching"
            else somebody(task, theme, seed)
        )
        return [*hands, SimulatedOperator(PROFILES["careful"], seed)]

    return make


def play(folder: Path, name: str) -> str:
    """Play a live session of two runs, with a note, a pause for pain and answers to questions;
    return its id.
    """
    few = {"reaches_per_attempt": 2} if name == "reaching" else {"prompts_per_attempt": 4}
    plan = make_plan(catalogue(), name, ["P01"], {**SETTINGS, **few}, seed=4)
    clock = VirtualClock()
    run = start(plan, folder, catalogue(), clock, nodes_of(name, clock))
    run.begin()
    run.session.bus.publish(NOTE_ADDED, NoteAdded(text="sits well", actor="operator.ana"))
    while not sum(len(cascade) for cascade in run.recorder._queue) > 250:
        assert clock.step()
    run.session.bus.publish(COMMAND, SessionCommand(command="pause", reason="pain"))
    run.session.bus.publish(COMMAND, SessionCommand(command="resume"))
    run.recorder.write()
    run.close()
    clock = VirtualClock(10**14)
    return to_end(resume(run.id, folder, catalogue(), clock, nodes_of(name, clock)), clock)


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, str]:
    """A data folder with two sessions: at keys, and with a sensor."""
    folder = tmp_path_factory.mktemp("altered")
    return folder, play(folder, "keyboard"), play(folder, "reaching")


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
ALTERATIONS: dict[str, tuple[int, str]] = {
    "a reaction time": (KEYS, "UPDATE trials SET reaction_time_ms=reaction_time_ms-50 WHERE session=:s AND trial=2"),
    "a response": (KEYS, "UPDATE trials SET response='x', correct=1-correct WHERE session=:s AND trial=1"),
    "a stimulus": (KEYS, "UPDATE trials SET stimulus='q' WHERE session=:s AND trial=3"),
    "onsets": (KEYS, "UPDATE trials SET onset_ns=onset_ns+1000000 WHERE session=:s"),
    "the flags of a trial": (KEYS, "UPDATE trials SET timing=json_set(timing, '$.flags', json('[]'),"
                             " '$.handler_delay_ms', 9) WHERE session=:s AND trial=1"),
    "the measures of a reach": (SENSOR, "UPDATE trials SET details=json_set(details, '$.valid', 7) WHERE session=:s"),
    "a name that stands twice in JSON": (SENSOR, "UPDATE trials SET details='{\"reach_time_ms\": 5,' ||"
                                         " substr(details, 2) WHERE session=:s"),
    "trials that were exchanged": (KEYS, "UPDATE trials SET trial=-1 WHERE session=:s AND trial=1 AND attempt=1;"
                                   "UPDATE trials SET trial=1 WHERE session=:s AND trial=2 AND attempt=1;"
                                   "UPDATE trials SET trial=2 WHERE session=:s AND trial=-1"),
    "the last trial deleted": (KEYS, "DELETE FROM trials WHERE rowid=(SELECT max(rowid) FROM trials WHERE session=:s)"),
    "a trial added": (KEYS, "INSERT INTO trials (session, attempt, trial, seat, run, timing, details)"
                      " SELECT session, attempt, trial+1, seat, run, timing, details FROM trials"
                      " WHERE session=:s ORDER BY attempt DESC, trial DESC LIMIT 1"),
    "a result of an attempt": (KEYS, "UPDATE attempts SET metric=metric*0.9 WHERE session=:s AND attempt=2"),
    "an outcome": (KEYS, "UPDATE attempts SET outcome='success', feedback='positive', accuracy=1, goal=5000"
                   " WHERE session=:s"),
    "levels": (KEYS, "UPDATE attempts SET level=level+1 WHERE session=:s"),
    "the last attempt deleted": (KEYS, "DELETE FROM attempts WHERE session=:s AND attempt=3;"
                                 "DELETE FROM trials WHERE session=:s AND attempt=3"),
    "practice": (KEYS, "UPDATE attempts SET practice=1 WHERE session=:s AND attempt=1"),
    "the choice of feedback": (KEYS, "UPDATE attempts SET choice=json_set(choice, '$.form', 'other') WHERE session=:s"),
    "a decision on a proposal": (KEYS, "UPDATE actions SET decision='vetoed', actor='operator.ben' WHERE session=:s"),
    "the time of a decision": (KEYS, "UPDATE actions SET decided_ns=decided_ns+5 WHERE session=:s"),
    "an action deleted": (KEYS, "DELETE FROM actions WHERE session=:s AND id=(SELECT max(id) FROM actions"
                          " WHERE session=:s)"),
    "a note": (KEYS, "UPDATE notes SET text='sits badly' WHERE session=:s"),
    "a note added": (KEYS, "INSERT INTO notes (session, at_ns, author, text, label) VALUES (:s, 5, 'ben', 'x', '')"),
    "an answer": (KEYS, "UPDATE answers SET answer='0' WHERE session=:s AND number=1"),
    "a pause for pain": (KEYS, "DELETE FROM records WHERE session=:s AND moment='pause'"),
    "a message's text": (KEYS, f"UPDATE messages SET message=replace(message, '1', '2') WHERE session_number={_LOG}"
                         " AND seq=40"),
    "a message's time": (KEYS, f"UPDATE messages SET at_ns=at_ns+1 WHERE session_number={_LOG} AND seq=40"),
    "a message's topic": (KEYS, f"UPDATE messages SET topic=topic+1 WHERE session_number={_LOG} AND seq=40"),
    "messages that were exchanged": (KEYS, f"UPDATE messages SET seq=-1 WHERE session_number={_LOG} AND seq=40;"
                                     f"UPDATE messages SET seq=40 WHERE session_number={_LOG} AND seq=41;"
                                     f"UPDATE messages SET seq=41 WHERE session_number={_LOG} AND seq=-1"),
    "the last message deleted": (KEYS, f"DELETE FROM messages WHERE session_number={_LOG} AND seq="
                                 f"(SELECT max(seq) FROM messages WHERE session_number={_LOG})"),
    "a message added": (KEYS, "INSERT INTO messages SELECT session_number, seq+1, run, at_ns, topic, message FROM"
                        f" messages WHERE session_number={_LOG} ORDER BY seq DESC LIMIT 1"),
    "the participant": (KEYS, "UPDATE seats SET participant='P02' WHERE session=:s;"
                        "INSERT INTO participants (code, created_at) VALUES ('P02', '')"),
    "the clock of a run": (KEYS, "UPDATE runs SET clock_anchor=json_set(clock_anchor, '$.clock_ns', 5)"
                           " WHERE session=:s AND run=1"),
    "a run added": (KEYS, "INSERT INTO runs SELECT session, 3, clock_anchor, boot_id, pid, software, machine FROM runs"
                    " WHERE session=:s AND run=2"),
    "the rate of a sensor": (SENSOR, "UPDATE imu_streams SET rate_hz=200 WHERE session=:s AND stream=1"),
    "samples": (SENSOR, "UPDATE imu_chunks SET data=zeroblob(length(data)) WHERE session=:s AND seq=2;"
                "UPDATE imu_chunks SET crc32=crc32(data) WHERE session=:s AND seq=2"),
    "the time of samples": (SENSOR, "UPDATE imu_chunks SET t0_ns=t0_ns+1, before_event=before_event+1 WHERE session=:s"
                            " AND seq=3"),
    "the last samples deleted": (SENSOR, "DELETE FROM imu_chunks WHERE rowid=(SELECT max(rowid) FROM imu_chunks"
                                 " WHERE session=:s)"),
    "the status": (KEYS, "UPDATE sessions SET status='aborted' WHERE id=:s"),
    "the time of the end": (KEYS, "UPDATE sessions SET ended_at='2026-01-01T00:00:00+00:00' WHERE id=:s"),
    "the date": (KEYS, "UPDATE sessions SET started_at='2026-01-01T00:00:00+00:00' WHERE id=:s"),
    "the seed": (KEYS, "UPDATE sessions SET seed=seed+1 WHERE id=:s"),
    "the settings": (KEYS, "UPDATE sessions SET parameters=json_set(parameters, '$.threshold', 1) WHERE id=:s"),
    "the versions": (KEYS, "UPDATE sessions SET software=json_set(software, '$.sar_tui', '9') WHERE id=:s"),
    "a simulation that becomes a person": (KEYS, "UPDATE sessions SET mode='simulated' WHERE id=:s"),
    "hashes removed": (KEYS, "DELETE FROM log_hashes WHERE session=:s"),
    "all hashes removed": (KEYS, "DELETE FROM log_hashes WHERE session=:s;"
                           "UPDATE sessions SET log_hash='' WHERE id=:s"),
    "the last hash removed": (KEYS, f"DELETE FROM messages WHERE session_number={_LOG} AND seq="
                              f"(SELECT max(seq) FROM messages WHERE session_number={_LOG});"
                              "DELETE FROM log_hashes WHERE rowid="
                              "(SELECT max(rowid) FROM log_hashes WHERE session=:s)"),
}  # fmt: skip


def test_sessions_as_they_were_recorded_are_whole(recorded: tuple[str, str], data: Path) -> None:
    assert found(data) == []
    for table in "trials attempts actions answers notes records imu_chunks runs".split():
        assert value(data, f"SELECT count(*) FROM {table}") > 0, table


@pytest.mark.parametrize("name", ALTERATIONS)
def test_an_alteration_is_found_and_named(name: str, recorded: tuple[str, str], data: Path) -> None:
    which, statement = ALTERATIONS[name]
    session, other = recorded[which], recorded[1 - which]
    alter(data, statement, session)
    told = found(data)
    assert [flaw for flaw in told if flaw.where == session and flaw.kind in ("log", "rows")], told
    assert not [flaw for flaw in told if flaw.where == other]


OF_ROWS = ("a response", "the last trial deleted", "a trial added", "levels", "an action deleted",
           "a note", "an answer", "the status", "the time of the end")  # fmt: skip


@pytest.mark.parametrize("name", OF_ROWS)
def test_a_repair_makes_altered_results_again_from_the_log(
    name: str, recorded: tuple[str, str], data: Path
) -> None:
    before = contents(data)
    alter(data, ALTERATIONS[name][1], recorded[KEYS])
    assert contents(data) != before
    done = repair(data)
    assert (done.rebuilt, done.flaws) == ([recorded[KEYS]], [])
    assert done.backup
    assert done.aside
    assert contents(data) == before
    assert found(data) == []


def contents(data: Path) -> dict[str, list[Any]]:
    tables = {"sessions": "id"} | dict.fromkeys(
        "trials attempts actions answers notes".split(), "session"
    )
    return {
        table: sorted(map(repr, sql(data, f"SELECT * FROM {table} ORDER BY {of}")))
        for table, of in tables.items()
    }


@pytest.mark.parametrize(
    "text", ["{", "[]", "7", '["x"]', "[7, 7, 7, 7, 7, 7]", "null", "", '[{"a": [[["b"]]]}]']
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
    "beside",
    ["{", "[7]", '[["chunk"]]', '[["run", "x", []]]', '[[["a"]]]', "[[]]", '[["facts", 1]]'],
)
def test_no_text_of_a_hash_stops_a_check(
    beside: str, recorded: tuple[str, str], data: Path
) -> None:
    where = "WHERE session=:s AND number=2"
    alter(data, f"UPDATE log_hashes SET beside='{beside}' {where}", recorded[SENSOR])
    assert {flaw.where for flaw in found(data)} == {recorded[SENSOR]}


@pytest.mark.parametrize(
    "statement",
    [
        *(f"UPDATE log_hashes SET {odd} WHERE session=:s AND number=2"
          for odd in ("seq='x'", "number='x'", "hash=x'ff'", "beside=x'ff'")),
        "UPDATE sessions SET log_hash=x'ff' WHERE id=:s",
        "UPDATE seats SET participant=NULL WHERE session=:s",
        "UPDATE imu_streams SET rate_hz=9e999 WHERE session=:s",
        "UPDATE trials SET reaction_time_ms=9e999, trial=x'00' WHERE session=:s AND trial=1 AND attempt=1",
        "UPDATE attempts SET metric='fast', started_ns=NULL WHERE session=:s AND attempt=1",
    ],
)  # fmt: skip
def test_no_value_of_another_type_stops_the_check(
    statement: str, recorded: tuple[str, str], data: Path
) -> None:
    alter(data, statement, recorded[SENSOR])
    assert recorded[SENSOR] in {flaw.where for flaw in found(data)}


def test_altered_results_are_told_beside_facts(recorded: tuple[str, str], data: Path) -> None:
    alter(data, ALTERATIONS["the seed"][1], recorded[KEYS])
    alter(data, ALTERATIONS["a response"][1], recorded[KEYS])
    assert [flaw.kind for flaw in found(data)] == ["log", "rows"]


def test_a_repair_leaves_sessions_of_altered_logs_as_is(
    recorded: tuple[str, str], data: Path
) -> None:
    alter(data, ALTERATIONS["a message's text"][1], recorded[KEYS])
    alter(data, ALTERATIONS["a note"][1], recorded[KEYS])
    before = contents(data)
    done = repair(data)
    assert (done.rebuilt, {flaw.kind for flaw in done.flaws}) == ([], {"log", "rows"})
    assert contents(data) == before


def test_a_backup_is_verified_by_the_hashes(recorded: tuple[str, str], data: Path) -> None:
    alter(data, ALTERATIONS["samples"][1], recorded[SENSOR])
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
    alter(other, ALTERATIONS["a response"][1], recorded[KEYS])
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


def note_of(database: Connection, session: str) -> int:
    """Return the number of the first note."""
    logged = messages.read(database, session)
    return next(one.seq for one in logged if isinstance(one.message, NoteAdded))


def test_a_note_that_was_erased_leaves_its_hash(recorded: tuple[str, str], data: Path) -> None:
    session = recorded[KEYS]
    with closing(connect(data)) as database:
        seq = note_of(database, session)
        assert not erase_note(database, data, session, seq + 1, actor="ana", reason="no note")
        assert erase_note(database, data, session, seq, actor="ana", reason="a name")
        assert list(flaws(database)) == []
        assert sql(database, "SELECT text, label FROM notes WHERE session=?", session) == [("", "")]
        row = sessions.find(database, data, session)
        assert replay(database, data, catalogue(), row).identical
    left = (data / FILE).read_bytes().count(b"sits well")
    assert left == 2, "the message and the row of the other session"
    where = f"WHERE session_number={_LOG} AND seq={seq + 1}"
    alter(data, f"UPDATE messages SET at_ns=at_ns+1 {where}", session)
    assert {flaw.where for flaw in found(data)} == {session}


def test_an_erased_note_cannot_be_replaced_by_another(
    recorded: tuple[str, str], data: Path
) -> None:
    session, other = recorded[KEYS], NoteAdded(text="sits badly", actor="operator.ana")
    with closing(connect(data)) as database:
        seq = note_of(database, session)
        assert erase_note(database, data, session, seq, actor="ana", reason="a name")
        messages.replace(database, session, seq, NOTE_ADDED, other)
        sql(database, "UPDATE notes SET text='sits badly' WHERE session=?", session)
        assert {flaw.kind for flaw in flaws(database)} == {"log"}


def test_a_discarded_and_restored_session_is_whole(recorded: tuple[str, str], data: Path) -> None:
    session = recorded[KEYS]
    with closing(connect(data)) as database:
        for change in ("discarded", "restored"):
            assert change_status(database, data, session, change, actor="ana", reason="by mistake")
            assert list(flaws(database)) == []
        row = sessions.find(database, data, session)
        assert replay(database, data, catalogue(), row).identical
    alter(data, "UPDATE sessions SET status='discarded' WHERE id=:s", session)
    assert [flaw.kind for flaw in found(data)] == ["rows"]


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
    assert call("check").code == 1
    assert repair(data).flaws == []
    assert contents(data) == before
    assert found(data) == []
