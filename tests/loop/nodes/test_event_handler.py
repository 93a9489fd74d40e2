"""The event handler runs the keyboard task: keys, pauses, storage, faults."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Details, Metric, Result, Situation, Stimulus, Trial
from sar_tui.model.units import MS
from sar_tui.rules.parameters import TaskParameters
from tests.facts import each, facts
from tests.loop_driver import LoopDriver

NewSession = Callable[..., LoopDriver]


@pytest.fixture
def new_session(keyboard: type[Task], calm: Theme) -> NewSession:
    """Start a keyboard session; by default two attempts of three prompts each."""

    def start(**settings: Any) -> LoopDriver:
        return LoopDriver(keyboard, calm, **{"prompts_per_attempt": 3, "attempts": 2, **settings})

    return start


def stages(driver: LoopDriver) -> list[str]:
    return [waiting.what for waiting in driver.all(t.WAITING)]


def flags(driver: LoopDriver) -> tuple[str, ...]:
    return driver.last(t.TRIAL).timing.flags


def numbers(driver: LoopDriver) -> list[tuple[int, int]]:
    return [(trial.attempt, trial.trial) for trial in driver.all(t.TRIAL)]


# --- a normal session


def test_a_session_runs_from_the_instructions_to_its_end(new_session: NewSession) -> None:
    driver = new_session()
    assert (driver.waiting.what, driver.waiting.stage) == ("enter", "instructions")
    driver.enter()
    assert facts(driver.waiting, "what stage attempt_name") == (
        "enter",
        "attempt",
        "attempt 1 of 2",
    )
    assert (
        driver.waiting.goal
        == "Your goal: press the right key in less than 1 second on average, with 3 of 3 right."
    )
    driver.attempt()
    assert (driver.waiting.stage, driver.waiting.attempt_name) == ("attempt", "attempt 2 of 2")
    driver.attempt()
    assert (driver.waiting.what, driver.waiting.stage) == ("enter", "review")
    assert driver.all(t.SESSION_ENDED) == [], "the last feedback is read before the goodbye"
    driver.press("enter")
    assert driver.waiting.what == "nothing"
    assert numbers(driver) == [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)]
    assert [end.status for end in driver.all(t.SESSION_ENDED)] == ["completed"]
    assert driver.session.faults == []


def test_with_one_seat_it_is_always_its_turn(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.attempt()
    assert {waiting.seat for waiting in driver.all(t.WAITING)} == {"A"}


def test_a_trial_is_quiet_then_foreperiod_then_prompt(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.begin_attempt()
    assert stages(driver)[-3:] == ["quiet", "foreperiod", "response"]


def test_a_correct_key_is_stored_with_its_time_from_onset_to_stamp(new_session: NewSession) -> None:
    driver = new_session()
    prompt = driver.start()
    onset = driver.clock.now()
    driver.wait(432)
    driver.press(prompt.expected, at=driver.clock.now() - 2 * MS, lag=3 * MS)
    trial = driver.last(t.TRIAL)
    assert facts(trial, "attempt trial stimulus response") == (
        1,
        1,
        prompt.stimulus,
        prompt.expected,
    )
    assert trial.correct
    assert (trial.onset, trial.response_at) == (onset, onset + 430 * MS)
    assert trial.reaction_time_ms == trial.value == 430.0
    timing = trial.timing
    assert (timing.onset_source, timing.handler_delay_ms, timing.loop_lag_ms) == ("flush", 2.0, 3.0)
    assert (timing.false_starts, timing.presentation, timing.flags) == (0, 1, ())


def test_a_wrong_key_lowers_accuracy_and_is_not_in_the_metric(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    driver.answer(300, key="#")
    wrong = driver.last(t.TRIAL)
    assert facts(wrong, "response correct reaction_time_ms value") == ("#", False, 300.0, None)
    driver.answer(400)
    driver.answer(500)
    ended = driver.last(t.ATTEMPT_ENDED)
    assert facts(ended, "metric accuracy correct trials") == (450.0, pytest.approx(2 / 3), 2, 3)
    assert (ended.outcome, ended.feedback) == ("failure", "negative")
    assert driver.last(t.FEEDBACK).reason == "accuracy"


def test_a_miss_is_stored_with_nulls_after_the_time_out(new_session: NewSession) -> None:
    driver = new_session(response_timeout_ms=2000)
    driver.start()
    driver.wait(2049)
    assert driver.all(t.TRIAL) == []
    driver.wait(1)
    miss = driver.last(t.TRIAL)
    assert facts(miss, "response response_at reaction_time_ms value") == (None, None, None, None)
    assert not miss.correct
    assert miss.onset is not None


def test_an_attempt_with_no_correct_response_fails_with_an_empty_metric(
    new_session: NewSession,
) -> None:
    driver = new_session(start_level=2, min_accuracy=0.0)
    driver.enter()
    driver.attempt(wrong=3)
    ended = driver.last(t.ATTEMPT_ENDED)
    assert facts(ended, "metric accuracy outcome feedback") == (None, 0.0, "failure", "negative")
    assert driver.last(t.FEEDBACK).reason == "empty"
    assert driver.last(t.LEVEL).level == 1


def test_success_raises_and_failure_lowers_the_level_of_the_next_attempt(
    new_session: NewSession,
) -> None:
    driver = new_session(attempts=3, start_level=4)
    driver.enter()
    driver.attempt(400)
    driver.attempt(1400)
    driver.attempt(400)
    assert [ended.level for ended in driver.all(t.ATTEMPT_ENDED)] == [4, 5, 4]
    assert each(driver.all(t.LEVEL), "previous level reason") == [
        (4, 5, "success"),
        (5, 4, "failure"),
        (4, 5, "success"),
    ]


def test_an_attempt_is_in_memory_before_its_feedback(new_session: NewSession) -> None:
    driver = new_session(attempts=5, difficulty_policy="fixed", feedback_form="quantitative")
    driver.enter()
    for time_ms in (700, 700, 700, 650):
        driver.attempt(time_ms)
    assert "0.05 seconds faster than last time" in driver.last(t.ACTION).text
    topics = [
        record.topic
        for record in driver.records
        if record.topic in (t.TRIAL, t.ATTEMPT_ENDED, t.FEEDBACK, t.ACTION)
    ]
    assert topics[-4:] == [t.TRIAL, t.ATTEMPT_ENDED, t.FEEDBACK, t.ACTION]


def test_feedback_frequency_is_independent_of_difficulty(new_session: NewSession) -> None:
    driver = new_session(
        attempts=6, prompts_per_attempt=1, feedback_every=3, consecutive_successes=2
    )
    driver.enter()
    for _ in range(6):
        driver.attempt(400)
    assert each(driver.all(t.ATTEMPT_ENDED), "feedback") == ["none", "none", "positive"] * 2
    assert [feedback.attempt for feedback in driver.all(t.FEEDBACK)] == [3, 6]
    assert [ended.level for ended in driver.all(t.ATTEMPT_ENDED)] == [1, 1, 2, 2, 3, 3]


def test_practice_gets_feedback_but_changes_neither_level_nor_count(
    new_session: NewSession,
) -> None:
    driver = new_session(practice_attempts=1, attempts=2, feedback_every=2, start_level=3)
    driver.enter()
    assert driver.waiting.attempt_name == "practice 1 of 1"
    driver.attempt(400)
    assert driver.all(t.LEVEL) == []
    assert driver.waiting.attempt_name == "attempt 1 of 2"
    driver.attempt(400)
    driver.attempt(400)
    ended = driver.all(t.ATTEMPT_ENDED)
    assert each(ended, "attempt practice level") == [(1, True, 3), (2, False, 3), (3, False, 4)]
    assert [attempt.feedback for attempt in ended] == ["positive", "none", "positive"]
    assert driver.waiting.stage == "review"


def test_failures_in_practice_do_not_count_as_consecutive(new_session: NewSession) -> None:
    driver = new_session(practice_attempts=2, attempts=1, start_level=3, consecutive_failures=3)
    driver.enter()
    for _ in range(3):
        driver.attempt(1400)
    assert driver.all(t.LEVEL) == []


# --- keys outside the response window


def test_a_key_in_the_foreperiod_restarts_it_and_is_no_response(new_session: NewSession) -> None:
    driver = new_session(foreperiod_min_ms=800, foreperiod_max_ms=800)
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.wait(700)
    driver.press("f")
    pressed = driver.clock.now()
    assert driver.waiting.what == "quiet"
    prompt = driver.to_prompt()
    assert driver.clock.now() - pressed == (500 + 800 + 4) * MS
    assert driver.all(t.TRIAL) == []
    driver.wait(400)
    driver.press(prompt.expected)
    assert driver.last(t.TRIAL).timing.false_starts == 1
    assert driver.last(t.TRIAL).reaction_time_ms == 400.0


def test_the_foreperiod_lies_between_its_bounds_and_differs_from_trial_to_trial(
    new_session: NewSession,
) -> None:
    driver = new_session(prompts_per_attempt=20, foreperiod_min_ms=600, foreperiod_max_ms=900)
    driver.enter()
    driver.attempt()
    waits = [trial.timing.foreperiod_ms for trial in driver.all(t.TRIAL)]
    assert all(600 <= wait <= 900 for wait in waits)
    assert len(set(waits)) == 20
    shown = [record.at for record in driver.records if record.topic is t.PROMPT]
    began = [
        record.at
        for record in driver.records
        if record.topic is t.WAITING and record.message.what == "foreperiod"
    ]
    assert [(end - begin) / MS for begin, end in zip(began, shown, strict=True)] == pytest.approx(
        waits
    )


def test_a_foreperiod_begins_only_after_half_a_second_without_keys(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    entered = driver.clock.now()
    driver.until(lambda: driver.waiting.what == "foreperiod")
    assert driver.clock.now() - entered == 500 * MS
    driver.answer(300)
    answered = driver.clock.now()
    driver.until(lambda: driver.waiting.what == "foreperiod")
    assert driver.clock.now() - answered == 500 * MS


def test_a_key_before_the_foreperiod_delays_it_and_is_no_false_start(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    driver.wait(300)
    driver.press("f")
    pressed = driver.clock.now()
    driver.until(lambda: driver.waiting.what == "foreperiod")
    assert driver.clock.now() - pressed == 500 * MS
    assert driver.answer().timing.false_starts == 0


def test_after_a_quiet_miss_the_foreperiod_begins_at_once(new_session: NewSession) -> None:
    driver = new_session(response_timeout_ms=2000)
    driver.start()
    driver.until(lambda: driver.all(t.TRIAL))
    missed = driver.clock.now()
    driver.until(lambda: driver.waiting.what == "foreperiod")
    assert driver.clock.now() == missed


def test_a_held_key_delays_the_prompt_until_it_is_released(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    driver.wait(30)
    driver.hold("enter", ms=4000)
    released = driver.clock.now()
    assert driver.all(t.PROMPT) == []
    assert [started.attempt for started in driver.all(t.ATTEMPT_STARTED)] == [1]
    driver.to_prompt()
    assert driver.clock.now() - released >= (500 - 30 + 500) * MS
    assert driver.all(t.TRIAL) == []


def test_a_held_enter_begins_no_attempt(new_session: NewSession) -> None:
    driver = new_session()
    driver.wait(1000)
    driver.strike("enter")
    driver.wait(500)
    driver.hold("enter", ms=5000)
    assert (driver.waiting.stage, driver.all(t.ATTEMPT_STARTED)) == ("attempt", [])
    driver.wait(200)
    driver.press("enter")
    assert driver.waiting.stage == "trial"


def test_an_enter_that_was_down_when_the_session_began_skips_nothing(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.hold("enter", ms=5000)
    assert driver.waiting.stage == "instructions"


@pytest.mark.parametrize("between_ms", [20, 80, 300, 590])
def test_a_doubled_enter_passes_one_screen_only(new_session: NewSession, between_ms: int) -> None:
    driver = new_session(attempts=1, prompts_per_attempt=1)
    passed = []
    for _ in range(3):
        driver.wait(1000)
        passed.append(driver.waiting.stage)
        driver.strike("enter")
        driver.wait(between_ms)
        driver.strike("enter")
        if driver.waiting.stage == "trial":
            driver.answer()
    assert passed == ["instructions", "attempt", "review"]


def test_an_attempt_begins_only_after_quiet_keys(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.wait(2000)
    driver.strike("x")
    driver.wait(690)
    driver.strike("enter")
    assert driver.waiting.stage == "attempt"
    driver.wait(700)
    driver.strike("enter")
    assert driver.waiting.stage == "trial"


def test_only_enter_begins_an_attempt(new_session: NewSession) -> None:
    driver = new_session()
    driver.press("space")
    assert driver.waiting.stage == "instructions"
    driver.enter()
    driver.press("f")
    assert driver.waiting.stage == "attempt"


def test_a_key_before_onset_is_stored_as_an_anticipation_outside_the_metric(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.all(t.PROMPT))
    prompt = driver.last(t.PROMPT)
    driver.wait(1)
    driver.press(prompt.expected)
    assert driver.all(t.TRIAL) == []
    driver.wait(3)
    trial = driver.last(t.TRIAL)
    assert facts(trial, "response correct reaction_time_ms value") == (
        prompt.expected,
        True,
        None,
        None,
    )
    assert trial.response_at == trial.onset - 3 * MS
    assert trial.timing.flags == ("anticipation",)


def test_the_first_of_two_keys_before_onset_is_the_response(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.all(t.PROMPT))
    for key in ("#", driver.last(t.PROMPT).expected):
        driver.wait(1)
        driver.press(key)
    driver.to_prompt()
    assert [(trial.trial, trial.response) for trial in driver.all(t.TRIAL)] == [(1, "#")]
    assert driver.session.faults == []


def test_a_key_stamped_after_onset_but_handled_before_it_is_a_response(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.screen.shows = False
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.all(t.PROMPT))
    onset = driver.clock.now() + 2 * MS
    driver.wait(300)
    driver.press(driver.last(t.PROMPT).expected)
    assert driver.all(t.TRIAL) == []
    driver.screen.show(driver.last(t.PROMPT), at=onset)
    assert driver.last(t.TRIAL).reaction_time_ms == 298.0
    assert flags(driver) == ()


@pytest.mark.parametrize(
    ("reaction", "flagged"), [(0, True), (99, True), (99.999, True), (100, False), (101, False)]
)
def test_faster_than_a_tenth_of_a_second_is_an_anticipation(
    new_session: NewSession, reaction: float, flagged: bool
) -> None:
    driver = new_session()
    driver.start()
    trial = driver.answer(reaction)
    assert trial.reaction_time_ms == reaction
    assert ("anticipation" in trial.timing.flags) is flagged
    assert trial.value == (None if flagged else reaction)


def test_anticipations_are_correct_but_not_in_the_mean(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    for reaction in (50, 400, 600):
        driver.answer(reaction)
    ended = driver.last(t.ATTEMPT_ENDED)
    assert (ended.metric, ended.accuracy) == (500.0, 1.0)


def test_a_key_stamped_in_time_counts_even_if_handled_late(new_session: NewSession) -> None:
    driver = new_session(response_timeout_ms=2000)
    prompt = driver.start()
    onset = driver.clock.now()
    driver.wait(2030)
    driver.press(prompt.expected, at=onset + 2000 * MS)
    trial = driver.last(t.TRIAL)
    assert (trial.reaction_time_ms, trial.correct, trial.timing.flags) == (2000.0, True, ())
    assert trial.timing.handler_delay_ms == 30.0
    driver.wait(5000)
    assert numbers(driver)[0] == (1, 1)
    assert numbers(driver).count((1, 1)) == 1


def test_a_key_stamped_late_is_a_flagged_miss(new_session: NewSession) -> None:
    driver = new_session(response_timeout_ms=2000)
    prompt = driver.start()
    driver.wait(2030)
    driver.press(prompt.expected)
    trial = driver.last(t.TRIAL)
    assert (trial.response, trial.reaction_time_ms, trial.correct) == (None, None, False)
    assert trial.timing.flags == ("late_key",)


def test_a_key_after_the_miss_belongs_to_no_trial(new_session: NewSession) -> None:
    driver = new_session(response_timeout_ms=2000)
    prompt = driver.start()
    driver.wait(2060)
    driver.press(prompt.expected)
    assert numbers(driver) == [(1, 1)]
    assert driver.last(t.TRIAL).response is None
    assert driver.waiting.what == "quiet"


def test_repeats_of_a_held_key_never_count(new_session: NewSession) -> None:
    driver = new_session(quiet_ms=0, foreperiod_min_ms=0, foreperiod_max_ms=0, levels=["f"])
    driver.enter()
    driver.press("enter")
    driver.to_prompt()
    driver.wait(300)
    driver.press("f")
    driver.wait(30)
    for _ in range(20):
        driver.press("f")
        driver.wait(30)
    assert numbers(driver) == [(1, 1)]
    driver.wait(500)
    driver.press("f")
    assert driver.last(t.TRIAL).trial == 2
    assert "repeat_key" in flags(driver)


def test_a_paste_is_flagged_and_never_a_response(new_session: NewSession) -> None:
    driver = new_session()
    driver.start()
    driver.wait(200)
    driver.paste()
    assert driver.all(t.TRIAL) == []
    trial = driver.answer(300)
    assert (trial.correct, trial.timing.flags) == (True, ("paste",))


def test_a_paste_in_the_foreperiod_restarts_it(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.wait(100)
    driver.paste()
    pasted = driver.clock.now()
    assert driver.waiting.what == "quiet"
    driver.until(lambda: driver.waiting.what == "foreperiod")
    assert driver.clock.now() - pasted == 500 * MS
    assert driver.answer().timing.false_starts == 1


def test_a_lost_focus_is_flagged_and_never_a_response(new_session: NewSession) -> None:
    driver = new_session()
    driver.start()
    driver.focus(False)
    driver.focus(True)
    assert driver.all(t.TRIAL) == []
    assert driver.answer(300).timing.flags == ("focus_lost",)
    assert driver.answer(300).timing.flags == ()


def test_every_trial_without_focus_is_flagged(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.focus(False)
    driver.press("enter")
    assert driver.answer().timing.flags == ("focus_lost",)
    assert driver.answer().timing.flags == ("focus_lost",)
    driver.focus(True)
    assert driver.answer().timing.flags == ()


def test_an_onset_stamped_after_refresh_is_flagged(new_session: NewSession) -> None:
    driver = new_session()
    driver.screen.source = "refresh"
    driver.start()
    trial = driver.answer()
    assert (trial.timing.onset_source, trial.timing.flags) == ("refresh", ("onset_refresh",))


def test_an_onset_of_another_presentation_is_ignored(new_session: NewSession) -> None:
    driver = new_session()
    driver.start()
    stale = driver.screen.prompt
    driver.operate("repeat")
    driver.screen.shows = False
    driver.until(lambda: len(driver.all(t.PROMPT)) == 2)
    assert stale is not None
    driver.screen.show(stale)
    driver.wait(300)
    driver.press(stale.expected)
    assert driver.all(t.TRIAL) == []


@pytest.mark.parametrize(
    ("level", "typed", "correct"), [(1, str.upper, True), (16, str.swapcase, False)]
)
def test_case_is_ignored_unless_the_level_asks_for_shift(
    new_session: NewSession, level: int, typed: Callable[[str], str], correct: bool
) -> None:
    driver = new_session(start_level=level)
    prompt = driver.start()
    assert prompt.expected.isalpha()
    driver.wait(400)
    driver.press(typed(prompt.expected))
    assert driver.last(t.TRIAL).correct is correct


# --- pauses and commands


def in_quiet(driver: LoopDriver) -> None:
    driver.enter()
    driver.press("enter")


def in_foreperiod(driver: LoopDriver) -> None:
    in_quiet(driver)
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.wait(100)


def in_storing(driver: LoopDriver) -> None:
    driver.screen.stores = False
    driver.start()
    driver.answer()
    driver.until(lambda: driver.waiting.what == "storage")


def before_onset(driver: LoopDriver) -> None:
    in_foreperiod(driver)
    driver.until(lambda: driver.all(t.PROMPT))


def in_response(driver: LoopDriver) -> None:
    driver.start()
    driver.wait(100)


IN_A_TRIAL = [in_quiet, in_foreperiod, in_storing, before_onset, in_response]


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_trial_voided_by_a_pause_is_repeated_unchanged(
    new_session: NewSession, moment: Callable[[LoopDriver], None]
) -> None:
    driver, undisturbed = new_session(seed=5), new_session(seed=5)
    undisturbed.enter()
    undisturbed.attempt()
    moment(driver)
    done = len(driver.all(t.TRIAL))
    driver.operate("pause")
    assert (driver.waiting.what, driver.waiting.stage) == ("resume", "paused")
    voided = driver.last(t.VOIDED)
    assert (voided.attempt, voided.trial, voided.reason) == (1, done + 1, "pause")
    driver.wait(60_000)
    driver.press("enter")
    driver.press("f")
    assert driver.waiting.stage == "paused"
    assert len(driver.all(t.TRIAL)) == done
    driver.screen.stores = True
    if done:
        driver.screen.store(1, done)
    driver.operate("resume")
    while len(driver.all(t.TRIAL)) < 3:
        driver.answer()
    for trial, as_it_was in zip(driver.all(t.TRIAL), undisturbed.all(t.TRIAL), strict=True):
        assert facts(trial, "attempt trial stimulus") == (
            as_it_was.attempt,
            as_it_was.trial,
            as_it_was.stimulus,
        )
        assert trial.timing.foreperiod_ms == as_it_was.timing.foreperiod_ms
    assert driver.session.faults == []


def test_a_repeated_prompt_counts_its_presentations(new_session: NewSession) -> None:
    driver = new_session()
    first = driver.start()
    driver.operate("pause")
    driver.operate("resume")
    again = driver.to_prompt()
    assert (again.trial, again.stimulus, first.presentation, again.presentation) == (
        1,
        first.stimulus,
        1,
        2,
    )
    assert driver.answer().timing.presentation == 2


def test_flags_of_a_voided_prompt_are_not_on_its_repetition(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.press("f")
    driver.to_prompt()
    driver.paste()
    driver.operate("pause")
    driver.operate("resume")
    timing = driver.answer().timing
    assert (timing.false_starts, timing.flags) == (0, ())


def test_after_a_pause_come_a_quiet_time_and_a_whole_foreperiod(new_session: NewSession) -> None:
    driver = new_session(foreperiod_min_ms=700, foreperiod_max_ms=700)
    driver.start()
    driver.operate("pause")
    driver.wait(10_000)
    driver.operate("resume")
    resumed = driver.clock.now()
    driver.to_prompt()
    assert driver.clock.now() - resumed == (500 + 700 + 4) * MS


def test_nothing_times_out_in_a_pause(new_session: NewSession) -> None:
    driver = new_session()
    driver.start()
    driver.operate("pause")
    driver.wait(600_000)
    assert driver.all(t.TRIAL) == []
    assert driver.waiting.stage == "paused"


def test_a_pause_between_attempts_voids_nothing_and_returns_there(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.attempt()
    driver.operate("pause")
    assert driver.waiting.stage == "paused"
    driver.operate("resume")
    assert facts(driver.waiting, "what stage attempt") == ("enter", "attempt", 2)
    assert driver.all(t.VOIDED) == []


def test_a_pause_in_the_instructions_returns_to_them(new_session: NewSession) -> None:
    driver = new_session()
    driver.operate("pause")
    driver.operate("resume")
    assert driver.waiting.stage == "instructions"


@pytest.mark.parametrize("reason", ["tired", "pain", "finished"])
def test_the_reason_of_a_pause_is_reported_and_only_a_command_resumes(
    new_session: NewSession, reason: str
) -> None:
    driver = new_session()
    driver.start()
    driver.operate("pause")
    driver.operate("pause", reason=reason)
    assert facts(driver.waiting, "what stage reason") == ("resume", "paused", reason)
    driver.press("enter")
    assert driver.waiting.stage == "paused"
    driver.operate("resume")
    assert (driver.waiting.stage, driver.waiting.reason) == ("trial", "")
    assert len(driver.all(t.VOIDED)) == 1


@pytest.mark.parametrize(
    "moment",
    [*IN_A_TRIAL, lambda driver: None, LoopDriver.enter, lambda driver: driver.operate("pause")],
)
def test_an_end_aborts_from_anywhere_and_is_final(
    new_session: NewSession, moment: Callable[[LoopDriver], None]
) -> None:
    driver = new_session()
    moment(driver)
    done = len(driver.all(t.TRIAL))
    driver.operate("end")
    if done and not driver.screen.stores:
        assert driver.all(t.SESSION_ENDED) == [], "the last trial is not on disk yet"
        driver.screen.store(1, done)
    assert [end.status for end in driver.all(t.SESSION_ENDED)] == ["aborted"]
    assert driver.session.ended
    for act in ("resume", "skip", "repeat", "pause", "end"):
        driver.operate(act)
    driver.wait(60_000)
    assert driver.waiting.what == "nothing"
    assert len(driver.all(t.TRIAL)) == done
    assert len(driver.all(t.SESSION_ENDED)) == 1
    assert driver.last(t.ACTION).kind == "goodbye"


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_skipped_prompt_is_stored_and_the_next_follows(
    new_session: NewSession, moment: Callable[[LoopDriver], None]
) -> None:
    driver = new_session()
    moment(driver)
    done = len(driver.all(t.TRIAL))
    driver.screen.stores = True
    driver.operate("skip")
    skipped = driver.last(t.TRIAL)
    assert (skipped.trial, skipped.correct, skipped.response) == (done + 1, False, None)
    assert skipped.timing.flags == ("skipped",)
    assert driver.answer().trial == done + 2


def test_a_repeat_shows_the_prompt_again_under_its_number(new_session: NewSession) -> None:
    driver = new_session()
    first = driver.start()
    driver.wait(100)
    driver.operate("repeat")
    assert driver.last(t.VOIDED).reason == "repeat"
    again = driver.to_prompt()
    assert (again.trial, again.stimulus, again.presentation) == (first.trial, first.stimulus, 2)


@pytest.mark.parametrize("act", ["skip", "repeat"])
def test_outside_a_trial_there_is_nothing_to_skip_or_repeat(
    new_session: NewSession, act: str
) -> None:
    driver = new_session()
    driver.enter()
    said = len(driver.all(t.WAITING))
    driver.operate(act)
    assert (driver.all(t.TRIAL), driver.all(t.VOIDED), len(driver.all(t.WAITING))) == ([], [], said)


def test_a_level_set_between_attempts_applies_to_the_next_at_once(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.operate("level", value=5)
    assert driver.waiting.level == 5
    assert facts(driver.last(t.LEVEL), "previous level reason") == (1, 5, "operator")
    driver.attempt()
    assert driver.last(t.ATTEMPT_ENDED).level == 5
    assert driver.waiting.level == 6


def test_a_level_set_in_an_attempt_applies_to_the_next(new_session: NewSession) -> None:
    driver = new_session()
    driver.start()
    driver.operate("level", value=7)
    while not driver.all(t.ATTEMPT_ENDED):
        driver.answer()
    assert {prompt.level for prompt in driver.all(t.PROMPT)} == {1}
    assert driver.last(t.ATTEMPT_ENDED).level == 1
    assert driver.waiting.level == 7
    assert [(change.level, change.reason) for change in driver.all(t.LEVEL)] == [(7, "operator")]
    driver.wait(1000)
    driver.begin_attempt()
    assert driver.last(t.PROMPT).level == 7


def test_a_level_set_in_a_pause_of_an_attempt_waits_for_its_end_too(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.start()
    driver.operate("pause")
    driver.operate("level", value=7)
    driver.operate("resume")
    assert driver.to_prompt().level == 1


@pytest.mark.parametrize(("asked", "given"), [(0, 2), (-3, 2), (99, 6), (4, 4)])
def test_a_level_set_stays_within_its_bounds(
    new_session: NewSession, asked: int, given: int
) -> None:
    driver = new_session(min_level=2, max_level=6, start_level=3)
    driver.enter()
    driver.operate("level", value=asked)
    assert driver.last(t.LEVEL).level == given


# --- the disk


def test_the_next_prompt_waits_until_the_trial_is_stored(new_session: NewSession) -> None:
    driver = new_session()
    driver.screen.stores = False
    driver.start()
    driver.answer()
    driver.wait(60_000)
    assert len(driver.all(t.PROMPT)) == 1
    assert driver.waiting.what == "storage"
    driver.screen.store(1, 1)
    assert len(driver.all(t.PROMPT)) == 2


def test_an_acknowledgement_of_an_earlier_trial_is_not_enough(new_session: NewSession) -> None:
    driver = new_session()
    driver.start()
    driver.answer()
    driver.to_prompt()
    driver.screen.stores = False
    driver.answer()
    driver.wait(60_000)
    driver.screen.store(1, 1)
    assert len(driver.all(t.PROMPT)) == 2
    driver.screen.store(1, 2)
    assert len(driver.all(t.PROMPT)) == 3


def test_a_key_while_the_trial_is_stored_restarts_the_foreperiod(new_session: NewSession) -> None:
    driver = new_session()
    in_storing(driver)
    driver.press("f")
    assert driver.waiting.what == "quiet"
    driver.screen.store(1, 1)
    assert len(driver.all(t.PROMPT)) == 1
    driver.to_prompt()
    assert len(driver.all(t.PROMPT)) == 2


def test_the_first_prompt_of_an_attempt_waits_for_the_last_trial_of_the_one_before(
    new_session: NewSession,
) -> None:
    driver = new_session(prompts_per_attempt=1)
    driver.screen.stores = False
    driver.start()
    driver.answer()
    driver.wait(1000)
    driver.press("enter")
    driver.wait(60_000)
    assert (driver.waiting.what, driver.waiting.attempt) == ("storage", 2)
    driver.screen.store(1, 1)
    assert driver.last(t.PROMPT).attempt == 2


def test_a_session_is_complete_only_when_its_last_trial_is_stored(new_session: NewSession) -> None:
    driver = new_session(attempts=1, prompts_per_attempt=1)
    driver.screen.stores = False
    driver.start()
    driver.answer()
    driver.wait(60_000)
    driver.press("enter")
    driver.wait(60_000)
    assert (driver.waiting.what, driver.waiting.stage) == ("storage", "ended")
    assert driver.all(t.SESSION_ENDED) == []
    driver.operate("end")
    assert driver.all(t.SESSION_ENDED) == []
    driver.screen.store(1, 1)
    assert driver.last(t.SESSION_ENDED).status == "completed"


def test_at_the_end_too_an_acknowledgement_of_an_earlier_trial_is_not_enough(
    new_session: NewSession,
) -> None:
    driver = new_session(attempts=1, prompts_per_attempt=2)
    driver.screen.stores = False
    driver.start()
    driver.operate("skip")
    driver.operate("skip")
    driver.wait(1000)
    driver.press("enter")
    driver.screen.store(1, 1)
    assert driver.all(t.SESSION_ENDED) == []
    driver.screen.store(1, 2)
    assert driver.last(t.SESSION_ENDED).status == "completed"


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_disk_failure_pauses_and_enter_resumes_after_it(
    new_session: NewSession, moment: Callable[[LoopDriver], None]
) -> None:
    driver = new_session()
    moment(driver)
    done = len(driver.all(t.TRIAL))
    driver.disk(False)
    assert facts(driver.waiting, "what stage reason") == ("resume", "paused", "storage")
    for act in (
        lambda: driver.press("enter"),
        lambda: driver.operate("resume"),
        lambda: driver.operate("pause", "tired"),
    ):
        act()
        assert (driver.waiting.stage, driver.waiting.reason) == ("paused", "storage")
    driver.wait(60_000)
    driver.disk(True)
    assert facts(driver.waiting, "what stage reason") == ("enter", "paused", "restored")
    driver.screen.stores = True
    if done:
        driver.screen.store(1, done)
    driver.press("enter")
    assert driver.answer().trial == done + 1


def test_a_disk_failure_between_attempts_returns_there(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.disk(False)
    driver.disk(True)
    driver.press("enter")
    assert driver.waiting.stage == "attempt"


def test_a_disk_failure_in_a_pause_is_reported_first(new_session: NewSession) -> None:
    driver = new_session()
    driver.start()
    driver.operate("pause", reason="tired")
    driver.disk(False)
    assert driver.waiting.reason == "storage"
    driver.press("enter")
    driver.operate("resume")
    assert driver.waiting.reason == "storage"
    driver.disk(True)
    assert driver.waiting.reason == "tired", "the reason a person gave is not forgotten"


def test_a_trial_is_repeated_if_the_program_was_suspended(new_session: NewSession) -> None:
    driver = new_session()
    prompt = driver.start()
    driver.wait(50)
    driver.clock.set(driver.clock.now() + 8000 * MS)
    driver.wait(0)
    assert driver.all(t.TRIAL) == []
    assert driver.last(t.VOIDED).reason == "stalled"
    again = driver.to_prompt()
    assert (again.trial, again.stimulus, again.presentation) == (prompt.trial, prompt.stimulus, 2)


def suspended_in_foreperiod(driver: LoopDriver) -> None:
    """Suspend the program for four seconds in the first foreperiod."""
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.clock.set(driver.clock.now() + 4000 * MS)
    driver.wait(0)


def test_a_foreperiod_begins_anew_if_the_program_was_suspended_in_it(
    new_session: NewSession,
) -> None:
    driver = new_session()
    suspended_in_foreperiod(driver)
    assert driver.all(t.PROMPT) == []
    went_on = driver.clock.now()
    timing = driver.answer().timing
    assert driver.last(t.SHOWN).at - went_on >= timing.foreperiod_ms * MS
    assert (timing.presentation, timing.false_starts, timing.flags) == (1, 0, ())


def test_a_trial_is_repeated_if_its_key_waited_while_the_program_was_suspended(
    new_session: NewSession,
) -> None:
    driver = new_session()
    prompt = driver.start()
    driver.wait(2800)
    driver.press(prompt.expected, stalled=True)
    assert driver.all(t.TRIAL) == []
    assert driver.last(t.VOIDED).reason == "stalled"
    again = driver.to_prompt()
    assert (again.trial, again.stimulus, again.presentation) == (prompt.trial, prompt.stimulus, 2)
    driver.wait(300)
    driver.press(again.expected)
    assert driver.last(t.TRIAL).reaction_time_ms == 300.0


def test_a_miss_stores_the_delay_of_its_time_out(new_session: NewSession) -> None:
    driver = new_session(response_timeout_ms=1000)
    driver.start()
    driver.wait(900)
    driver.clock.set(driver.clock.now() + 300 * MS)
    driver.wait(60)
    timing = driver.last(t.TRIAL).timing
    assert 150 < timing.loop_lag_ms < 250


def test_a_participant_who_holds_a_key_is_asked_to_release_it(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    driver.begin_attempt()
    driver.answer()
    driver.hold("f", 2500)
    assert driver.waiting.reason == ""
    driver.hold("f", 1500)
    assert (driver.waiting.what, driver.waiting.reason) == ("quiet", "held")
    driver.wait(600)
    assert (driver.waiting.what, driver.waiting.reason) == ("foreperiod", "")


@pytest.mark.parametrize(
    "result",
    [
        Result(correct=True, response=("j",)),  # type: ignore[arg-type]
        Result(correct=True, response="j", details={"keys": [1, 2]}),  # type: ignore[dict-item]
        Result(correct=True, response="j", details={"key": object()}),  # type: ignore[dict-item]
        Result(correct=True, response="j", value=float("nan")),
        Result(correct=True, response="j", details={"share": float("inf")}),
    ],
)
def test_a_result_that_cannot_be_stored_stops_the_session(
    new_session: NewSession, result: Result
) -> None:
    driver = new_session()
    driver.start()
    driver.session.task.perceived = lambda trial, percept: result  # type: ignore[method-assign]
    driver.press("f")
    fault = driver.session.broken
    assert fault is not None
    assert "cannot be stored" in fault.error
    assert (driver.waiting.what, driver.waiting.stage) == ("nothing", "broken")
    said = len(driver.records)
    driver.wait(60_000)
    assert len(driver.records) == said, "nothing continues by itself"
    driver.press("enter")
    driver.operate("resume")
    assert driver.all(t.TRIAL) == []
    assert driver.waiting.stage == "broken"


def test_a_working_disk_changes_nothing(new_session: NewSession) -> None:
    driver = new_session()
    driver.start()
    said = len(driver.all(t.WAITING))
    driver.disk(True)
    assert len(driver.all(t.WAITING)) == said


# --- tasks of more than one key


class Taps(Task):
    """A task of as many taps of the space bar as possible."""

    name = "taps"
    title = "Taps"
    metric = Metric("taps", unit="taps", better="higher")

    def instructions(self) -> str:
        return "Tap."

    def stimulus(self, situation: Situation) -> Stimulus:
        return Stimulus("tap", expected="", text="Press: space")

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        return None

    def timed_out(self, trial: Trial) -> Result:
        return Result(
            correct=True, response=f"{len(trial.percepts)} taps", value=float(len(trial.percepts))
        )


def test_a_task_may_judge_all_its_keys_at_the_end(calm: Theme) -> None:
    driver = LoopDriver(
        Taps, calm, attempts=1, threshold=3, neutral_band=0, response_timeout_ms=3000
    )
    driver.start()
    for _ in range(5):
        driver.wait(200)
        driver.press("space")
    driver.until(lambda: driver.all(t.TRIAL))
    assert (driver.last(t.TRIAL).value, driver.last(t.ATTEMPT_ENDED).outcome) == (5.0, "success")


class Counted(Taps):
    name = "counted"

    class Details(Details, frozen=True):
        taps: int
        hand: str = "left"

    def timed_out(self, trial: Trial) -> Result:
        taps = len(trial.percepts)
        return Result(
            correct=bool(taps),
            response="j" * taps,
            details={"taps": taps, "hand": "right"} if taps else {},
        )


def test_a_trial_without_a_response_stores_the_same_details_as_others_and_no_empty_response(
    calm: Theme,
) -> None:
    driver = LoopDriver(Counted, calm, attempts=2, response_timeout_ms=3000)
    driver.start()
    driver.until(lambda: driver.all(t.TRIAL))
    assert driver.last(t.TRIAL).response is None
    assert driver.last(t.TRIAL).details == {"taps": None, "hand": "left"}
    driver.begin_attempt()
    driver.wait(200)
    driver.press("j")
    driver.until(lambda: len(driver.all(t.TRIAL)) == 2)
    assert driver.last(t.TRIAL).response == "j"
    assert driver.last(t.TRIAL).details == {"taps": 1, "hand": "right"}


def test_repeats_of_a_held_key_are_not_passed_to_the_task(calm: Theme) -> None:
    driver = LoopDriver(
        Taps, calm, attempts=1, threshold=3, neutral_band=0, response_timeout_ms=3000
    )
    driver.start()
    driver.wait(200)
    driver.hold("space", ms=2000)
    driver.until(lambda: driver.all(t.TRIAL))
    assert driver.last(t.TRIAL).value == 1.0
    assert "repeat_key" in flags(driver)


class Brittle(Taps):
    name = "brittle"

    def timed_out(self, trial: Trial) -> Result:
        raise ZeroDivisionError("no taps")


def test_a_task_that_raises_stops_the_session_with_a_fault(calm: Theme) -> None:
    driver = LoopDriver(Brittle, calm, attempts=1)
    driver.start()
    assert driver.session.broken is None
    driver.wait(10_000)
    assert driver.session.broken is not None
    assert driver.session.broken.error == "ZeroDivisionError: no taps"


@pytest.mark.parametrize("value", ["raised", None, ("a", "b")])
@pytest.mark.parametrize("method", ["instructions", "goal", "notice"])
def test_a_text_that_a_task_cannot_give_stops_the_session_instead_of_a_blank_screen(
    calm: Theme, method: str, value: object
) -> None:
    def give(*_: object) -> object:
        if value == "raised":
            raise ZeroDivisionError("no words")
        return value

    driver = LoopDriver(type("Mute", (Taps,), {"name": "mute", method: give}), calm, attempts=1)
    driver.enter()
    said = (
        "ZeroDivisionError: no words"
        if value == "raised"
        else f"TypeError: {method}() returned {value}, not a text"
    )
    assert driver.session.broken is not None
    assert driver.session.broken.error == said
    assert driver.last(t.WAITING).stage == "broken"


class Bounded(Taps):
    name = "bounded"
    Parameters = TaskParameters

    @property
    def levels(self) -> int:
        return 2


def test_a_task_with_few_levels_stays_within_them(calm: Theme) -> None:
    driver = LoopDriver(
        Bounded, calm, attempts=4, threshold=0, neutral_band=0, response_timeout_ms=1000
    )
    driver.enter()
    for _ in range(4):
        driver.begin_attempt()
        driver.wait(300)
        driver.press("space")
        driver.wait(1500)
    assert [ended.level for ended in driver.all(t.ATTEMPT_ENDED)] == [1, 2, 2, 2]


# --- arbitrary input

ACTS = st.lists(
    st.one_of(
        st.tuples(st.just("press"), st.sampled_from(["enter", "f", "j", "space", "left"])),
        st.tuples(st.just("wait"), st.sampled_from([1, 30, 99, 500, 1000, 3000])),
        st.tuples(
            st.just("operate"), st.sampled_from(["pause", "resume", "skip", "repeat", "level"])
        ),
        st.tuples(st.just("disk"), st.booleans()),
        st.tuples(st.just("focus"), st.booleans()),
        st.just(("paste", 3)),
        st.just(("answer", 400)),
    ),
    max_size=40,
)


@given(ACTS)
def test_any_input_gives_every_trial_once_in_order(
    keyboard: type[Task], calm: Theme, acts: list[tuple[str, Any]]
) -> None:
    driver = LoopDriver(keyboard, calm, prompts_per_attempt=2, attempts=2, start_level=3)
    for act, what in acts:
        if act == "answer":
            if driver.screen.onset is not None:
                driver.wait(what)
                driver.press(driver.last(t.PROMPT).expected)
        elif act == "operate":
            driver.operate(what, value=5 if what == "level" else None)
        else:
            getattr(driver, act)(what)
    driver.disk(True)
    driver.operate("resume")
    while not driver.session.ended:
        if driver.waiting.what == "enter":
            driver.wait(1000)
            driver.press("enter")
        else:
            assert driver.clock.step()
    assert numbers(driver) == [(1, 1), (1, 2), (2, 1), (2, 2)]
    assert each(driver.all(t.ATTEMPT_ENDED), "attempt trials") == [(1, 2), (2, 2)]
    assert driver.last(t.SESSION_ENDED).status == "completed"
    assert driver.session.faults == []
    for trial in driver.all(t.TRIAL):
        assert trial.value is None or (trial.correct and trial.value >= 100)
        assert trial.reaction_time_ms is None or 0 <= trial.reaction_time_ms <= 5000
