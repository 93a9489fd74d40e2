"""Samples of motion sensors in the database, in blocks with checksums."""

import sqlite3
import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import msgspec

from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.topics import IMU, SENSOR, TRUNK_IMU, TRUNK_SENSOR
from sar_tui.model.messages import BodyPart, ImuBlock, SensorChanged
from sar_tui.store.counted import COUNTS
from sar_tui.store.database import StoreError
from sar_tui.store.tables import IMU_CHUNKS, IMU_STREAMS

if TYPE_CHECKING:
    from sar_tui.motion.samples import Samples

STREAM = (
    "session", "stream", "seat", "run", "source", "model", "serial", "rate_hz", "rate_range_rad_s",
    "acceleration_range_m_s2", "layout", "attached_ns", "part",
)  # fmt: skip
CHUNK = (
    "session",
    "stream",
    "seq",
    "n",
    "t0_ns",
    "t1_ns",
    "before_event",
    "at_ns",
    "crc32",
    "data",
)
"""Columns of a row of each table, in the order in which they are stored and hashed."""
INSERT_STREAM = IMU_STREAMS.insert(*STREAM)
INSERT_CHUNK = IMU_CHUNKS.insert(*CHUNK)

_SAMPLES: dict[BodyPart, Topic[ImuBlock]] = {"hand": IMU, "trunk": TRUNK_IMU}
_PARTS: dict[str, BodyPart] = {
    IMU.name: "hand", SENSOR.name: "hand", TRUNK_IMU.name: "trunk", TRUNK_SENSOR.name: "trunk",
}  # fmt: skip
_Wearer = tuple[str, BodyPart]
"""A seat and a part of the body: where a sensor is."""


def layout() -> str:
    """Return the layout of a sample in ``imu_chunks.data``: names, types and shapes, as in numpy's
    ``dtype.descr``.
    """
    # imports numpy, which a session without a sensor does not need
    from sar_tui.motion.samples import (
        SAMPLE,
    )

    return msgspec.json.encode(SAMPLE.descr).decode()


class StreamRows:
    """Makes rows from sensor messages: a stream for each time a sensor is attached, a chunk for
    samples between events.

    Events between samples end a chunk, so that a replay can feed both in order. Each seat and part
    of the body has its own sensor.

    Args:
        session, run: the session and the run that the rows belong to.
        stream: number of the last stored stream.
        last: numbers of the last stored stream and chunk, by seat and part.
    """

    def __init__(
        self,
        session: str,
        run: int,
        stream: int = 0,
        last: dict[_Wearer, tuple[int, int]] | None = None,
    ) -> None:
        self._session = session
        self._run = run
        self._stream = stream
        self._last = dict(last or {})

    def rows(
        self, records: Sequence[Record]
    ) -> tuple[list[tuple[Any, ...]], list[tuple[Any, ...]], "StreamRows"]:
        """Return rows for ``imu_streams`` and ``imu_chunks``, and the StreamRows that continues
        after them.
        """
        after = StreamRows(self._session, self._run, self._stream, self._last)
        streams, chunks = [], []
        waiting: dict[_Wearer, list[Record]] = {}
        for record in records:
            if record.topic.name not in _PARTS:
                continue
            wearer = record.message.seat, _PARTS[record.topic.name]
            match record.message:
                case ImuBlock():
                    if wearer in waiting and waiting[wearer][-1].seq != record.seq:
                        chunks.append(after._chunk(wearer, waiting.pop(wearer)))
                    waiting.setdefault(wearer, []).append(record)
                case SensorChanged(state="attached") as sensor:
                    if wearer in waiting:
                        chunks.append(after._chunk(wearer, waiting.pop(wearer)))
                    streams.append(after._opened(wearer, sensor))
        chunks += [after._chunk(wearer, records) for wearer, records in waiting.items()]
        return streams, chunks, after

    def _opened(self, wearer: _Wearer, sensor: SensorChanged) -> tuple[Any, ...]:
        self._stream += 1
        self._last[wearer] = (self._stream, 0)
        return (
            self._session, self._stream, sensor.seat, self._run, sensor.source, sensor.model, sensor.serial,
            sensor.rate_hz, sensor.rate_range_rad_s, sensor.acceleration_range_m_s2, layout(), sensor.at, wearer[1],
        )  # fmt: skip

    def _chunk(self, wearer: _Wearer, records: Sequence[Record]) -> tuple[Any, ...]:
        from sar_tui.motion.samples import unpack

        stream, seq = self._last.get(wearer, (self._stream, 0))
        self._last[wearer] = (stream, seq := seq + 1)
        data = b"".join(
            record.message.samples for record in records if isinstance(record.message, ImuBlock)
        )
        stamps = unpack(data)["at"]
        return (
            self._session, stream, seq, len(stamps), int(stamps[0]), int(stamps[-1]), records[0].seq,
            records[-1].at, zlib.crc32(data), data,
        )  # fmt: skip


def resume_streams(db: sqlite3.Connection, session: str, run: int) -> StreamRows:
    """Return StreamRows that continue the numbers of a session's stored streams and chunks."""
    last = db.execute(
        "SELECT seat, part, max(imu_streams.stream), coalesce(max(seq), 0) FROM imu_streams"
        " LEFT JOIN imu_chunks USING (session, stream) WHERE session=? AND stream IN"
        " (SELECT max(stream) FROM imu_streams WHERE session=? GROUP BY seat, part) GROUP BY "
        "seat, part",
        (session, session),
    ).fetchall()
    newest: dict[_Wearer, tuple[int, int]] = {
        (seat, part): (stream, seq) for seat, part, stream, seq in last
    }
    return StreamRows(
        session, run, max((stream for stream, _ in newest.values()), default=0), newest
    )


def blocks(db: sqlite3.Connection, session: str) -> Iterator[Record]:
    """Yield a session's blocks of samples, each numbered like the event that followed it.

    Those of the trunk come first: perception had them when samples of the hand told it that a reach
    was over.

    Raises:
        StoreError: a block is damaged.
    """
    for seat, part, stream, seq, before, at, crc, data in db.execute(
        "SELECT seat, part, stream, seq, before_event, at_ns, crc32, data FROM imu_chunks"
        " LEFT JOIN imu_streams USING (session, stream) WHERE session=?"
        " ORDER BY before_event, part IS NOT 'trunk', stream, seq",
        (session,),
    ):
        if zlib.crc32(data) != crc:
            raise StoreError(
                f"Block {seq} of sensor stream {stream} of session {session} is damaged."
            )
        yield Record(before, at, _SAMPLES[part or "hand"], ImuBlock(seat=seat or "A", samples=data))


def last_sensors(db: sqlite3.Connection, participant: str) -> dict[str, tuple[str, str]]:
    """Return the sensors in the last session of a participant that counts and had any: model and serial
    number, by the part of the body.
    """
    rows = db.execute(
        "SELECT part, model, serial FROM imu_streams JOIN seats USING (session, seat)"
        " WHERE participant=:participant AND session=(SELECT session FROM imu_streams"
        " JOIN seats USING (session, seat) JOIN sessions ON sessions.id=session"
        f" WHERE participant=:participant AND {COUNTS} ORDER BY started_at DESC LIMIT 1)"
        " ORDER BY stream",
        {"participant": participant},
    )
    return {part: (model, serial) for part, model, serial in rows}


def samples(
    db: sqlite3.Connection,
    session: str,
    from_ns: int = -(2**63),
    to_ns: int = 2**63 - 1,
    run: int | None = None,
    seat: str = "A",
    part: BodyPart = "hand",
) -> "Samples":
    """Return the samples of a seat's sensor measured in [from_ns, to_ns).

    Stamps of different runs may overlap; ``run`` selects one.

    Raises:
        StoreError: a block is damaged.
    """
    from sar_tui.motion.samples import unpack

    found = []
    for stream, seq, crc, data in db.execute(
        "SELECT imu_chunks.stream, seq, crc32, data FROM imu_chunks JOIN imu_streams USING "
        "(session, stream)"
        " WHERE session=:session AND t1_ns>=:first AND t0_ns<:last AND (:run IS NULL OR run=:run) "
        "AND seat=:seat"
        " AND part=:part"
        " ORDER BY imu_chunks.stream, seq",
        {
            "session": session,
            "first": from_ns,
            "last": to_ns,
            "run": run,
            "seat": seat,
            "part": part,
        },
    ):
        if zlib.crc32(data) != crc:
            raise StoreError(
                f"Block {seq} of sensor stream {stream} of session {session} is damaged."
            )
        found.append(data)
    whole = unpack(b"".join(found))
    inside: Samples = whole[(whole["at"] >= from_ns) & (whole["at"] < to_ns)]
    return inside
