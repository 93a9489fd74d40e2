"""Settings of the timing of trials."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta


class TimingSettings(Settings, frozen=True, kw_only=True):
    """Time-outs, foreperiod and limits on responses."""

    response_timeout_ms: Annotated[
        int,
        meta(
            "Response time-out",
            "ms",
            "A prompt without a response counts as missed after this time.",
            ge=100,
            le=600_000,
            group="Timing",
        ),
    ] = 5000
    min_rt_ms: Annotated[
        int,
        meta(
            "Fastest real response",
            "ms",
            "A faster response is stored as an anticipation and left out of the result.",
            ge=0,
            le=1000,
            group="Timing",
        ),
    ] = 100
    quiet_ms: Annotated[
        int,
        meta(
            "Quiet before a prompt",
            "ms",
            "The wait begins after this time without a key press.",
            ge=0,
            le=5000,
            group="Timing",
        ),
    ] = 500
    foreperiod_min_ms: Annotated[
        int,
        meta(
            "Shortest wait",
            "ms",
            "The wait before a prompt is at least this long.",
            ge=0,
            le=60_000,
            group="Timing",
        ),
    ] = 500
    foreperiod_max_ms: Annotated[
        int,
        meta(
            "Longest wait",
            "ms",
            "The wait before a prompt is random, at most this long.",
            ge=0,
            le=60_000,
            group="Timing",
        ),
    ] = 1500
    repeat_interval_ms: Annotated[
        int,
        meta(
            "Key repeat interval",
            "ms",
            "The same key again within this time is a held key, not a press.",
            ge=0,
            le=1000,
            group="Timing",
        ),
    ] = 50

    def problems(self) -> dict[str, str]:
        """Return why the limits of the foreperiod do not fit together, by parameter."""
        if self.foreperiod_min_ms <= self.foreperiod_max_ms:
            return {}
        shortest, longest = self.foreperiod_min_ms, self.foreperiod_max_ms
        return {
            "foreperiod_min_ms": f"Shortest wait ({shortest} ms) is above the longest ({longest} "
            "ms)."
        }
