"""Given trials that the participant starts, when they wait, hurry or fail, then each trial is theirs to begin."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.framework.clock import MS
from sar_tui.framework.nodes.trials import MOST_AGAIN
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import ATTEMPT_ENDED, PROMPT, TRIAL, VOIDED, WAITING
from tests.lifting import SLIPPED, Bench, Lift

Sit = Callable[..., Bench]


@pytest.fixture
def sit(calm: Theme) -> Sit:
    """Sit down to two attempts of two lifts each, unless told otherwise."""

    def at(**settings: Any) -> Bench:
        return Bench(Lift, calm, **{"attempts": 2, **settings})

    return at


def waits(desk: Bench) -> list[str]:
    return [waiting.what for waiting in desk.all(WAITING)]


def numbers(desk: Bench) -> list[tuple[int, int]]:
    return [(trial.attempt, trial.trial) for trial in desk.all(TRIAL)]


# --- the key that starts a trial -----------------------------------------------------------------------------


def test_a_trial_waits_for_its_start_as_long_as_the_participant_likes(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.attempt, desk.waiting.trial) == ("start", "trial", 1, 1)
    assert desk.waiting.goal == "Weight 1. Stand still."
    desk.wait(3_600_000)
    assert desk.waiting.what == "start"
    assert (desk.all(PROMPT), desk.all(TRIAL), desk.all(VOIDED)) == ([], [], [])


def test_the_start_key_shows_the_prompt_at_once(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.press("space")
    (prompt,) = desk.all(PROMPT)
    assert (prompt.attempt, prompt.trial, prompt.presentation, prompt.stimulus) == (1, 1, 1, "1 kg")
    assert waits(desk)[-2:] == ["start", "response"], "neither quiet nor a foreperiod"
    assert prompt.started == desk.clock.now()


def test_a_trial_is_told_when_its_key_was_pressed_not_when_it_was_handled(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    pressed = desk.clock.now() - 7 * MS
    desk.press("space", at=pressed)
    assert desk.last(PROMPT).started == pressed


@pytest.mark.parametrize("key", ["enter", "u", "k", "s"])
def test_no_other_key_starts_a_trial(sit: Sit, key: str) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.press(key)
    desk.wait(5000)
    assert desk.waiting.what == "start"
    assert desk.all(PROMPT) == []


def test_a_held_start_key_starts_one_trial_and_not_the_next(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.hold("space", ms=300)
    desk.operate("skip")
    desk.hold("space", ms=900)
    assert (desk.waiting.what, desk.waiting.trial, len(desk.all(PROMPT))) == ("start", 2, 1)
    desk.wait(600)
    desk.press("space")
    assert len(desk.all(PROMPT)) == 1, "so soon after the last it is held still"
    desk.wait(700)
    desk.press("space")
    assert len(desk.all(PROMPT)) == 2


def test_each_trial_of_an_attempt_is_started_and_a_new_attempt_is_begun_with_enter(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.lift()
    assert (desk.waiting.what, desk.waiting.trial) == ("start", 2)
    desk.lift()
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.attempt) == ("enter", "attempt", 2)
    desk.press("space")
    assert desk.waiting.stage == "attempt"
    desk.press("enter")
    desk.wait(700)
    desk.lift()
    desk.lift()
    assert numbers(desk) == [(1, 1), (1, 2), (2, 1), (2, 2)]
    assert desk.waiting.stage == "review"


def test_a_trial_started_before_the_last_is_stored_waits_for_the_disk_and_no_key_disturbs_it(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.screen.stores = False
    desk.lift()
    desk.press("space")
    pressed = desk.clock.now()
    assert desk.waiting.what == "storage"
    desk.wait(200)
    desk.press("k")
    assert desk.waiting.what == "storage"
    desk.screen.store(1, 1)
    assert desk.last(PROMPT).trial == 2
    assert desk.last(PROMPT).started == pressed


def test_a_time_out_counts_from_the_prompt_however_long_the_start_was_awaited(sit: Sit) -> None:
    desk = sit(response_timeout_ms=2000)
    desk.begin_lifts()
    desk.wait(10_000)
    desk.press("space")
    desk.to_prompt()
    desk.wait(2049)
    assert desk.all(TRIAL) == []
    desk.wait(1)
    assert (desk.last(TRIAL).response, desk.last(TRIAL).correct) == (None, False)


def test_a_pause_before_the_start_goes_back_to_it(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.operate("pause")
    desk.press("space")
    assert (desk.waiting.stage, desk.all(PROMPT)) == ("paused", [])
    desk.wait(1000)
    desk.operate("resume")
    assert (desk.waiting.what, desk.waiting.trial) == ("start", 1)
    desk.lift()
    assert numbers(desk) == [(1, 1)]


def test_a_pause_in_a_trial_has_it_started_again(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.press("space")
    desk.to_prompt()
    desk.press("k")
    desk.operate("pause")
    desk.operate("resume")
    assert desk.waiting.what == "start"
    desk.wait(700)
    desk.press("space")
    again = desk.to_prompt()
    assert (again.trial, again.presentation, again.started) == (1, 2, desk.clock.now() - 4 * MS)
    desk.wait(300)
    desk.press("u")
    assert desk.all(TRIAL) == [], "what was lifted before the pause is forgotten"


def test_a_trial_that_was_not_started_can_be_skipped(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.operate("skip")
    skipped = desk.last(TRIAL)
    assert (skipped.trial, skipped.correct, skipped.onset, skipped.timing.flags) == (1, False, None, ("skipped",))
    assert (desk.waiting.what, desk.waiting.trial) == ("start", 2)


@pytest.mark.parametrize("presses", [(), ("space",), ("space", "k")])
def test_a_session_cut_off_in_a_trial_has_it_started_again(sit: Sit, calm: Theme, presses: tuple[str, ...]) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.lift()
    for key in presses:
        desk.press(key)
        desk.wait(100)
    resumed = Bench(Lift, calm, attempts=2, history=desk.records)
    assert (resumed.waiting.what, resumed.waiting.reason) == ("enter", "interrupted")
    resumed.press("enter")
    assert (resumed.waiting.what, resumed.waiting.trial) == ("start", 2)
    resumed.lift()
    assert (resumed.last(TRIAL).attempt, resumed.last(TRIAL).trial, resumed.last(TRIAL).correct) == (1, 2, True)


# --- with a signal, or without --------------------------------------------------------------------------------


def test_with_a_signal_the_start_is_followed_by_quiet_and_a_foreperiod(sit: Sit) -> None:
    desk = sit(signal=True, foreperiod_min_ms=900, foreperiod_max_ms=900)
    desk.begin_lifts()
    desk.press("space")
    started = desk.clock.now()
    prompt = desk.to_prompt()
    assert waits(desk)[-4:] == ["start", "quiet", "foreperiod", "response"]
    assert desk.clock.now() - started == (500 + 900 + 4) * MS
    assert prompt.started == started
    desk.press("d")
    assert desk.last(TRIAL).timing.foreperiod_ms == 900.0


def test_a_key_before_the_signal_begins_the_foreperiod_anew_and_the_start_stands(sit: Sit) -> None:
    desk = sit(signal=True, foreperiod_min_ms=900, foreperiod_max_ms=900)
    desk.begin_lifts()
    desk.press("space")
    started = desk.clock.now()
    desk.until(lambda: desk.waiting.what == "foreperiod")
    desk.wait(400)
    desk.press("space")
    pressed = desk.clock.now()
    assert desk.to_prompt().started == started
    assert desk.clock.now() - pressed == (500 + 900 + 4) * MS
    desk.press("d")
    assert desk.last(TRIAL).timing.false_starts == 1


def test_a_task_that_neither_waits_for_a_start_nor_for_a_foreperiod_shows_its_prompts_at_once(sit: Sit) -> None:
    desk = sit(by_itself=True)
    desk.enter()
    desk.press("enter")
    assert [prompt.trial for prompt in desk.all(PROMPT)] == [1]
    desk.to_prompt()
    desk.press("d")
    desk.wait(0)
    assert [prompt.trial for prompt in desk.all(PROMPT)] == [1, 2]
    assert {"quiet", "foreperiod"} & set(waits(desk)) == set()
    assert desk.last(TRIAL).timing.foreperiod_ms == 0


# --- a response that lasts ------------------------------------------------------------------------------------


def test_the_row_of_a_movement_begins_with_its_onset_and_ends_with_its_end(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.lift(450)
    trial = desk.last(TRIAL)
    end = desk.clock.now() - 300 * MS
    assert (trial.onset, trial.response_at, trial.value) == (end - 450 * MS, end, 450.0)
    assert (trial.response, trial.correct, trial.details) == ("lift", True, {"sway": 4.5, "grip": 50.0})
    assert trial.timing.flags == ()


def test_without_a_signal_there_is_no_reaction_time_and_nothing_is_an_anticipation(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.press("space")
    desk.press("k")
    desk.wait(5)
    desk.press("u")
    trial = desk.last(TRIAL)
    assert (trial.reaction_time_ms, trial.value, trial.timing.flags) == (None, 5.0, ())


def test_with_a_signal_the_reaction_time_runs_from_the_signal_to_the_movements_onset(sit: Sit) -> None:
    desk = sit(signal=True)
    desk.begin_lifts()
    desk.lift(450)
    trial = desk.last(TRIAL)
    assert (trial.reaction_time_ms, trial.value, trial.timing.flags) == (200.0, 450.0, ())


def test_a_movement_that_begins_too_soon_after_the_signal_is_an_anticipation_however_late_it_ends(sit: Sit) -> None:
    desk = sit(signal=True, lifts=1)
    desk.begin_lifts()
    desk.press("space")
    desk.to_prompt()
    desk.wait(99)
    desk.press("k")
    desk.wait(2000)
    desk.press("u")
    trial = desk.last(TRIAL)
    assert (trial.reaction_time_ms, trial.value, trial.correct, trial.timing.flags) == (
        99.0,
        None,
        True,
        ("anticipation",),
    )
    assert desk.last(ATTEMPT_ENDED).metric is None


def test_a_movement_that_begins_before_the_signal_is_an_anticipation_without_a_reaction_time(sit: Sit) -> None:
    desk = sit(signal=True, lifts=1)
    desk.begin_lifts()
    desk.press("space")
    desk.until(lambda: desk.all(PROMPT))
    desk.wait(1)
    desk.press("k")
    desk.to_prompt()
    desk.wait(500)
    desk.press("u")
    trial = desk.last(TRIAL)
    assert (trial.reaction_time_ms, trial.value, trial.timing.flags) == (None, None, ("anticipation",))
    assert trial.response_at - trial.onset == 503 * MS


# --- a trial of which nothing can be said ---------------------------------------------------------------------


def test_a_trial_of_which_nothing_can_be_said_is_done_once_more_and_the_participant_is_told_why(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    first = desk.waiting
    desk.lift(end="?")
    assert desk.all(TRIAL) == []
    voided = desk.last(VOIDED)
    assert (voided.attempt, voided.trial, voided.presentation, voided.reason) == (1, 1, 1, "slipped")
    assert (desk.waiting.what, desk.waiting.trial, desk.waiting.notice) == ("start", 1, SLIPPED)
    assert (first.notice, desk.waiting.goal) == ("", first.goal)
    desk.lift()
    assert numbers(desk) == [(1, 1)]
    assert desk.last(TRIAL).timing.presentation == 2
    assert desk.waiting.notice == "", "the next trial is no repetition"


def test_what_was_perceived_before_a_trial_is_done_once_more_is_forgotten(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.lift(end="?")
    desk.press("space")
    desk.to_prompt()
    desk.wait(300)
    desk.press("u")
    assert desk.all(TRIAL) == [], "no weight was taken off the table this time"
    desk.press("k")
    desk.wait(300)
    desk.press("u")
    assert desk.last(TRIAL).value == 300.0


def test_a_trial_may_be_done_over_as_soon_as_its_prompt_is_seen(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    desk.press("space")
    desk.press("?")
    desk.press("u")
    desk.wait(4)
    assert (desk.waiting.what, desk.waiting.notice, desk.all(TRIAL)) == ("start", SLIPPED, [])
    assert desk.session.faults == []


def test_however_often_a_trial_is_done_over_its_prompt_is_the_same(sit: Sit) -> None:
    desk = sit(signal=True)
    desk.begin_lifts()
    for _ in range(MOST_AGAIN - 1):
        desk.lift(end="?")
    desk.lift()
    prompts = desk.all(PROMPT)
    assert [(prompt.trial, prompt.presentation) for prompt in prompts] == [(1, n) for n in range(1, MOST_AGAIN + 1)]
    assert len({prompt.stimulus for prompt in prompts}) == 1
    shown = [record.at for record in desk.records if record.topic is PROMPT]
    began = [record.at for record in desk.records if record.topic is WAITING and record.message.what == "foreperiod"]
    assert len({end - begin for begin, end in zip(began, shown, strict=True)}) == 1
    assert numbers(desk) == [(1, 1)]


def test_a_trial_of_which_nothing_can_be_said_is_not_asked_for_without_end(sit: Sit) -> None:
    desk = sit()
    desk.begin_lifts()
    for _ in range(MOST_AGAIN):
        desk.lift(end="?")
    (missed,) = desk.all(TRIAL)
    assert (missed.correct, missed.timing.flags) == (False, ("unmeasured", "slipped"))
    assert (desk.waiting.what, desk.waiting.trial, desk.waiting.notice) == ("start", 2, "")
    desk.lift(end="?")
    assert len(desk.all(TRIAL)) == 1, "and each trial has as many tries"


# --- what has to be known first -------------------------------------------------------------------------------


def test_a_level_is_announced_before_the_first_attempt_and_when_it_is_another(sit: Sit) -> None:
    desk = sit(attempts=3, lifts=1, start_level=3)
    desk.enter()
    assert desk.waiting.notice == "Weight 3 after 0"
    desk.press("enter")
    desk.wait(300)
    assert desk.waiting.notice == "", "a trial that is not repeated has nothing to tell"
    desk.lift(end="d")
    assert (desk.waiting.stage, desk.waiting.notice) == ("attempt", "Weight 2 after 3")
    desk.operate("level", value=3)
    assert (desk.waiting.stage, desk.waiting.notice) == ("attempt", ""), "the level is what it was"


def test_a_level_that_stays_is_not_announced_again(sit: Sit) -> None:
    desk = sit(lifts=1, difficulty_policy="fixed")
    desk.begin_lifts()
    desk.lift()
    assert (desk.waiting.stage, desk.waiting.notice) == ("attempt", "")
