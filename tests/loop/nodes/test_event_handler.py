"""The event handler runs the keyboard task: keys, pauses, storage, faults."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Metric, Result, Situation, Stimulus, Trial
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.loop_driver import LoopDriver

CATALOGUE = Catalogue()
KEYBOARD, CALM = CATALOGUE.task("keyboard"), CATALOGUE.theme("calm")


def session(at: str = "instructions", **settings: Any) -> LoopDriver:
    """Start a keyboard session, by default two attempts of three prompts, and go on to a place."""
    driver = LoopDriver(KEYBOARD, CALM, **{"prompts_per_attempt": 3, "attempts": 2, **settings})
    if at != "instructions":
        driver.enter()
    if at not in ("instructions", "attempt"):
        driver.press("enter")
    if at == "foreperiod":
        driver.until(lambda: driver.waiting.what == "foreperiod")
    elif at == "before onset":
        driver.until(lambda: driver.all(t.PROMPT))
    elif at == "prompt":
        driver.to_prompt()
    elif at == "storage":
        driver.screen.stores = False
        driver.answer()
        driver.until(lambda: driver.waiting.what == "storage")
    return driver


def now(driver: LoopDriver, names: str = "what stage") -> tuple[Any, ...]:
    return facts(driver.waiting, names)


def numbers(driver: LoopDriver) -> list[tuple[int, int]]:
    return each(driver.all(t.TRIAL), "attempt trial")


def ms_since(driver: LoopDriver, moment: int) -> float:
    return (driver.clock.now() - moment) / MS


# --- a normal session


def test_a_session_runs_from_the_instructions_to_its_end() -> None:
    driver = session()
    driver.press("space")
    assert now(driver) == ("enter", "instructions")
    driver.enter()
    driver.press("f")
    assert now(driver, "what stage attempt_name") == ("enter", "attempt", "attempt 1 of 2")
    assert "3 of 3 right" in driver.waiting.goal
    driver.attempt()
    assert now(driver, "stage attempt_name") == ("attempt", "attempt 2 of 2")
    driver.attempt()
    assert now(driver) == ("enter", "review")
    assert driver.all(t.SESSION_ENDED) == [], "the last feedback is read before the goodbye"
    driver.press("enter")
    assert driver.waiting.what == "nothing"
    assert numbers(driver) == [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)]
    assert each(driver.all(t.SESSION_ENDED), "status") == ["completed"]
    assert driver.session.faults == []
    assert {waiting.seat for waiting in driver.all(t.WAITING)} == {"A"}, "there is one seat"


def test_a_correct_key_is_stored_with_its_time_from_onset_to_stamp() -> None:
    driver = session("prompt")
    assert each(driver.all(t.WAITING), "what")[-3:] == ["quiet", "foreperiod", "response"]
    prompt, onset = driver.last(t.PROMPT), driver.clock.now()
    driver.wait(432)
    driver.press(prompt.expected, at=driver.clock.now() - 2 * MS, lag=3 * MS)
    trial = driver.last(t.TRIAL)
    answered = (1, 1, prompt.stimulus, prompt.expected, True)
    assert facts(trial, "attempt trial stimulus response correct") == answered
    assert (trial.onset, trial.response_at) == (onset, onset + 430 * MS)
    assert trial.reaction_time_ms == trial.value == 430.0
    of_machine = facts(trial.timing, "onset_source handler_delay_ms loop_lag_ms")
    assert of_machine == ("flush", 2.0, 3.0)
    assert facts(trial.timing, "false_starts presentation flags") == (0, 1, ())


def test_a_wrong_key_lowers_accuracy_and_is_not_in_the_metric() -> None:
    driver = session("quiet")
    wrong = driver.answer(300, key="#")
    stored = facts(wrong, "response correct reaction_time_ms value")
    assert stored == ("#", False, 300.0, None)
    driver.answer(400)
    driver.answer(500)
    ended = driver.last(t.ATTEMPT_ENDED)
    assert facts(ended, "metric correct trials") == (450.0, 2, 3)
    assert ended.accuracy == pytest.approx(2 / 3)
    assert facts(ended, "outcome feedback") == ("failure", "negative")
    assert driver.last(t.FEEDBACK).reason == "accuracy"


def test_a_miss_is_stored_with_nulls_after_the_time_out() -> None:
    driver = session("prompt", response_timeout_ms=2000)
    driver.wait(2049)
    assert driver.all(t.TRIAL) == []
    driver.wait(1)
    miss = driver.last(t.TRIAL)
    assert {*facts(miss, "response response_at reaction_time_ms value")} == {None}
    assert not miss.correct
    assert miss.onset is not None
    missed = driver.clock.now()
    driver.until(lambda: driver.waiting.what == "foreperiod")
    assert driver.clock.now() == missed, "no key was pressed for long"


def test_success_raises_and_failure_lowers_the_level_of_the_next_attempt() -> None:
    driver = session("attempt", attempts=3, start_level=4)
    for time_ms in (400, 1400, 400):
        driver.attempt(time_ms)
    assert each(driver.all(t.ATTEMPT_ENDED), "level") == [4, 5, 4]
    changes = [(4, 5, "success"), (5, 4, "failure"), (4, 5, "success")]
    assert each(driver.all(t.LEVEL), "previous level reason") == changes


def test_practice_gets_feedback_but_changes_neither_level_nor_count() -> None:
    driver = session("attempt", practice_attempts=1, feedback_every=2, start_level=3)
    assert driver.waiting.attempt_name == "practice 1 of 1"
    driver.attempt(400)
    assert driver.all(t.LEVEL) == []
    assert driver.waiting.attempt_name == "attempt 1 of 2"
    driver.attempt(400)
    driver.attempt(400)
    ended = driver.all(t.ATTEMPT_ENDED)
    assert each(ended, "attempt practice level") == [(1, True, 3), (2, False, 3), (3, False, 4)]
    assert each(ended, "feedback") == ["positive", "none", "positive"]
    assert driver.waiting.stage == "review"


# --- keys outside the response window


@pytest.mark.parametrize("disturb", [lambda driver: driver.press("f"), LoopDriver.paste])
def test_a_key_in_the_foreperiod_restarts_it_and_is_no_response(
    disturb: Callable[[LoopDriver], None],
) -> None:
    driver = session("foreperiod", foreperiod_min_ms=800, foreperiod_max_ms=800)
    driver.wait(700)
    disturb(driver)
    pressed = driver.clock.now()
    assert driver.waiting.what == "quiet"
    driver.to_prompt()
    assert ms_since(driver, pressed) == 500 + 800 + 4
    assert driver.all(t.TRIAL) == []
    assert facts(driver.answer(400), "timing.false_starts reaction_time_ms") == (1, 400.0)


def test_the_foreperiod_lies_between_its_bounds_and_differs_from_trial_to_trial() -> None:
    bounds = {"foreperiod_min_ms": 600, "foreperiod_max_ms": 900}
    driver = session("attempt", prompts_per_attempt=20, **bounds)
    driver.attempt()
    waits = each(driver.all(t.TRIAL), "timing.foreperiod_ms")
    assert all(600 <= wait <= 900 for wait in waits)
    assert len(set(waits)) == 20
    shown = [one.at for one in driver.records if one.topic is t.PROMPT]
    waited = [one for one in driver.records if one.topic is t.WAITING]
    began = [one.at for one in waited if one.message.what == "foreperiod"]
    lasted = [(end - begin) / MS for begin, end in zip(began, shown, strict=True)]
    assert lasted == pytest.approx(waits)


def test_a_foreperiod_begins_only_after_half_a_second_without_keys() -> None:
    driver = session("quiet")
    driver.wait(300)
    for press in (lambda: driver.press("f"), lambda: driver.answer(300)):
        press()
        pressed = driver.clock.now()
        driver.until(lambda: driver.waiting.what == "foreperiod")
        assert ms_since(driver, pressed) == 500
    assert driver.last(t.TRIAL).timing.false_starts == 0, "there was no foreperiod yet"


@pytest.mark.parametrize("between_ms", [20, 590])
def test_a_doubled_enter_passes_one_screen_only(between_ms: int) -> None:
    driver = session(attempts=1, prompts_per_attempt=1)
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


def test_an_attempt_begins_only_after_quiet_keys() -> None:
    driver = session("attempt")
    driver.wait(2000)
    driver.strike("x")
    for wait_ms, stage in ((690, "attempt"), (700, "trial")):
        driver.wait(wait_ms)
        driver.strike("enter")
        assert driver.waiting.stage == stage


def test_the_first_of_two_keys_before_onset_is_stored_as_an_anticipation() -> None:
    driver = session("before onset")
    expected = driver.last(t.PROMPT).expected
    for key in (expected, "#"):
        driver.wait(1)
        driver.press(key)
    assert driver.all(t.TRIAL) == []
    driver.to_prompt()
    (trial,) = driver.all(t.TRIAL)
    stored = facts(trial, "response correct reaction_time_ms value timing.flags")
    assert stored == (expected, True, None, None, ("anticipation",))
    assert trial.response_at == trial.onset - 3 * MS
    assert driver.session.faults == []


def test_a_key_stamped_after_onset_but_handled_before_it_is_a_response() -> None:
    driver = session("quiet")
    driver.screen.shows = False
    driver.until(lambda: driver.all(t.PROMPT))
    onset = driver.clock.now() + 2 * MS
    driver.wait(300)
    driver.press(driver.last(t.PROMPT).expected)
    assert driver.all(t.TRIAL) == []
    driver.screen.show(driver.last(t.PROMPT), at=onset)
    assert facts(driver.last(t.TRIAL), "reaction_time_ms timing.flags") == (298.0, ())


@pytest.mark.parametrize(
    ("reaction", "flagged"), [(0, True), (99, True), (99.999, True), (100, False), (101, False)]
)
def test_faster_than_a_tenth_of_a_second_is_an_anticipation(reaction: float, flagged: bool) -> None:
    trial = session("prompt").answer(reaction)
    assert trial.reaction_time_ms == reaction
    assert ("anticipation" in trial.timing.flags) is flagged
    assert trial.value == (None if flagged else reaction)


def test_a_key_stamped_in_time_counts_even_if_handled_late() -> None:
    driver = session("prompt", response_timeout_ms=2000)
    onset = driver.clock.now()
    driver.wait(2030)
    driver.press(driver.last(t.PROMPT).expected, at=onset + 2000 * MS)
    trial = driver.last(t.TRIAL)
    assert facts(trial, "reaction_time_ms correct timing.flags") == (2000.0, True, ())
    assert trial.timing.handler_delay_ms == 30.0
    driver.wait(5000)
    assert numbers(driver).count((1, 1)) == 1


def test_a_key_stamped_late_is_a_flagged_miss() -> None:
    driver = session("prompt", response_timeout_ms=2000)
    driver.wait(2030)
    driver.press(driver.last(t.PROMPT).expected)
    missed = facts(driver.last(t.TRIAL), "response reaction_time_ms correct timing.flags")
    assert missed == (None, None, False, ("late_key",))


def test_repeats_of_a_held_key_never_count() -> None:
    at_once = {"quiet_ms": 0, "foreperiod_min_ms": 0, "foreperiod_max_ms": 0}
    driver = session("prompt", levels=["f"], **at_once)
    driver.wait(300)
    for _ in range(21):
        driver.press("f")
        driver.wait(30)
    assert numbers(driver) == [(1, 1)]
    driver.wait(500)
    driver.press("f")
    assert driver.last(t.TRIAL).trial == 2
    assert "repeat_key" in driver.last(t.TRIAL).timing.flags


def test_a_paste_and_a_lost_focus_are_flagged_and_no_responses() -> None:
    driver = session("prompt")
    driver.wait(200)
    driver.paste()
    driver.focus(False)
    assert driver.all(t.TRIAL) == []
    assert facts(driver.answer(300), "correct timing.flags") == (True, ("paste", "focus_lost"))
    assert driver.answer().timing.flags == ("focus_lost",), "it is not back yet"
    driver.focus(True)
    assert driver.answer().timing.flags == ()


def test_an_onset_stamped_after_refresh_is_flagged() -> None:
    driver = session()
    driver.screen.source = "refresh"
    driver.start()
    stamped = facts(driver.answer().timing, "onset_source flags")
    assert stamped == ("refresh", ("onset_refresh",))


def test_an_onset_of_another_presentation_is_ignored() -> None:
    driver = session("prompt")
    stale = driver.last(t.PROMPT)
    driver.operate("repeat")
    driver.screen.shows = False
    driver.until(lambda: len(driver.all(t.PROMPT)) == 2)
    driver.screen.show(stale)
    driver.wait(300)
    driver.press(stale.expected)
    assert driver.all(t.TRIAL) == []


# --- pauses and commands

IN_A_TRIAL = ["quiet", "foreperiod", "storage", "before onset", "prompt"]


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_trial_voided_by_a_pause_is_repeated_unchanged(moment: str) -> None:
    undisturbed = session("attempt", seed=5)
    undisturbed.attempt()
    driver = session(moment, seed=5)
    done = len(driver.all(t.TRIAL))
    driver.operate("pause")
    assert now(driver) == ("resume", "paused")
    assert facts(driver.last(t.VOIDED), "attempt trial reason") == (1, done + 1, "pause")
    driver.wait(60_000)
    driver.press("enter")
    driver.press("f")
    assert (driver.waiting.stage, len(driver.all(t.TRIAL))) == ("paused", done)
    driver.screen.stores = True
    if done:
        driver.screen.store(1, done)
    driver.operate("resume")
    while len(driver.all(t.TRIAL)) < 3:
        driver.answer()
    same = "attempt trial stimulus timing.foreperiod_ms"
    assert each(driver.all(t.TRIAL), same) == each(undisturbed.all(t.TRIAL), same)
    assert driver.session.faults == []


def test_a_repetition_counts_its_presentation_and_has_no_flags_of_the_voided_prompt() -> None:
    driver = session("foreperiod")
    driver.press("f")
    driver.to_prompt()
    driver.paste()
    driver.operate("pause")
    driver.operate("resume")
    assert facts(driver.answer().timing, "presentation false_starts flags") == (2, 0, ())


def test_after_a_pause_come_a_quiet_time_and_a_whole_foreperiod() -> None:
    driver = session("prompt", foreperiod_min_ms=700, foreperiod_max_ms=700)
    driver.operate("pause")
    driver.wait(600_000)
    assert (driver.all(t.TRIAL), driver.waiting.stage) == ([], "paused"), "nothing times out"
    driver.operate("resume")
    resumed = driver.clock.now()
    driver.to_prompt()
    assert ms_since(driver, resumed) == 500 + 700 + 4


def test_the_reason_of_a_pause_is_reported_and_only_a_command_resumes() -> None:
    driver = session("prompt")
    driver.operate("pause")
    driver.operate("pause", reason="pain")
    assert now(driver, "what stage reason") == ("resume", "paused", "pain")
    driver.press("enter")
    assert driver.waiting.stage == "paused"
    driver.operate("resume")
    assert now(driver, "stage reason") == ("trial", "")
    assert len(driver.all(t.VOIDED)) == 1


@pytest.mark.parametrize("moment", [*IN_A_TRIAL, "instructions", "attempt", "paused"])
def test_an_end_aborts_from_anywhere_and_is_final(moment: str) -> None:
    driver = session(moment if moment != "paused" else "instructions")
    if moment == "paused":
        driver.operate("pause")
    done = len(driver.all(t.TRIAL))
    driver.operate("end")
    if done:
        assert driver.all(t.SESSION_ENDED) == [], "the last trial is not on disk yet"
        driver.screen.store(1, done)
    assert each(driver.all(t.SESSION_ENDED), "status") == ["aborted"]
    assert driver.session.ended
    for act in ("resume", "skip", "repeat", "pause", "end"):
        driver.operate(act)
    driver.wait(60_000)
    assert driver.waiting.what == "nothing"
    assert (len(driver.all(t.TRIAL)), len(driver.all(t.SESSION_ENDED))) == (done, 1)
    assert driver.last(t.ACTION).kind == "goodbye"


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_skipped_prompt_is_stored_and_the_next_follows(moment: str) -> None:
    driver = session(moment)
    done = len(driver.all(t.TRIAL))
    driver.screen.stores = True
    driver.operate("skip")
    skipped = facts(driver.last(t.TRIAL), "trial correct response timing.flags")
    assert skipped == (done + 1, False, None, ("skipped",))
    assert driver.answer().trial == done + 2


def test_a_level_set_between_attempts_applies_to_the_next_at_once_within_its_bounds() -> None:
    driver = session("attempt", min_level=2, max_level=6, start_level=3)
    for asked, level in ((0, 2), (99, 6)):
        before = driver.waiting.level
        driver.operate("level", value=asked)
        assert driver.waiting.level == level
        assert facts(driver.last(t.LEVEL), "previous level reason") == (before, level, "operator")
    driver.attempt(1400)
    assert (driver.last(t.ATTEMPT_ENDED).level, driver.waiting.level) == (6, 5)


def test_a_level_set_in_an_attempt_applies_to_the_next() -> None:
    driver = session("prompt")
    driver.operate("pause")
    driver.operate("level", value=7)
    driver.operate("resume")
    while not driver.all(t.ATTEMPT_ENDED):
        driver.answer()
    assert {*each(driver.all(t.PROMPT), "level")} == {1}
    assert (driver.last(t.ATTEMPT_ENDED).level, driver.waiting.level) == (1, 7)
    assert each(driver.all(t.LEVEL), "level reason") == [(7, "operator")]
    driver.wait(1000)
    assert driver.begin_attempt().level == 7


# --- the disk


def test_the_next_prompt_waits_until_its_own_predecessor_is_stored() -> None:
    driver = session("prompt")
    driver.screen.stores = False
    for trial in (1, 2):
        driver.answer()
        driver.wait(60_000)
        driver.screen.store(1, trial - 1)
        assert (len(driver.all(t.PROMPT)), driver.waiting.what) == (trial, "storage")
        driver.screen.store(1, trial)
        assert len(driver.all(t.PROMPT)) == trial + 1


def test_a_key_while_the_trial_is_stored_restarts_the_foreperiod() -> None:
    driver = session("storage")
    driver.press("f")
    assert driver.waiting.what == "quiet"
    driver.screen.store(1, 1)
    assert len(driver.all(t.PROMPT)) == 1
    driver.to_prompt()
    assert len(driver.all(t.PROMPT)) == 2


def test_a_session_is_complete_only_when_its_last_trial_is_stored() -> None:
    driver = session("prompt", attempts=1, prompts_per_attempt=2)
    driver.screen.stores = False
    driver.operate("skip")
    driver.operate("skip")
    driver.wait(60_000)
    driver.press("enter")
    driver.wait(60_000)
    assert now(driver) == ("storage", "ended")
    driver.operate("end")
    driver.screen.store(1, 1)
    assert driver.all(t.SESSION_ENDED) == [], "an earlier trial is not enough"
    driver.screen.store(1, 2)
    assert driver.last(t.SESSION_ENDED).status == "completed"


@pytest.mark.parametrize("moment", IN_A_TRIAL)
def test_a_disk_failure_pauses_and_enter_resumes_after_it(moment: str) -> None:
    driver = session(moment)
    done = len(driver.all(t.TRIAL))
    driver.disk(False)
    assert now(driver, "what stage reason") == ("resume", "paused", "storage")
    driver.press("enter")
    driver.operate("resume")
    assert now(driver, "stage reason") == ("paused", "storage")
    driver.operate("pause", "tired")
    assert now(driver, "stage reason") == ("paused", "storage")
    driver.wait(60_000)
    driver.disk(True)
    assert now(driver, "what stage reason") == ("enter", "paused", "restored")
    driver.screen.stores = True
    if done:
        driver.screen.store(1, done)
    driver.press("enter")
    assert driver.answer().trial == done + 1


def test_a_disk_failure_in_a_pause_is_reported_first() -> None:
    driver = session("prompt")
    driver.operate("pause", reason="tired")
    driver.disk(False)
    assert driver.waiting.reason == "storage"
    driver.disk(True)
    assert driver.waiting.reason == "tired", "the reason a person gave is not forgotten"


def test_a_working_disk_changes_nothing() -> None:
    driver = session("prompt")
    said = len(driver.all(t.WAITING))
    driver.disk(True)
    assert len(driver.all(t.WAITING)) == said


# --- faults of the machine, keys held, results that cannot be stored


@pytest.mark.parametrize("by_key", [False, True])
def test_a_trial_is_repeated_if_the_program_was_suspended(by_key: bool) -> None:
    driver = session("prompt")
    prompt = driver.last(t.PROMPT)
    if by_key:
        driver.wait(2800)
        driver.press(prompt.expected, stalled=True)
    else:
        driver.clock.set(driver.clock.now() + 8000 * MS)
        driver.wait(0)
    assert driver.all(t.TRIAL) == []
    assert driver.last(t.VOIDED).reason == "stalled"
    again = facts(driver.to_prompt(), "trial stimulus presentation")
    assert again == (prompt.trial, prompt.stimulus, 2)
    assert driver.answer(300).reaction_time_ms == 300.0


def test_a_foreperiod_begins_anew_if_the_program_was_suspended_in_it() -> None:
    driver = session("foreperiod")
    driver.clock.set(driver.clock.now() + 4000 * MS)
    driver.wait(0)
    assert driver.all(t.PROMPT) == []
    went_on = driver.clock.now()
    timing = driver.answer().timing
    assert driver.last(t.SHOWN).at - went_on >= timing.foreperiod_ms * MS
    assert facts(timing, "presentation false_starts flags") == (1, 0, ())


def test_a_miss_stores_the_delay_of_its_time_out() -> None:
    driver = session("prompt", response_timeout_ms=1000)
    driver.wait(900)
    driver.clock.set(driver.clock.now() + 300 * MS)
    driver.wait(60)
    assert 150 < driver.last(t.TRIAL).timing.loop_lag_ms < 250


def test_a_participant_who_holds_a_key_is_asked_to_release_it() -> None:
    driver = session("quiet")
    driver.answer()
    driver.hold("f", 2500)
    assert driver.waiting.reason == ""
    driver.hold("f", 1500)
    assert now(driver, "what reason") == ("quiet", "held")
    driver.wait(600)
    assert now(driver, "what reason") == ("foreperiod", "")


@pytest.mark.parametrize(
    "result",
    [
        {"response": ("j",)},
        {"details": {"keys": [1, 2]}},
        {"details": {"key": object()}},
        {"value": float("nan")},
        {"details": {"share": float("inf")}},
    ],
)
def test_a_result_that_cannot_be_stored_stops_the_session(result: dict[str, Any]) -> None:
    driver = session("prompt")
    unstorable = Result(**{"correct": True, "response": "j", **result})
    driver.session.task.perceived = lambda trial, percept: unstorable  # type: ignore[method-assign]
    driver.press("f")
    fault = driver.session.broken
    assert fault is not None
    assert "cannot be stored" in fault.error
    assert now(driver) == ("nothing", "broken")
    said = len(driver.records)
    driver.wait(60_000)
    assert len(driver.records) == said, "nothing continues by itself"
    driver.press("enter")
    driver.operate("resume")
    assert (driver.all(t.TRIAL), driver.waiting.stage) == ([], "broken")


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
        taps = len(trial.percepts)
        return Result(correct=True, response=f"{taps} taps", value=float(taps))


def tapping(task: type[Task] = Taps, **settings: Any) -> LoopDriver:
    some = {"attempts": 1, "threshold": 3, "neutral_band": 0, "response_timeout_ms": 3000}
    return LoopDriver(task, CALM, **{**some, **settings})


def test_repeats_of_a_held_key_are_not_passed_to_the_task() -> None:
    driver = tapping()
    driver.start()
    driver.wait(200)
    driver.hold("space", ms=2000)
    driver.until(lambda: driver.all(t.TRIAL))
    assert driver.last(t.TRIAL).value == 1.0
    assert "repeat_key" in driver.last(t.TRIAL).timing.flags


def failing(value: object) -> Callable[..., object]:
    """Return a method that returns the value, or raises it."""

    def give(*_: object) -> object:
        if isinstance(value, Exception):
            raise value
        return value

    return give


NO_WORDS = ZeroDivisionError("no words")


@pytest.mark.parametrize("value", [NO_WORDS, None, ("a", "b")])
@pytest.mark.parametrize("method", ["instructions", "goal", "notice"])
def test_a_text_that_a_task_cannot_give_stops_the_session_instead_of_a_blank_screen(
    method: str, value: object
) -> None:
    driver = tapping(type("Mute", (Taps,), {"name": "mute", method: failing(value)}))
    driver.enter()
    no_text = f"TypeError: {method}() returned {value}, not a text"
    said = "ZeroDivisionError: no words" if value is NO_WORDS else no_text
    assert driver.session.broken is not None
    assert driver.session.broken.error == said
    assert driver.waiting.stage == "broken"


def test_a_task_with_few_levels_stays_within_them() -> None:
    bounded = type("Bounded", (Taps,), {"name": "bounded", "levels": property(lambda task: 2)})
    driver = tapping(bounded, attempts=4, threshold=0, response_timeout_ms=1000)
    driver.enter()
    for _ in range(4):
        driver.begin_attempt()
        driver.wait(300)
        driver.press("space")
        driver.wait(1500)
    assert each(driver.all(t.ATTEMPT_ENDED), "level") == [1, 2, 2, 2]


# --- arbitrary input

COMMANDS = ["pause", "resume", "skip", "repeat", "level", "stop"]
ACTS = st.lists(
    st.one_of(
        st.tuples(st.just("press"), st.sampled_from(["enter", "f", "j", "space", "left"])),
        st.tuples(st.just("wait"), st.sampled_from([1, 30, 99, 500, 1000, 3000])),
        st.tuples(st.just("operate"), st.sampled_from(COMMANDS)),
        st.tuples(st.sampled_from(["disk", "focus"]), st.booleans()),
        st.just(("paste", 3)),
        st.just(("answer", 400)),
    ),
    max_size=40,
)


@given(ACTS)
def test_any_input_gives_every_trial_once_in_order(acts: list[tuple[str, Any]]) -> None:
    driver = session(prompts_per_attempt=2, start_level=3)
    for act, what in acts:
        if act == "operate":
            driver.operate(what, value=5 if what == "level" else None)
        elif act != "answer":
            getattr(driver, act)(what)
        elif driver.screen.onset is not None:
            driver.answer(what)
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
