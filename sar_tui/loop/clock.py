"""Clocks: integer nanoseconds, live or virtual.

A session takes all times from one clock, so the same nodes run live and, thousands of times faster,
in a simulation, a replay or a test.
"""

import contextlib
import heapq
import itertools
import queue
import sys
import threading
import time
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Protocol

from sar_tui.model.units import MS, SECOND
from sar_tui.plugin_calls import inherited

if TYPE_CHECKING:
    import asyncio

STALLED = 250 * MS
"""A timer later than this means that the program was suspended."""


def host_now() -> int:
    """Return the host's monotonic clock in ns, the one Textual uses for key events
    (``perf_counter`` on Windows).
    """
    return time.perf_counter_ns() if sys.platform == "win32" else time.monotonic_ns()


class Handle(Protocol):
    """Scheduled callback that can be cancelled."""

    def cancel(self) -> None: ...


class Clock(Protocol):
    """Interface of the clocks that a session can use."""

    def now(self) -> int:
        """Return the present time in ns, comparable only within one run of the program."""
        ...

    def call_at(self, when: int, callback: Callable[[], object]) -> Handle:
        """Call ``callback`` at ``when`` (ns), on the thread that owns the clock."""
        ...

    def call_soon(self, callback: Callable[[], object]) -> None:
        """Call ``callback`` as soon as the owning thread is free. The only method that other
        threads may call.
        """
        ...


class LiveClock:
    """The host's monotonic clock. Callbacks run inside ``run``; the task that awaits it owns the
    session.
    """

    def __init__(self, loop: "asyncio.AbstractEventLoop") -> None:
        import asyncio  # a program without a live session does not need it

        self._loop = loop
        self._due: asyncio.Queue[Callable[[], object]] = asyncio.Queue()

    def now(self) -> int:
        return host_now()

    def call_at(self, when: int, callback: Callable[[], object]) -> Handle:
        return self._loop.call_later(
            max(0, when - host_now()) / SECOND, self._due.put_nowait, inherited(callback)
        )

    def call_soon(self, callback: Callable[[], object]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed: the session is over
            self._loop.call_soon_threadsafe(self._due.put_nowait, inherited(callback))

    async def run(self) -> None:
        """Run callbacks as they fall due, until cancelled."""
        while True:
            (await self._due.get())()


class _Due:
    """Entry of the virtual clock's queue."""

    __slots__ = ("callback",)

    def __init__(self, callback: Callable[[], object]) -> None:
        self.callback: Callable[[], object] | None = callback

    def cancel(self) -> None:
        self.callback = None


class VirtualClock:
    """A clock that moves only when it is stepped, from one callback to the next.

    Twenty minutes of a session take milliseconds, and are the same each time: callbacks run in the
    order of their time, and those of the same time in the order of their request. ``set`` moves the
    clock without running callbacks, for a replay, in which recorded timer messages replace the
    timers.
    """

    def __init__(self, start: int = 0) -> None:
        self._now = start
        self._order = itertools.count()
        self._queue: list[tuple[int, int, _Due]] = []

    def now(self) -> int:
        return self._now

    def call_at(self, when: int, callback: Callable[[], object]) -> Handle:
        due = _Due(inherited(callback))
        heapq.heappush(self._queue, (max(when, self._now), next(self._order), due))
        return due

    def call_soon(self, callback: Callable[[], object]) -> None:
        self.call_at(self._now, callback)

    def set(self, now: int) -> None:
        """Set the time without running the callbacks due until then; they run late."""
        self._now = now

    def next_at(self) -> int | None:
        """Return the time of the next callback; None if there is none."""
        while self._queue and self._queue[0][2].callback is None:
            heapq.heappop(self._queue)
        return self._queue[0][0] if self._queue else None

    def step(self, until: int | None = None) -> bool:
        """Jump to the next callback (not beyond ``until``) and run it; False if there is none."""
        while self._queue:
            when, _, due = self._queue[0]
            if until is not None and when > until:
                return False
            heapq.heappop(self._queue)
            if due.callback is not None:
                self._now = max(self._now, when)
                due.callback()
                return True
        return False

    def advance(self, duration: int) -> None:
        """Let ``duration`` ns pass, and run the callbacks due in that time."""
        until = self._now + duration
        while self.step(until):
            pass
        self._now = until


# --- a clock for devices


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
