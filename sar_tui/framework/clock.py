"""Clocks: integer nanoseconds, live or virtual.

Everything in a session takes its time from one clock, so that the same nodes run in front of a person and,
thousands of times faster, in a simulation, a replay or a test.
"""

import asyncio
import contextlib
import heapq
import itertools
import sys
import time
from collections.abc import Callable
from typing import Protocol

MS = 1_000_000
"""Nanoseconds in a millisecond."""
SECOND = 1_000_000_000
"""Nanoseconds in a second."""


def host_now() -> int:
    """The host's steady clock in ns: the one Textual stamps keys with (``perf_counter`` on Windows)."""
    return time.perf_counter_ns() if sys.platform == "win32" else time.monotonic_ns()


class Handle(Protocol):
    """A callback that is due, and can be called off."""

    def cancel(self) -> None: ...


class Clock(Protocol):
    """What a session needs of time."""

    def now(self) -> int:
        """The present, in ns. Comparable only within one run of the program."""
        ...

    def call_at(self, when: int, callback: Callable[[], object]) -> Handle:
        """Call back at ``when`` (ns), on the thread that owns the clock."""
        ...

    def call_soon(self, callback: Callable[[], object]) -> None:
        """Call back as soon as the owning thread is free. The one method other threads may call."""
        ...


class LiveClock:
    """The host's steady clock. Its callbacks run inside ``run``, so that whoever awaits that owns the session."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._due: asyncio.Queue[Callable[[], object]] = asyncio.Queue()

    def now(self) -> int:
        return host_now()

    def call_at(self, when: int, callback: Callable[[], object]) -> Handle:
        return self._loop.call_later(max(0, when - host_now()) / SECOND, self._due.put_nowait, callback)

    def call_soon(self, callback: Callable[[], object]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed: the session is over
            self._loop.call_soon_threadsafe(self._due.put_nowait, callback)

    async def run(self) -> None:
        """Run callbacks as they fall due, until cancelled."""
        while True:
            (await self._due.get())()


class _Due:
    """A place in the virtual clock's queue."""

    __slots__ = ("callback",)

    def __init__(self, callback: Callable[[], object]) -> None:
        self.callback: Callable[[], object] | None = callback

    def cancel(self) -> None:
        self.callback = None


class VirtualClock:
    """A clock that stands still until told to move, and then jumps from one callback to the next.

    Twenty minutes of a session pass in milliseconds, and identically each time: callbacks run in the order of
    their time, and of their request where times are equal. ``set`` moves the clock without running anything;
    that is what a replay wants, in which the recorded timer firings stand in for the timers.
    """

    def __init__(self, start: int = 0) -> None:
        self._now = start
        self._order = itertools.count()
        self._queue: list[tuple[int, int, _Due]] = []

    def now(self) -> int:
        return self._now

    def call_at(self, when: int, callback: Callable[[], object]) -> Handle:
        due = _Due(callback)
        heapq.heappush(self._queue, (max(when, self._now), next(self._order), due))
        return due

    def call_soon(self, callback: Callable[[], object]) -> None:
        self.call_at(self._now, callback)

    def set(self, now: int) -> None:
        """Set the time without running what would have been due; it then runs late."""
        self._now = now

    def step(self, until: int | None = None) -> bool:
        """Jump to the next callback (not beyond ``until``) and run it; False when there is none."""
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
        """Let ``duration`` ns pass, running all that falls due."""
        until = self._now + duration
        while self.step(until):
            pass
        self._now = until
