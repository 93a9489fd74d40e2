"""Unanswered prompts are answered with the task's advice, and never with a request to be slower."""

import pytest

from sar_tui.loop.attempt_scoring import AttemptFacts, score_seats
from sar_tui.loop.replay_comparison import is_same
from sar_tui.loop.task import Task
from sar_tui.model.messages import Feedback
from sar_tui.model.trial_types import Result
from sar_tui.rules.feedback import History
from sar_tui.rules.parameters import build

RIGHT = Result(correct=True, response="f", response_at=1, value=400.0)
WRONG = Result(correct=False, response="x", response_at=1, value=400.0)
NOTHING = Result(correct=False)
SKIPPED = Result(correct=False, flags=("skipped",))
ADVICE = "Press the key as soon as you see it."


def feedback_on(kind: type[Task], *results: Result, **parameters: object) -> Feedback:
    task = kind(build(kind.Parameters, parameters))
    facts = AttemptFacts(attempt=1, practice=False, level=1, started=0, ended=1)
    return score_seats(task, facts, {"A": results}, {"A": History()}).seats["A"].feedback


@pytest.mark.parametrize(
    ("results", "advice"),
    [
        ((NOTHING,) * 4, ADVICE),
        ((RIGHT, NOTHING, NOTHING, NOTHING), ADVICE),
        ((WRONG, WRONG, NOTHING, NOTHING), ADVICE),
        ((WRONG, WRONG, WRONG, NOTHING), ""),
        ((WRONG,) * 4, ""),
        ((SKIPPED,) * 4, ""),
        ((RIGHT, RIGHT, RIGHT, RIGHT), ""),
    ],
    ids=[
        "none",
        "one-right",
        "half-wrong",
        "mostly-wrong",
        "wrong",
        "skipped-by-the-therapist",
        "right",
    ],
)
def test_an_attempt_is_advised_on_what_most_of_its_prompts_lacked(
    keyboard: type[Task], results: tuple[Result, ...], advice: str
) -> None:
    assert feedback_on(keyboard, *results).advice == advice


def test_an_attempt_that_needs_no_accuracy_is_advised_too(keyboard: type[Task]) -> None:
    said = feedback_on(keyboard, NOTHING, NOTHING, min_accuracy=0)
    assert (said.reason, said.advice) == ("empty", ADVICE)


def test_the_advice_is_in_the_sessions_language(keyboard: type[Task]) -> None:
    assert (
        feedback_on(keyboard, NOTHING, language="es").advice == "Pulse la tecla en cuanto la vea."
    )


def test_a_session_stored_without_advice_can_still_be_replayed(keyboard: type[Task]) -> None:
    now = feedback_on(keyboard, NOTHING)
    assert is_same(feedback_on(keyboard, NOTHING, language="es"), now)
