"""The session's clock, as well as it is known in another program: pure arithmetic of pings."""

from collections import deque
from collections.abc import Callable

from sar_tui.framework.clock import host_now
from sar_tui.link.protocol import Pong
from sar_tui.link.same_host import clock_id

_REMEMBERED = 16


class RemoteClock:
    """On the same machine it is that machine's clock; elsewhere, of the last pings the shortest tells best.

    The error is at most half of that ping's round trip.

    Args:
        own: the clock of this program (ns).
        here: whose that is.
    """

    def __init__(self, own: Callable[[], int] = host_now, here: str | None = None) -> None:
        self._own = own
        self._here = clock_id() if here is None else here
        self._host = ""
        self._pings: deque[tuple[int, int]] = deque(maxlen=_REMEMBERED)
        self._offset = 0

    def now(self) -> int:
        """The session's clock (ns); until there was a ping, this program's own."""
        return self._own() + self._offset

    def learn(self, pong: Pong, arrived: int | None = None) -> None:
        """Take an answer on, which came at ``arrived`` (by default now), on this program's clock."""
        at = self._own() if arrived is None else arrived
        if pong.host != self._host:  # the session's machine was started anew
            self._host = pong.host
            self._pings.clear()
        if at < pong.ping:
            return
        self._pings.append((at - pong.ping, pong.clock - (at + pong.ping) // 2))
        self._offset = 0 if pong.host == self._here else min(self._pings)[1]
