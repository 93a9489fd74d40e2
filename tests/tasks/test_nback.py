"""The n-back task: its letters and their pace, its score, and the effect of load on its simulated
people.
"""

from statistics import NormalDist

import pytest

from sar_tui.loop.topics import PROMPT, TRIAL
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Result
from sar_tui.plugins import Catalogue
from tests.loop_driver import LoopDriver
from tests.tasks.conftest import EffectSession

NBACK = Catalogue().task("nback")


def results(hits: int, misses: int, alarms: int, passed: int) -> list[Result]:
    return [
        *[Result(correct=True, response="space")] * hits,
        *[Result(correct=False)] * misses,
        *[Result(correct=False, response="space")] * alarms,
        *[Result(correct=True)] * passed,
    ]


def test_the_score_is_hits_minus_false_alarms() -> None:
    task = NBACK(NBACK.Parameters())
    score = task.score(results(hits=8, misses=2, alarms=1, passed=19))
    assert score.metric == pytest.approx(80 - 5)
    assert score.accuracy == pytest.approx(27 / 30)
    assert task.score(results(0, 10, 0, 20)).metric == 0  # nothing is pressed
    assert task.score(results(10, 0, 20, 0)).metric == 0  # all is pressed


def test_d_prime_has_half_a_response_more_in_each_count() -> None:
    task = NBACK(NBACK.Parameters())
    found = task.measures(results(hits=8, misses=2, alarms=1, passed=19))["d_prime"]
    cdf = NormalDist().cdf
    criterion = -NormalDist().inv_cdf(1.5 / 21)
    assert cdf(found - criterion) == pytest.approx(8.5 / 11)
    assert task.measures(results(5, 5, 5, 5))["d_prime"] == pytest.approx(0)


def test_letters_keep_their_pace_and_only_the_first_press_counts(calm: Theme) -> None:
    driver = LoopDriver(NBACK, calm, attempts=1, letters=10)
    driver.start()
    driver.wait(700)
    driver.press("x")
    driver.press("space")
    driver.wait(300)
    driver.press("space")
    driver.wait(1000)
    assert driver.all(TRIAL) == []
    driver.wait(1000)
    (first,) = driver.all(TRIAL)
    # nothing comes before the first letter
    assert (first.response, first.correct) == ("space", False)
    assert first.reaction_time_ms == pytest.approx(700, abs=10)
    driver.wait(2500)
    assert len(driver.all(TRIAL)) == 2


def test_an_interrupted_attempt_begins_again_with_other_letters(calm: Theme) -> None:
    driver = LoopDriver(NBACK, calm, attempts=1, letters=10)
    driver.start()
    driver.wait(7000)
    before = [prompt.stimulus for prompt in driver.all(PROMPT)]
    driver.operate("pause")
    driver.wait(1000)
    driver.operate("resume")
    driver.wait(300)
    driver.begin_attempt()
    driver.wait(30_000)
    again = [prompt.stimulus for prompt in driver.all(PROMPT)][len(before) :]
    assert len(again) == 11
    assert again[: len(before)] != before


def test_as_many_letters_as_declared_are_the_same(effect_session: EffectSession) -> None:
    session = effect_session("nback")
    for attempt, n in ((1, 1), (2, 2)):
        trials = [trial for trial in session if trial.attempt == attempt]
        letters = [trial.stimulus for trial in trials]
        assert len(letters) == 30 + n
        same = [place >= n and letter == letters[place - n] for place, letter in enumerate(letters)]
        assert same == [trial.data["target"] for trial in trials]
        assert sum(same) == 9
