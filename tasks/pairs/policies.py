"""What a trial of two comes to, by policy: pure functions of who pressed what, and when."""

from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from sar_tui.framework.messages import Json, KeyPerceived
from sar_tui.framework.task import Result, Results


class Response(NamedTuple):
    """What one of the two did: nothing, where there is no percept. ``is_real``: not too soon to be a response."""

    asked: str
    percept: KeyPerceived | None
    latency_ms: float | None
    is_real: bool

    @property
    def is_right(self) -> bool:
        """Whether the key was the one that was asked for."""
        return self.percept is not None and self.percept.key.casefold() == self.asked.casefold()

    def result(self, details: Json) -> Result:
        """It alone, held against the goal by its own reaction time."""
        press = self.percept
        gap = None if press is None or press.gap is None else press.gap / 1_000_000
        return Result(
            correct=self.is_right,
            response=press.key if press else None,
            response_at=press.at if press else None,
            value=self.latency_ms,
            details={**details, "asked": self.asked, "right": self.is_right, "key_gap_ms": gap},
        )


def race(responses: Mapping[str, Response], details: Json) -> Results:
    """The fastest right response wins; with equal stamps both do. Each keeps the time of their own."""
    fair = {seat: one.latency_ms for seat, one in responses.items() if one.is_right and one.is_real}
    fastest = min((latency for latency in fair.values() if latency is not None), default=None)
    return {
        seat: one.result({**details, "won": fastest is not None and fair.get(seat) == fastest})
        for seat, one in responses.items()
    }


def cooperate(responses: Mapping[str, Response], details: Json, window_ms: float) -> Results:
    """Right is only what both did right, and within the window; then both have the time of the later one."""
    latencies = [one.latency_ms for one in responses.values() if one.latency_ms is not None]
    both = len(latencies) == len(responses)
    gap = max(latencies) - min(latencies) if both else None
    together = gap is not None and gap <= window_ms and all(one.is_right and one.is_real for one in responses.values())
    shared: Json = {**details, "together": together, "between_ms": gap}
    return {
        seat: msgspec.structs.replace(one.result(shared), correct=together, value=max(latencies) if together else None)
        for seat, one in responses.items()
    }
