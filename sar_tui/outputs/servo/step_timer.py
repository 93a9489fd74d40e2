"""Calls a servo's steps at their times: on a thread, or by timers of a virtual clock."""

import threading
from collections.abc import Callable

from sar_tui.loop.clock import Clock, Handle, VirtualClock
from sar_tui.model.units import SECOND


class StepTimer:
    """Calls steps at their times, and the next one at once when woken.

    Args:
        clock: a virtual clock calls the steps itself; otherwise a thread does, since a device may
            block.
        step: does what is due, and returns the ns until its next call; None: not until woken.
        last: called after the last step, in the same way.
    """

    def __init__(
        self, clock: Clock, step: Callable[[], int | None], last: Callable[[], None]
    ) -> None:
        self._clock = clock
        self._step = step
        self._last = last
        self._woken = threading.Event()
        self._finished = False
        self._due: Handle | None = None
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Take the first step."""
        if not isinstance(self._clock, VirtualClock):
            self._thread = threading.Thread(target=self._run, name="servo", daemon=True)
            self._thread.start()
        else:
            self.wake()

    def wake(self) -> None:
        """Take a step as soon as possible. May be called from any thread."""
        if self._thread:
            self._woken.set()
        else:
            self._tick_in(0)

    def finish(self, seconds: float) -> None:
        """Take only the last step. Waits for it, at most ``seconds`` if a device hangs."""
        if self._finished:
            return
        self._finished = True
        if self._thread:
            self._woken.set()
            self._thread.join(seconds)
        else:
            self._tick_in(None)
            self._last()

    def _run(self) -> None:
        while not self._finished:
            self._woken.clear()
            pause = self._step()
            self._woken.wait(None if pause is None else pause / SECOND)
        self._last()

    def _tick_in(self, pause: int | None) -> None:
        if self._due:
            self._due.cancel()
        self._due = (
            None if pause is None else self._clock.call_at(self._clock.now() + pause, self._tick)
        )

    def _tick(self) -> None:
        if not self._finished:
            self._tick_in(self._step())
