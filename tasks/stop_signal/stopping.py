"""The delay of the cross that stops, and the time to stop, both from the results so far."""

from collections.abc import Sequence
from math import ceil
from statistics import fmean
from typing import Any

FIRST_MS, STEP_MS, LAST_MS = 250.0, 50.0, 1000.0
"""Delays of the cross: the first one, a step, and the longest."""


def next_delay_ms(results: Sequence[Any]) -> float | None:
    """Return the delay of the next cross, from the last one and what became of it; None if there
    was no cross.
    """
    last = next((result for result in reversed(results) if result.details["stop"]), None)
    if last is None:
        return None
    step = STEP_MS if last.response is None else -STEP_MS
    return min(
        max(round(float(last.details["delay_ms"]) / STEP_MS) * STEP_MS + step, STEP_MS), LAST_MS
    )


def stop_signal_rt(results: Sequence[Any]) -> float | None:
    """Return the stop-signal reaction time, ms: by integration, with omissions as the slowest
    responses.

    Of all responses to arrows, as large a share comes before it as there are responses despite a
    cross; then the mean delay of crosses is taken off. A key before the cross counts as a response
    despite it. It is None if that share is not between 0.25 and 0.75, where it cannot be estimated
    well (Verbruggen et al. 2019).
    """
    crosses = [result for result in results if result.details["stop"]]
    arrows = [result for result in results if result.details["stop"] is False]
    found = [result.value for result in arrows if result.value is not None]
    share = fmean(result.response is not None for result in crosses) if crosses else 0.0
    if not found or not 0.25 <= share <= 0.75:
        return None
    times = sorted([*found, *[max(found)] * (len(arrows) - len(found))])
    return float(
        times[ceil(share * len(times)) - 1]
        - fmean(result.details["delay_ms"] for result in crosses)
    )
