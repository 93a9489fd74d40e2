"""Prompts, scores and texts of the keyboard task."""

from collections import Counter
from itertools import product
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.task import Task
from sar_tui.model.messages import KeyPerceived
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Performance, Result, Situation, Stimulus, Trial
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import build


def make(**parameters: object) -> Task:
    kind = Catalogue().task("keyboard")
    return kind(build(kind.Parameters, parameters))


def situation(trial: int, attempt: int = 1, level: int = 1, seed: int = 1) -> Situation:
    return Situation(
        attempt, trial, level, RandomStreams(seed, attempt, trial), RandomStreams(seed)
    )


def prompts(task: Task, count: int = 20, **where: Any) -> list[str]:
    return [task.stimulus(situation(trial, **where)).name for trial in range(1, count + 1)]


def judged(
    task: Task,
    key: str,
    stimulus: Stimulus,
    level: int = 1,
    after: int = 400,
    gap: int | None = None,
) -> Result:
    trial = Trial(situation(1, level=level), stimulus, onset=1000 * MS)
    at = (1000 + after) * MS
    result = task.perceived(trial, KeyPerceived(key=key, at=at, gap=gap, repeat=False, delay=0))
    assert result is not None
    return result


def test_an_arrow_is_drawn_and_named() -> None:
    task = make(choice_set="arrow keys")
    asked = [task.stimulus(situation(trial, level=3)) for trial in range(60)]
    drawn = {"left": "←", "right": "→", "up": "↑", "down": "↓"}
    assert {each.name: each.glyph for each in asked} == drawn
    for each in asked:
        assert (each.text, each.hint) == (f"Press: {each.name}", "arrow key")
        assert (each.expected, each.choices) == (each.name, 4)


@given(st.permutations(range(1, 21)), st.integers(1, 10), st.sampled_from(["random", "repeating"]))
def test_prompts_do_not_depend_on_the_order_of_requests(
    order: list[int], level: int, sequence: str
) -> None:
    task = make(sequence=sequence)
    asked = {trial: task.stimulus(situation(trial, level=level)) for trial in order}
    again = prompts(make(sequence=sequence), level=level)
    assert [asked[trial].name for trial in range(1, 21)] == again


@given(st.integers(2, 15), st.integers(1, 10), st.integers(0, 99))
def test_a_repeating_sequence_repeats_within_an_attempt_and_in_every_attempt(
    length: int, level: int, seed: int
) -> None:
    task = make(sequence="repeating", sequence_length=length)
    first = prompts(task, 45, level=level, seed=seed)
    assert all(first[place] == first[place - length] for place in range(length, 45))
    assert prompts(task, 45, level=level, seed=seed, attempt=7) == first


@pytest.mark.parametrize("sequence", ["random", "repeating"])
def test_prompts_differ_between_seeds_and_random_ones_between_attempts(sequence: str) -> None:
    task = make(sequence=sequence)
    found = {
        tuple(prompts(task, 10, attempt=attempt, level=6, seed=seed))
        for attempt, seed in product(range(1, 5), range(4))
    }
    assert len(found) == (16 if sequence == "random" else 4)


def test_all_keys_of_a_level_are_about_equally_frequent() -> None:
    counts = Counter(prompts(make(), 4000, level=5))
    assert len(counts) == 6
    assert all(abs(count - 4000 / 6) < 120 for count in counts.values())


def test_custom_levels_are_used_as_given() -> None:
    task = make(levels=["ab", "abc", "Ab1"])
    assert task.levels == 3
    assert set(prompts(task, 60, level=2)) == set("abc")
    assert set(prompts(task, 60, level=3)) == set("Ab1")
    stimulus = Stimulus("A", "A", "Press: A")
    assert not judged(task, "a", stimulus, level=3).correct
    assert judged(task, "B", Stimulus("b", "b", "Press: b"), level=2).correct


@pytest.mark.parametrize(
    ("parameters", "name", "part"),
    [
        ({"levels": ["aa"]}, "levels", "'aa' names no key, a key twice"),
        ({"levels": ["a\t"]}, "levels", "cannot be typed"),
        ({"levels": ["ab", ""]}, "levels", "'' names no key"),
        ({"levels": ["ab"], "start_level": 2}, "start_level", "only 1 levels"),
        ({"choice_set": "arrow keys", "start_level": 4}, "start_level", "only 3 levels"),
        ({"choice_set": "arrow keys", "start_level": 5, "min_level": 5}, "start_level", "level 5"),
    ],
)
def test_invalid_settings_are_reported(parameters: dict[str, object], name: str, part: str) -> None:
    with pytest.raises(ParameterError) as caught:
        make(**parameters)
    assert part in caught.value.problems[name]


def test_the_correct_key_counts_in_either_case_and_is_timed_from_onset() -> None:
    task = make()
    result = judged(task, "F", Stimulus("f", "f", "Press: f", choices=2), after=432, gap=500 * MS)
    assert (result.correct, result.response, result.value) == (True, "F", 432.0)
    assert result.details == {"choices": 2, "key_gap_ms": 500.0}
    assert judged(task, "f", Stimulus("f", "f", "Press: f")).details["key_gap_ms"] is None


@pytest.mark.parametrize("key", ["j", "enter", "space", "", "ff", "tab"])
def test_any_other_key_is_wrong(key: str) -> None:
    result = judged(make(), key, Stimulus("f", "f", "Press: f"))
    assert (result.correct, result.response) == (False, key)


@given(st.integers(15, 20), st.integers(1, 200), st.sampled_from(["qwerty", "azerty", "qwertz"]))
def test_case_matters_if_shift_is_required(level: int, trial: int, layout: str) -> None:
    task = make(layout=layout)
    stimulus = task.stimulus(situation(trial, level=level))
    assert judged(task, stimulus.expected, stimulus, level=level).correct
    swapped = stimulus.expected.swapcase()
    if level >= 16 and swapped != stimulus.expected:
        assert not judged(task, swapped, stimulus, level=level).correct


@pytest.mark.parametrize(
    ("layout", "key", "hint"),
    [("qwerty", "A", "with Shift"), ("qwerty", "a", ""), ("qwerty", "?", "with Shift"), ("qwerty", "2", ""),
     ("azerty", "2", "with Shift"), ("azerty", "(", ""), ("qwertz", "!", "with Shift"), ("qwertz", "-", "")],
)  # fmt: skip
def test_the_hint_says_if_shift_is_needed(layout: str, key: str, hint: str) -> None:
    task = make(layout=layout)
    found = {
        s.name: s.hint for s in (task.stimulus(situation(trial, level=20)) for trial in range(3000))
    }
    assert found[key] == hint


@given(st.integers(1, 200), st.integers(0, 100))
def test_the_goal_asks_for_exactly_the_accuracy_that_success_needs(
    count: int, percent: int
) -> None:
    accuracy = percent / 100
    goal = make(prompts_per_attempt=count, min_accuracy=accuracy).goal(1)
    needed = next(right for right in range(count + 1) if right / count >= accuracy)
    assert (f"{needed} of {count} right" in goal) == (needed > 0)
    assert ("at least" in goal) == (0 < needed < count), "there is no more than all"
    assert "less than 1 second " in goal


def test_a_miss_keeps_the_number_of_choices() -> None:
    trial = Trial(situation(1), Stimulus("f", "f", "Press: f", choices=2), onset=0)
    result = make().timed_out(trial)
    assert (result.correct, result.response, result.value) == (False, None, None)
    assert result.details == {"choices": 2, "key_gap_ms": None}


RESULTS = st.lists(
    st.builds(
        Result,
        correct=st.booleans(),
        value=st.one_of(st.none(), st.floats(0, 5000)),
        flags=st.sampled_from([(), ("anticipation",), ("paste",)]),
    ),
    min_size=1,
    max_size=30,
)


@given(RESULTS)
def test_the_score_is_the_mean_reaction_time_and_the_accuracy(results: list[Result]) -> None:
    score = make().score(results)
    counting = [r for r in results if r.correct and "anticipation" not in r.flags]
    good = [r.value for r in counting if r.value is not None]
    right = sum(r.correct for r in results)
    assert score.metric == (pytest.approx(sum(good) / len(good)) if good else None)
    assert (score.correct, score.trials) == (right, len(results))
    assert score.accuracy == right / len(results)


@given(st.sampled_from("asdfjkl;1A?"), st.integers(0, 500))
def test_a_slip_is_never_the_right_key(expected: str, seed: int) -> None:
    stimulus = Stimulus(expected, expected, f"Press: {expected}")
    ((at, key),) = make().rehearse(stimulus, Performance(400.0, slips=True), RandomStreams(seed))
    assert at == 400.0
    assert key.casefold() != expected.casefold()
    assert make().rehearse(stimulus, Performance(400.0), RandomStreams(seed)) == [(400.0, expected)]


def test_the_default_parameters_are_those_of_the_thesis() -> None:
    it = make().parameters
    assert (it.prompts_per_attempt, it.attempts) == (20, 20)
    assert (it.threshold, it.neutral_band, it.min_accuracy) == (1000, 10, 0.8)
    assert (it.consecutive_successes, it.consecutive_failures) == (1, 1)
