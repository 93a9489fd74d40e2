"""A motion sensor's samples in the database: blocks of them, each checked."""

import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import msgspec
import sqlite_utils

from sar_tui.framework.bus import Record
from sar_tui.framework.messages import ImuBlock, SensorChanged
from sar_tui.framework.topics import IMU
from sar_tui.store.database import StoreError

if TYPE_CHECKING:
    from sar_tui.motion.samples import Samples

INSERT_STREAM = (
    "INSERT INTO imu_streams (session, stream, seat, run, source, model, serial, rate_hz, rate_range_rad_s,"
    " acceleration_range_m_s2, layout, attached_ns) VALUES (?,?,?,?,?,?,?,?,?,?,?,?)"
)
INSERT_CHUNK = (
    "INSERT INTO imu_chunks (session, stream, seq, n, t0_ns, t1_ns, before_event, at_ns, crc32, data)"
    " VALUES (?,?,?,?,?,?,?,?,?,?)"
)


def layout() -> str:
    """How a sample lies in ``imu_chunks.data``: names, types and shapes as numpy's ``dtype.descr`` has them."""
    from sar_tui.motion.samples import SAMPLE  # loads numpy, which a session without a sensor does not need

    return msgspec.json.encode(SAMPLE.descr).decode()


class Streams:
    """Makes rows of what a sensor tells: a stream each time one is attached, a chunk for the samples between events.

    Chunks begin and end where events lie between them, so that a replay can feed both in their order.

    Args:
        session, run: what the rows belong to.
        stream, seq: the numbers of the last stream and chunk that the session has already.
    """

    def __init__(self, session: str, run: int, stream: int = 0, seq: int = 0) -> None:
        self._session = session
        self._run = run
        self._stream = stream
        self._seq = seq

    def rows(self, records: Sequence[Record]) -> tuple[list[tuple[Any, ...]], list[tuple[Any, ...]], "Streams"]:
        """Rows for ``imu_streams`` and ``imu_chunks``, and where the counting stands after them."""
        after = Streams(self._session, self._run, self._stream, self._seq)
        streams, chunks = [], []
        waiting: list[Record] = []
        for record in records:
            match record.message:
                case ImuBlock():
                    if waiting and waiting[-1].seq != record.seq:
                        chunks.append(after._chunk(waiting))
                        waiting = []
                    waiting.append(record)
                case SensorChanged(state="attached") as sensor:
                    if waiting:
                        chunks.append(after._chunk(waiting))
                        waiting = []
                    streams.append(after._opened(sensor))
        if waiting:
            chunks.append(after._chunk(waiting))
        return streams, chunks, after

    def _opened(self, sensor: SensorChanged) -> tuple[Any, ...]:
        self._stream += 1
        self._seq = 0
        return (
            self._session, self._stream, sensor.seat, self._run, sensor.source, sensor.model, sensor.serial,
            sensor.rate_hz, sensor.rate_range_rad_s, sensor.acceleration_range_m_s2, layout(), sensor.at,
        )  # fmt: skip

    def _chunk(self, records: Sequence[Record]) -> tuple[Any, ...]:
        from sar_tui.motion.samples import unpack

        self._seq += 1
        data = b"".join(record.message.samples for record in records if isinstance(record.message, ImuBlock))
        stamps = unpack(data)["at"]
        return (
            self._session, self._stream, self._seq, len(stamps), int(stamps[0]), int(stamps[-1]), records[0].seq,
            records[-1].at, zlib.crc32(data), data,
        )  # fmt: skip


def counted(db: sqlite_utils.Database, session: str, run: int) -> Streams:
    """Go on counting where a session's streams and chunks end."""
    (stream,) = db.execute("SELECT coalesce(max(stream), 0) FROM imu_streams WHERE session=?", (session,)).fetchone()
    (seq,) = db.execute(
        "SELECT coalesce(max(seq), 0) FROM imu_chunks WHERE session=? AND stream=?", (session, stream)
    ).fetchone()
    return Streams(session, run, stream, seq)


def blocks(db: sqlite_utils.Database, session: str) -> Iterator[Record]:
    """A session's samples as they passed on the bus, each before the event that its record's number names.

    Raises:
        StoreError: a block is damaged.
    """
    for stream, seq, before, at, crc, data in db.execute(
        "SELECT stream, seq, before_event, at_ns, crc32, data FROM imu_chunks WHERE session=? ORDER BY stream, seq",
        (session,),
    ):
        if zlib.crc32(data) != crc:
            raise StoreError(f"Block {seq} of sensor stream {stream} of session {session} is damaged.")
        yield Record(before, at, IMU, ImuBlock(samples=data))


def samples(
    db: sqlite_utils.Database,
    session: str,
    from_ns: int = -(2**63),
    to_ns: int = 2**63 - 1,
    run: int | None = None,
) -> "Samples":
    """A session's samples measured in [from_ns, to_ns), of one run of the program where stamps may recur.

    Raises:
        StoreError: a block is damaged.
    """
    from sar_tui.motion.samples import unpack

    found = []
    for stream, seq, crc, data in db.execute(
        "SELECT imu_chunks.stream, seq, crc32, data FROM imu_chunks JOIN imu_streams USING (session, stream)"
        " WHERE session=:session AND t1_ns>=:first AND t0_ns<:last AND (:run IS NULL OR run=:run)"
        " ORDER BY imu_chunks.stream, seq",
        {"session": session, "first": from_ns, "last": to_ns, "run": run},
    ):
        if zlib.crc32(data) != crc:
            raise StoreError(f"Block {seq} of sensor stream {stream} of session {session} is damaged.")
        found.append(data)
    whole = unpack(b"".join(found))
    inside: Samples = whole[(whole["at"] >= from_ns) & (whole["at"] < to_ns)]
    return inside
