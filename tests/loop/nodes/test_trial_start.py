"""Trials that the participant starts."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.script import MAX_PRESENTATIONS
from sar_tui.loop.topics import ATTEMPT_ENDED, PROMPT, TRIAL, VOIDED, WAITING
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from tests.facts import each, facts
from tests.lifting_task import SLIPPED, Lift, LiftDriver

NewSession = Callable[..., LiftDriver]


@pytest.fixture
def new_session(calm: Theme) -> NewSession:
    """Start a session; by default two attempts of two lifts each."""

    def start(**settings: Any) -> LiftDriver:
        return LiftDriver(Lift, calm, **{"attempts": 2, **settings})

    return start


def waits(driver: LiftDriver) -> list[str]:
    return [waiting.what for waiting in driver.all(WAITING)]


def numbers(driver: LiftDriver) -> list[tuple[int, int]]:
    return [(trial.attempt, trial.trial) for trial in driver.all(TRIAL)]


# --- the key that starts a trial


def test_a_trial_waits_for_its_start_without_limit(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    assert facts(driver.waiting, "what stage attempt trial") == ("start", "trial", 1, 1)
    assert driver.waiting.goal == "Weight 1. Stand still."
    driver.wait(3_600_000)
    assert driver.waiting.what == "start"
    assert (driver.all(PROMPT), driver.all(TRIAL), driver.all(VOIDED)) == ([], [], [])


def test_the_start_key_shows_the_prompt_at_once(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.press("space")
    (prompt,) = driver.all(PROMPT)
    assert (prompt.attempt, prompt.trial, prompt.presentation, prompt.stimulus) == (1, 1, 1, "1 kg")
    assert waits(driver)[-2:] == ["start", "response"], "neither quiet nor a foreperiod"
    assert prompt.started == driver.clock.now()


def test_a_trial_starts_at_the_stamp_of_the_start_key(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    pressed = driver.clock.now() - 7 * MS
    driver.press("space", at=pressed)
    assert driver.last(PROMPT).started == pressed


@pytest.mark.parametrize("key", ["enter", "u", "k", "s"])
def test_no_other_key_starts_a_trial(new_session: NewSession, key: str) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.press(key)
    driver.wait(5000)
    assert driver.waiting.what == "start"
    assert driver.all(PROMPT) == []


def test_a_held_start_key_starts_only_one_trial(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.hold("space", ms=300)
    driver.operate("skip")
    driver.hold("space", ms=900)
    assert (driver.waiting.what, driver.waiting.trial, len(driver.all(PROMPT))) == ("start", 2, 1)
    driver.wait(600)
    driver.press("space")
    assert len(driver.all(PROMPT)) == 1, "so soon after the last press the key is still held"
    driver.wait(700)
    driver.press("space")
    assert len(driver.all(PROMPT)) == 2


@pytest.mark.parametrize("interval_ms", [300, 500, 650])
def test_a_start_key_that_is_tapped_again_and_again_starts_a_trial(
    new_session: NewSession, interval_ms: int
) -> None:
    driver = new_session()
    driver.enter()
    driver.press("space")
    driver.press("enter")
    for _ in range(3):
        driver.wait(interval_ms)
        driver.press("space")
    assert len(driver.all(PROMPT)) == 1


def test_a_start_key_that_is_held_for_long_starts_no_trial(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.press("space")
    driver.to_prompt()
    driver.wait(800)
    for key in ("k", "space", "u"):
        driver.press(key)
    assert driver.waiting.what == "start"
    driver.wait(500)
    driver.hold("space", ms=20_000, every_ms=40)
    assert len(driver.all(PROMPT)) == 1


def test_each_trial_needs_a_start_and_each_attempt_enter(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.lift()
    assert (driver.waiting.what, driver.waiting.trial) == ("start", 2)
    driver.lift()
    assert facts(driver.waiting, "what stage attempt") == ("enter", "attempt", 2)
    driver.press("space")
    assert driver.waiting.stage == "attempt"
    driver.press("enter")
    driver.wait(700)
    driver.lift()
    driver.lift()
    assert numbers(driver) == [(1, 1), (1, 2), (2, 1), (2, 2)]
    assert driver.waiting.stage == "review"


def test_a_started_trial_waits_for_storage_undisturbed_by_keys(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.screen.stores = False
    driver.lift()
    driver.press("space")
    pressed = driver.clock.now()
    assert driver.waiting.what == "storage"
    driver.wait(200)
    driver.press("k")
    assert driver.waiting.what == "storage"
    driver.screen.store(1, 1)
    assert driver.last(PROMPT).trial == 2
    assert driver.last(PROMPT).started == pressed


def test_the_time_out_counts_from_the_prompt(new_session: NewSession) -> None:
    driver = new_session(response_timeout_ms=2000)
    driver.begin_lifts()
    driver.wait(10_000)
    driver.press("space")
    driver.to_prompt()
    driver.wait(2049)
    assert driver.all(TRIAL) == []
    driver.wait(1)
    assert (driver.last(TRIAL).response, driver.last(TRIAL).correct) == (None, False)


def test_a_pause_before_the_start_returns_there(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.operate("pause")
    driver.press("space")
    assert (driver.waiting.stage, driver.all(PROMPT)) == ("paused", [])
    driver.wait(1000)
    driver.operate("resume")
    assert (driver.waiting.what, driver.waiting.trial) == ("start", 1)
    driver.lift()
    assert numbers(driver) == [(1, 1)]


def test_after_a_pause_a_trial_must_be_started_again(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.press("space")
    driver.to_prompt()
    driver.press("k")
    driver.operate("pause")
    driver.operate("resume")
    assert driver.waiting.what == "start"
    driver.wait(700)
    driver.press("space")
    again = driver.to_prompt()
    assert (again.trial, again.presentation, again.started) == (1, 2, driver.clock.now() - 4 * MS)
    driver.wait(300)
    driver.press("u")
    assert driver.all(TRIAL) == [], "what was lifted before the pause is forgotten"


def test_a_trial_that_was_not_started_can_be_skipped(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.operate("skip")
    skipped = driver.last(TRIAL)
    assert facts(skipped, "trial correct onset timing.flags") == (1, False, None, ("skipped",))
    assert (driver.waiting.what, driver.waiting.trial) == ("start", 2)


@pytest.mark.parametrize("presses", [(), ("space",), ("space", "k")])
def test_after_a_resume_a_trial_must_be_started_again(
    new_session: NewSession, calm: Theme, presses: tuple[str, ...]
) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.lift()
    for key in presses:
        driver.press(key)
        driver.wait(100)
    resumed = LiftDriver(Lift, calm, attempts=2, history=driver.records)
    assert (resumed.waiting.what, resumed.waiting.reason) == ("enter", "interrupted")
    resumed.press("enter")
    assert (resumed.waiting.what, resumed.waiting.trial) == ("start", 2)
    resumed.lift()
    assert facts(resumed.last(TRIAL), "attempt trial correct") == (1, 2, True)


# --- with a signal, or without


def test_with_a_signal_the_start_is_followed_by_quiet_and_a_foreperiod(
    new_session: NewSession,
) -> None:
    driver = new_session(signal=True, foreperiod_min_ms=900, foreperiod_max_ms=900)
    driver.begin_lifts()
    driver.press("space")
    started = driver.clock.now()
    prompt = driver.to_prompt()
    assert waits(driver)[-4:] == ["start", "quiet", "foreperiod", "response"]
    assert driver.clock.now() - started == (500 + 900 + 4) * MS
    assert prompt.started == started
    driver.press("d")
    assert driver.last(TRIAL).timing.foreperiod_ms == 900.0


def test_a_key_before_the_signal_restarts_the_foreperiod_only(new_session: NewSession) -> None:
    driver = new_session(signal=True, foreperiod_min_ms=900, foreperiod_max_ms=900)
    driver.begin_lifts()
    driver.press("space")
    started = driver.clock.now()
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.wait(400)
    driver.press("space")
    pressed = driver.clock.now()
    assert driver.to_prompt().started == started
    assert driver.clock.now() - pressed == (500 + 900 + 4) * MS
    driver.press("d")
    assert driver.last(TRIAL).timing.false_starts == 1


def test_without_start_key_and_foreperiod_prompts_come_at_once(new_session: NewSession) -> None:
    driver = new_session(by_itself=True)
    driver.enter()
    driver.press("enter")
    assert [prompt.trial for prompt in driver.all(PROMPT)] == [1]
    driver.to_prompt()
    driver.press("d")
    driver.wait(0)
    assert [prompt.trial for prompt in driver.all(PROMPT)] == [1, 2]
    assert {"quiet", "foreperiod"} & set(waits(driver)) == set()
    assert driver.last(TRIAL).timing.foreperiod_ms == 0


# --- a response that lasts


def test_the_row_of_a_movement_has_its_onset_and_end(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.lift(450)
    trial = driver.last(TRIAL)
    end = driver.clock.now() - 300 * MS
    assert (trial.onset, trial.response_at, trial.value) == (end - 450 * MS, end, 450.0)
    assert facts(trial, "response correct details") == ("lift", True, {"sway": 4.5, "grip": 50.0})
    assert trial.timing.flags == ()


def test_without_a_signal_there_is_no_reaction_time_or_anticipation(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.press("space")
    driver.press("k")
    driver.wait(5)
    driver.press("u")
    trial = driver.last(TRIAL)
    assert (trial.reaction_time_ms, trial.value, trial.timing.flags) == (None, 5.0, ())


def test_with_a_signal_the_reaction_time_ends_at_movement_onset(new_session: NewSession) -> None:
    driver = new_session(signal=True)
    driver.begin_lifts()
    driver.lift(450)
    trial = driver.last(TRIAL)
    assert (trial.reaction_time_ms, trial.value, trial.timing.flags) == (200.0, 450.0, ())


def test_a_movement_that_begins_too_soon_is_an_anticipation(new_session: NewSession) -> None:
    driver = new_session(signal=True, lifts=1)
    driver.begin_lifts()
    driver.press("space")
    driver.to_prompt()
    driver.wait(99)
    driver.press("k")
    driver.wait(2000)
    driver.press("u")
    trial = driver.last(TRIAL)
    assert facts(trial, "reaction_time_ms value correct timing.flags") == (
        99.0,
        None,
        True,
        ("anticipation",),
    )
    assert driver.last(ATTEMPT_ENDED).metric is None


def test_a_movement_before_the_signal_is_an_anticipation_without_reaction_time(
    new_session: NewSession,
) -> None:
    driver = new_session(signal=True, lifts=1)
    driver.begin_lifts()
    driver.press("space")
    driver.until(lambda: driver.all(PROMPT))
    driver.wait(1)
    driver.press("k")
    driver.to_prompt()
    driver.wait(500)
    driver.press("u")
    trial = driver.last(TRIAL)
    assert facts(trial, "reaction_time_ms value timing.flags") == (None, None, ("anticipation",))
    assert trial.response_at - trial.onset == 503 * MS


# --- unmeasurable trials


def test_an_unmeasurable_trial_is_repeated_with_a_notice(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    first = driver.waiting
    driver.lift(end="?")
    assert driver.all(TRIAL) == []
    voided = driver.last(VOIDED)
    assert facts(voided, "attempt trial presentation reason") == (1, 1, 1, "slipped")
    assert facts(driver.waiting, "what trial notice") == ("start", 1, SLIPPED)
    assert (first.notice, driver.waiting.goal) == ("", first.goal)
    driver.lift()
    assert numbers(driver) == [(1, 1)]
    assert driver.last(TRIAL).timing.presentation == 2
    assert driver.waiting.notice == "", "the next trial is no repetition"


def test_percepts_before_a_repetition_are_forgotten(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.lift(end="?")
    driver.press("space")
    driver.to_prompt()
    driver.wait(300)
    driver.press("u")
    assert driver.all(TRIAL) == [], "no weight was taken off the table this time"
    driver.press("k")
    driver.wait(300)
    driver.press("u")
    assert driver.last(TRIAL).value == 300.0


def test_a_trial_may_be_repeated_right_after_its_prompt(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.press("space")
    driver.press("?")
    driver.press("u")
    driver.wait(4)
    assert (driver.waiting.what, driver.waiting.notice, driver.all(TRIAL)) == ("start", SLIPPED, [])
    assert driver.session.faults == []


def test_repetitions_show_the_same_prompt(new_session: NewSession) -> None:
    driver = new_session(signal=True)
    driver.begin_lifts()
    for _ in range(MAX_PRESENTATIONS - 1):
        driver.lift(end="?")
    driver.lift()
    prompts = driver.all(PROMPT)
    assert each(prompts, "trial presentation") == [(1, n) for n in range(1, MAX_PRESENTATIONS + 1)]
    assert len({prompt.stimulus for prompt in prompts}) == 1
    shown = [record.at for record in driver.records if record.topic is PROMPT]
    began = [
        record.at
        for record in driver.records
        if record.topic is WAITING and record.message.what == "foreperiod"
    ]
    assert len({end - begin for begin, end in zip(began, shown, strict=True)}) == 1
    assert numbers(driver) == [(1, 1)]


def test_an_unmeasurable_trial_is_repeated_a_limited_number_of_times(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.begin_lifts()
    for _ in range(MAX_PRESENTATIONS):
        driver.lift(end="?")
    (missed,) = driver.all(TRIAL)
    assert (missed.correct, missed.timing.flags) == (False, ("unmeasured", "slipped"))
    assert (driver.waiting.what, driver.waiting.trial, driver.waiting.notice) == ("start", 2, "")
    driver.lift(end="?")
    assert len(driver.all(TRIAL)) == 1, "each trial has as many repetitions"


# --- notices


def test_a_level_is_announced_at_the_start_and_when_it_changes(new_session: NewSession) -> None:
    driver = new_session(attempts=3, lifts=1, start_level=3)
    driver.enter()
    assert driver.waiting.notice == "Weight 3 after 0"
    driver.press("enter")
    driver.wait(300)
    assert driver.waiting.notice == "", "a trial that is not repeated has no notice"
    driver.lift(end="d")
    assert (driver.waiting.stage, driver.waiting.notice) == ("attempt", "Weight 2 after 3")
    driver.operate("level", value=3)
    assert facts(driver.waiting, "stage notice") == ("attempt", ""), "the level did not change"


def test_a_level_that_stays_is_not_announced_again(new_session: NewSession) -> None:
    driver = new_session(lifts=1, difficulty_policy="fixed")
    driver.begin_lifts()
    driver.lift()
    assert (driver.waiting.stage, driver.waiting.notice) == ("attempt", "")
