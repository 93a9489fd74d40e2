"""A virtual clock that keeps real time while a device is at work."""

import queue
import threading
from collections.abc import Callable, Hashable

from sar_tui.loop.clock import Handle, VirtualClock, host_now
from sar_tui.model.units import SECOND


class PacedClock(VirtualClock):
    """A virtual clock for simulations with outputs that work on a thread of their own.

    It jumps from one callback to the next, except while work goes on: then it takes as long as the
    host's clock, or until another thread hands over a callback.

    Attributes:
        timers: number of callbacks requested for a later time so far. Code that requested one
            follows this clock.
    """

    def __init__(self, start: int = 0) -> None:
        super().__init__(start)
        self.timers = 0
        self._owner = threading.get_ident()
        self._work: set[Hashable] = set()
        self._handed: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._since: int | None = None
        self._latest = start

    def now(self) -> int:
        """Return the present time, which goes on during a wait."""
        since = self._since
        return self._now if since is None else min(self._now + host_now() - since, self._latest)

    def call_at(self, when: int, callback: Callable[[], object]) -> Handle:
        self.timers += when > self._now
        return super().call_at(when, callback)

    def call_soon(self, callback: Callable[[], object]) -> None:
        if threading.get_ident() == self._owner:
            super().call_soon(callback)
        else:
            self._handed.put(callback)

    def begin_work(self, name: Hashable) -> None:
        """Keep real time until this work ends."""
        self._work.add(name)

    def end_work(self, name: Hashable) -> None:
        """End a work; harmless if it has not begun."""
        self._work.discard(name)

    def step(self, until: int | None = None) -> bool:
        """Run the next callback, after waiting for it or for another thread while work goes on."""
        while self._work and (when := self.next_at()) is not None and when > self._now:
            self._wait(when if until is None else min(when, until))
            if until is not None and self._now >= until:
                break
        while not self._handed.empty():
            super().call_soon(self._handed.get())
        return super().step(until)

    def _wait(self, latest: int) -> None:
        """Wait until a time, or until another thread hands over a callback."""
        self._latest, self._since = latest, host_now()
        try:
            handed = self._handed.get(timeout=(latest - self._now) / SECOND)
        except queue.Empty:
            self._now, self._since = latest, None
        else:
            self._now, self._since = self.now(), None
            super().call_soon(handed)
