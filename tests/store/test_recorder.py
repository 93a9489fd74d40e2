"""The recorder acknowledges exactly the trials that are stored."""

import sqlite3
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec
import pytest
from sqlite_utils import Database

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ACTION,
    ALL,
    ATTEMPT_ENDED,
    COMMAND,
    MARKED,
    STORAGE,
    STORED,
    TRIAL,
    WAITING,
)
from sar_tui.model.messages import (
    SessionCommand,
    StorageChanged,
    Stored,
    Timing,
    TrialEnded,
    TrialMarked,
)
from sar_tui.model.units import SECOND
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output, Report
from sar_tui.rules.parameters import build
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.messages import Numbers, numbers
from sar_tui.store.recorder import GROUP, Recorder
from sar_tui.store.rows import rows_of
from sar_tui.store.tables import ATTEMPTS, TRIALS
from tests.outputs.fake_outputs import FakeOutput, Speaker
from tests.played import catalogue
from tests.store.by_hand import sql, value
from tests.store.test_sessions import enter

A_TRIAL = TrialEnded(
    attempt=1, trial=1, stimulus="f", response="f", correct=True, onset=0, response_at=1,
    reaction_time_ms=1.0, value=1.0, timing=Timing("virtual", 0.0, 0.0, 0, 1, 0.0, ()), details={},
)  # fmt: skip


class Recorded:
    """A simulated session with a recorder that works inline, or on calls of
    ``write_on_a_thread``.
    """

    def __init__(
        self, data: Path, *, inline: bool = True, seed: int = 3, outputs: Sequence[Output] = (),
        **parameters: Any,
    ) -> None:  # fmt: skip
        theme, kind = catalogue().theme("calm"), catalogue().task("keyboard")
        settings = {"attempts": 2, "prompts_per_attempt": 3, **parameters}
        task: Task = kind(build(kind.Parameters, settings))
        extra: list[Node] = [SimulatedParticipant(PEOPLE["average"], task, seed)]
        extra += [OutputNode(output, output.name, theme) for output in outputs]
        self.clock = VirtualClock()
        self.session = Session(task, theme, self.clock, seed, extra)
        self.database, self.reader = connect(data), connect(data)
        self.id = enter(self.database, seed=seed, parameters=task.parameters)
        sessions.begin_run(self.database, self.id, software={}, machine={})
        self.recorder = Recorder(self.database, self.id, 1, self.session.bus, inline=inline)
        self.records: list[Record] = []
        self.session.bus.tap(self.records.extend)

    def step(self) -> bool:
        return not self.session.ended and self.clock.step()

    def finish(self) -> "Recorded":
        while self.step():
            pass
        return self

    def play(self) -> "Recorded":
        """Play the whole session, and store it."""
        self.session.begin()
        self.finish()
        self.recorder.write()
        return self

    def until(self, is_so: Callable[[], object]) -> None:
        while not is_so():
            assert self.step()

    def write_on_a_thread(self) -> None:
        """Write once in another thread, as the recorder's own does."""
        thread = threading.Thread(target=self.recorder.try_write)
        thread.start()
        thread.join()

    def write_and_hear(self) -> None:
        """Write in another thread, and take what it tells."""
        self.write_on_a_thread()
        self.clock.advance(0)

    def all(self, topic: Any) -> list[Any]:
        return [record.message for record in self.records if record.topic is topic]

    def stored(self, table: str) -> list[Any]:
        """Return what another program sees in the database."""
        order = "seq" if table == "events" else "rowid"
        query = f"SELECT * FROM {table} WHERE session=? ORDER BY {order}"
        return list(Database(self.reader).query(query, [self.id]))

    @property
    def trials(self) -> list[tuple[int, int]]:
        """Attempts and trials that are stored."""
        return [(row["attempt"], row["trial"]) for row in self.stored("trials")]

    @property
    def actions(self) -> list[dict[str, Any]]:
        return sessions.rows(self.reader, "actions", self.id)

    @property
    def history(self) -> list[Record]:
        return list(sessions.history(self.reader, self.id))


def test_a_whole_session_is_in_the_tables_as_it_was_on_the_bus(data: Path) -> None:
    recorded = Recorded(data).play()
    assert recorded.history == recorded.records
    assert recorded.recorder.pending == 0
    tables = ("events", "trials", "attempts")
    assert {row["run"] for table in tables for row in recorded.stored(table)} == {1}
    ((status, ended),) = sql(data, "SELECT status, ended_at FROM sessions")
    assert (status, ended is not None) == ("completed", True)
    for table, topic in ((TRIALS, TRIAL), (ATTEMPTS, ATTEMPT_ENDED)):
        rows = sessions.rows(recorded.reader, table.name, recorded.id)  # type: ignore[arg-type]
        columns = [column for column in table.columns if column.name not in ("session", "run")]
        for row, message in zip(rows, recorded.all(topic), strict=True):
            fields = msgspec.json.decode(msgspec.json.encode(message))
            for column in columns:
                assert row[column.name] == fields[column.field or column.name], column.name
    kinds = ["greeting", "instruction", "feedback", "feedback", "goodbye"]
    assert [row["kind"] for row in recorded.actions] == kinds
    for row, action in zip(recorded.actions, recorded.all(ACTION), strict=True):
        assert row["final"] == msgspec.to_builtins(action)
        assert row["proposed"]["text"] == row["final"]["text"]
        assert (row["decision"], row["actor"]) == ("accepted", "agent")
        assert row["proposed_ns"] <= row["decided_ns"] <= row["started_ns"] <= row["ended_ns"]


def test_a_dropped_action_is_stored_with_who_dropped_it(data: Path) -> None:
    recorded = Recorded(data, outputs=[Speaker(60_000)])
    recorded.session.begin()
    recorded.clock.advance(SECOND)
    at = recorded.clock.now()
    recorded.session.bus.publish(COMMAND, SessionCommand(command="stop", at=at))
    recorded.finish()
    recorded.recorder.write()
    greeting, instruction = recorded.actions[:2]
    names = ("kind", "decision", "actor", "decided_ns", "started_ns", "ended_ns")
    assert [greeting[name] for name in names] == ["greeting", "accepted", "agent", 0, 0, at]
    dropped = ["instruction", "dropped", "stop", at, None, None]
    assert [instruction[name] for name in names] == dropped
    assert instruction["final"] is None
    assert instruction["proposed"]["spoken"] == recorded.session.task.instructions()


def test_an_action_lasts_from_its_first_part_to_its_last_in_any_order(data: Path) -> None:
    robot = FakeOutput("robot", frozenset({"say"}))
    recorded = Recorded(data, outputs=[Speaker(2000), robot])
    recorded.session.begin()
    recorded.clock.advance(SECOND // 2)
    robot.report("a1", "say", "started")
    recorded.clock.advance(2 * SECOND)
    robot._send_report(Report("a1", "say", "done", SECOND))
    recorded.clock.advance(0)
    recorded.recorder.write()
    assert [recorded.actions[0][f"{end}_ns"] for end in ("started", "ended")] == [0, 2 * SECOND]


def test_on_a_virtual_clock_trials_are_acknowledged_at_once_and_written_together(
    data: Path,
) -> None:
    recorded = Recorded(data, attempts=12, prompts_per_attempt=20)
    # stored before the first message, in a transaction of their own
    numbers(recorded.database, recorded.id)
    statements: list[str] = []
    recorded.database.set_trace_callback(statements.append)
    recorded.session.begin()
    recorded.finish()
    trials = [(attempt, trial) for attempt in range(1, 13) for trial in range(1, 21)]
    assert [(stored.attempt, stored.trial) for stored in recorded.all(STORED)] == trials
    assert recorded.trials == trials
    assert statements.count("COMMIT") == 1 + len(recorded.records) // GROUP == 2
    recorded.recorder.write()
    assert recorded.history == recorded.records


def test_on_a_thread_a_trial_is_acknowledged_once_it_was_written(data: Path) -> None:
    recorded = Recorded(data, inline=False)
    recorded.session.begin()
    recorded.until(lambda: recorded.all(TRIAL))
    assert recorded.stored("events") == []
    recorded.until(lambda: recorded.all(WAITING)[-1].what == "storage")
    recorded.write_on_a_thread()
    assert recorded.trials == [(1, 1)]
    assert recorded.all(STORED) == []
    recorded.until(lambda: recorded.all(STORED))
    assert recorded.all(STORED) == [Stored(attempt=1, trial=1)]
    assert recorded.all(WAITING)[-1].what == "response"


def test_a_stopped_thread_writes_the_remaining_messages_and_ends(data: Path) -> None:
    recorded = Recorded(data, inline=False)
    stopped = threading.Event()
    thread = threading.Thread(target=recorded.recorder.run, args=(stopped.is_set,))
    recorded.session.begin()
    thread.start()
    recorded.session.bus.publish(STORAGE, StorageChanged(working=True))
    stopped.set()
    recorded.recorder.wake()
    thread.join()
    assert recorded.recorder.pending == 0
    assert recorded.history == recorded.records
    with pytest.raises(sqlite3.ProgrammingError, match="closed"):
        recorded.database.execute("SELECT 1")


def fill(recorded: Recorded) -> None:
    """Fill the disk: the database can no longer grow."""
    pages = value(recorded.database, "PRAGMA page_count")
    sql(recorded.database, f"PRAGMA max_page_count={pages}")


def make_room(recorded: Recorded) -> None:
    sql(recorded.database, "PRAGMA max_page_count=1000000")


def test_on_a_full_disk_only_stored_trials_are_acknowledged_and_later_all(data: Path) -> None:
    recorded = Recorded(data, inline=False, attempts=3, prompts_per_attempt=20)
    acknowledged: list[tuple[int, int]] = []

    def check(stored: Stored) -> None:
        acknowledged.append((stored.attempt, stored.trial))
        assert acknowledged[-1] in recorded.trials

    recorded.session.bus.subscribe(STORED, check)
    recorded.session.begin()
    fill(recorded)
    while not recorded.all(STORAGE):
        before = len(recorded.all(WAITING))
        recorded.until(lambda before=before: len(recorded.all(WAITING)) > before)
        recorded.write_and_hear()
        assert set(acknowledged) <= set(recorded.trials)
    (refusal,) = recorded.all(STORAGE)
    assert not refusal.working
    assert "The disk is full" in refusal.reason
    waiting = recorded.all(WAITING)[-1]
    assert (waiting.stage, waiting.reason) == ("paused", "storage")
    there = recorded.trials
    for _ in range(3):
        recorded.write_and_hear()
    assert len(recorded.all(STORAGE)) == 1
    assert recorded.recorder.pending > 0
    assert recorded.trials == there

    make_room(recorded)
    recorded.write_and_hear()
    assert [storage.working for storage in recorded.all(STORAGE)] == [False, True]
    assert recorded.all(WAITING)[-1].reason == "restored"
    while not recorded.session.ended:
        assert recorded.step()
        if recorded.all(WAITING)[-1].what == "storage":
            recorded.write_and_hear()
    recorded.write_on_a_thread()
    assert len(recorded.all(STORAGE)) == 2
    assert acknowledged == [(attempt, trial) for attempt in (1, 2, 3) for trial in range(1, 21)]
    assert recorded.history == recorded.records
    assert recorded.trials == acknowledged
    assert recorded.session.faults == []


def test_other_errors_than_a_full_disk_are_reported_each_and_everything_is_stored(
    data: Path,
) -> None:
    recorded = Recorded(data, inline=False)
    recorded.session.begin()
    sql(recorded.database, "PRAGMA query_only=1")
    recorded.write_and_hear()
    sql(recorded.database, "PRAGMA query_only=0")
    here = numbers(recorded.reader, recorded.id)
    first_number = (here.session, here.topics["input/key"])
    sql(recorded.reader, "INSERT INTO messages VALUES (?,1,1,0,?,'[]')", *first_number)
    for _ in range(3):
        recorded.write_and_hear()
    first, second = recorded.all(STORAGE)
    assert (first.working, second.working) == (False, False)
    assert "is read-only" in first.reason
    assert "UNIQUE constraint failed: messages.session_number, messages.seq" in second.reason
    assert "full" not in second.reason
    assert recorded.recorder.pending > 0
    sql(recorded.reader, "DELETE FROM messages")
    recorded.write_and_hear()
    assert recorded.all(STORAGE)[-1].working


@pytest.mark.parametrize(
    ("odd", "why"),
    [({"details": {"odd": object()}}, "TypeError"), ({"onset": 2**70}, "OverflowError")],
)
def test_a_message_that_cannot_be_written_ends_no_thread(data: Path, odd: Any, why: str) -> None:
    recorded = Recorded(data, inline=False)
    recorded.session.begin()
    recorded.recorder([Record(1000, 0, TRIAL, msgspec.structs.replace(A_TRIAL, **odd))])
    for _ in range(2):
        recorded.write_and_hear()
    (refusal,) = recorded.all(STORAGE)
    assert f"cannot be stored ({why}: " in refusal.reason
    assert recorded.recorder.pending > 0
    with pytest.raises(StoreError) as caught:
        recorded.recorder.write()
    assert not caught.value.temporary


def test_on_a_virtual_clock_a_full_disk_raises_and_everything_before_it_is_kept(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.store.recorder.GROUP", 50)
    recorded = Recorded(data, attempts=5, prompts_per_attempt=20)
    fill(recorded)
    recorded.session.begin()
    with pytest.raises(StoreError, match="The disk is full"):
        recorded.finish()
    done = [(trial.attempt, trial.trial) for trial in recorded.all(TRIAL)]
    assert recorded.trials == done[: len(recorded.trials)]
    assert recorded.recorder.pending > 0
    make_room(recorded)
    recorded.recorder.write()
    assert recorded.recorder.pending == 0
    assert recorded.history[: len(recorded.records)] == recorded.records


NUMBERS = Numbers(1, dict.fromkeys(ALL, 2))


def marked(seat: str = "A", mark: str = "leaned") -> TrialMarked:
    return TrialMarked(seat=seat, attempt=1, trial=2, mark=mark, correct=True)


def test_a_mark_before_its_trials_row_is_in_it_and_one_after_is_stored_apart() -> None:
    before, other, ended = (
        (MARKED, marked()),
        (MARKED, marked("B")),
        (TRIAL, msgspec.structs.replace(A_TRIAL, trial=2)),
    )
    after = (MARKED, marked(mark=""))
    for given, marks in (
        ((before, other, ended), [(True, "leaned", "s", 1, 2, "B")]),
        ((ended, after), [(True, None, "s", 1, 2, "A")]),
    ):
        records = [
            Record(seq, seq, topic, message) for seq, (topic, message) in enumerate(given, 1)
        ]
        assert rows_of("s", 1, records, NUMBERS, "")["marks"] == marks
