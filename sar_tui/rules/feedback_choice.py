"""The feedback on an attempt, by the schedule that is set: due or not, and in which form."""

from typing import Literal

import msgspec

from sar_tui.model.messages import FeedbackChoice
from sar_tui.rules.feedback import History
from sar_tui.rules.judgement import JudgedAttempt, degree
from sar_tui.rules.parameters import TaskParameters
from sar_tui.rules.policies import FEEDBACK, own_settings

Content = Literal["results", "performance", "both"]


def remember(history: History, attempt: JudgedAttempt, parameters: TaskParameters) -> History:
    """Return the history with one more scored attempt."""
    policy = FEEDBACK[parameters.feedback_schedule]
    length = policy.recent(own_settings(policy.settings, parameters))
    return History(
        since=history.since + 1,
        skill=max(0, history.skill + (1 if attempt.outcome == "success" else -1)),
        paced_by=history.paced_by,
        recent=(*history.recent, attempt)[-length:],
    )


def choose(
    history: History,
    attempt: JudgedAttempt,
    parameters: TaskParameters,
    content: Content,
    *,
    practice: bool = False,
) -> FeedbackChoice:
    """Decide on the feedback on an attempt, by the schedule that is set.

    Args:
        history: of the scored attempts, this one included (see ``remember``) unless it is for
            practice.
        attempt: the attempt.
        parameters: of the session.
        content: the task's content of feedback (``Task.feedback_on``).
        practice: True if the attempt is for practice. Most schedules give feedback on each of
            those.
    """
    schedule = parameters.feedback_schedule
    policy = FEEDBACK[schedule]
    decision = policy.decide(history, attempt, own_settings(policy.settings, parameters))
    if practice and policy.feedback_on_practice:
        decision = decision._replace(
            due=True, why="Each practice attempt gets feedback.", tolerance=None, attempts=1
        )
    return FeedbackChoice(
        schedule=schedule,
        due=decision.due,
        why=decision.why,
        content=content,
        form=parameters.feedback_form,
        compared_with=parameters.feedback_compared_with,
        degree="clear" if attempt.has_no_result else degree(attempt.score.metric, attempt.target),
        delay_ms=0 if schedule == "request" else parameters.feedback_delay_ms,
        since=history.since,
        interval=decision.interval,
        tolerance=decision.tolerance,
        attempts=decision.attempts,
    )


def given(history: History) -> History:
    """Return the history after feedback was given."""
    return msgspec.structs.replace(history, since=0, paced_by=history.skill)
