"""Samples of motion sensors in the database, in blocks with checksums."""

import sqlite3
import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import msgspec

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


_OF_SENSORS = {ImuBlock, SensorChanged}


def layout() -> str:
    """Return the layout of a sample in ``imu_chunks.data``: names, types and shapes, as in numpy's ``dtype.descr``."""
    from sar_tui.motion.samples import SAMPLE  # imports numpy, which a session without a sensor does not need

    return msgspec.json.encode(SAMPLE.descr).decode()


class StreamRows:
    """Makes rows from sensor messages: a stream for each time a sensor is attached, a chunk for samples between events.

    Events between samples end a chunk, so that a replay can feed both in order. Each seat has its own sensor.

    Args:
        session, run: the session and the run that the rows belong to.
        stream: number of the last stored stream.
        last: numbers of the last stored stream and chunk, by seat.
    """

    def __init__(self, session: str, run: int, stream: int = 0, last: dict[str, tuple[int, int]] | None = None) -> None:
        self._session = session
        self._run = run
        self._stream = stream
        self._last = dict(last or {})

    def rows(self, records: Sequence[Record]) -> tuple[list[tuple[Any, ...]], list[tuple[Any, ...]], "StreamRows"]:
        """Return rows for ``imu_streams`` and ``imu_chunks``, and the StreamRows that continues after them."""
        after = StreamRows(self._session, self._run, self._stream, self._last)
        streams, chunks = [], []
        waiting: dict[str, list[Record]] = {}
        for record in records:
            if type(record.message) not in _OF_SENSORS:
                continue
            seat = record.message.seat
            match record.message:
                case ImuBlock():
                    if seat in waiting and waiting[seat][-1].seq != record.seq:
                        chunks.append(after._chunk(seat, waiting.pop(seat)))
                    waiting.setdefault(seat, []).append(record)
                case SensorChanged(state="attached") as sensor:
                    if seat in waiting:
                        chunks.append(after._chunk(seat, waiting.pop(seat)))
                    streams.append(after._opened(sensor))
        chunks += [after._chunk(seat, records) for seat, records in waiting.items()]
        return streams, chunks, after

    def _opened(self, sensor: SensorChanged) -> tuple[Any, ...]:
        self._stream += 1
        self._last[sensor.seat] = (self._stream, 0)
        return (
            self._session, self._stream, sensor.seat, self._run, sensor.source, sensor.model, sensor.serial,
            sensor.rate_hz, sensor.rate_range_rad_s, sensor.acceleration_range_m_s2, layout(), sensor.at,
        )  # fmt: skip

    def _chunk(self, seat: str, records: Sequence[Record]) -> tuple[Any, ...]:
        from sar_tui.motion.samples import unpack

        stream, seq = self._last.get(seat, (self._stream, 0))
        self._last[seat] = (stream, seq := seq + 1)
        data = b"".join(record.message.samples for record in records if isinstance(record.message, ImuBlock))
        stamps = unpack(data)["at"]
        return (
            self._session, stream, seq, len(stamps), int(stamps[0]), int(stamps[-1]), records[0].seq,
            records[-1].at, zlib.crc32(data), data,
        )  # fmt: skip


def resume_streams(db: sqlite3.Connection, session: str, run: int) -> StreamRows:
    """Return StreamRows that continue the numbers of a session's stored streams and chunks."""
    last = db.execute(
        "SELECT seat, max(imu_streams.stream), coalesce(max(seq), 0) FROM imu_streams"
        " LEFT JOIN imu_chunks USING (session, stream) WHERE session=? AND stream IN"
        " (SELECT max(stream) FROM imu_streams WHERE session=? GROUP BY seat) GROUP BY seat",
        (session, session),
    ).fetchall()
    newest = {seat: (stream, seq) for seat, stream, seq in last}
    return StreamRows(session, run, max((stream for stream, _ in newest.values()), default=0), newest)


def blocks(db: sqlite3.Connection, session: str, after: int = 0) -> Iterator[Record]:
    """Yield a session's blocks of samples after event ``after``, each numbered like the event that followed it.

    Raises:
        StoreError: a block is damaged.
    """
    for seat, stream, seq, before, at, crc, data in db.execute(
        "SELECT seat, stream, seq, before_event, at_ns, crc32, data FROM imu_chunks"
        " LEFT JOIN imu_streams USING (session, stream) WHERE session=? AND before_event>?"
        " ORDER BY before_event, stream, seq",
        (session, after),
    ):
        if zlib.crc32(data) != crc:
            raise StoreError(f"Block {seq} of sensor stream {stream} of session {session} is damaged.")
        yield Record(before, at, IMU, ImuBlock(seat=seat or "A", samples=data))


def samples(
    db: sqlite3.Connection,
    session: str,
    from_ns: int = -(2**63),
    to_ns: int = 2**63 - 1,
    run: int | None = None,
    seat: str = "A",
) -> "Samples":
    """Return a seat's samples measured in [from_ns, to_ns).

    Stamps of different runs may overlap; ``run`` selects one.

    Raises:
        StoreError: a block is damaged.
    """
    from sar_tui.motion.samples import unpack

    found = []
    for stream, seq, crc, data in db.execute(
        "SELECT imu_chunks.stream, seq, crc32, data FROM imu_chunks JOIN imu_streams USING (session, stream)"
        " WHERE session=:session AND t1_ns>=:first AND t0_ns<:last AND (:run IS NULL OR run=:run) AND seat=:seat"
        " ORDER BY imu_chunks.stream, seq",
        {"session": session, "first": from_ns, "last": to_ns, "run": run, "seat": seat},
    ):
        if zlib.crc32(data) != crc:
            raise StoreError(f"Block {seq} of sensor stream {stream} of session {session} is damaged.")
        found.append(data)
    whole = unpack(b"".join(found))
    inside: Samples = whole[(whole["at"] >= from_ns) & (whole["at"] < to_ns)]
    return inside
