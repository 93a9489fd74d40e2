"""Calls a source that makes its own samples when the next ones are due."""

import threading
from collections.abc import Callable

from sar_tui.loop.clock import Clock, Handle, host_now
from sar_tui.model.units import SECOND


class Pace:
    """Calls a step at its times: by a clock's callbacks, or on a thread.

    Args:
        step: does what is due at the given time (ns), and returns the time of its next call; None
            for never.
        clock: the clock whose callbacks to use; if None, a thread on the host's clock.
    """

    def __init__(self, step: Callable[[int], int | None], clock: Clock | None = None) -> None:
        self._step = step
        self._clock = clock
        self._stopped = threading.Event()
        self._due: Handle | None = None
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Take the first step as soon as possible."""
        self.stop()
        self._stopped = threading.Event()
        if self._clock:
            self._tick_at(self._clock, self._clock.now())
        else:
            self._thread = threading.Thread(
                target=self._run, args=(self._stopped,), name="sensor", daemon=True
            )
            self._thread.start()

    def stop(self) -> None:
        """Take no more steps. Waits for one under way, unless called by it."""
        self._stopped.set()
        if self._due:
            self._due.cancel()
            self._due = None
        if self._thread and self._thread is not threading.current_thread():
            self._thread.join()
        self._thread = None

    def _tick_at(self, clock: Clock, when: int) -> None:
        def tick() -> None:
            due = self._step(clock.now())
            if due is not None and not stopped.is_set():
                self._tick_at(clock, due)

        stopped = self._stopped
        self._due = clock.call_at(when, tick)

    def _run(self, stopped: threading.Event) -> None:
        due: int | None = host_now()
        while due is not None and not stopped.wait(max(0, due - host_now()) / SECOND):
            due = self._step(host_now())
