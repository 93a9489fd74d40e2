"""Ends a call of a plug-in's code that does not return, so that keys and signals work again."""

import threading
from collections.abc import Callable
from types import TracebackType

from sar_tui.plugin_calls import LIMIT_S, NotResponding, PluginCall, under_way

PERIOD_S = 1.0
"""Interval at which the watchdog looks."""
_MOST_ERRORS = 3
"""A call that goes on after this many errors, or is in a library that no error reaches, is given
up.
"""


class PluginWatchdog:
    """Watches the thread that creates it, from a thread of its own. A context manager.

    A call that does not return gets a `NotResponding` where it is, which is then reported like any
    other error of the plug-in. Time in which the whole program stood still (a suspended computer)
    does not count.

    Args:
        give_up: called with the plug-in, such as ``task reaching``, from the watchdog's thread,
            when no error ends the call.
        limit_s, period_s: longest duration of a call, and the interval at which it is checked.
    """

    def __init__(
        self, give_up: Callable[[str], object], limit_s: float = LIMIT_S, period_s: float = PERIOD_S
    ) -> None:
        self._give_up = give_up
        self._most_looks = max(1, round(limit_s / period_s))
        self._period_s = period_s
        self._watched = threading.get_ident()
        self._stopped = threading.Event()
        self._call: PluginCall | None = None
        self._looks = 0

    def __enter__(self) -> "PluginWatchdog":
        threading.Thread(target=self._run, name="plug-in watchdog", daemon=True).start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stopped.set()

    def _run(self) -> None:
        while not self._stopped.wait(self._period_s):
            self.look()

    def look(self) -> None:
        """Find out whether the same call is still under way, and end it if it is and its time is
        over.
        """
        call = under_way(self._watched)
        if call is None or call is not self._call:
            self._call, self._looks = call, 0
            return
        self._looks += 1
        errors = self._looks - self._most_looks
        if errors >= _MOST_ERRORS:
            self._give_up(call.plugin)
        elif errors >= 0:
            import ctypes  # loads slowly, and is hardly ever needed

            ctypes.pythonapi.PyThreadState_SetAsyncExc(
                ctypes.c_ulong(self._watched), ctypes.py_object(NotResponding)
            )
