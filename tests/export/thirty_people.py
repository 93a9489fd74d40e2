"""Thirty people who trained on one machine between two starts of it, each on another day, in the
order of their codes.

Their records hold the true date wherever a record may: the steady clock in stamps of many places,
the sensor's own clock, versions that changed meanwhile, numbers and texts of a task that read as a
time.
"""

import json
import zlib
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from random import Random
from sqlite3 import Connection
from typing import NamedTuple

import numpy as np
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.motion.samples import unpack
from sar_tui.store import participants
from sar_tui.store.database import connect
from tests.played import simulated
from tests.recorded import event, told
from tests.store.by_hand import add_message, insert, sql

MANY = 30
BEGAN = datetime(2026, 2, 2, 8, 3, 17, 250_000, tzinfo=UTC)
UPTIME_NS = 100 * 86_400 * 10**9
"""Time that the machine had been on when the study began."""
BOOT = "8f14e45f-ceea-467f-9575-1d4b2a1f2f3c"
_SENSOR_EVERY = 5
_TIMING = {
    "measured_at": "",
    "median_ms": 0.2,
    "robust_sd_ms": 0.1,
    "p99_ms": 0.9,
    "verdict": "fit",
}


class Study(NamedTuple):
    """The study: its data folder, and when each person truly trained."""

    data: Path
    began: dict[str, datetime]


def store_people(data: Path, monkeypatch: pytest.MonkeyPatch, many: int = MANY) -> Study:
    """Store the sessions of the first so many people, in the order in which they were."""
    random, began, moment = Random(24), {}, BEGAN
    for number in range(many):
        code = f"P{number + 1:02d}"
        began[code] = moment
        for task in ("keyboard", "reaching") if number % _SENSOR_EVERY == 0 else ("keyboard",):
            count = "reaches_per_attempt" if task == "reaching" else "prompts_per_attempt"
            start = moment + timedelta(minutes=20 * (task == "reaching"))
            clock = UPTIME_NS + (start - BEGAN) // timedelta(microseconds=1) * 1000
            monkeypatch.setattr(
                "sar_tui.runs.simulate.VirtualClock", lambda at=clock: VirtualClock(at)
            )
            seed = random.randrange(10**9, 2**31)
            session = simulated(data, task, code, seed=seed, **{"attempts": 1, count: 2})
            with closing(connect(data)) as database:
                _date(database, session, code, number, start, clock)
                _stamp(database, session, clock, start)
                _tell(database, session, code, start)
        days, minutes = random.randint(1, 5), random.randint(-40, 40)
        moment += timedelta(days=days, minutes=minutes, microseconds=number * 977)
    return Study(data, began)


def _date(
    database: Connection, session: str, code: str, number: int, moment: datetime, clock: int
) -> None:
    """Give a session its date, and the versions of that time."""
    at, ended = moment.isoformat(), (moment + timedelta(minutes=9)).isoformat()
    participants.add(database, code)
    sql(database, "UPDATE participants SET created_at=? WHERE code=?", at, code)
    timing = json.dumps(_TIMING | {"n": 300 + number // 8})
    sql(
        database,
        "UPDATE sessions SET started_at=?, ended_at=?, mode='live', software=json_set(software, '$.sar_tui', ?,"
        " '$.python', ?, '$.packages.numpy', ?, '$.task.hash', ?, '$.theme.hash', ?),"
        " machine=json_set(machine, '$.timing', json(?), '$.terminal', ?) WHERE id=?",
        at, ended, f"0.{number // 10}", f"3.11.{number // 6}", f"2.{number // 5}", f"{number // 3:064x}",
        f"{number // 7:064x}", timing, f"term {number // 4}", session,
    )  # fmt: skip
    add_message(database, session, 0, clock, "session/started", {"rules": 1 + number // 10})
    sql(
        database,
        "UPDATE runs SET clock_anchor=json_set(clock_anchor, '$.utc', ?, '$.utc_offset_s', ?), boot_id=?, pid=?,"
        " software=(SELECT software FROM sessions WHERE id=session) WHERE session=?",
        at, 3600 if number < MANY // 2 else 7200, BOOT, 1000 + number, session,
    )  # fmt: skip


def _stamp(database: Connection, session: str, clock: int, moment: datetime) -> None:
    """Put the steady clock, and the time of day, into what tasks and sensors keep."""
    sql(
        database,
        "UPDATE trials SET details=json_set(details, '$.seen_at', ?, '$.seen_s', ?, '$.steps_ns', json(?)),"
        " data=json_set(data, '$.made', ?, '$.made_ns', ?), timing=json_set(timing, '$.frame_onsets_ns', json(?))"
        " WHERE session=?",
        clock + 5, moment.timestamp() + 0.25, json.dumps([clock + 1, clock + 2]), moment.isoformat(), clock + 3,
        json.dumps([clock + 7, clock + 8]), session,
    )  # fmt: skip
    best = "qualities=json_set(qualities, '$.best_ns', ?)"
    sql(database, f"UPDATE attempts SET {best} WHERE session=?", clock + 9, session)
    insert(database, "notes", session=session, at_ns=0, author="operator.ana", text="")
    for row, block in sql(database, "SELECT rowid, data FROM imu_chunks WHERE session=?", session):
        samples = np.array(unpack(block))
        samples["device_ms"] += clock / 1e6
        changed = samples.tobytes()
        update = "UPDATE imu_chunks SET data=?, crc32=? WHERE rowid=?"
        sql(database, update, changed, zlib.crc32(changed), row)


def _tell(database: Connection, session: str, code: str, moment: datetime) -> None:
    """Add what is asked of a person, and what happened to them."""
    at, day = moment.isoformat(), moment.date().isoformat()
    told(database, code, "after", "pain", "3", session=session)
    event(database, code, day, what="It hurt.", severity="mild", session=session)
    dated = "recorded_at=?, at=CASE kind WHEN 'pain' THEN ? ELSE at END"
    sql(database, f"UPDATE records SET {dated} WHERE session=?", at, at, session)
