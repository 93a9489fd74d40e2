"""The Go/No-Go task: its shapes, its score, and the errors of its simulated people."""

from statistics import NormalDist, fmean

import pytest

from sar_tui.loop.topics import PROMPT, TRIAL
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Result
from sar_tui.plugins import Catalogue
from sar_tui.simulation.participant_model import mean_time
from tests.loop_driver import LoopDriver
from tests.tasks.conftest import EffectSession

GONOGO = Catalogue().task("gonogo")


def shape(go: bool, pressed: bool) -> Result:
    value = 400.0 if go and pressed else None
    return Result(
        correct=go == pressed,
        response="space" if pressed else None,
        value=value,
        details={"go": go},
    )


def test_sensitivity_is_the_distance_between_two_normal_distributions() -> None:
    """An ideal observer whose evidence is d' apart, with a criterion in the middle, presses at
    Φ(d'/2) and Φ(-d'/2).
    """
    hits = NormalDist().cdf(1.0)
    count = 10_000
    pressed = {True: round(count * hits), False: round(count * (1 - hits))}
    results = [shape(go, number < pressed[go]) for go in (True, False) for number in range(count)]
    measures = GONOGO(GONOGO.Parameters()).measures(results)
    assert measures["d_prime"] == pytest.approx(2.0, abs=0.01)
    assert measures["commissions"] == pytest.approx(100 * (1 - hits), abs=0.01)


def test_sensitivity_is_finite_without_an_error() -> None:
    task = GONOGO(GONOGO.Parameters())
    results = [shape(True, True)] * 15 + [shape(False, False)] * 5
    z = NormalDist().inv_cdf
    assert task.measures(results) == {
        "commissions": 0,
        "d_prime": pytest.approx(z(15.5 / 16) - z(0.5 / 6)),
    }
    assert task.measures(results[:15]) == {}


def test_a_key_at_a_square_is_wrong_and_waiting_is_right(calm: Theme) -> None:
    driver = LoopDriver(GONOGO, calm, attempts=1, prompts_per_attempt=12, squares=0.5)
    driver.start()
    judged: list[tuple[bool, bool]] = []
    for number in range(12):
        while len(driver.all(PROMPT)) == number:
            driver.wait(100)
        go, presses = driver.last(PROMPT).data["go"], number % 2 == 0
        driver.wait(400)
        if presses:
            driver.press("space")
        while len(driver.all(TRIAL)) == number:
            driver.wait(100)
        row = driver.last(TRIAL)
        assert row.correct is (go == presses)
        assert (row.value is not None) is (go and presses)
        judged.append((go, presses))
    assert len(set(judged)) == 4


def test_people_who_press_at_a_square_are_sooner_than_at_circles(
    effect_session: EffectSession,
) -> None:
    trials = effect_session("gonogo")
    squares = [trial for trial in trials if not trial.data["go"]]
    errors = [trial for trial in squares if trial.response is not None]
    assert len(errors) / len(squares) == pytest.approx(0.15, abs=0.06)
    times = [trial.reaction_time_ms for trial in errors if trial.reaction_time_ms is not None]
    usual = mean_time([trial for trial in trials if trial.data["go"]])
    assert usual is not None
    assert fmean(times) < usual
