"""What a trial of two comes to, by policy: pure functions of who did what, and when."""

from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from sar_tui.framework.messages import Json
from sar_tui.framework.trial_types import Result, Results


class Response(NamedTuple):
    """What one of the two did.

    Args:
        asked: what they were asked for.
        is_over: whether nothing more is waited for: they responded, or were seen not to.
        done: what they did: a key's name, or a reach; None for nothing.
        at: when, ns: the key's stamp, or that of the movement's onset.
        latency_ms: since the prompt's onset.
        is_real: not too soon to be a response.
        details: what is kept of it.
        flags: what to beware of.
        remark: what they should hear of it, where it failed.
    """

    asked: str
    is_over: bool = False
    done: str | None = None
    at: int | None = None
    latency_ms: float | None = None
    is_real: bool = False
    details: Json = {}
    flags: tuple[str, ...] = ()
    remark: str = ""

    @property
    def is_right(self) -> bool:
        """Whether it was what was asked for."""
        return self.done is not None and self.done.casefold() == self.asked.casefold()

    def result(self, details: Json) -> Result:
        """It alone, held against the goal by its own reaction time."""
        return Result(
            correct=self.is_right,
            response=self.done,
            response_at=self.at,
            value=self.latency_ms,
            details={**details, "asked": self.asked, "right": self.is_right, **self.details},
            flags=self.flags,
            remark=self.remark,
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
