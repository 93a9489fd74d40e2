"""A change of a session after its end is in its log, stored with the change of its row; a replay
leaves it out.
"""

from contextlib import closing
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import COMMAND, RECORD_CHANGED
from sar_tui.model.messages import RecordChanged, SessionCommand
from sar_tui.replay.replay import replay
from sar_tui.runs.plan import Plan
from sar_tui.runs.run import Run, find_resumable, resume, start
from sar_tui.store import messages, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.integrity import flaws
from sar_tui.store.locks import Held, hold
from sar_tui.store.record_changes import change_status
from tests.played import catalogue
from tests.store.by_hand import sql
from tests.store.test_sessions import enter


def status(database: Connection, session: str) -> str | None:
    return sessions.stored_status(database, session)


def changed(database: Connection, session: str) -> list[RecordChanged]:
    logged = (one.message for one in messages.read(database, session))
    return [message for message in logged if isinstance(message, RecordChanged)]


def test_an_interrupted_one_is_dismissed_and_restored(database: Connection, data: Path) -> None:
    session = enter(database)
    assert change_status(database, data, session, "dismissed", actor="ana", reason="moved away")
    assert [row["status"] for row in sessions.listing(database, data)] == ["dismissed"]
    with pytest.raises(StoreError, match="is dismissed; only a live one"):
        find_resumable(database, data, session)
    assert change_status(database, data, session, "restored", actor="ben")
    assert find_resumable(database, data, session)["id"] == session
    told = [(one.change, one.actor, one.reason, one.at[-6:]) for one in changed(database, session)]
    assert told == [("dismissed", "ana", "moved away", "+00:00"), ("restored", "ben", "", "+00:00")]


@pytest.mark.parametrize("stored", ["completed", "aborted"])
def test_an_ended_session_is_not_dismissed(stored: str, database: Connection, data: Path) -> None:
    session = enter(database)
    sql(database, "UPDATE sessions SET status=?", stored)
    assert not change_status(database, data, session, "dismissed", actor="ana")
    assert not change_status(database, data, session, "restored", actor="ana")
    assert status(database, session) == stored
    assert changed(database, session) == []


def test_a_session_that_is_open_elsewhere_is_not_changed(database: Connection, data: Path) -> None:
    session = enter(database)
    lock = hold(data, "session", session)
    with pytest.raises(Held):
        change_status(database, data, session, "dismissed", actor="ana")
    lock.release()
    assert status(database, session) == "running"
    assert changed(database, session) == []


def play(data: Path, plan: Plan, until: str) -> str:
    """Play the first messages of a session, and return its id."""
    return leave(start(plan, data, catalogue(), VirtualClock(), lambda *_: []), until)


def leave(run: Run, until: str) -> str:
    run.begin()
    if until == "aborted":
        run.session.bus.publish(COMMAND, SessionCommand(command="end"))
    run.recorder.write()
    run.close()
    return run.id


@pytest.mark.parametrize("ended", ["interrupted", "aborted"])
def test_a_discarded_session_is_restored_to_what_it_was(ended: str, data: Path, plan: Plan) -> None:
    session = play(data, plan, ended)
    with closing(connect(data)) as database:
        before = sessions.find(database, data, session)
        assert before["status"] == ended
        count = messages.last(database, session)[0]
        assert change_status(database, data, session, "discarded", actor="ana", reason="by mistake")
        assert status(database, session) == "discarded"
        assert change_status(database, data, session, "restored", actor="ana")
        after = sessions.find(database, data, session)
        assert after | {"log_hash": ""} == before | {"log_hash": ""}
        assert list(flaws(database)) == []
        stored = list(messages.read(database, session))
        assert [one.seq for one in stored] == list(range(1, count + 3))
        assert [(one.topic, one.run) for one in stored[count:]] == [(RECORD_CHANGED, 1)] * 2
        assert stored[-1].at == stored[count - 1].at
        assert replay(database, data, catalogue(), before).identical


def test_a_restored_session_goes_on_counting(data: Path, plan: Plan) -> None:
    session = play(data, plan, "interrupted")
    with closing(connect(data)) as database:
        change_status(database, data, session, "dismissed", actor="ana")
        change_status(database, data, session, "restored", actor="ana")
        count = messages.last(database, session)[0]
    leave(resume(session, data, catalogue(), VirtualClock(), lambda *_: []), "aborted")
    with closing(connect(data)) as database:
        row = sessions.find(database, data, session)
        assert row["status"] == "aborted"
        stored = list(messages.read(database, session))
        assert [one.seq for one in stored] == list(range(1, len(stored) + 1))
        assert {one.run for one in stored[count:]} == {2}
        assert replay(database, data, catalogue(), row).identical
