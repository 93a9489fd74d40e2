"""The scores of an attempt: the spread of its trials, and the task's advice on unanswered
prompts.
"""

from statistics import stdev
from typing import Any

import pytest
from msgspec.structs import replace

from sar_tui.loop.attempt_scoring import AttemptFacts, SeatScore, score_seats
from sar_tui.loop.replay_comparison import is_same
from sar_tui.loop.task import Task
from sar_tui.model.messages import AttemptEnded, Feedback, Spread
from sar_tui.model.trial_types import DOUBTFUL, Result
from sar_tui.rules.feedback import History
from sar_tui.rules.parameters import build
from tests.lifting_task import Lift


def scored(kind: type[Task], *results: Result, **parameters: object) -> SeatScore:
    task = kind(build(kind.Parameters, parameters))
    facts = AttemptFacts(attempt=1, practice=False, level=1, started=0, ended=1)
    return score_seats(task, facts, {"A": list(results)}, {"A": History()}).seats["A"]


# --- the spread, by which a change can be told from noise


class Median(Lift):
    """The metric is no mean of the trials."""

    def score(self, results: Any) -> Any:
        return replace(super().score(results), metric=123.0)


def lift(time_ms: float, sway: float, *flags: str, correct: bool = True) -> Result:
    return Result(
        correct=correct, response="lift", value=time_ms, details={"sway": sway}, flags=flags
    )


def ended(*results: Result, kind: type[Task] = Lift) -> AttemptEnded:
    return scored(kind, *results).ended


def test_the_number_and_sd_of_right_trials_are_published() -> None:
    found = ended(lift(900, 5), lift(1000, 7), lift(1100, 12), lift(5000, 99, correct=False))
    expected = {"lift_time": Spread(3, 100.0), "sway": Spread(3, stdev([5.0, 7.0, 12.0]))}
    assert found.spreads == expected
    assert ended(lift(900, 5)).spreads == {"lift_time": Spread(1, 0.0), "sway": Spread(1, 0.0)}


def test_a_metric_that_is_no_mean_of_its_trials_has_no_spread() -> None:
    assert set(ended(lift(900, 5), lift(1000, 7), kind=Median).spreads) == {"sway"}


def test_a_doubtful_trial_counts_for_the_result_but_not_for_qualities() -> None:
    found = ended(lift(900, 5), lift(1000, 7), lift(1100, 9, DOUBTFUL))
    assert (found.metric, found.qualities["sway"]) == (1000.0, 6.0)
    assert found.spreads == {"lift_time": Spread(0, 0.0), "sway": Spread(2, stdev([5.0, 7.0]))}


# --- unanswered prompts

RIGHT = Result(correct=True, response="f", response_at=1, value=400.0)
WRONG = Result(correct=False, response="x", response_at=1, value=400.0)
NOTHING = Result(correct=False)
SKIPPED = Result(correct=False, flags=("skipped",))
ADVICE = "Press the key as soon as you see it."


def feedback_on(kind: type[Task], *results: Result, **parameters: object) -> Feedback:
    feedback = scored(kind, *results, **parameters).feedback
    assert feedback
    return feedback


@pytest.mark.parametrize(
    ("results", "advice"),
    [
        ((NOTHING,) * 4, ADVICE),
        ((RIGHT, NOTHING, NOTHING, NOTHING), ADVICE),
        ((WRONG, WRONG, NOTHING, NOTHING), ADVICE),
        ((WRONG, WRONG, WRONG, NOTHING), ""),
        ((SKIPPED,) * 4, ""),
        ((RIGHT,) * 4, ""),
    ],
    ids="none one-right half-wrong mostly-wrong skipped-by-the-therapist right".split(),
)
def test_an_attempt_is_advised_on_what_most_of_its_prompts_lacked(
    keyboard: type[Task], results: tuple[Result, ...], advice: str
) -> None:
    assert feedback_on(keyboard, *results).advice == advice


def test_an_attempt_that_needs_no_accuracy_is_advised_too(keyboard: type[Task]) -> None:
    said = feedback_on(keyboard, NOTHING, NOTHING, min_accuracy=0)
    assert (said.reason, said.advice) == ("empty", ADVICE)


def test_a_session_stored_with_other_advice_can_still_be_replayed(keyboard: type[Task]) -> None:
    english, spanish = (feedback_on(keyboard, NOTHING, language=name) for name in ("en", "es"))
    assert spanish.advice == "Pulse la tecla en cuanto la vea."
    assert is_same(spanish, english)
