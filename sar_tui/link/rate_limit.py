"""How fast a peer may be: pure counting of what it sends, and of what was refused of it."""

from collections.abc import Hashable
from typing import Generic, TypeVar

from sar_tui.framework.clock import SECOND

K = TypeVar("K", bound=Hashable)


class TokenBucket:
    """A token bucket: ``rate`` things a second, and ``burst`` of them at once after a quiet spell."""

    def __init__(self, rate: float, burst: int) -> None:
        self._rate, self._burst = rate, burst
        self._left = float(burst)
        self._at: int | None = None

    def take(self, now: int) -> bool:
        """Whether one more is within the pace at ``now`` (ns, never going back)."""
        if self._at is not None:
            self._left = min(self._burst, self._left + (now - self._at) / SECOND * self._rate)
        self._at = now
        if self._left < 1:
            return False
        self._left -= 1
        return True


class RepeatThrottle(Generic[K]):
    """Tells of what happens again and again: at once the first time, then once in ``every`` ns, with how often.

    It knows no more than ``most`` things at a time: what is beyond them is not told until there is room again.
    """

    def __init__(self, every: int = SECOND, most: int = 100) -> None:
        self._every, self._most = every, most
        self._told: dict[K, int] = {}
        self._counts: dict[K, int] = {}

    def add(self, key: K, now: int) -> int:
        """It happened at ``now``: how often since it was last told, or 0 where it is not time to tell yet."""
        if key not in self._told and len(self._told) >= self._most:
            return 0
        self._counts[key] = self._counts.get(key, 0) + 1
        return self._take(key, now)

    def due(self, now: int) -> list[tuple[K, int]]:
        """What has happened since it was last told, and may be told by now; the rest is forgotten in time."""
        found = [(key, count) for key in list(self._counts) if (count := self._take(key, now))]
        over = [key for key, told in self._told.items() if key not in self._counts and now - told >= self._every]
        for key in over:
            del self._told[key]
        return found

    def _take(self, key: K, now: int) -> int:
        if key in self._told and now - self._told[key] < self._every:
            return 0
        self._told[key] = now
        return self._counts.pop(key)
