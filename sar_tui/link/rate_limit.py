"""Rate limits: a token bucket for what peers send, and a throttle for reports of what was
refused.
"""

from collections.abc import Hashable
from typing import Generic, TypeVar

from sar_tui.model.units import SECOND

K = TypeVar("K", bound=Hashable)

ACTS_PER_S, ACTS_BURST = 30, 60
"""Limit of what a peer sends; nobody types faster."""
SNAPSHOTS_PER_S, SNAPSHOTS_BURST = 1, 3
"""Limit of how often a peer is sent the whole state of the session."""


class TokenBucket:
    """Token bucket: ``rate`` tokens per second, at most ``burst`` at once."""

    def __init__(self, rate: float, burst: int) -> None:
        self._rate, self._burst = rate, burst
        self._tokens = float(burst)
        self._at: int | None = None

    def take(self, now: int) -> bool:
        """Take a token at ``now`` (ns, never decreasing); False if there is none."""
        if self._at is not None:
            self._tokens = min(self._burst, self._tokens + (now - self._at) / SECOND * self._rate)
        self._at = now
        if self._tokens < 1:
            return False
        self._tokens -= 1
        return True


class ReportThrottle(Generic[K]):
    """Limits reports of a repeated event: the first at once, then one per ``interval`` (ns) with a
    count.

    It tracks at most ``max_keys`` events at a time and drops others until there is room.
    """

    def __init__(self, interval: int = SECOND, max_keys: int = 100) -> None:
        self._interval, self._max_keys = interval, max_keys
        self._reported_at: dict[K, int] = {}
        self._counts: dict[K, int] = {}

    def add(self, key: K, now: int) -> int:
        """Count an event; return its count since the last report if a report is due, else 0."""
        if key not in self._reported_at and len(self._reported_at) >= self._max_keys:
            return 0
        self._counts[key] = self._counts.get(key, 0) + 1
        return self._take(key, now)

    def due(self, now: int) -> list[tuple[K, int]]:
        """Return the events to report now, with their counts, and forget those that stopped."""
        found = [(key, count) for key in list(self._counts) if (count := self._take(key, now))]
        over = [
            key
            for key, at in self._reported_at.items()
            if key not in self._counts and now - at >= self._interval
        ]
        for key in over:
            del self._reported_at[key]
        return found

    def _take(self, key: K, now: int) -> int:
        if key in self._reported_at and now - self._reported_at[key] < self._interval:
            return 0
        self._reported_at[key] = now
        return self._counts.pop(key)
