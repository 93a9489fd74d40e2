"""The spread of an attempt's trials is published with its means, so that a change can be told from
noise.
"""

from statistics import stdev

from sar_tui.loop.attempt_scoring import AttemptFacts, score_seats
from sar_tui.loop.task import Task
from sar_tui.model.messages import AttemptEnded, Spread
from sar_tui.model.trial_types import DOUBTFUL, Result
from sar_tui.rules.feedback import History
from sar_tui.rules.parameters import build
from tests.lifting_task import Lift


class Median(Lift):
    """The metric is no mean of the trials."""

    def score(self, results: object) -> object:  # type: ignore[override]
        from msgspec.structs import replace

        return replace(super().score(results), metric=123.0)  # type: ignore[arg-type]


def lift(time_ms: float, sway: float, *flags: str, correct: bool = True) -> Result:
    return Result(
        correct=correct, response="lift", value=time_ms, details={"sway": sway}, flags=flags
    )


def ended(*results: Result, kind: type[Task] = Lift) -> AttemptEnded:
    task = kind(build(kind.Parameters, {}))
    facts = AttemptFacts(attempt=1, practice=False, level=1, started=0, ended=1)
    return score_seats(task, facts, {"A": list(results)}, {"A": History()}).seats["A"].ended


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
