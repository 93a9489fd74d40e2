"""Estimate of the session's clock in another program, from pings."""

import os
import platform
from collections import deque
from collections.abc import Callable
from pathlib import Path

from sar_tui.link.protocol import Pong
from sar_tui.loop.clock import host_now

_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
_TIME_NAMESPACE = "/proc/self/ns/time"
_MAX_PINGS = 16


def clock_id() -> str:
    """Return an id shared by all programs that read the same monotonic clock.

    Where the system has no such id, it is unique to this process.
    """
    try:
        boot = _BOOT_ID.read_text().strip()
    except OSError:
        return f"{platform.node()}-{os.getpid()}"
    try:
        return f"{boot} {os.readlink(_TIME_NAMESPACE)}"
    except OSError:
        return boot


class RemoteClock:
    """The session's clock: this program's own on the same machine, else estimated from the fastest
    of recent pings.

    The error is at most half of that ping's round trip.

    Args:
        own: this program's clock (ns).
        own_id: its id, by default ``clock_id()``.
    """

    def __init__(self, own: Callable[[], int] = host_now, own_id: str | None = None) -> None:
        self._own = own
        self._own_id = clock_id() if own_id is None else own_id
        self._remote_id = ""
        self._pings: deque[tuple[int, int]] = deque(maxlen=_MAX_PINGS)
        self._offset = 0

    def now(self) -> int:
        """Return the session's time (ns); before the first ping, this program's own."""
        return self._own() + self._offset

    def update(self, pong: Pong, received_at: int | None = None) -> None:
        """Add a ping's answer, received at ``received_at`` (default: now) on this program's clock
        (ns).
        """
        at = self._own() if received_at is None else received_at
        if pong.clock_id != self._remote_id:  # the session's machine was restarted
            self._remote_id = pong.clock_id
            self._pings.clear()
        if at < pong.ping_sent_at:
            return
        self._pings.append(
            (at - pong.ping_sent_at, pong.session_time - (at + pong.ping_sent_at) // 2)
        )
        self._offset = 0 if pong.clock_id == self._own_id else min(self._pings)[1]
