"""Schedules of augmented feedback: which attempts get feedback.

First the parts of a schedule, then the six that are included (after Schmidt & Lee, Motor Control
and Learning, on augmented feedback), with their settings. Schedules of others:
docs/write-a-policy.md.
"""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, NamedTuple

import msgspec

from sar_tui.rules.declaration import Settings, in_group
from sar_tui.rules.judgement import ROUNDING, JudgedAttempt

setting = in_group("Feedback")


class History(msgspec.Struct, frozen=True):
    """The scored attempts of a seat, as far as the schedules need them.

    ``since``: number of attempts since the last feedback. ``skill``: successes minus failures,
    never below 0; ``paced_by``: the skill at the last feedback. ``recent``: the last attempts,
    oldest first, as many as a summary takes.
    """

    since: int = 0
    skill: int = 0
    paced_by: int = 0
    recent: tuple[JudgedAttempt, ...] = ()


class Decision(NamedTuple):
    """A schedule's decision on an attempt; see `messages.FeedbackChoice` for its fields."""

    due: bool
    why: str
    interval: int | None = None
    tolerance: float | None = None
    attempts: int = 1


class FeedbackPolicy(NamedTuple):
    """A schedule of feedback.

    Args:
        decide: returns the decision on the last attempt of a history, from that history, the
            attempt and the policy's own settings. It must be pure: a resumed session computes it
            again.
        settings: the type of those settings.
        feedback_on_practice: True if each practice attempt gets feedback, whatever ``decide``
            returns.
        recent: returns the number of attempts that the history has to hold, from the settings.
        summary: a few words for the therapist who chooses among the schedules.
    """

    decide: Callable[[History, JudgedAttempt, Any], Decision]
    settings: type[Settings] = Settings
    feedback_on_practice: bool = True
    recent: Callable[[Any], int] = lambda _: 1
    summary: str = ""


def decide_every(since: int, interval: int, note: str = "") -> Decision:
    """Return the decision of a schedule with feedback every ``interval`` attempts; ``note`` is
    added to the reason.
    """
    why = (
        f"Due every {interval} attempts; {since} since the last."
        if interval > 1
        else "Due after every attempt."
    )
    return Decision(since >= interval, f"{why} {note}".rstrip(), interval)


class EverySettings(Settings, frozen=True, kw_only=True):
    """Settings of the schedules ``every`` and ``summary``."""

    feedback_every: Annotated[
        int,
        setting(
            "Feedback every",
            "attempts",
            "For every and summary: the number of attempts n.",
            ge=1,
            le=100,
        ),
    ] = 1


def on_every(history: History, attempt: JudgedAttempt, settings: EverySettings) -> Decision:
    """Return the decision: due if enough attempts have passed since the last feedback."""
    return decide_every(history.since, settings.feedback_every)


def on_the_last(history: History, attempt: JudgedAttempt, settings: EverySettings) -> Decision:
    """Return the decision: due if enough attempts have passed to summarise them."""
    decision = decide_every(history.since, settings.feedback_every)
    return decision._replace(attempts=len(history.recent)) if decision.due else decision


RAREST = 10
"""The longest interval of ``faded``, in attempts."""


class FadedSettings(Settings, frozen=True, kw_only=True):
    """Settings of the schedule ``faded``."""

    feedback_fade: Annotated[
        int,
        setting(
            "Fading",
            "successes",
            "For faded: each time successes outnumber failures by this many more, feedback is "
            "rarer by one attempt.",
            ge=1,
            le=50,
        ),
    ] = 2


def less_with_success(
    history: History, attempt: JudgedAttempt, settings: FadedSettings
) -> Decision:
    """Return the decision: due if enough attempts have passed for the skill shown so far.

    A success lengthens the interval only after the next feedback; a failure shortens it at once.
    """
    ahead = min(history.paced_by, history.skill)
    note = (
        f"Successes outnumber failures by {history.skill}, at the last feedback by "
        f"{history.paced_by}."
    )
    return decide_every(history.since, min(RAREST, 1 + ahead // settings.feedback_fade), note)


class BandwidthSettings(Settings, frozen=True, kw_only=True):
    """Settings of the schedule ``bandwidth``."""

    feedback_tolerance: Annotated[
        float,
        setting(
            "Bandwidth",
            "% of the goal",
            "For bandwidth: no feedback on results within this distance of the goal.",
            ge=0,
            le=100,
        ),
    ] = 10.0


def outside_tolerance(
    history: History, attempt: JudgedAttempt, settings: BandwidthSettings
) -> Decision:
    """Return the decision: due if the result is farther from the goal than the tolerance, or if
    there is none.
    """
    goal, metric = attempt.target.threshold, attempt.score.metric
    tolerance = abs(goal) * settings.feedback_tolerance / 100
    if attempt.has_no_result or metric is None:
        return Decision(
            True, "Too few responses were right, or none could be timed.", tolerance=tolerance
        )
    off = abs(metric - goal)
    due = off > tolerance + ROUNDING * abs(goal)
    why = (
        f"{off:.4g} off the goal, {'more than' if due else 'within'} the tolerance of "
        f"{tolerance:.4g}."
    )
    return Decision(due, why, tolerance=tolerance)


def on_request(history: History, attempt: JudgedAttempt, settings: Settings) -> Decision:
    """Return the decision: never due."""
    return Decision(False, "Feedback is given when the participant asks for it.")


def never(history: History, attempt: JudgedAttempt, settings: Settings) -> Decision:
    """Return the decision: never due."""
    return Decision(False, "No feedback is given.")


INCLUDED: Mapping[str, FeedbackPolicy] = {
    "every": FeedbackPolicy(on_every, EverySettings, summary="after every n attempts."),
    "faded": FeedbackPolicy(less_with_success, FadedSettings, summary="less often with success."),
    "bandwidth": FeedbackPolicy(
        outside_tolerance, BandwidthSettings, summary="only away from the goal."
    ),
    "summary": FeedbackPolicy(
        on_the_last,
        EverySettings,
        recent=lambda settings: settings.feedback_every,
        summary="on the last n attempts.",
    ),
    "request": FeedbackPolicy(
        on_request, feedback_on_practice=False, summary="when the participant asks (Tab)."
    ),
    "none": FeedbackPolicy(never, feedback_on_practice=False, summary="never."),
}
"""Included schedules by name: a value of the setting ``feedback_schedule``."""
