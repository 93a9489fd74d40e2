"""Feedback on a single trial: a sign, points or a word on the screen, before the next trial begins.
Pure.
"""

from collections.abc import Sequence

from sar_tui.model.messages import TrialFeedback
from sar_tui.model.trial_types import Result, Results, Show, Situation
from sar_tui.model.units import MS

RIGHT, WRONG = "✓", "✗"
_UNJUDGED = ("skipped", "unmeasured")
"""Flags of results that say nothing about the participant."""


def trial_feedback(
    situation: Situation, results: Results, seats: Sequence[str], sign_ms: int
) -> TrialFeedback | None:
    """Return the feedback on a trial; None if nothing is shown.

    Args:
        situation: of the trial.
        results: of the trial, by seat.
        seats: of the task: the first one sees its answer on the left if answers differ.
        sign_ms: how long a tick or a cross is shown for a result of which the task shows nothing;
            0: it is not.
    """
    shows = {seat: show for seat, result in results.items() if (show := _show(result, sign_ms))}
    if not shows:
        return None
    texts = [shows[seat].text if seat in shows else "" for seat in seats]
    differ = len(results) > 1 and len(set(texts)) > 1
    return TrialFeedback(
        seat=next(iter(results)) if len(results) == 1 else "",
        attempt=situation.attempt,
        trial=situation.trial,
        text=" ".join(filter(None, texts)) if differ else next(iter(shows.values())).text,
        halves=tuple(texts) if differ else (),
        duration=max(show.ms for show in shows.values()) * MS,
    )


def _show(result: Result, sign_ms: int) -> Show | None:
    if result.show or not sign_ms or set(_UNJUDGED) & set(result.flags):
        return result.show
    return Show(RIGHT if result.correct else WRONG, sign_ms)
