"""Given a person at the keyboard, when they press, pause, fall asleep or sneeze, then each is taken as what it is."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework.clock import MS
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.task import Metric, Result, Situation, Stimulus, Task, Trial
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import (
    ACTION,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    FEEDBACK,
    LEVEL,
    PROMPT,
    SESSION_ENDED,
    TRIAL,
    VOIDED,
    WAITING,
)
from tests.desk import Desk

Sit = Callable[..., Desk]


@pytest.fixture
def sit(keyboard: type[Task], calm: Theme) -> Sit:
    """Sit down to a keyboard session of two attempts with three prompts each, unless told otherwise."""

    def at(**settings: Any) -> Desk:
        return Desk(keyboard, calm, **{"prompts_per_attempt": 3, "attempts": 2, **settings})

    return at


def stages(desk: Desk) -> list[str]:
    return [waiting.what for waiting in desk.all(WAITING)]


def flags(desk: Desk) -> tuple[str, ...]:
    return desk.last(TRIAL).timing.flags


def numbers(desk: Desk) -> list[tuple[int, int]]:
    return [(trial.attempt, trial.trial) for trial in desk.all(TRIAL)]


# --- a session that goes well -----------------------------------------------------------------------------


def test_a_session_goes_from_the_instructions_through_its_attempts_to_its_end(sit: Sit) -> None:
    desk = sit()
    assert (desk.waiting.what, desk.waiting.stage) == ("enter", "instructions")
    desk.enter()
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.attempt_name) == ("enter", "attempt", "attempt 1 of 2")
    assert (
        desk.waiting.goal
        == "Your goal: press the right key in less than 1 second on average, with at least 3 of 3 right."
    )
    desk.attempt()
    assert (desk.waiting.stage, desk.waiting.attempt_name) == ("attempt", "attempt 2 of 2")
    desk.attempt()
    assert (desk.waiting.what, desk.waiting.stage) == ("enter", "review")
    assert desk.all(SESSION_ENDED) == [], "the last answer is read before the goodbye"
    desk.press("enter")
    assert desk.waiting.what == "nothing"
    assert numbers(desk) == [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)]
    assert [end.status for end in desk.all(SESSION_ENDED)] == ["completed"]
    assert desk.session.faults == []


def test_alone_it_is_always_ones_own_turn(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.attempt()
    assert {waiting.seat for waiting in desk.all(WAITING)} == {"A"}


def test_a_trial_is_quiet_then_foreperiod_then_prompt(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.begin_attempt()
    assert stages(desk)[-3:] == ["quiet", "foreperiod", "response"]


def test_a_right_key_is_a_row_with_its_time_from_onset_to_stamp(sit: Sit) -> None:
    desk = sit()
    prompt = desk.start()
    onset = desk.clock.now()
    desk.wait(432)
    desk.press(prompt.expected, at=desk.clock.now() - 2 * MS, lag=3 * MS)
    trial = desk.last(TRIAL)
    assert (trial.attempt, trial.trial, trial.stimulus, trial.response) == (1, 1, prompt.stimulus, prompt.expected)
    assert trial.correct
    assert (trial.onset, trial.response_at) == (onset, onset + 430 * MS)
    assert trial.reaction_time_ms == trial.value == 430.0
    timing = trial.timing
    assert (timing.onset_source, timing.handler_delay_ms, timing.loop_lag_ms) == ("flush", 2.0, 3.0)
    assert (timing.false_starts, timing.presentation, timing.flags) == (0, 1, ())


def test_a_wrong_key_is_a_row_that_adds_nothing_to_the_metric_and_lowers_accuracy(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    desk.answer(300, key="#")
    wrong = desk.last(TRIAL)
    assert (wrong.response, wrong.correct, wrong.reaction_time_ms, wrong.value) == ("#", False, 300.0, None)
    desk.answer(400)
    desk.answer(500)
    ended = desk.last(ATTEMPT_ENDED)
    assert (ended.metric, ended.accuracy, ended.correct, ended.trials) == (450.0, pytest.approx(2 / 3), 2, 3)
    assert (ended.outcome, ended.feedback) == ("failure", "negative")
    assert desk.last(FEEDBACK).reason == "accuracy"


def test_a_miss_is_a_row_of_nulls_after_the_time_out(sit: Sit) -> None:
    desk = sit(response_timeout_ms=2000)
    desk.start()
    desk.wait(2049)
    assert desk.all(TRIAL) == []
    desk.wait(1)
    miss = desk.last(TRIAL)
    assert (miss.response, miss.response_at, miss.reaction_time_ms, miss.value) == (None, None, None, None)
    assert not miss.correct
    assert miss.onset is not None


def test_an_attempt_with_no_correct_response_fails_with_an_empty_metric(sit: Sit) -> None:
    desk = sit(start_level=2, min_accuracy=0.0)
    desk.enter()
    desk.attempt(wrong=3)
    ended = desk.last(ATTEMPT_ENDED)
    assert (ended.metric, ended.accuracy, ended.outcome, ended.feedback) == (None, 0.0, "failure", "negative")
    assert desk.last(FEEDBACK).reason == "empty"
    assert desk.last(LEVEL).level == 1


def test_success_raises_and_failure_lowers_the_level_of_the_next_attempt(sit: Sit) -> None:
    desk = sit(attempts=3, start_level=4)
    desk.enter()
    desk.attempt(400)
    desk.attempt(1400)
    desk.attempt(400)
    assert [ended.level for ended in desk.all(ATTEMPT_ENDED)] == [4, 5, 4]
    assert [(change.previous, change.level, change.reason) for change in desk.all(LEVEL)] == [
        (4, 5, "success"),
        (5, 4, "failure"),
        (4, 5, "success"),
    ]


def test_an_attempt_is_in_memory_before_it_is_spoken_of_and_then_the_words_come(sit: Sit) -> None:
    desk = sit(attempts=3, difficulty_policy="fixed", feedback_form="quantitative")
    desk.enter()
    desk.attempt(700)
    desk.attempt(650)
    assert "50 ms faster than last time" in desk.last(ACTION).text
    topics = [record.topic for record in desk.records if record.topic in (TRIAL, ATTEMPT_ENDED, FEEDBACK, ACTION)]
    assert topics[-4:] == [TRIAL, ATTEMPT_ENDED, FEEDBACK, ACTION]


def test_feedback_comes_at_its_own_frequency_whatever_the_difficulty_does(sit: Sit) -> None:
    desk = sit(attempts=6, prompts_per_attempt=1, feedback_every=3, consecutive_successes=2)
    desk.enter()
    for _ in range(6):
        desk.attempt(400)
    assert [ended.feedback for ended in desk.all(ATTEMPT_ENDED)] == ["none", "none", "positive"] * 2
    assert [feedback.attempt for feedback in desk.all(FEEDBACK)] == [3, 6]
    assert [ended.level for ended in desk.all(ATTEMPT_ENDED)] == [1, 1, 2, 2, 3, 3]


def test_practice_is_answered_but_changes_neither_level_nor_count(sit: Sit) -> None:
    desk = sit(practice_attempts=1, attempts=2, feedback_every=2, start_level=3)
    desk.enter()
    assert desk.waiting.attempt_name == "practice 1 of 1"
    desk.attempt(400)
    assert desk.all(LEVEL) == []
    assert desk.waiting.attempt_name == "attempt 1 of 2"
    desk.attempt(400)
    desk.attempt(400)
    ended = desk.all(ATTEMPT_ENDED)
    assert [(attempt.attempt, attempt.practice, attempt.level) for attempt in ended] == [
        (1, True, 3),
        (2, False, 3),
        (3, False, 4),
    ]
    assert [attempt.feedback for attempt in ended] == ["positive", "none", "positive"]
    assert desk.waiting.stage == "review"


def test_failures_in_practice_are_no_part_of_a_row_of_failures(sit: Sit) -> None:
    desk = sit(practice_attempts=2, attempts=1, start_level=3, consecutive_failures=3)
    desk.enter()
    for _ in range(3):
        desk.attempt(1400)
    assert desk.all(LEVEL) == []


# --- keys where none belong -------------------------------------------------------------------------------


def test_a_key_in_the_foreperiod_begins_it_anew_and_is_never_a_response(sit: Sit) -> None:
    desk = sit(foreperiod_min_ms=800, foreperiod_max_ms=800)
    desk.enter()
    desk.press("enter")
    desk.until(lambda: desk.waiting.what == "foreperiod")
    desk.wait(700)
    desk.press("f")
    pressed = desk.clock.now()
    assert desk.waiting.what == "quiet"
    prompt = desk.to_prompt()
    assert desk.clock.now() - pressed == (500 + 800 + 4) * MS
    assert desk.all(TRIAL) == []
    desk.wait(400)
    desk.press(prompt.expected)
    assert desk.last(TRIAL).timing.false_starts == 1
    assert desk.last(TRIAL).reaction_time_ms == 400.0


def test_the_foreperiod_lies_between_its_bounds_and_differs_from_trial_to_trial(sit: Sit) -> None:
    desk = sit(prompts_per_attempt=20, foreperiod_min_ms=600, foreperiod_max_ms=900)
    desk.enter()
    desk.attempt()
    waits = [trial.timing.foreperiod_ms for trial in desk.all(TRIAL)]
    assert all(600 <= wait <= 900 for wait in waits)
    assert len(set(waits)) == 20
    shown = [record.at for record in desk.records if record.topic is PROMPT]
    began = [record.at for record in desk.records if record.topic is WAITING and record.message.what == "foreperiod"]
    assert [(end - begin) / MS for begin, end in zip(began, shown, strict=True)] == pytest.approx(waits)


def test_a_foreperiod_begins_only_after_half_a_second_without_keys(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    entered = desk.clock.now()
    desk.until(lambda: desk.waiting.what == "foreperiod")
    assert desk.clock.now() - entered == 500 * MS
    desk.answer(300)
    answered = desk.clock.now()
    desk.until(lambda: desk.waiting.what == "foreperiod")
    assert desk.clock.now() - answered == 500 * MS


def test_a_key_while_quiet_is_awaited_puts_it_off_and_is_no_false_start(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    desk.wait(300)
    desk.press("f")
    pressed = desk.clock.now()
    desk.until(lambda: desk.waiting.what == "foreperiod")
    assert desk.clock.now() - pressed == 500 * MS
    assert desk.answer().timing.false_starts == 0


def test_after_a_quiet_miss_the_foreperiod_begins_at_once(sit: Sit) -> None:
    desk = sit(response_timeout_ms=2000)
    desk.start()
    desk.until(lambda: desk.all(TRIAL))
    missed = desk.clock.now()
    desk.until(lambda: desk.waiting.what == "foreperiod")
    assert desk.clock.now() == missed


def test_a_held_key_puts_the_prompt_off_until_it_is_let_go(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    desk.wait(30)
    desk.hold("enter", ms=4000)
    let_go = desk.clock.now()
    assert desk.all(PROMPT) == []
    assert [started.attempt for started in desk.all(ATTEMPT_STARTED)] == [1]
    desk.to_prompt()
    assert desk.clock.now() - let_go >= (500 - 30 + 500) * MS
    assert desk.all(TRIAL) == []


def test_a_held_enter_begins_no_attempt(sit: Sit) -> None:
    desk = sit()
    desk.hold("enter", ms=900)
    assert desk.waiting.stage == "attempt"
    desk.wait(200)
    desk.press("enter")
    assert desk.waiting.stage == "trial"


def test_only_enter_begins(sit: Sit) -> None:
    desk = sit()
    desk.press("space")
    assert desk.waiting.stage == "instructions"
    desk.enter()
    desk.press("f")
    assert desk.waiting.stage == "attempt"


def test_a_key_before_onset_is_an_anticipation_kept_flagged_and_out_of_the_metric(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    desk.until(lambda: desk.all(PROMPT))
    prompt = desk.last(PROMPT)
    desk.wait(1)
    desk.press(prompt.expected)
    assert desk.all(TRIAL) == []
    desk.wait(3)
    trial = desk.last(TRIAL)
    assert (trial.response, trial.correct, trial.reaction_time_ms, trial.value) == (prompt.expected, True, None, None)
    assert trial.response_at == trial.onset - 3 * MS
    assert trial.timing.flags == ("anticipation",)


def test_of_two_keys_before_onset_the_first_is_the_response_and_the_other_none(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    desk.until(lambda: desk.all(PROMPT))
    for key in ("#", desk.last(PROMPT).expected):
        desk.wait(1)
        desk.press(key)
    desk.to_prompt()
    assert [(trial.trial, trial.response) for trial in desk.all(TRIAL)] == [(1, "#")]
    assert desk.session.faults == []


def test_a_key_stamped_after_onset_but_handled_before_it_is_a_response(sit: Sit) -> None:
    desk = sit()
    desk.screen.shows = False
    desk.enter()
    desk.press("enter")
    desk.until(lambda: desk.all(PROMPT))
    onset = desk.clock.now() + 2 * MS
    desk.wait(300)
    desk.press(desk.last(PROMPT).expected)
    assert desk.all(TRIAL) == []
    desk.screen.show(desk.last(PROMPT), at=onset)
    assert desk.last(TRIAL).reaction_time_ms == 298.0
    assert flags(desk) == ()


@pytest.mark.parametrize(("reaction", "flagged"), [(0, True), (99, True), (99.999, True), (100, False), (101, False)])
def test_faster_than_a_tenth_of_a_second_is_an_anticipation(sit: Sit, reaction: float, flagged: bool) -> None:
    desk = sit()
    desk.start()
    trial = desk.answer(reaction)
    assert trial.reaction_time_ms == reaction
    assert ("anticipation" in trial.timing.flags) is flagged
    assert trial.value == (None if flagged else reaction)


def test_anticipations_are_right_keys_that_no_mean_holds(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    for reaction in (50, 400, 600):
        desk.answer(reaction)
    ended = desk.last(ATTEMPT_ENDED)
    assert (ended.metric, ended.accuracy) == (500.0, 1.0)


def test_a_key_stamped_in_time_counts_although_it_is_handled_late(sit: Sit) -> None:
    desk = sit(response_timeout_ms=2000)
    prompt = desk.start()
    onset = desk.clock.now()
    desk.wait(2030)
    desk.press(prompt.expected, at=onset + 2000 * MS)
    trial = desk.last(TRIAL)
    assert (trial.reaction_time_ms, trial.correct, trial.timing.flags) == (2000.0, True, ())
    assert trial.timing.handler_delay_ms == 30.0
    desk.wait(5000)
    assert numbers(desk)[0] == (1, 1)
    assert numbers(desk).count((1, 1)) == 1


def test_a_key_stamped_late_is_a_miss_that_says_so(sit: Sit) -> None:
    desk = sit(response_timeout_ms=2000)
    prompt = desk.start()
    desk.wait(2030)
    desk.press(prompt.expected)
    trial = desk.last(TRIAL)
    assert (trial.response, trial.reaction_time_ms, trial.correct) == (None, None, False)
    assert trial.timing.flags == ("late_key",)


def test_a_key_after_the_miss_belongs_to_no_trial(sit: Sit) -> None:
    desk = sit(response_timeout_ms=2000)
    prompt = desk.start()
    desk.wait(2060)
    desk.press(prompt.expected)
    assert numbers(desk) == [(1, 1)]
    assert desk.last(TRIAL).response is None
    assert desk.waiting.what == "quiet"


def test_repeats_of_a_held_key_never_count(sit: Sit) -> None:
    desk = sit(quiet_ms=0, foreperiod_min_ms=0, foreperiod_max_ms=0, levels=["f"])
    desk.enter()
    desk.press("enter")
    desk.to_prompt()
    desk.wait(300)
    desk.press("f")
    desk.wait(30)
    for _ in range(20):
        desk.press("f")
        desk.wait(30)
    assert numbers(desk) == [(1, 1)]
    desk.wait(500)
    desk.press("f")
    assert desk.last(TRIAL).trial == 2
    assert "repeat_key" in flags(desk)


def test_a_paste_is_flagged_and_never_a_response(sit: Sit) -> None:
    desk = sit()
    desk.start()
    desk.wait(200)
    desk.paste()
    assert desk.all(TRIAL) == []
    trial = desk.answer(300)
    assert (trial.correct, trial.timing.flags) == (True, ("paste",))


def test_a_paste_in_the_foreperiod_begins_it_anew(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    desk.until(lambda: desk.waiting.what == "foreperiod")
    desk.wait(100)
    desk.paste()
    pasted = desk.clock.now()
    assert desk.waiting.what == "quiet"
    desk.until(lambda: desk.waiting.what == "foreperiod")
    assert desk.clock.now() - pasted == 500 * MS
    assert desk.answer().timing.false_starts == 1


def test_a_lost_focus_is_flagged_and_never_a_response(sit: Sit) -> None:
    desk = sit()
    desk.start()
    desk.focus(False)
    desk.focus(True)
    assert desk.all(TRIAL) == []
    assert desk.answer(300).timing.flags == ("focus_lost",)
    assert desk.answer(300).timing.flags == ()


def test_a_focus_that_stays_away_flags_every_trial_until_it_is_back(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.focus(False)
    desk.press("enter")
    assert desk.answer().timing.flags == ("focus_lost",)
    assert desk.answer().timing.flags == ("focus_lost",)
    desk.focus(True)
    assert desk.answer().timing.flags == ()


def test_an_onset_known_less_surely_is_flagged(sit: Sit) -> None:
    desk = sit()
    desk.screen.source = "refresh"
    desk.start()
    trial = desk.answer()
    assert (trial.timing.onset_source, trial.timing.flags) == ("refresh", ("onset_refresh",))


def test_a_report_of_another_presentation_is_no_onset(sit: Sit) -> None:
    desk = sit()
    desk.start()
    stale = desk.screen.prompt
    desk.operate("repeat")
    desk.screen.shows = False
    desk.until(lambda: len(desk.all(PROMPT)) == 2)
    assert stale is not None
    desk.screen.show(stale)
    desk.wait(300)
    desk.press(stale.expected)
    assert desk.all(TRIAL) == []


@pytest.mark.parametrize(("level", "typed", "correct"), [(1, str.upper, True), (8, str.swapcase, False)])
def test_case_is_ignored_unless_the_level_asks_for_shift(
    sit: Sit, level: int, typed: Callable[[str], str], correct: bool
) -> None:
    desk = sit(start_level=level)
    prompt = desk.start()
    assert prompt.expected.isalpha()
    desk.wait(400)
    desk.press(typed(prompt.expected))
    assert desk.last(TRIAL).correct is correct


# --- pausing, and what an operator may do -----------------------------------------------------------------


def in_quiet(desk: Desk) -> None:
    desk.enter()
    desk.press("enter")


def in_foreperiod(desk: Desk) -> None:
    in_quiet(desk)
    desk.until(lambda: desk.waiting.what == "foreperiod")
    desk.wait(100)


def in_storing(desk: Desk) -> None:
    desk.screen.stores = False
    desk.start()
    desk.answer()
    desk.until(lambda: desk.waiting.what == "storage")


def before_onset(desk: Desk) -> None:
    in_foreperiod(desk)
    desk.until(lambda: desk.all(PROMPT))


def in_response(desk: Desk) -> None:
    desk.start()
    desk.wait(100)


IN_A_TRIAL = [in_quiet, in_foreperiod, in_storing, before_onset, in_response]


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_pause_in_a_trial_voids_it_and_it_is_repeated_as_it_was(sit: Sit, moment: Callable[[Desk], None]) -> None:
    desk, undisturbed = sit(seed=5), sit(seed=5)
    undisturbed.enter()
    undisturbed.attempt()
    moment(desk)
    done = len(desk.all(TRIAL))
    desk.operate("pause")
    assert (desk.waiting.what, desk.waiting.stage) == ("resume", "paused")
    voided = desk.last(VOIDED)
    assert (voided.attempt, voided.trial, voided.reason) == (1, done + 1, "pause")
    desk.wait(60_000)
    desk.press("enter")
    desk.press("f")
    assert desk.waiting.stage == "paused"
    assert len(desk.all(TRIAL)) == done
    desk.screen.stores = True
    if done:
        desk.screen.store(1, done)
    desk.operate("resume")
    while len(desk.all(TRIAL)) < 3:
        desk.answer()
    for trial, as_it_was in zip(desk.all(TRIAL), undisturbed.all(TRIAL), strict=True):
        assert (trial.attempt, trial.trial, trial.stimulus) == (as_it_was.attempt, as_it_was.trial, as_it_was.stimulus)
        assert trial.timing.foreperiod_ms == as_it_was.timing.foreperiod_ms
    assert desk.session.faults == []


def test_a_repeated_prompt_says_how_often_it_was_shown(sit: Sit) -> None:
    desk = sit()
    first = desk.start()
    desk.operate("pause")
    desk.operate("resume")
    again = desk.to_prompt()
    assert (again.trial, again.stimulus, first.presentation, again.presentation) == (1, first.stimulus, 1, 2)
    assert desk.answer().timing.presentation == 2


def test_what_befell_a_prompt_before_a_pause_is_not_told_of_its_repetition(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.press("enter")
    desk.until(lambda: desk.waiting.what == "foreperiod")
    desk.press("f")
    desk.to_prompt()
    desk.paste()
    desk.operate("pause")
    desk.operate("resume")
    timing = desk.answer().timing
    assert (timing.false_starts, timing.flags) == (0, ())


def test_after_a_pause_there_is_quiet_and_a_whole_foreperiod(sit: Sit) -> None:
    desk = sit(foreperiod_min_ms=700, foreperiod_max_ms=700)
    desk.start()
    desk.operate("pause")
    desk.wait(10_000)
    desk.operate("resume")
    resumed = desk.clock.now()
    desk.to_prompt()
    assert desk.clock.now() - resumed == (500 + 700 + 4) * MS


def test_nothing_times_out_in_a_pause(sit: Sit) -> None:
    desk = sit()
    desk.start()
    desk.operate("pause")
    desk.wait(600_000)
    assert desk.all(TRIAL) == []
    assert desk.waiting.stage == "paused"


def test_a_pause_between_attempts_voids_nothing_and_goes_back_there(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.attempt()
    desk.operate("pause")
    assert desk.waiting.stage == "paused"
    desk.operate("resume")
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.attempt) == ("enter", "attempt", 2)
    assert desk.all(VOIDED) == []


def test_a_pause_in_the_instructions_goes_back_to_them(sit: Sit) -> None:
    desk = sit()
    desk.operate("pause")
    desk.operate("resume")
    assert desk.waiting.stage == "instructions"


@pytest.mark.parametrize("reason", ["tired", "pain", "finished"])
def test_how_a_person_is_is_told_and_only_a_decision_goes_on(sit: Sit, reason: str) -> None:
    desk = sit()
    desk.start()
    desk.operate("pause")
    desk.operate("pause", reason=reason)
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.reason) == ("resume", "paused", reason)
    desk.press("enter")
    assert desk.waiting.stage == "paused"
    desk.operate("resume")
    assert (desk.waiting.stage, desk.waiting.reason) == ("trial", "")
    assert len(desk.all(VOIDED)) == 1


@pytest.mark.parametrize("moment", [*IN_A_TRIAL, lambda desk: None, Desk.enter, lambda desk: desk.operate("pause")])
def test_an_end_aborts_from_anywhere_and_is_final(sit: Sit, moment: Callable[[Desk], None]) -> None:
    desk = sit()
    moment(desk)
    done = len(desk.all(TRIAL))
    desk.operate("end")
    if done and not desk.screen.stores:
        assert desk.all(SESSION_ENDED) == [], "the last trial is not on the disk yet"
        desk.screen.store(1, done)
    assert [end.status for end in desk.all(SESSION_ENDED)] == ["aborted"]
    assert desk.session.ended
    for act in ("resume", "skip", "repeat", "pause", "end"):
        desk.operate(act)
    desk.wait(60_000)
    assert desk.waiting.what == "nothing"
    assert len(desk.all(TRIAL)) == done
    assert len(desk.all(SESSION_ENDED)) == 1
    assert desk.last(ACTION).kind == "goodbye"


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_skipped_prompt_is_a_row_of_its_own_and_the_next_follows(sit: Sit, moment: Callable[[Desk], None]) -> None:
    desk = sit()
    moment(desk)
    done = len(desk.all(TRIAL))
    desk.screen.stores = True
    desk.operate("skip")
    skipped = desk.last(TRIAL)
    assert (skipped.trial, skipped.correct, skipped.response) == (done + 1, False, None)
    assert skipped.timing.flags == ("skipped",)
    assert desk.answer().trial == done + 2


def test_a_repeat_shows_the_prompt_again_under_its_number(sit: Sit) -> None:
    desk = sit()
    first = desk.start()
    desk.wait(100)
    desk.operate("repeat")
    assert desk.last(VOIDED).reason == "repeat"
    again = desk.to_prompt()
    assert (again.trial, again.stimulus, again.presentation) == (first.trial, first.stimulus, 2)


@pytest.mark.parametrize("act", ["skip", "repeat"])
def test_outside_a_trial_there_is_nothing_to_skip_or_repeat(sit: Sit, act: str) -> None:
    desk = sit()
    desk.enter()
    said = len(desk.all(WAITING))
    desk.operate(act)
    assert (desk.all(TRIAL), desk.all(VOIDED), len(desk.all(WAITING))) == ([], [], said)


def test_a_level_set_between_attempts_is_that_of_the_next_and_told_at_once(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.operate("level", value=5)
    assert desk.waiting.level == 5
    assert (desk.last(LEVEL).previous, desk.last(LEVEL).level, desk.last(LEVEL).reason) == (1, 5, "operator")
    desk.attempt()
    assert desk.last(ATTEMPT_ENDED).level == 5
    assert desk.waiting.level == 6


def test_a_level_set_in_an_attempt_is_that_of_the_next_and_the_attempt_keeps_its_own(sit: Sit) -> None:
    desk = sit()
    desk.start()
    desk.operate("level", value=7)
    while not desk.all(ATTEMPT_ENDED):
        desk.answer()
    assert {prompt.level for prompt in desk.all(PROMPT)} == {1}
    assert desk.last(ATTEMPT_ENDED).level == 1
    assert desk.waiting.level == 7
    assert [(change.level, change.reason) for change in desk.all(LEVEL)] == [(7, "operator")]
    desk.wait(1000)
    desk.begin_attempt()
    assert desk.last(PROMPT).level == 7


def test_a_level_set_in_a_pause_of_an_attempt_waits_for_its_end_too(sit: Sit) -> None:
    desk = sit()
    desk.start()
    desk.operate("pause")
    desk.operate("level", value=7)
    desk.operate("resume")
    assert desk.to_prompt().level == 1


@pytest.mark.parametrize(("asked", "given"), [(0, 2), (-3, 2), (99, 6), (4, 4)])
def test_a_level_set_stays_within_its_bounds(sit: Sit, asked: int, given: int) -> None:
    desk = sit(min_level=2, max_level=6, start_level=3)
    desk.enter()
    desk.operate("level", value=asked)
    assert desk.last(LEVEL).level == given


# --- the disk -----------------------------------------------------------------------------------------------


def test_the_next_prompt_waits_until_the_trial_is_stored(sit: Sit) -> None:
    desk = sit()
    desk.screen.stores = False
    desk.start()
    desk.answer()
    desk.wait(60_000)
    assert len(desk.all(PROMPT)) == 1
    assert desk.waiting.what == "storage"
    desk.screen.store(1, 1)
    assert len(desk.all(PROMPT)) == 2


def test_an_acknowledgement_of_an_earlier_trial_is_not_enough(sit: Sit) -> None:
    desk = sit()
    desk.start()
    desk.answer()
    desk.to_prompt()
    desk.screen.stores = False
    desk.answer()
    desk.wait(60_000)
    desk.screen.store(1, 1)
    assert len(desk.all(PROMPT)) == 2
    desk.screen.store(1, 2)
    assert len(desk.all(PROMPT)) == 3


def test_a_key_while_the_disk_is_waited_for_begins_the_foreperiod_anew(sit: Sit) -> None:
    desk = sit()
    in_storing(desk)
    desk.press("f")
    assert desk.waiting.what == "quiet"
    desk.screen.store(1, 1)
    assert len(desk.all(PROMPT)) == 1
    desk.to_prompt()
    assert len(desk.all(PROMPT)) == 2


def test_the_first_prompt_of_an_attempt_waits_for_the_last_trial_of_the_one_before(sit: Sit) -> None:
    desk = sit(prompts_per_attempt=1)
    desk.screen.stores = False
    desk.start()
    desk.answer()
    desk.wait(1000)
    desk.press("enter")
    desk.wait(60_000)
    assert (desk.waiting.what, desk.waiting.attempt) == ("storage", 2)
    desk.screen.store(1, 1)
    assert desk.last(PROMPT).attempt == 2


def test_a_session_is_complete_only_when_its_last_trial_is_stored(sit: Sit) -> None:
    desk = sit(attempts=1, prompts_per_attempt=1)
    desk.screen.stores = False
    desk.start()
    desk.answer()
    desk.wait(60_000)
    desk.press("enter")
    desk.wait(60_000)
    assert (desk.waiting.what, desk.waiting.stage) == ("storage", "ended")
    assert desk.all(SESSION_ENDED) == []
    desk.operate("end")
    assert desk.all(SESSION_ENDED) == []
    desk.screen.store(1, 1)
    assert desk.last(SESSION_ENDED).status == "completed"


def test_at_the_end_too_an_acknowledgement_of_an_earlier_trial_is_not_enough(sit: Sit) -> None:
    desk = sit(attempts=1, prompts_per_attempt=2)
    desk.screen.stores = False
    desk.start()
    desk.operate("skip")
    desk.operate("skip")
    desk.wait(1000)
    desk.press("enter")
    desk.screen.store(1, 1)
    assert desk.all(SESSION_ENDED) == []
    desk.screen.store(1, 2)
    assert desk.last(SESSION_ENDED).status == "completed"


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_disk_that_refuses_pauses_and_enter_goes_on_once_it_writes_again(
    sit: Sit, moment: Callable[[Desk], None]
) -> None:
    desk = sit()
    moment(desk)
    done = len(desk.all(TRIAL))
    desk.disk(False)
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.reason) == ("resume", "paused", "storage")
    for act in (lambda: desk.press("enter"), lambda: desk.operate("resume"), lambda: desk.operate("pause", "tired")):
        act()
        assert (desk.waiting.stage, desk.waiting.reason) == ("paused", "storage")
    desk.wait(60_000)
    desk.disk(True)
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.reason) == ("enter", "paused", "restored")
    desk.screen.stores = True
    if done:
        desk.screen.store(1, done)
    desk.press("enter")
    assert desk.answer().trial == done + 1


def test_a_disk_that_refuses_between_attempts_goes_back_there(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.disk(False)
    desk.disk(True)
    desk.press("enter")
    assert desk.waiting.stage == "attempt"


def test_a_disk_that_refuses_in_a_pause_is_told_and_comes_first(sit: Sit) -> None:
    desk = sit()
    desk.start()
    desk.operate("pause", reason="tired")
    desk.disk(False)
    assert desk.waiting.reason == "storage"
    desk.press("enter")
    desk.operate("resume")
    assert desk.waiting.reason == "storage"
    desk.disk(True)
    assert desk.waiting.reason == "tired", "what a person said is not forgotten"


def test_a_program_that_stood_still_repeats_the_trial_instead_of_calling_it_missed(sit: Sit) -> None:
    desk = sit()
    prompt = desk.start()
    desk.wait(50)
    desk.clock.set(desk.clock.now() + 8000 * MS)
    desk.wait(0)
    assert desk.all(TRIAL) == []
    assert desk.last(VOIDED).reason == "stalled"
    again = desk.to_prompt()
    assert (again.trial, again.stimulus, again.presentation) == (prompt.trial, prompt.stimulus, 2)


def test_a_miss_tells_how_late_its_time_out_was(sit: Sit) -> None:
    desk = sit(response_timeout_ms=1000)
    desk.start()
    desk.wait(900)
    desk.clock.set(desk.clock.now() + 300 * MS)
    desk.wait(60)
    timing = desk.last(TRIAL).timing
    assert 150 < timing.loop_lag_ms < 250


def test_who_leans_on_a_key_is_asked_to_let_go(sit: Sit) -> None:
    desk = sit()
    desk.enter()
    desk.begin_attempt()
    desk.answer()
    desk.hold("f", 2500)
    assert desk.waiting.reason == ""
    desk.hold("f", 1500)
    assert (desk.waiting.what, desk.waiting.reason) == ("quiet", "held")
    desk.wait(600)
    assert (desk.waiting.what, desk.waiting.reason) == ("foreperiod", "")


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
def test_a_result_that_cannot_be_kept_stops_the_session_for_good(sit: Sit, result: Result) -> None:
    desk = sit()
    desk.start()
    desk.session.task.perceived = lambda trial, percept: result  # type: ignore[method-assign]
    desk.press("f")
    fault = desk.session.broken
    assert fault is not None
    assert "cannot be kept" in fault.error
    assert (desk.waiting.what, desk.waiting.stage) == ("nothing", "broken")
    said = len(desk.records)
    desk.wait(60_000)
    assert len(desk.records) == said, "nothing goes on by itself"
    desk.press("enter")
    desk.operate("resume")
    assert desk.all(TRIAL) == []
    assert desk.waiting.stage == "broken"


def test_a_disk_that_writes_changes_nothing(sit: Sit) -> None:
    desk = sit()
    desk.start()
    said = len(desk.all(WAITING))
    desk.disk(True)
    assert len(desk.all(WAITING)) == said


# --- tasks of more than one key -----------------------------------------------------------------------------


class Taps(Task):
    """As many taps of the space bar as you can."""

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
        return Result(correct=True, response=f"{len(trial.percepts)} taps", value=float(len(trial.percepts)))


def test_a_task_may_go_on_waiting_and_judge_all_its_keys_at_the_end(calm: Theme) -> None:
    desk = Desk(Taps, calm, attempts=1, threshold=3, neutral_band=0, response_timeout_ms=3000)
    desk.start()
    for _ in range(5):
        desk.wait(200)
        desk.press("space")
    desk.until(lambda: desk.all(TRIAL))
    assert (desk.last(TRIAL).value, desk.last(ATTEMPT_ENDED).outcome) == (5.0, "success")


def test_what_a_held_key_repeats_is_not_handed_to_the_task(calm: Theme) -> None:
    desk = Desk(Taps, calm, attempts=1, threshold=3, neutral_band=0, response_timeout_ms=3000)
    desk.start()
    desk.wait(200)
    desk.hold("space", ms=2000)
    desk.until(lambda: desk.all(TRIAL))
    assert desk.last(TRIAL).value == 1.0
    assert "repeat_key" in flags(desk)


class Brittle(Taps):
    name = "brittle"

    def timed_out(self, trial: Trial) -> Result:
        raise ZeroDivisionError("no taps")


def test_a_task_that_raises_is_told_of_as_the_fault_that_stops_the_session(calm: Theme) -> None:
    desk = Desk(Brittle, calm, attempts=1)
    desk.start()
    assert desk.session.broken is None
    desk.wait(10_000)
    assert desk.session.broken is not None
    assert desk.session.broken.error == "ZeroDivisionError: no taps"


class Bounded(Taps):
    name = "bounded"
    Parameters = TaskParameters

    @property
    def levels(self) -> int:
        return 2


def test_a_task_with_few_levels_stays_within_them(calm: Theme) -> None:
    desk = Desk(Bounded, calm, attempts=4, threshold=0, neutral_band=0, response_timeout_ms=1000)
    desk.enter()
    for _ in range(4):
        desk.begin_attempt()
        desk.wait(300)
        desk.press("space")
        desk.wait(1500)
    assert [ended.level for ended in desk.all(ATTEMPT_ENDED)] == [1, 2, 2, 2]


# --- whatever anyone does -------------------------------------------------------------------------------------

ACTS = st.lists(
    st.one_of(
        st.tuples(st.just("press"), st.sampled_from(["enter", "f", "j", "space", "left"])),
        st.tuples(st.just("wait"), st.sampled_from([1, 30, 99, 500, 1000, 3000])),
        st.tuples(st.just("operate"), st.sampled_from(["pause", "resume", "skip", "repeat", "level"])),
        st.tuples(st.just("disk"), st.booleans()),
        st.tuples(st.just("focus"), st.booleans()),
        st.just(("paste", 3)),
        st.just(("answer", 400)),
    ),
    max_size=40,
)


@given(ACTS)
def test_whatever_anyone_does_every_trial_comes_once_in_order_and_nothing_breaks(
    keyboard: type[Task], calm: Theme, acts: list[tuple[str, Any]]
) -> None:
    desk = Desk(keyboard, calm, prompts_per_attempt=2, attempts=2, start_level=3)
    for act, what in acts:
        if act == "answer":
            if desk.screen.onset is not None:
                desk.wait(what)
                desk.press(desk.last(PROMPT).expected)
        elif act == "operate":
            desk.operate(what, value=5 if what == "level" else None)
        else:
            getattr(desk, act)(what)
    desk.disk(True)
    desk.operate("resume")
    while not desk.session.ended:
        if desk.waiting.what == "enter":
            desk.wait(1000)
            desk.press("enter")
        else:
            assert desk.clock.step()
    assert numbers(desk) == [(1, 1), (1, 2), (2, 1), (2, 2)]
    assert [(ended.attempt, ended.trials) for ended in desk.all(ATTEMPT_ENDED)] == [(1, 2), (2, 2)]
    assert desk.last(SESSION_ENDED).status == "completed"
    assert desk.session.faults == []
    for trial in desk.all(TRIAL):
        assert trial.value is None or (trial.correct and trial.value >= 100)
        assert trial.reaction_time_ms is None or 0 <= trial.reaction_time_ms <= 5000
