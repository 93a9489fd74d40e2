"""Thread that sends markers to one destination, and counts what became of them."""

import queue
import threading
from collections.abc import Callable
from statistics import median
from typing import Literal

from sar_tui.loop.clock import host_now
from sar_tui.model.units import MS
from sar_tui.outputs.markers.marker import Destination, Marker, MarkerError
from sar_tui.plugin_calls import describe

LONGEST_QUEUE = 10_000
RETRY_SECONDS = 2.0
"""Time between attempts to open a destination that failed."""
LAST_SECONDS = 1.0
"""Longest wait for the last markers at the end of a session."""
_TIMED = "prompt_onset"
"""The event whose lateness is measured: it is sent as soon as it has happened."""

Changed = Callable[[Literal["open", "failing", "working"], str], None]
"""Receives ``open``, ``failing`` or ``working``, and a text. Called on the sender's thread."""


class Sender:
    """Sends markers in order, on a thread of its own, so that the session never waits.

    If the destination fails, markers are lost until it can be opened again: a late trigger would be
    a wrong one.

    Args:
        destination: where to; used by no other sender.
        session: the session's id.
        task: its task.
        changed: receives each change of the destination's state.
        now: the clock of the markers' stamps, in ns.
        longest_queue: markers that may wait to be sent; more are lost.

    Attributes:
        sent: markers that were sent.
        unheard: those of them that are known to have had no receiver.
        closing: a fact from closing the destination.
    """

    def __init__(
        self,
        destination: Destination,
        session: str,
        task: str,
        changed: Changed,
        now: Callable[[], int] = host_now,
        longest_queue: int = LONGEST_QUEUE,
    ) -> None:
        self.address = destination.address
        self.sent = self.unheard = 0
        self.closing = ""
        self._failed = self._overflowed = 0
        self._late_ns: list[int] = []
        self._destination, self._session, self._task = destination, session, task
        self._changed, self._now = changed, now
        self._queue: queue.Queue[Marker | None] = queue.Queue(longest_queue)
        self._is_open = self._has_failed = False
        self._thread = threading.Thread(
            target=self._run, name=f"markers {self.address}", daemon=True
        )
        self._thread.start()

    @property
    def lost(self) -> int:
        """Number of markers that could not be sent."""
        return self._failed + self._overflowed

    @property
    def late_ms(self) -> tuple[float, float] | None:
        """Median and largest time in ms from a prompt's onset until its marker was sent; None
        without prompts.
        """
        late = self._late_ns[:]
        return (round(median(late) / MS, 3), round(max(late) / MS, 3)) if late else None

    def put(self, marker: Marker) -> None:
        """Have a marker sent. Never waits; may be called from any thread."""
        try:
            self._queue.put_nowait(marker)
        except queue.Full:
            self._overflowed += 1

    def finish(self) -> None:
        """Send what is left and close the destination, within ``LAST_SECONDS``. May be called
        again.
        """
        if self._thread.is_alive():
            try:
                self._queue.put(None, timeout=LAST_SECONDS)
            except queue.Full:
                return
            self._thread.join(LAST_SECONDS)
        self._failed += sum(1 for _ in iter(self._left, None))

    def _left(self) -> Marker | None:
        try:
            return self._queue.get_nowait()
        except queue.Empty:
            return None

    # --- on the thread

    def _run(self) -> None:
        self._open()
        while True:
            try:
                marker = self._queue.get(timeout=None if self._is_open else RETRY_SECONDS)
            except queue.Empty:
                self._open()
                continue
            if marker is None:
                break
            if self._is_open:
                self._send(marker)
            else:
                self._failed += 1
        try:
            self.closing = self._destination.close()
        except Exception as error:
            self.closing = describe(error)

    def _open(self) -> None:
        try:
            fact = self._destination.open(self._session, self._task)
        except Exception as error:
            self._fail(error)
        else:
            self._is_open = True
            self._changed("working" if self._has_failed else "open", fact)
            self._has_failed = False

    def _send(self, marker: Marker) -> None:
        now = self._now()
        try:
            heard = self._destination.send(marker)
        except Exception as error:
            self._failed += 1
            self._fail(error)
            return
        if marker.event == _TIMED:
            self._late_ns.append(now - marker.ns)
        self.sent += 1
        self.unheard += not heard

    def _fail(self, error: Exception) -> None:
        self._is_open = False
        if not self._has_failed:
            self._has_failed = True
            self._changed(
                "failing", str(error) if isinstance(error, MarkerError) else describe(error)
            )
        try:
            self._destination.close()
        except Exception:  # it has failed already
            return
