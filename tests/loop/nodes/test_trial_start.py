"""Trials that the participant starts."""

from typing import Any

import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.script import MAX_PRESENTATIONS
from sar_tui.model.units import MS
from tests.facts import each, facts
from tests.lifting_task import SLIPPED, LiftDriver, lifting

SIGNAL = {"signal": True, "foreperiod_min_ms": 900, "foreperiod_max_ms": 900}


def waits(driver: LiftDriver) -> list[str]:
    return each(driver.all(t.WAITING), "what")


def now(driver: LiftDriver, names: str = "what trial") -> tuple[Any, ...]:
    return facts(driver.waiting, names)


# --- the key that starts a trial


def test_a_trial_waits_for_its_start_key_without_limit() -> None:
    driver = lifting()
    assert now(driver, "what stage attempt trial") == ("start", "trial", 1, 1)
    assert driver.waiting.goal == "Weight 1. Stand still."
    for key in ("enter", "u", "k", "s"):
        driver.press(key)
    driver.wait(3_600_000)
    assert driver.waiting.what == "start"
    assert driver.all(t.PROMPT) == driver.all(t.TRIAL) == driver.all(t.VOIDED) == []


def test_the_start_key_shows_the_prompt_at_once_and_starts_the_trial_at_its_stamp() -> None:
    driver = lifting()
    pressed = driver.clock.now() - 7 * MS
    driver.press("space", at=pressed)
    prompted = [(1, 1, 1, "1 kg", pressed)]
    assert each(driver.all(t.PROMPT), "attempt trial presentation stimulus started") == prompted
    assert waits(driver)[-2:] == ["start", "response"], "neither quiet nor a foreperiod"


def test_a_held_start_key_starts_only_one_trial() -> None:
    driver = lifting()
    driver.hold("space", ms=300)
    driver.operate("skip")
    driver.hold("space", ms=900)
    assert (*now(driver), len(driver.all(t.PROMPT))) == ("start", 2, 1)
    driver.wait(600)
    driver.press("space")
    assert len(driver.all(t.PROMPT)) == 1, "so soon after the last press the key is still held"
    driver.wait(700)
    driver.press("space")
    assert len(driver.all(t.PROMPT)) == 2


def test_a_started_trial_waits_for_storage_undisturbed_by_keys() -> None:
    driver = lifting()
    driver.screen.stores = False
    driver.lift()
    driver.press("space")
    pressed = driver.clock.now()
    assert driver.waiting.what == "storage"
    driver.wait(200)
    driver.press("k")
    assert driver.waiting.what == "storage"
    driver.screen.store(1, 1)
    assert facts(driver.last(t.PROMPT), "trial started") == (2, pressed)


def test_a_trial_that_is_not_done_in_time_is_missed() -> None:
    driver = lifting("prompt", response_timeout_ms=2000)
    driver.wait(2050)
    assert facts(driver.last(t.TRIAL), "response correct") == (None, False)


def test_after_a_pause_a_trial_must_be_started_again() -> None:
    driver = lifting("prompt")
    driver.press("k")
    driver.operate("pause")
    driver.operate("resume")
    assert driver.waiting.what == "start"
    driver.wait(700)
    again = driver.to_lift()
    started = driver.clock.now() - 4 * MS
    assert facts(again, "trial presentation started") == (1, 2, started)
    driver.wait(300)
    driver.press("u")
    assert driver.all(t.TRIAL) == [], "what was lifted before the pause is forgotten"


# --- with a signal, or without


def test_with_a_signal_the_start_is_followed_by_a_foreperiod_that_a_key_restarts() -> None:
    driver = lifting(**SIGNAL)
    driver.press("space")
    started = driver.clock.now()
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.wait(400)
    driver.press("space")
    pressed = driver.clock.now()
    assert driver.to_prompt().started == started
    assert driver.clock.now() - pressed == (500 + 900 + 4) * MS
    assert waits(driver)[-6:] == ["start", *["quiet", "foreperiod"] * 2, "response"]
    driver.press("d")
    assert facts(driver.last(t.TRIAL).timing, "foreperiod_ms false_starts") == (900.0, 1)


def test_without_start_key_and_foreperiod_prompts_come_at_once() -> None:
    driver = lifting("attempt", by_itself=True)
    driver.press("enter")
    assert each(driver.all(t.PROMPT), "trial") == [1]
    driver.to_prompt()
    driver.press("d")
    driver.wait(0)
    assert each(driver.all(t.PROMPT), "trial") == [1, 2]
    assert {"quiet", "foreperiod"} & set(waits(driver)) == set()
    assert driver.last(t.TRIAL).timing.foreperiod_ms == 0


# --- a response that lasts

MOVED = "reaction_time_ms value correct timing.flags"


def test_the_row_of_a_movement_has_its_onset_and_end() -> None:
    driver = lifting()
    driver.lift(450)
    trial = driver.last(t.TRIAL)
    end = driver.clock.now() - 300 * MS
    assert facts(trial, "onset response_at value") == (end - 450 * MS, end, 450.0)
    assert facts(trial, "response correct timing.flags") == ("lift", True, ())
    assert trial.details == {"sway": 4.5, "grip": 50.0}


@pytest.mark.parametrize(
    ("signal", "began_ms", "stored"),
    [
        (False, 5, (None, 450.0, True, ())),
        (True, 200, (200.0, 450.0, True, ())),
        (True, 99, (99.0, None, True, ("anticipation",))),
    ],
    ids=["without a signal", "after a signal", "too soon after it"],
)
def test_the_reaction_time_ends_at_movement_onset_and_needs_a_signal(
    signal: bool, began_ms: int, stored: tuple[Any, ...]
) -> None:
    driver = lifting("prompt", signal=signal, lifts=1)
    driver.wait(began_ms)
    driver.press("k")
    driver.wait(450)
    driver.press("u")
    assert facts(driver.last(t.TRIAL), MOVED) == stored
    assert driver.last(t.ATTEMPT_ENDED).metric == stored[1]


def test_a_movement_before_the_signal_is_an_anticipation_without_reaction_time() -> None:
    driver = lifting(signal=True, lifts=1)
    driver.press("space")
    driver.until(lambda: driver.all(t.PROMPT))
    driver.wait(1)
    driver.press("k")
    driver.to_prompt()
    driver.wait(500)
    driver.press("u")
    trial = driver.last(t.TRIAL)
    assert facts(trial, MOVED) == (None, None, True, ("anticipation",))
    assert trial.response_at - trial.onset == 503 * MS


# --- unmeasurable trials


def test_an_unmeasurable_trial_is_repeated_with_a_notice() -> None:
    driver = lifting()
    first = driver.waiting
    driver.lift(end="?")
    assert driver.all(t.TRIAL) == []
    voided = facts(driver.last(t.VOIDED), "attempt trial presentation reason")
    assert voided == (1, 1, 1, "slipped")
    assert now(driver, "what trial notice") == ("start", 1, SLIPPED)
    assert (first.notice, driver.waiting.goal) == ("", first.goal)
    driver.lift()
    assert each(driver.all(t.TRIAL), "attempt trial timing.presentation") == [(1, 1, 2)]
    assert driver.waiting.notice == "", "the next trial is no repetition"


def test_an_unmeasurable_trial_is_repeated_a_limited_number_of_times() -> None:
    driver = lifting()
    for _ in range(MAX_PRESENTATIONS):
        driver.lift(end="?")
    missed = each(driver.all(t.TRIAL), "correct timing.flags")
    assert missed == [(False, ("unmeasured", "slipped"))]
    assert now(driver, "what trial notice") == ("start", 2, "")
    driver.lift(end="?")
    assert len(driver.all(t.TRIAL)) == 1, "each trial has as many repetitions"


# --- notices


def test_a_level_is_announced_at_the_start_and_when_it_changes() -> None:
    driver = lifting("attempt", attempts=3, lifts=1, start_level=3)
    assert driver.waiting.notice == "Weight 3 after 0"
    driver.press("enter")
    driver.wait(300)
    assert driver.waiting.notice == "", "a trial that is not repeated has no notice"
    driver.lift(end="d")
    assert now(driver, "stage notice") == ("attempt", "Weight 2 after 3")
    driver.operate("level", value=3)
    assert now(driver, "stage notice") == ("attempt", ""), "the level did not change"
