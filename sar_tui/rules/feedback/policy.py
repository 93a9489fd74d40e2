"""The parts of a feedback schedule."""

from collections.abc import Callable
from typing import Any, NamedTuple

import msgspec

from sar_tui.rules.declaration import Settings
from sar_tui.rules.judgement import JudgedAttempt


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
    """

    decide: Callable[[History, JudgedAttempt, Any], Decision]
    settings: type[Settings] = Settings
    feedback_on_practice: bool = True
    recent: Callable[[Any], int] = lambda _: 1


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
