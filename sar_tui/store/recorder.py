"""The Recorder: a tap on the bus that writes every message to the disk and acknowledges trials."""

import sqlite3
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, ClassVar

from sar_tui.framework import messages as m
from sar_tui.framework.bus import Bus, Record, Topic
from sar_tui.framework.topics import STORAGE, STORED
from sar_tui.store import imu
from sar_tui.store.database import StoreError, transaction
from sar_tui.store.rows import SQL, rows_of

BATCH_SECONDS = 0.1
"""Longest time until a message that is not a trial is written."""
RETRY_SECONDS = 1.0
"""Time until a failed write is tried again."""
GROUP = 2000
"""Number of messages in a transaction on a virtual clock, where nobody waits for a trial."""
_PERMANENT = "Waiting will not help. End the session: what was saved so far is kept."


class Recorder:
    """Writes a session's messages. A trial and everything before it is one transaction, which is then acknowledged.

    In a live session ``run`` writes in a thread, so that the bus never waits for the disk. While writing fails, all
    messages are kept, writing is retried, and the reason is published. On a virtual clock nobody waits for the disk:
    a trial is acknowledged as it ends, and many are written in one transaction.

    Args:
        database: if inline, the caller's connection; else a connection of the recorder's own, which ``run`` closes.
        session, run: the session and the run that the rows belong to.
        bus: the bus to tap; acknowledgements are posted to it.
        inline: on a virtual clock: write on the bus's own thread, ``GROUP`` messages at a time and at the end.
    """

    name: ClassVar[str] = "recorder"
    emits: ClassVar[tuple[Topic[Any], ...]] = (STORED, STORAGE)

    def __init__(self, database: sqlite3.Connection, session: str, run: int, bus: Bus, *, inline: bool = False) -> None:
        self._database = database
        self._session = session
        self._run = run
        self._bus = bus
        self._inline = inline
        self._queue: deque[list[Record]] = deque()
        self._queued = 0
        self._wake = threading.Event()
        self._finished = threading.Event()
        self._problem: str | None = None
        self._streams = imu.resume_streams(database, session, run)
        bus.tap(self)

    def __call__(self, cascade: list[Record]) -> None:
        """Queue a cascade of the bus."""
        self._queue.append(cascade)
        if self._inline:
            self._group(cascade)
        elif any(isinstance(record.message, m.TrialEnded | m.SessionEnded) for record in cascade):
            self._wake.set()

    def _group(self, cascade: list[Record]) -> None:
        """Acknowledge the trials of a cascade, and write after one of them if there is enough, or at the end.

        Writing at another time would divide the samples of a sensor into other chunks.
        """
        self._queued += len(cascade)
        is_due = False
        for record in cascade:
            if type(message := record.message) is m.TrialEnded:
                self._bus.publish(STORED, _stored(message))
                is_due = is_due or self._queued >= GROUP
            elif type(message) is m.SessionEnded:
                is_due = True
        if is_due:
            self.write()

    @property
    def pending(self) -> int:
        """Number of cascades that are not on the disk yet."""
        return len(self._queue)

    def run(self, is_stopped: Callable[[], bool]) -> None:
        """Write until stopped, then write the rest and close the connection. Call it once, in a thread of its own."""
        try:
            while not is_stopped():
                self._wake.wait(RETRY_SECONDS if self._problem else BATCH_SECONDS)
                self._wake.clear()
                self.try_write()
            self.try_write()
        finally:
            try:
                if not self._inline:
                    self._database.close()
            finally:
                self._finished.set()

    def wait(self, seconds: float) -> bool:
        """Wait until a stopped ``run`` has written the rest. Return False if that takes longer than ``seconds``."""
        return self._finished.wait(seconds)

    def wake(self) -> None:
        """Wake ``run``, so that it checks at once if it is stopped."""
        self._wake.set()

    def try_write(self) -> None:
        """Write what is queued. Report to the session when writing fails, and when it works again."""
        try:
            self.write()
        except StoreError as error:
            reason = str(error) if error.temporary else f"{error} {_PERMANENT}"
            if reason != self._problem:
                self._problem = reason
                self._bus.post(STORAGE, m.StorageChanged(working=False, reason=reason))
        else:
            if self._problem:
                self._problem = None
                self._bus.post(STORAGE, m.StorageChanged(working=True))

    def write(self) -> None:
        """Commit everything that is queued as one transaction, and in a live session acknowledge its trials.

        Raises:
            StoreError: the disk cannot write, or a message cannot be stored; everything stays queued.
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
        except Exception as error:  # a task's values do not fit into a row
            raise StoreError(f"A message cannot be stored ({type(error).__name__}: {error}).") from error
        self._streams = streams
        for _ in range(count):
            self._queue.popleft()
        if self._inline:
            self._queued = 0
            return
        for record in records:
            if isinstance(trial := record.message, m.TrialEnded):
                self._bus.post(STORED, _stored(trial))


def _stored(trial: m.TrialEnded) -> m.Stored:
    return m.Stored(seat=trial.seat, attempt=trial.attempt, trial=trial.trial)
