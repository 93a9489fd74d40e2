"""A message is stored in a short form, and read as it was, by the program and in the view
``events``.
"""

import json
from pathlib import Path
from sqlite3 import Connection
from typing import Any

import msgspec
import pytest

from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.topics import KEY, PRESENCE, REPORT, SENSOR, WAITING
from sar_tui.model import messages as m
from sar_tui.store import messages, rows, sessions
from sar_tui.store.database import StoreError, transaction
from tests.played import simulated
from tests.store.by_hand import sql, value

SAMPLES: list[tuple[Topic[Any], m.Message]] = [
    (KEY, m.KeyPressed(key="f", at=5)),
    (KEY, m.KeyPressed(seat="B", key='"\n\\é☺', at=5, loop_lag=3)),
    (WAITING, m.Waiting(what="enter", stage="attempt")),
    (WAITING, m.Waiting(what="enter", stage="attempt", level=3, ask="tab")),
    (PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True, peers={"ana": "operator"})),
    (SENSOR, m.SensorChanged(state="gap", at=5, duration_ms=0.1 + 0.2)),
]  # fmt: skip


SESSION = "5e55100001"


def store(database: Connection, topic: Topic[Any], *given: m.Message) -> None:
    """Store messages with the numbers 1, 2, …, at 7 ns."""
    records = [Record(seq, 7, topic, message) for seq, message in enumerate(given, 1)]
    made = rows.rows_of(SESSION, 1, records, messages.numbers(database, SESSION), "")
    with transaction(database) as connection:
        connection.executemany(rows.SQL["messages"], made["messages"])


def read(database: Connection) -> list[m.Message]:
    return [stored.message for stored in messages.read(database, SESSION)]


@pytest.mark.parametrize(("topic", "message"), SAMPLES)
def test_a_message_is_read_as_is(database: Connection, topic: Topic[Any], message: Any) -> None:
    sessions.create(
        database, SESSION, task="keyboard", theme="calm", participant="P01", seed=1, parameters={},
        software={}, machine={}, mode="live",
    )  # fmt: skip
    store(database, topic, message)
    assert read(database) == [message]
    ((session, seq, run, at, name, text),) = sql(database, "SELECT * FROM events")
    assert (session, seq, run, at, name) == (SESSION, 1, 1, 7, topic.name)
    assert json.loads(text) == msgspec.to_builtins(message)


def test_every_message_of_a_session_is_the_same_in_the_view_and_to_the_program(
    database: Connection, data: Path
) -> None:
    session = simulated(data, operator="careful", attempts=3, prompts_per_attempt=3)
    query = "SELECT seq, run, at_ns, topic, message FROM events WHERE session=?"
    shown = {seq: (*rest, json.loads(text)) for seq, *rest, text in sql(database, query, session)}
    stored = list(messages.read(database, session))
    assert len({one.topic for one in stored}) > 15
    assert [one.seq for one in stored] == sorted(shown)
    for seq, run, at, topic, message in stored:
        told = json.loads(msgspec.json.encode(message))
        assert shown[seq] == (run, at, topic.name, told), topic.name


def test_a_message_of_a_version_with_other_fields_is_read_with_the_defaults_of_that_version(
    database: Connection,
) -> None:
    store(database, KEY, m.KeyPressed(key="f", at=5, loop_lag=9))
    fields = '[["at"],["key"],["loop_lag",4],["pressure",1]]'
    sql(database, "INSERT INTO topics (name, fields) VALUES ('input/key', ?)", fields)
    sql(database, "UPDATE messages SET topic=last_insert_rowid(), message='[5,\"f\"]'")
    assert read(database) == [m.KeyPressed(key="f", at=5, loop_lag=4)]
    text = value(database, "SELECT message FROM events")
    assert json.loads(text) == {"at": 5, "key": "f", "loop_lag": 4, "pressure": 1}


@pytest.mark.parametrize(
    "damage",
    [
        "messages SET topic=999",
        "topics SET name='input/none' WHERE name='input/key'",
        *(f"messages SET message='{text}'" for text in ("[]", "[7, 5]", "not json", "{}", "[1]")),
    ],
)
def test_a_message_that_cannot_be_read_is_named(database: Connection, damage: str) -> None:
    store(database, KEY, m.KeyPressed(key="f", at=5))
    sql(database, f"UPDATE {damage}")
    with pytest.raises(StoreError, match=f"Message 1 of session {SESSION} cannot be read"):
        read(database)


def test_the_names_of_a_topic_and_its_fields_are_stored_once(database: Connection) -> None:
    store(database, KEY, m.KeyPressed(key="f", at=5))
    before = sql(database, "SELECT * FROM topics")
    here = messages.numbers(database, "another")
    assert sql(database, "SELECT * FROM topics") == before
    assert here.topics[PRESENCE.name] == messages.PRESENCE_ID, "which its index names"


def test_a_report_is_read_and_written_with_its_stored_names() -> None:
    """Pages for authors of plug-ins read the stored ``deed`` under the name ``part``."""
    stored = {"seat": "A", "action": "a1", "output": "speech", "deed": "say", "state": "done", "at": 7,
              "detail": ""}  # fmt: skip
    message = msgspec.json.decode(msgspec.json.encode(stored), type=REPORT.type)
    assert message.part == "say"
    assert msgspec.json.decode(msgspec.json.encode(message)) == stored
