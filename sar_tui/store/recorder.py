"""The Recorder: a tap on the bus that writes every message to the disk and acknowledges trials."""

import contextlib
import sqlite3
import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from sar_tui.loop.bus import Bus, Record, Topic
from sar_tui.loop.topics import STORAGE, STORED
from sar_tui.model import messages as m
from sar_tui.store import imu, log_hashes
from sar_tui.store.database import StoreConnection, StoreError, transaction
from sar_tui.store.messages import Numbers, StoredRow, layout, numbers
from sar_tui.store.rows import SQL, Rows, rows_of
from sar_tui.store.safeguard import Safeguard
from sar_tui.store.training_days import utc

BATCH_SECONDS = 0.1
"""Longest time until a message that is not a trial is written."""
RETRY_SECONDS = 1.0
"""Time until a failed write is tried again."""
GROUP = 2000
"""Number of messages in a transaction on a virtual clock, where nobody waits for a trial."""
LOCKED_TRIES = 10
"""Failed writes in succession until it is reported that another program keeps the database
locked.
"""
_CACHE_KB = 256
"""Memory for pages of the database: a recorder reads next to nothing, and would fill SQLite's 2
MB.
"""
_PERMANENT = "Waiting will not help. End the session: what was saved so far is kept."


class Recorder:
    """Writes a session's messages. A trial and everything before it is one transaction, which is
    then acknowledged.

    In a live session ``run`` writes in a thread, so that the bus never waits for the disk. While
    writing fails, all messages are kept, writing is retried, and the reason is published. On a
    virtual clock nobody waits for the disk: a trial is acknowledged as it ends, and many are
    written in one transaction.

    Args:
        database: if inline, the caller's connection; else a connection of the recorder's own, which
            ``run`` closes.
        session, run: the session and the run that the rows belong to.
        bus: the bus to tap; acknowledgements are posted to it.
        inline: on a virtual clock: write on the bus's own thread, ``GROUP`` messages at a time and
            at the end.
        withholds: returns True as long as no samples of sensors may be stored.
        safeguard: where the session goes on if the database is removed, or still locked at the end.
        now: returns the time at which rows are stored, UTC.
    """

    name: ClassVar[str] = "recorder"
    emits: ClassVar[tuple[Topic[Any], ...]] = (STORED, STORAGE)

    def __init__(
        self,
        database: sqlite3.Connection,
        session: str,
        run: int,
        bus: Bus,
        *,
        withholds: Callable[[], bool] = lambda: False,
        inline: bool = False,
        safeguard: Safeguard | None = None,
        now: Callable[[], str] = utc,
    ) -> None:
        self._database = database
        self._session = session
        self._run = run
        self._bus = bus
        self._inline = inline
        self._now = now
        self._withholds = withholds
        self._queue: deque[list[Record]] = deque()
        self._queued = 0
        self._wake = threading.Event()
        self._finished = threading.Event()
        self._problem: str | None = None
        self._locked = 0
        self._committed: list[list[Record]] = []
        self.safeguard = safeguard
        if not inline:
            database.execute(f"PRAGMA cache_size=-{_CACHE_KB}")
        self._numbers: tuple[sqlite3.Connection, Numbers] | None = None
        self._streams = imu.resume_streams(database, session, run)
        self._last_group = log_hashes.last(database, session)
        bus.tap(self)

    def __call__(self, cascade: list[Record]) -> None:
        """Queue a cascade of the bus."""
        if any(record.topic.stream for record in cascade) and self._withholds():
            cascade = [record for record in cascade if not record.topic.stream]
        self._queue.append(cascade)
        if self._inline:
            self._group(cascade)
        elif any(isinstance(record.message, m.TrialEnded | m.SessionEnded) for record in cascade):
            self._wake.set()

    def _group(self, cascade: list[Record]) -> None:
        """Acknowledge the trials of a cascade, and write after one of them if there is enough, or
        at the end.

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
        return len(self._queue) + len(self._committed)

    def run(self, is_stopped: Callable[[], bool]) -> None:
        """Write until stopped, then write the rest and close the connection. Call it once, in a
        thread of its own.
        """
        try:
            while not is_stopped():
                self._wake.wait(RETRY_SECONDS if self._problem else BATCH_SECONDS)
                self._wake.clear()
                self.try_write()
            self._write_last()
        finally:
            try:
                if not self._inline:
                    self._database.close()
                    if self.safeguard:
                        self.safeguard.close()
            finally:
                self._finished.set()

    def wait(self, seconds: float) -> bool:
        """Wait until a stopped ``run`` has written the rest. Return False if that takes longer than
        ``seconds``.
        """
        return self._finished.wait(seconds)

    def wake(self) -> None:
        """Wake ``run``, so that it checks at once if it is stopped."""
        self._wake.set()

    def try_write(self) -> None:
        """Write what is queued. Report to the session when writing fails, and when it works
        again.
        """
        try:
            self.write()
        except StoreError as error:
            self._locked = self._locked + 1 if error.locked else 0
            if 0 < self._locked < LOCKED_TRIES:
                return
            reason = str(error) if error.temporary else f"{error} {_PERMANENT}"
            if reason != self._problem:
                self._problem = reason
                self._bus.post(STORAGE, m.StorageChanged(working=False, reason=reason))
        else:
            self._locked = 0
            if self._problem:
                self._problem = None
                self._bus.post(STORAGE, m.StorageChanged(working=True))

    def _write_last(self) -> None:
        """Write the rest at the end of a run; into a rescue file if the database cannot be written
        to now.
        """
        try:
            self.write()
        except StoreError as error:
            with contextlib.suppress(StoreError):
                if error.temporary and self._take_over(str(error), at_end=True):
                    self._write_or_give_up()

    def _write_or_give_up(self) -> None:
        try:
            self.write()
        except StoreError:
            if self.safeguard and isinstance(self._database, StoreConnection):
                self.safeguard.give_up(self._database)

    def _stay_in_place(self) -> None:
        """Go on in a rescue file if the files of the database were removed or replaced, and say so.

        Raises:
            StoreError: it cannot be written. What was committed last is not acknowledged.
        """
        if self.safeguard and isinstance(self._database, StoreConnection):
            self._use(self.safeguard.in_place(self._database))

    def _take_over(self, reason: str, *, at_end: bool = False) -> bool:
        """Go on in a rescue file because the database cannot be written to; False without a
        safeguard.

        Raises:
            StoreError: it cannot be written.
        """
        if self.safeguard is None or not isinstance(self._database, StoreConnection):
            return False
        self._use(self.safeguard.take_over(self._database, reason, at_end=at_end))
        return True

    def _use(self, database: StoreConnection) -> None:
        if self.safeguard and database is not self._database:
            self._database.close()
            self._database = database
            self._problem = None
            self._bus.post(STORAGE, m.StorageChanged(working=True, reason=self.safeguard.text))

    def write(self) -> None:
        """Commit everything that is queued as one transaction, and in a live session acknowledge
        its trials.

        Raises:
            StoreError: the disk cannot write, or a message cannot be stored; everything stays
                queued.
        """
        self._stay_in_place()
        count = len(self._queue)
        if not count and not self._committed:
            return
        records = [record for cascade in list(self._queue)[:count] for record in cascade]
        try:
            messages = [record for record in records if not record.topic.stream]
            numbers_here = self._numbers_here()
            rows = rows_of(self._session, self._run, messages, numbers_here, self._now())
            rows["streams"], rows["chunks"], streams = self._streams.rows(records)
            group = self._hash(messages, rows) if records else self._last_group
            self._commit(rows)
        except StoreError as error:
            if error.bad_input and self._take_over(str(error)):  # the file is damaged
                self.write()
                return
            raise
        except Exception as error:  # a task's values do not fit into a row
            raise StoreError(
                f"A message cannot be stored ({type(error).__name__}: {error})."
            ) from error
        self._streams = streams
        self._last_group = group
        for _ in range(count):
            self._committed.append(self._queue.popleft())
        self._queued = 0
        self._stay_in_place()
        records = [record for cascade in self._committed for record in cascade]
        self._committed.clear()
        if self._inline:
            return
        if self.safeguard:
            self.safeguard.saved(records)
        for record in records:
            if isinstance(trial := record.message, m.TrialEnded):
                self._bus.post(STORED, _stored(trial))

    def _hash(self, messages: Sequence[Record], rows: Rows) -> log_hashes.Last | None:
        """Add the hash of a group of messages to its rows, with the samples and the end that are
        stored with them.
        """
        if self._last_group is None:  # they were removed, which `check` tells
            return None
        stored = [
            StoredRow(one.seq, self._run, one.at, one.topic.name, layout(one.topic), row[-1])
            for one, row in zip(messages, rows["messages"], strict=True)
        ]
        beside: list[tuple[log_hashes.Entry, bytes]] = [
            *((["stream", row[1]], log_hashes.stream_hash(row)) for row in rows["streams"]),
            *((["chunk", *row[1:3]], log_hashes.chunk_hash(row)) for row in rows["chunks"]),
            *(
                (["ended", ended], log_hashes.end_hash(ended))
                for _, ended, _ in rows["session_ends"]
            ),
        ]
        group, row = log_hashes.next_group(self._last_group, self._session, stored, beside)
        rows["log_hashes"], rows["last_hashes"] = [row], [(group.hash, self._session)]
        return group

    def _commit(self, rows: Rows) -> None:
        with transaction(self._database) as connection:
            for kind, statement in SQL.items():
                if rows[kind]:
                    connection.executemany(statement, rows[kind])

    def _numbers_here(self) -> Numbers:
        """Return the numbers of the session and the topics in the database that is written to."""
        if self._numbers is None or self._numbers[0] is not self._database:
            self._numbers = self._database, numbers(self._database, self._session)
        return self._numbers[1]


def _stored(trial: m.TrialEnded) -> m.Stored:
    return m.Stored(seat=trial.seat, attempt=trial.attempt, trial=trial.trial)
