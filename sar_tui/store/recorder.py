"""The Recorder: a tap on the bus that puts every message on the disk, and says when it is there."""

import threading
from collections import deque
from collections.abc import Callable
from typing import Any, ClassVar

import sqlite_utils

from sar_tui.framework import messages as m
from sar_tui.framework.bus import Bus, Record, Topic
from sar_tui.framework.topics import STORAGE, STORED
from sar_tui.store import imu
from sar_tui.store.database import StoreError, transaction
from sar_tui.store.rows import SQL, rows_of

BATCH_SECONDS = 0.1
"""How long a message that is no trial may wait for the disk."""
RETRY_SECONDS = 1.0
"""How often a disk that refused is asked again."""
_NO_WAITING = "Waiting will hardly help: end the session, and what was saved before is kept."


class Recorder:
    """Writes a session's messages. A trial, and all before it, is one transaction, and is then acknowledged.

    Inline (on a virtual clock) it writes as soon as a trial ends. In a live session ``run`` is given a thread:
    the bus never waits for the disk. While nothing can be written, everything is kept and tried again, and the
    session is told why.

    Args:
        database: inline, the caller's connection; else one of the recorder's own, which ``run`` closes.
        session, run: what the rows belong to.
        bus: is tapped, and told of what is stored.
        inline: write on the bus' own thread.
    """

    name: ClassVar[str] = "recorder"
    emits: ClassVar[tuple[Topic[Any], ...]] = (STORED, STORAGE)

    def __init__(
        self, database: sqlite_utils.Database, session: str, run: int, bus: Bus, *, inline: bool = False
    ) -> None:
        self._database = database
        self._session = session
        self._run = run
        self._bus = bus
        self._inline = inline
        self._queue: deque[list[Record]] = deque()
        self._wake = threading.Event()
        self._finished = threading.Event()
        self._refusal: str | None = None
        self._streams = imu.counted(database, session, run)
        bus.tap(self)

    def __call__(self, cascade: list[Record]) -> None:
        """Take a cascade from the bus."""
        self._queue.append(cascade)
        if any(isinstance(record.message, m.TrialEnded | m.SessionEnded) for record in cascade):
            if self._inline:
                self.write()
            else:
                self._wake.set()

    @property
    def pending(self) -> int:
        """How many cascades are not on the disk yet."""
        return len(self._queue)

    def run(self, is_stopped: Callable[[], bool]) -> None:
        """Write until stopped, and then what is left; then close the connection. For a thread of its own, once."""
        try:
            while not is_stopped():
                self._wake.wait(RETRY_SECONDS if self._refusal else BATCH_SECONDS)
                self._wake.clear()
                self.try_write()
            self.try_write()
        finally:
            try:
                if not self._inline:
                    self._database.conn.close()
            finally:
                self._finished.set()

    def wait(self, seconds: float) -> bool:
        """Wait for a stopped ``run`` to have written the rest; False if it has not by then."""
        return self._finished.wait(seconds)

    def stop(self) -> None:
        """Wake the thread, so that it sees that it is stopped."""
        self._wake.set()

    def try_write(self) -> None:
        """Write what waits. The session is told when that fails, and when it works again."""
        try:
            self.write()
        except StoreError as error:
            reason = str(error) if error.temporary else f"{error} {_NO_WAITING}"
            if reason != self._refusal:
                self._refusal = reason
                self._bus.post(STORAGE, m.StorageChanged(working=False, reason=reason))
        else:
            if self._refusal:
                self._refusal = None
                self._bus.post(STORAGE, m.StorageChanged(working=True))

    def write(self) -> None:
        """Commit all that waits as one transaction, and acknowledge its trials.

        Raises:
            StoreError: the disk refuses, or a message cannot be written down; everything still waits.
        """
        count = len(self._queue)
        if not count:
            return
        records = [record for cascade in list(self._queue)[:count] for record in cascade]
        try:
            rows = rows_of(self._session, self._run, [record for record in records if not record.topic.stream])
            rows["streams"], rows["chunks"], streams = self._streams.rows(records)
            with transaction(self._database) as connection:
                for kind, statement in SQL.items():
                    if rows[kind]:
                        connection.executemany(statement, rows[kind])
        except StoreError:
            raise
        except Exception as error:  # what a task said cannot be put into a row
            raise StoreError(f"A message cannot be written down ({type(error).__name__}: {error}).") from error
        self._streams = streams
        for _ in range(count):
            self._queue.popleft()
        for record in records:
            if isinstance(trial := record.message, m.TrialEnded):
                self._bus.post(STORED, m.Stored(seat=trial.seat, attempt=trial.attempt, trial=trial.trial))
