"""Moving in time with the beat: the turns of a hand whose motion is known, the row's score, and
simulated people.
"""

import sys
from statistics import fmean
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sar_tui.model.theme import Theme
from sar_tui.motion.samples import SAMPLE, Samples
from sar_tui.plugins import Catalogue
from sar_tui.validation.effects import effects, play

TEMPO: Any = Catalogue().task("tracking_tempo")
BEATS: Any = sys.modules[TEMPO.__module__]


@pytest.fixture(scope="module")
def turns() -> Any:
    TEMPO(TEMPO.Parameters()).nodes()  # loads the module
    return sys.modules[f"{TEMPO.__module__.rpartition('.')[0]}.turns"]


def swinging(period_s: float, seed: int, rate_hz: float = 100.0) -> tuple[Samples, list[float]]:
    """Return samples of a hand that swings about any axis, with noise, bias and tremor, and when it
    turns, in s.
    """
    random = np.random.default_rng(seed)
    time_s = np.arange(0.0, 12.0, 1 / rate_hz)
    swings = np.where((time_s > 2) & (time_s < 2 + 8 * period_s), np.pi / period_s, 0.0)
    rate = 0.3 * swings * np.sin(swings * (time_s - 2))
    rate += 0.05 * np.sin(2 * np.pi * 6 * time_s)
    axis = Rotation.random(rng=random).apply([0.0, 0.0, 1.0])
    samples = np.zeros(len(time_s), SAMPLE)
    samples["at"] = np.round(time_s * 1e9)
    samples["device_ms"] = time_s * 1000
    samples["rate"] = (
        rate[:, None] * axis + random.normal(0, 0.02, (len(time_s), 3)) + [0.01, -0.02, 0.015]
    )
    return samples, [2 + period_s * turn for turn in range(1, 8)]


@pytest.mark.parametrize(("period_s", "seed"), [(0.5, 1), (0.9, 2), (1.2, 3)])
def test_each_turn_of_a_hand_that_swings_about_any_axis_is_found(
    turns: Any, period_s: float, seed: int
) -> None:
    samples, truth = swinging(period_s, seed)
    assert [at / 1e9 for at in turns.turn_times(samples)] == pytest.approx(truth, abs=0.02)


def test_a_hand_at_rest_has_no_turns(turns: Any) -> None:
    samples, _ = swinging(1.0, 3)
    assert turns.turn_times(samples[samples["at"] < 1.9e9]) == []


def test_missing_samples_are_no_turns_but_a_reason_to_repeat(turns: Any) -> None:
    samples, _ = swinging(1.0, 4)
    hole = samples[(samples["at"] < 5e9) | (samples["at"] > 5.2e9)]
    faults = [turns.fault(each) for each in (samples, samples[:5], samples[:0], hole)]
    assert faults == ["", "samples", "samples", "gap"]


def test_a_row_is_scored_by_the_one_turn_near_each_beat() -> None:
    at = [round(second * 1e9) for second in range(8)]
    turned = [int(1e9 * moment) for moment in (0.97, 1.98, 2.92, 3.97, 4.2, 5.9, 6.3)]
    found = BEATS.in_time(at, turned, 1000.0)
    assert found.followed == pytest.approx(3 / 6), "at 4 s and 6 s there are two turns, at 5 s none"
    assert found.asynchrony_ms == pytest.approx(fmean((-30, -20, -80)))
    assert BEATS.in_time(at, [], 1000.0) == (None, None, 0.0)


def test_those_who_keep_a_tempo_of_their_own_do_not_follow_the_beat(calm: Theme) -> None:
    (effect,) = (effect for kind, effect in effects(Catalogue()) if kind is TEMPO)

    class Own(TEMPO):  # type: ignore[misc]
        def rehearse(self, stimulus: Any, performance: Any, streams: Any) -> Any:
            return super().rehearse(stimulus, type(performance)(500.0, slips=True), streams)

    trials = play(Own, effect, calm, 1)
    assert not any(trial.correct for trial in trials)
    assert {trial.value for trial in trials} == {None}
    assert {trial.timing.tone_source for trial in trials} == {"virtual"}
