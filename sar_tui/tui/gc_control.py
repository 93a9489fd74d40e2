"""A quiet machine while a response is awaited: no garbage collection, fast thread switches, and a watch on lag."""

import asyncio
import gc
import sys

from sar_tui.framework.clock import MS, host_now

SWITCH_INTERVAL = 0.0005
"""Seconds a thread may hold the interpreter while another wants it: the input thread must get to its stamp."""
_PERIOD = 0.02


class GcControl:
    """Steers the garbage collector around an attempt, and measures how late the event loop runs within a trial."""

    def __init__(self) -> None:
        self._handle: asyncio.TimerHandle | None = None
        self._worst = 0
        self._due = 0

    def begin_attempt(self) -> None:
        """Clear up, and leave all that lives now out of later collections."""
        sys.setswitchinterval(SWITCH_INTERVAL)
        gc.collect()
        gc.freeze()

    def end_attempt(self) -> None:
        """Clear up after the attempt, where it disturbs nobody."""
        self.end_trial()
        gc.unfreeze()
        gc.collect()

    def begin_trial(self) -> None:
        """No collection from here on; watch the loop."""
        gc.disable()
        self._worst = 0
        if self._handle is None:
            self._watch()

    def end_trial(self) -> None:
        """The response is in, or will not come."""
        gc.enable()
        if self._handle:
            self._handle.cancel()
            self._handle = None

    @property
    def lag(self) -> int:
        """How late (ns) the loop was at its worst since the trial began."""
        return self._worst

    def _watch(self) -> None:
        self._due = host_now() + round(_PERIOD * 1000) * MS
        self._handle = asyncio.get_running_loop().call_later(_PERIOD, self._tick)

    def _tick(self) -> None:
        self._worst = max(self._worst, host_now() - self._due)
        self._watch()
