"""A change of a session after its end is in its log, stored with the change of its row; a replay
leaves it out.
"""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import COMMAND, RECORD_CHANGED
from sar_tui.model.messages import RecordChanged, SessionCommand
from sar_tui.plugins import Catalogue
from sar_tui.replay.replay import replay
from sar_tui.runs.plan import Plan
from sar_tui.runs.run import Run, find_resumable, resume, start
from sar_tui.store import messages, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.integrity import flaws
from sar_tui.store.locks import Held, hold
from sar_tui.store.record_changes import change_status
from tests.program import Call
from tests.store.test_sessions import enter


def status(database: sqlite3.Connection, session: str) -> str | None:
    return sessions.stored_status(database, session)


def changed(database: sqlite3.Connection, session: str) -> list[RecordChanged]:
    return [
        one.message
        for one in messages.read(database, session)
        if isinstance(one.message, RecordChanged)
    ]


@pytest.mark.parametrize("stored", ["running", "interrupted"])
def test_an_interrupted_session_is_dismissed_and_restored(
    stored: str, database: sqlite3.Connection, data: Path
) -> None:
    session = enter(database)
    database.execute("UPDATE sessions SET status=?", (stored,))
    assert change_status(database, data, session, "dismissed", actor="ana", reason="moved away")
    assert [row["status"] for row in sessions.listing(database, data)] == ["dismissed"]
    with pytest.raises(
        StoreError, match="is dismissed; only a live one that was interrupted can be resumed"
    ):
        find_resumable(database, data, session)
    assert change_status(database, data, session, "restored", actor="ben")
    assert find_resumable(database, data, session)["id"] == session
    told = [(one.change, one.actor, one.reason, one.at[-6:]) for one in changed(database, session)]
    assert told == [("dismissed", "ana", "moved away", "+00:00"), ("restored", "ben", "", "+00:00")]


@pytest.mark.parametrize("stored", ["completed", "aborted"])
def test_a_session_that_has_ended_is_not_dismissed(
    stored: str, database: sqlite3.Connection, data: Path
) -> None:
    session = enter(database)
    database.execute("UPDATE sessions SET status=?", (stored,))
    assert not change_status(database, data, session, "dismissed", actor="ana")
    assert not change_status(database, data, session, "restored", actor="ana")
    assert status(database, session) == stored
    assert changed(database, session) == []


def test_a_session_that_is_open_in_a_program_is_not_changed(
    database: sqlite3.Connection, data: Path
) -> None:
    session = enter(database)
    lock = hold(data, "session", session)
    with pytest.raises(Held):
        change_status(database, data, session, "dismissed", actor="ana")
    lock.release()
    assert status(database, session) == "running"
    assert changed(database, session) == []


def play(data: Path, catalogue: Catalogue, plan: Plan, until: str) -> Run:
    """Play the first messages of a session."""
    run = start(plan, data, catalogue, VirtualClock(), lambda *_: [])
    run.begin()
    if until == "aborted":
        run.session.bus.publish(COMMAND, SessionCommand(command="end"))
    run.recorder.write()
    run.close()
    return run


@pytest.mark.parametrize("ended", ["interrupted", "aborted"])
def test_a_discarded_session_is_restored_to_what_it_was(
    ended: str, data: Path, catalogue: Catalogue, plan: Plan
) -> None:
    session = play(data, catalogue, plan, ended).id
    with closing(connect(data)) as database:
        before = sessions.find(database, data, session)
        assert before["status"] == ended
        count = messages.last(database, session)[0]
        assert change_status(database, data, session, "discarded", actor="ana", reason="by mistake")
        assert status(database, session) == "discarded"
        assert change_status(database, data, session, "restored", actor="ana")
        assert sessions.find(database, data, session) | {"log_hash": ""} == before | {
            "log_hash": ""
        }
        assert list(flaws(database)) == []
        stored = list(messages.read(database, session))
        assert [one.seq for one in stored] == list(range(1, count + 3))
        assert [(one.topic, one.run) for one in stored[count:]] == [(RECORD_CHANGED, 1)] * 2
        assert stored[-1].at == stored[count - 1].at
        assert replay(database, data, catalogue, before).identical


def test_a_restored_session_is_resumed_and_its_numbers_go_on(
    data: Path, catalogue: Catalogue, plan: Plan
) -> None:
    session = play(data, catalogue, plan, "interrupted").id
    with closing(connect(data)) as database:
        change_status(database, data, session, "dismissed", actor="ana")
        change_status(database, data, session, "restored", actor="ana")
        count = messages.last(database, session)[0]
    run = resume(session, data, catalogue, VirtualClock(), lambda *_: [])
    run.begin()
    run.session.bus.publish(COMMAND, SessionCommand(command="end"))
    run.recorder.write()
    run.close()
    with closing(connect(data)) as database:
        row = sessions.find(database, data, session)
        assert row["status"] == "aborted"
        stored = list(messages.read(database, session))
        assert [one.seq for one in stored] == list(range(1, len(stored) + 1))
        assert {one.run for one in stored[count:]} == {2}
        assert replay(database, data, catalogue, row).identical


def test_a_dismissed_session_is_listed_by_the_program_and_not_resumed(
    call: Call, tmp_path: Path
) -> None:
    with closing(connect(tmp_path / "data")) as database:
        session = enter(database)
        change_status(database, tmp_path / "data", session, "dismissed", actor="ana")
    assert "dismissed" in call("sessions").out
    assert call("sessions", "--json").json["sessions"][0]["id"] == session
    assert call("resume").code == 2
