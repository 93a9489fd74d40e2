"""The stop-signal task: the time to stop of known races, the delay that follows the participant,
simulated people.
"""

import sys
from random import Random
from statistics import fmean
from typing import Any

import pytest

from sar_tui.loop.topics import ATTEMPT_ENDED
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Result
from sar_tui.plugins import Catalogue
from tests.loop_driver import LoopDriver
from tests.tasks.conftest import EffectSession

STOP_SIGNAL = Catalogue().task("stop_signal")
STOPPING: Any = sys.modules[STOP_SIGNAL.__module__]


def arrow(value: float | None) -> Result:
    return Result(
        correct=value is not None,
        response=None if value is None else "left",
        value=value,
        details={"stop": False, "delay_ms": None},
    )


def cross(delay: float, pressed: bool) -> Result:
    return Result(
        correct=not pressed,
        response="left" if pressed else None,
        details={"stop": True, "delay_ms": float(delay)},
    )


def test_the_time_to_stop_of_a_race_is_found() -> None:
    needed, random = 180.0, Random("race")
    results: list[Result] = []
    for _ in range(8000):
        finishes = random.gauss(560, 110)
        if random.random() < 0.75:
            results.append(arrow(finishes))
            continue
        delay = STOPPING.next_delay_ms(results[-60:]) or STOPPING.FIRST_MS
        results.append(cross(delay, pressed=finishes < delay + random.gauss(needed, 20)))
    assert STOPPING.stop_signal_rt(results) == pytest.approx(needed, abs=8)
    pressed = [result.response is not None for result in results if result.details["stop"]]
    assert fmean(pressed) == pytest.approx(0.5, abs=0.03), "the delay follows the participant"


def test_omissions_count_as_the_slowest_responses() -> None:
    crosses = [cross(200, pressed=True), cross(200, pressed=False)]
    whole = [*map(arrow, (400, 450, 500, 550)), *crosses]
    assert STOPPING.stop_signal_rt(whole) == 450 - 200
    assert STOPPING.stop_signal_rt([*whole, arrow(None), arrow(None)]) == 500 - 200


@pytest.mark.parametrize("pressed", [0, 1, 9, 10])
def test_there_is_no_time_to_stop_if_nearly_all_or_nearly_none_were_stopped(
    pressed: int,
) -> None:
    crosses = [cross(200, pressed=number < pressed) for number in range(10)]
    assert STOPPING.stop_signal_rt([arrow(400), arrow(500), *crosses]) is None


def test_the_delay_grows_after_a_stop_and_shrinks_after_a_key_within_its_bounds() -> None:
    assert STOPPING.next_delay_ms([arrow(400)]) is None
    assert STOPPING.next_delay_ms([cross(251.4, pressed=False), arrow(400)]) == 300
    assert STOPPING.next_delay_ms([cross(249.2, pressed=True)]) == 200
    assert STOPPING.next_delay_ms([cross(50, pressed=True)]) == 50
    assert STOPPING.next_delay_ms([cross(1000, pressed=False)]) == 1000


def test_the_delay_goes_on_in_the_next_attempt(calm: Theme) -> None:
    driver = LoopDriver(STOP_SIGNAL, calm, attempts=2, prompts_per_attempt=8, crosses=0.5)
    driver.start()

    def delays() -> list[float | None]:
        """Press at once in an attempt, and return the delays of its crosses."""
        driver.begin_attempt()
        found = []
        for _ in range(8):
            prompt = driver.to_prompt()
            found += [prompt.frames[0].ms] if prompt.frames else []
            driver.answer(30, key="left")
        return found

    first = delays()
    carried = driver.last(ATTEMPT_ENDED).qualities["next_delay_ms"]
    assert (first[0], carried) == (250, 250 - 50 * len(first))
    assert delays()[0] == carried


def test_about_a_quarter_are_crosses_shown_after_their_delay(
    effect_session: EffectSession,
) -> None:
    trials = effect_session("stop_signal")
    crosses = [trial for trial in trials if trial.details["stop"]]
    assert 0.15 < len(crosses) / len(trials) < 0.35
    onsets = [(trial.timing.frame_onsets_ns or (), trial) for trial in crosses]
    seen = [(shown, trial) for shown, trial in onsets if len(shown) > 1]
    for shown, trial in seen:
        assert trial.details["delay_ms"] == pytest.approx((shown[1] - shown[0]) / 1e6)
    assert seen
