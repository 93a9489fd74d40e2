"""Control of the garbage collector while a response is awaited, and measurement of the event loop's
lag.
"""

import asyncio
import gc
import sys

from sar_tui.loop.clock import STALLED, host_now
from sar_tui.model.units import MS

SWITCH_INTERVAL = 0.0005
"""Seconds a thread may hold the interpreter while another waits; short, so that keys are stamped in
time.
"""
_PERIOD = 0.02
_WAKING = 50 * MS
"""After a suspension the program's threads go on within this time of each other."""


def end_loading() -> None:
    """Turn the garbage collector on, if it was off while the program was loaded, and let it pass
    over all that was.
    """
    if not gc.isenabled():
        gc.freeze()
        gc.enable()


class GcControl:
    """Turns the garbage collector off in trials, and measures how late the event loop runs in
    them.
    """

    def __init__(self) -> None:
        self._handle: asyncio.TimerHandle | None = None
        self._worst = 0
        self._due = 0
        self._went_on: int | None = None

    def begin_attempt(self) -> None:
        """Collect, and exclude all present objects from later collections."""
        sys.setswitchinterval(SWITCH_INTERVAL)
        gc.collect()
        gc.freeze()

    def end_attempt(self) -> None:
        """Collect after the attempt."""
        self.end_trial()
        gc.unfreeze()
        gc.collect()

    def begin_trial(self) -> None:
        """Turn the collector off, and begin to measure the lag."""
        gc.disable()
        self._worst = 0
        self._went_on = None
        if self._handle is None:
            self._watch()

    def end_trial(self) -> None:
        """Turn the collector on, and stop measuring."""
        gc.enable()
        if self._handle:
            self._handle.cancel()
            self._handle = None

    @property
    def lag(self) -> int:
        """Largest lag of the event loop (ns) since the trial began."""
        return self._worst

    def is_stalled(self, at: int) -> bool:
        """Return True if the program went on at ``at`` (ns) after it had been suspended in the
        trial.

        What was stamped then had waited in the terminal for some unknown time.
        """
        if self._handle:
            self._measure()
        return self._went_on is not None and abs(at - self._went_on) < _WAKING

    def _measure(self) -> None:
        now = host_now()
        late = now - self._due
        self._worst = max(self._worst, late)
        if late > STALLED:
            self._went_on = now

    def _watch(self) -> None:
        self._due = host_now() + round(_PERIOD * 1000) * MS
        self._handle = asyncio.get_running_loop().call_later(_PERIOD, self._tick)

    def _tick(self) -> None:
        self._measure()
        self._watch()
