"""Results of a trial by policy, as pure functions of both responses."""

from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from sar_tui.api.task import Json, Result, Results


class Response(NamedTuple):
    """The response of one seat.

    Args:
        asked: the response asked for: a key's name, or a reach.
        is_over: True if no more is expected: the seat responded, or its sensor saw no whole reach.
        done: the response; None for none.
        at: time stamp of the key press or the movement onset (ns).
        latency_ms: time from the prompt's onset.
        is_real: False for an anticipation.
        details: stored with the trial.
        flags: added to ``trials.timing``.
        remark: said to the participant if the attempt fails.
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
        """True if it is the response asked for."""
        return self.done is not None and self.done.casefold() == self.asked.casefold()

    def result(self, details: Json) -> Result:
        """Return the result of this response alone, with its own reaction time."""
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
    """Return the results of a race: the fastest right response wins, or both if equal. Each keeps
    its own time.
    """
    fair = {seat: one.latency_ms for seat, one in responses.items() if one.is_right and one.is_real}
    fastest = min((latency for latency in fair.values() if latency is not None), default=None)
    return {
        seat: one.result({**details, "won": fastest is not None and fair.get(seat) == fastest})
        for seat, one in responses.items()
    }


def cooperate(responses: Mapping[str, Response], details: Json, window_ms: float) -> Results:
    """Return the results of cooperation: right if both are right within the window; both get the
    later time.
    """
    latencies = [one.latency_ms for one in responses.values() if one.latency_ms is not None]
    both = len(latencies) == len(responses)
    gap = max(latencies) - min(latencies) if both else None
    together = (
        gap is not None
        and gap <= window_ms
        and all(one.is_right and one.is_real for one in responses.values())
    )
    shared: Json = {**details, "together": together, "between_ms": gap}
    return {
        seat: msgspec.structs.replace(
            one.result(shared), correct=together, value=max(latencies) if together else None
        )
        for seat, one in responses.items()
    }
