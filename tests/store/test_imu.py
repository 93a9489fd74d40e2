"""Samples of a sensor are stored completely and in order."""

import json
import zlib
from collections.abc import Iterable
from pathlib import Path
from sqlite3 import Connection
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlite_utils import Database

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.topics import (
    IMU,
    KEY,
    REACH,
    SENSOR,
    STORAGE,
    STORED,
    TRIAL,
    TRUNK_IMU,
    TRUNK_SENSOR,
)
from sar_tui.model.messages import ImuBlock, KeyPressed, SensorChanged
from sar_tui.motion.samples import SAMPLE, Samples, pack, unpack
from sar_tui.store import imu, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.recorder import Recorder
from sar_tui.store.tables import IMU_CHUNKS
from tests.examples import examples
from tests.store.by_hand import sql
from tests.store.test_sessions import enter
from tests.tasks.reaching.reaching_driver import ReachingDriver, merged

NAMES = tuple(column.name for column in IMU_CHUNKS.columns)


# --- rows of messages


def block(before: int, *stamps: int, at: int = 0) -> Record:
    """Return a block of samples that precedes the message with a number."""
    samples = np.zeros(len(stamps), SAMPLE)
    samples["at"] = stamps
    return Record(before, at or stamps[-1], IMU, ImuBlock(samples=pack(samples)))


def key(seq: int) -> Record:
    return Record(seq, seq, KEY, KeyPressed(key="x", at=seq))


def attached(seq: int, **facts: Any) -> Record:
    return Record(seq, seq, SENSOR, SensorChanged(state="attached", at=seq, **facts))


def chunks(*records: Record, streams: imu.StreamRows | None = None) -> list[dict[str, Any]]:
    rows = (streams or imu.StreamRows("s", 1)).rows(records)[1]
    return [dict(zip(NAMES, row, strict=True)) for row in rows]


def test_samples_are_one_chunk_until_a_message_divides_them() -> None:
    """A block has no number of its own: it carries the number of the message that is derived from
    it.
    """
    (chunk,) = chunks(attached(1), block(2, 10, 20), block(2, 30, at=35), key(2))
    names = ("n", "t0_ns", "t1_ns", "before_event", "at_ns")
    assert [chunk[name] for name in names] == [3, 10, 30, 2, 35]
    assert unpack(chunk["data"])["at"].tolist() == [10, 20, 30]
    assert chunk["crc32"] == zlib.crc32(chunk["data"])
    records = (attached(1), block(2, 10), block(2, 20), key(2), key(3), block(4, 30))
    names = ("stream", "seq", "before_event", "n", "t1_ns")
    found = [[chunk[name] for name in names] for chunk in chunks(*records)]
    assert found == [[1, 1, 2, 2, 20], [1, 2, 4, 1, 30]]


def test_only_an_attachment_begins_a_stream_whose_chunks_are_counted_from_one() -> None:
    states: Any = "detached gap saturated stalled flowing error ended".split()
    others = [Record(3, 3, SENSOR, SensorChanged(state=state, at=3)) for state in states]
    facts = {"source": "test", "model": "By hand", "serial": "7", "rate_hz": 250.0,
             "rate_range_rad_s": 5.0}  # fmt: skip
    again = [attached(4, **facts), block(5, 30)]
    records = [attached(1), block(2, 10), key(2), *others, block(4, 20), *again]
    streams, rows, _ = imu.StreamRows("s", 4).rows(records)
    assert [(row[1], row[2]) for row in rows] == [(1, 1), (1, 2), (2, 1)]
    assert [row[:4] for row in streams] == [("s", 1, "A", 4), ("s", 2, "A", 4)]
    assert streams[1][4:] == (*facts.values(), 0.0, imu.layout(), 4, "hand")


def test_hand_and_trunk_have_their_own_streams_and_a_replay_gets_the_trunk_first(
    database: Connection,
) -> None:
    trunk = Record(1, 1, TRUNK_SENSOR, SensorChanged(state="attached", at=1))
    leaning = Record(5, 40, TRUNK_IMU, block(5, 10, 20).message)
    records = [attached(1), trunk, block(5, 30), leaning, block(5, 50), key(5)]
    streams, rows, _ = imu.StreamRows("s", 1).rows(records)
    database.executemany(imu.INSERT_STREAM, streams)
    database.executemany(imu.INSERT_CHUNK, rows)
    found = [(each.topic, len(unpack(each.message.samples))) for each in imu.blocks(database, "s")]
    assert found == [(TRUNK_IMU, 2), (IMU, 2)]
    assert [len(imu.samples(database, "s", part=part)) for part in ("hand", "trunk")] == [2, 2]
    resumed = imu.resume_streams(database, "s", 2)
    assert [row[1:3] for row in resumed.rows([leaning, block(5, 60)])[1]] == [(2, 2), (1, 2)]


def test_chunks_are_counted_across_batches_once_they_are_stored() -> None:
    streams = imu.StreamRows("s", 1)
    batch = [attached(1), block(2, 10)]
    first, again = streams.rows(batch), streams.rows(batch)
    assert first[:2] == again[:2], "a batch that was not stored is numbered as before"
    (next_chunk,) = chunks(block(2, 20), streams=first[2])
    assert (next_chunk["stream"], next_chunk["seq"]) == (1, 2)


def test_the_layout_says_how_to_read_the_bytes_without_this_program() -> None:
    layout = [(name, kind, tuple(*shape)) for name, kind, *shape in json.loads(imu.layout())]
    assert np.dtype(layout) == SAMPLE


# --- a session in the database


class StoredSession:
    """A recorded reaching session; the recorder works inline, or on calls of ``write``."""

    def __init__(
        self,
        data: Path,
        *,
        inline: bool = True,
        of: "StoredSession | None" = None,
        **parameters: Any,
    ) -> None:
        self.data, self.inline = data, inline
        self.database, self.reader = connect(data), connect(data)
        self.id = of.id if of else enter(self.database, task="reaching")
        history = list(sessions.history(self.database, self.id)) if of else None
        run = sessions.begin_run(self.database, self.id, software={}, machine={})
        self.driver = ReachingDriver(begin=False, history=history, **parameters)
        self.driver.screen.stores = False
        bus = self.driver.session.bus
        self.recorder = Recorder(self.database, self.id, run, bus, inline=inline)
        self.driver.session.begin(run)

    def do(self, reaches: int) -> "StoredSession":
        """Do a number of reaches, one per attempt, starting at the instructions."""
        self.driver.start_session(rest_ms=2000)
        self.driver.reach()
        for _ in range(reaches - 1):
            self.driver.wait(300)
            self.driver.begin()
            self.driver.reach()
        if self.inline:
            self.recorder.write()
        return self

    def write(self) -> None:
        """Write as the recorder's thread does, and handle its acknowledgements."""
        self.recorder.try_write()
        self.driver.wait(0)

    @property
    def history(self) -> list[Record]:
        return list(sessions.history(self.reader, self.id))

    @property
    def streams(self) -> list[dict[str, Any]]:
        return sessions.rows(self.reader, "imu_streams", self.id)

    def chunks(self, stream: int = 0) -> list[dict[str, Any]]:
        """Return the chunks of a stream, or of all, which must be counted from one."""
        query = "SELECT * FROM imu_chunks WHERE session=? ORDER BY stream, seq"
        found = list(Database(self.reader).query(query, [self.id]))
        for each in {chunk["stream"] for chunk in found}:
            seqs = [chunk["seq"] for chunk in found if chunk["stream"] == each]
            assert seqs == list(range(1, len(seqs) + 1))
        return [chunk for chunk in found if stream in (0, chunk["stream"])]

    def samples(self, from_ns: int = 0, to_ns: int = 2**62, run: int | None = None) -> Samples:
        return imu.samples(self.reader, self.id, from_ns, to_ns, run)

    def assert_whole(self) -> None:
        """All that passed is stored, and derived again from what is stored."""
        assert self.samples().tobytes() == self.driver.samples.tobytes()
        assert merged(self.history) == merged(self.driver.records)
        assert replayed(self.history, self.driver) == events(self.driver.records)


def test_samples_and_messages_do_not_depend_on_how_many_are_written_at_a_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for group in (1, 100, 5000):
        monkeypatch.setattr("sar_tui.store.recorder.GROUP", group)
        stored = StoredSession(tmp_path / str(group)).do(2)
        rows = [{**chunk, "session": ""} for chunk in stored.chunks()]
        found.append((rows, stored.history))
    assert found[0] == found[1] == found[2]


def test_every_sample_is_stored_in_few_rows_and_found_by_when_it_was_measured(data: Path) -> None:
    stored = StoredSession(data).do(2)
    (stream,) = stored.streams
    names = ("stream", "run", "source", "rate_hz")
    assert [stream[name] for name in names] == [1, 1, "simulated", 250.0]
    stamps = stored.driver.samples["at"]
    assert sum(chunk["n"] for chunk in stored.chunks()) == len(stamps) > 1500
    blocks = [record for record in stored.driver.records if record.topic is IMU]
    assert len(stored.chunks()) < len(blocks) / 4, "few rows, not one a block"
    for first, last in [(0, 1), (100, 100), (249, 900), (0, len(stamps) - 1)]:
        found = stored.samples(int(stamps[first]), int(stamps[last]))
        assert found["at"].tolist() == stamps[first:last].tolist()
    assert len(stored.samples(int(stamps[-1]))) == 1
    assert len(stored.samples(0, int(stamps[0]))) == 0
    assert len(stored.samples(run=2)) == 0
    assert len(imu.samples(stored.reader, "another", 0, 2**62)) == 0


def test_a_damaged_block_is_named_and_never_taken_for_samples(data: Path) -> None:
    stored = StoredSession(data).do(1)
    number = len(stored.chunks()) // 2
    damaged, following = stored.chunks()[number - 1 : number + 1]
    whole = damaged["data"]
    a_byte_changed = bytes([whole[0] ^ 1]) + whole[1:]
    for bad in (a_byte_changed, whole[: -SAMPLE.itemsize], following["data"]):
        sql(data, "UPDATE imu_chunks SET data=? WHERE session=? AND seq=?", bad, stored.id, number)
        words = f"Block {number} of sensor stream 1 of session {stored.id} is damaged"
        for read in (stored.samples, lambda: stored.history):
            with pytest.raises(StoreError, match=words):
                read()
        assert len(stored.samples(0, damaged["t0_ns"])), "what is not damaged can still be read"


def events(records: Iterable[Record]) -> list[Record]:
    return [record for record in records if record.topic is not IMU]


# --- resumed


def replayed(history: list[Record], driver: ReachingDriver) -> list[Record]:
    """Return the messages that the nodes derive from a history."""
    again = Session(driver.session.task, driver.session.theme, VirtualClock(), 1)
    derived: list[Record] = []
    again.bus.tap(derived.extend)
    again.replay(history)
    return events(derived)


@pytest.mark.parametrize(
    "parameters",
    [{}, {"go_signal": True}, {"sensor": "patient"}, {"detector": "fixed-threshold"}],
)
def test_a_sensors_session_is_derived_again_from_rows(data: Path, parameters: Any) -> None:
    stored = StoredSession(data, **parameters).do(2)
    assert len(stored.driver.all(REACH)) >= 2
    stored.assert_whole()


@examples(15)
@given(st.data())
def test_a_session_cut_off_anywhere_and_written_in_any_batches_can_be_replayed(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Samples that were written together are read as one block, including a long wait for a go
    signal.
    """
    folder, signal = tmp_path_factory.mktemp("stored"), data.draw(st.booleans())
    stored = StoredSession(folder, inline=False, go_signal=signal, attempts=1)
    driver = stored.driver

    def wait(most: int) -> None:
        for _ in range(data.draw(st.integers(0, most))):
            driver.wait(data.draw(st.integers(20, 900)))
            stored.write()

    driver.start_session(rest_ms=1000)
    driver.start()
    driver.move(200)
    wait(8)
    if data.draw(st.booleans()):
        driver.press("space")
    wait(4)
    assert replayed(stored.history, driver) == events(stored.history)
    go_signal = driver.session.task.has_foreperiod
    resumed = StoredSession(stored.data, of=stored, go_signal=go_signal, attempts=1)
    assert resumed.driver.session.faults == []


def test_a_trial_is_acknowledged_with_its_samples_and_a_second_run_has_the_next_stream(
    data: Path,
) -> None:
    first = StoredSession(data, inline=False).do(1)
    assert first.driver.all(STORED) == []
    first.write()
    assert first.driver.all(STORED) != []
    details = first.driver.last(TRIAL).details
    window = (int(details[name] or 0) for name in ("window_from_ns", "window_to_ns"))
    assert len(first.samples(*window)) == details["samples"]
    first.driver.wait(300)
    first.driver.begin()
    first.driver.start()
    first.driver.move(100)
    first.driver.wait(600)
    first.write()
    before, cut = first.chunks(), first.history

    second = StoredSession(data, of=first)
    second.driver.wait(100)
    assert second.driver.waiting.reason == "interrupted"
    second.driver.enter()
    second.driver.wait(2000)
    assert second.driver.reach().correct
    second.recorder.write()
    assert [(stream["stream"], stream["run"]) for stream in second.streams] == [(1, 1), (2, 2)]
    assert second.chunks()[: len(before)] == before
    assert second.samples(run=2).tobytes() == second.driver.samples.tobytes()
    assert second.samples(run=1).tobytes() == first.driver.samples.tobytes()
    stored = events(second.history)
    assert [each.seq for each in stored] == list(range(1, len(stored) + 1))
    assert merged(second.history) == merged([*cut, *second.driver.records])
    assert replayed(second.history, second.driver) == stored


# --- a full disk


def test_samples_wait_while_the_disk_is_full_and_none_is_lost_or_doubled(data: Path) -> None:
    stored = StoredSession(data, inline=False)
    driver = stored.driver
    driver.start_session(rest_ms=500)
    stored.write()
    there = stored.chunks()
    sql(stored.database, "PRAGMA query_only=1")
    driver.wait(1000)
    for _ in range(3):
        stored.write()
        driver.wait(700)
    assert [storage.working for storage in driver.all(STORAGE)] == [False]
    assert (driver.waiting.stage, driver.waiting.reason) == ("paused", "storage")
    assert stored.chunks() == there

    sql(stored.database, "PRAGMA query_only=0")
    stored.write()
    assert driver.waiting.reason == "restored"
    driver.enter()
    driver.wait(2000)
    driver.start()
    driver.move(200)
    driver.wait(2000)
    driver.press("space")
    driver.to_row()
    stored.write()
    stored.write()
    stored.assert_whole()
