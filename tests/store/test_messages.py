"""A message is stored in a short form, and read as it was, by the program and in the view
``events``.
"""

import json
import sqlite3
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.task import Task
from sar_tui.loop.topics import KEY, PRESENCE, SENSOR, WAITING
from sar_tui.model import messages as m
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.operator import PROFILES
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import messages, rows, sessions
from sar_tui.store.database import StoreError, transaction

SESSION = "5e55100001"


def store(database: sqlite3.Connection, topic: Topic[Any], *given: m.Message) -> None:
    """Store messages with the numbers 1, 2, …, at 7 ns."""
    records = [Record(seq, 7, topic, message) for seq, message in enumerate(given, 1)]
    made = rows.rows_of(SESSION, 1, records, messages.numbers(database, SESSION))
    with transaction(database) as connection:
        connection.executemany(rows.SQL["messages"], made["messages"])


def read(database: sqlite3.Connection) -> list[m.Message]:
    return [stored.message for stored in messages.read(database, SESSION)]


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        (KEY, m.KeyPressed(key="f", at=5)),
        (KEY, m.KeyPressed(seat="B", key='"\n\\é☺', at=5, loop_lag=3)),
        (WAITING, m.Waiting(what="enter", stage="attempt")),
        (WAITING, m.Waiting(what="enter", stage="attempt", level=3, ask="tab")),
        (
            PRESENCE,
            m.OperatorChanged(
                actor="operator.ana", state="joined", operated=True, peers={"ana": "operator"}
            ),
        ),
        (SENSOR, m.SensorChanged(state="gap", at=5, duration_ms=0.1 + 0.2)),
    ],
)
def test_a_message_is_read_as_it_was(
    database: sqlite3.Connection, topic: Topic[Any], message: m.Message
) -> None:
    sessions_row(database)
    store(database, topic, message)
    assert read(database) == [message]
    ((session, seq, run, at, name, text),) = database.execute("SELECT * FROM events").fetchall()
    assert (session, seq, run, at, name) == (SESSION, 1, 1, 7, topic.name)
    assert json.loads(text) == msgspec.to_builtins(message)


def sessions_row(database: sqlite3.Connection) -> None:
    sessions.create(
        database, SESSION, task="keyboard", theme="calm", participant="P01", seed=1, parameters={},
        software={}, machine={}, mode="live",
    )  # fmt: skip


def test_messages_after_a_number_can_be_read_alone(database: sqlite3.Connection) -> None:
    pressed = [m.KeyPressed(key=key, at=1) for key in "abc"]
    store(database, KEY, *pressed)


def test_every_message_of_a_session_is_the_same_in_the_view_and_to_the_program(
    database: sqlite3.Connection, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    plan = make_plan(
        catalogue,
        keyboard,
        ["SIM"],
        {"attempts": 3, "prompts_per_attempt": 3},
        seed=3,
        mode="simulated",
    )
    session = simulate(plan, PEOPLE["average"], data, catalogue, operator=PROFILES["careful"])
    seen = database.execute(
        "SELECT seq, run, at_ns, topic, message FROM events WHERE session=?", (session,)
    )
    shown = {seq: (run, at, topic, json.loads(text)) for seq, run, at, topic, text in seen}
    stored = list(messages.read(database, session))
    assert len({one.topic for one in stored}) > 15
    assert [one.seq for one in stored] == sorted(shown)
    for seq, run, at, topic, message in stored:
        assert shown[seq] == (run, at, topic.name, json.loads(msgspec.json.encode(message))), (
            topic.name
        )


def test_messages_take_half_the_space_of_their_objects(
    database: sqlite3.Connection, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    plan = make_plan(catalogue, keyboard, ["SIM"], {"attempts": 2}, seed=3, mode="simulated")
    simulate(plan, PEOPLE["average"], data, catalogue)
    ((objects, names),) = database.execute(
        "SELECT sum(length(message)), sum(length(session) + length(topic)) FROM events WHERE "
        "topic<>'theme/applied'"
    ).fetchall()
    ((stored,),) = database.execute(
        "SELECT sum(length(message)) FROM messages JOIN topics ON id=topic WHERE name<>'theme/applied'"
    ).fetchall()
    assert stored < 0.4 * (objects + names)


def test_a_message_of_a_version_with_other_fields_is_read_with_the_defaults_of_that_version(
    database: sqlite3.Connection,
) -> None:
    store(database, KEY, m.KeyPressed(key="f", at=5, loop_lag=9))
    database.execute(
        "INSERT INTO topics (name, fields) VALUES ('input/key', ?)",
        ('[["at"],["key"],["loop_lag",4],["pressure",1]]',),
    )
    database.execute("UPDATE messages SET topic=last_insert_rowid(), message='[5,\"f\"]'")
    assert read(database) == [m.KeyPressed(key="f", at=5, loop_lag=4)]
    ((text,),) = database.execute("SELECT message FROM events").fetchall()
    assert json.loads(text) == {"at": 5, "key": "f", "loop_lag": 4, "pressure": 1}


@pytest.mark.parametrize("text", ["[]", "[7, 5]", "not json", "{}"])
def test_a_message_that_cannot_be_read_is_named(database: sqlite3.Connection, text: str) -> None:
    store(database, KEY, m.KeyPressed(key="f", at=5))
    database.execute("UPDATE messages SET message=?", (text,))
    with pytest.raises(StoreError, match=f"Message 1 of session {SESSION} cannot be read"):
        read(database)


def test_a_message_whose_topic_is_damaged_is_named(database: sqlite3.Connection) -> None:
    store(database, KEY, m.KeyPressed(key="f", at=5))
    database.execute("UPDATE messages SET topic=999")
    with pytest.raises(StoreError, match=f"Message 1 of session {SESSION} cannot be read"):
        read(database)


def test_the_names_of_a_topic_and_its_fields_are_stored_once(database: sqlite3.Connection) -> None:
    store(database, KEY, m.KeyPressed(key="f", at=5))
    before = database.execute("SELECT * FROM topics").fetchall()
    messages.numbers(database, "another")
    assert database.execute("SELECT * FROM topics").fetchall() == before


def test_the_number_of_presence_is_the_one_in_its_index(database: sqlite3.Connection) -> None:
    here = messages.numbers(database, SESSION)
    assert here.topics[PRESENCE.name] == messages.PRESENCE_ID
