"""Feedback texts have the right form, numbers and direction."""

from typing import Any
from unittest import mock

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from sar_tui.loop.phrase_keys import QUALITATIVE, QUANTITATIVE, holds_number
from sar_tui.loop.task import Task
from sar_tui.model.language import BUNDLED
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Metric
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.rules.real_change import Change
from tests.facts import each
from tests.lifting_task import Lift
from tests.loop.nodes.agent_driver import Agent, Spelled, spelled, spelling

CATALOGUE = Catalogue()
VOICES = [
    CATALOGUE.theme(name, language)
    for name in CATALOGUE.theme_names()
    for language in CATALOGUE.theme(name).languages
]
FORMS = ("qualitative", "quantitative", "both")
REFERENCES = ("last attempt", "best attempt", "session's mean", "goal")
CONTENTS = ("results", "performance", "both")
REMARK = "Please wait for the signal before you lift."


class Reps(Lift):
    """The same task with a metric that is counted: higher is better, fractions count."""

    name = "reps"
    metric = Metric("reps", "reps", "higher", improved="more", worsened="fewer", decimals=1)


LIFTS = st.fixed_dictionaries(
    {
        "metric": st.one_of(
            st.none(), st.floats(150, 3000), st.sampled_from([990.0, 1000.0, 1010.0])
        ),
        "level": st.integers(1, 3),
        "correct": st.integers(10, 20),
        "remark": st.sampled_from(["", REMARK]),
        "sums_up": st.sampled_from([1, 1, 1, 4]),
        "reached": st.integers(0, 4),
        "practice": st.booleans(),
    },
    optional={"sway": st.floats(0, 50), "grip": st.floats(0, 99)},
)
REAL = Change(0.0, 0.0, "better")
SESSIONS = st.lists(LIFTS, min_size=1, max_size=12)


def lift(**fields: object) -> dict[str, Any]:
    """Return an attempt that reached its goal."""
    return {"metric": 900.0, "level": 1, "correct": 20, **fields}


# --- the form


@given(
    SESSIONS,
    st.sampled_from(VOICES),
    st.sampled_from(REFERENCES),
    st.sampled_from(CONTENTS),
    st.sampled_from([{}, {"1": 700.0, "2": 400.0}]),
    st.integers(0, 1000),
)
def test_qualitative_feedback_has_no_number_and_quantitative_always_one(
    attempts: list[dict[str, Any]],
    theme: Theme,
    reference: str,
    about: str,
    best: dict[str, float],
    seed: int,
) -> None:
    agents = {
        form: Agent(Lift, theme, form, seed, best, about=about, feedback_compared_with=reference)
        for form in FORMS
    }
    for attempt in attempts:
        said = {form: agent.feedback_on(**attempt) for form, agent in agents.items()}
        assert not holds_number(said["qualitative"], theme.language), said["qualitative"]
        assert any(character.isdigit() for character in said["quantitative"]), said["quantitative"]
        assert any(character.isdigit() for character in said["both"]), said["both"]
        assert all(text and "{" not in text for text in said.values())


@example([lift(sway=0.0), lift(sway=40.0)], "last attempt", "both").via(
    "no previous value to compute a percentage from"
)
@given(SESSIONS, st.sampled_from(REFERENCES), st.sampled_from(CONTENTS))
def test_the_form_both_gives_words_then_figures(
    attempts: list[dict[str, Any]], reference: str, about: str
) -> None:
    theme, compared = spelling(VOICES[0]), {"feedback_compared_with": reference}
    agents = {form: Agent(Lift, theme, form, about=about, **compared) for form in FORMS}
    for attempt in attempts:
        said = {
            form: each(spelled(agent.feedback_on(**attempt)), "situation")
            for form, agent in agents.items()
        }
        assert set(said["qualitative"]) <= set(QUALITATIVE)
        first, *more = said["quantitative"]
        assert first in QUANTITATIVE
        assert set(more) <= {*QUANTITATIVE, *said["qualitative"]}, (
            "words if the change has no percentage"
        )
        assert said["both"][-len(said["quantitative"]) :] == said["quantitative"]
        assert set(said["both"]) <= {*said["qualitative"], *said["quantitative"]}


# --- the right number, in the right direction


def figures(
    task: type[Task],
    attempts: list[tuple[float, int]],
    reference: str,
    best: dict[str, float] | None = None,
    **parameters: object,
) -> list[Spelled]:
    """Return the figures in the feedback on each of successive attempts, of which each change is
    told; test_feedback_on_change.py has which are.
    """
    voice, compared = spelling(VOICES[0]), {"feedback_compared_with": reference, **parameters}
    agent = Agent(task, voice, "quantitative", 1, best, **compared)
    with mock.patch("sar_tui.loop.feedback_text.judge_result", return_value=REAL):
        return [spelled(agent.feedback_on(metric, level))[0] for metric, level in attempts]


RESULTS = st.lists(st.tuples(st.floats(1, 3000), st.integers(1, 2)), min_size=1, max_size=12)


def shown(metric: Metric, value: float, decimals: int = 2) -> str:
    """Return a result as it is shown: a time in seconds."""
    return metric.show(value) if metric.unit != "ms" else f"{value / 1000:.{decimals}f} seconds"


def difference(metric: Metric, value: float, against: float, decimals: int) -> str:
    """Return the difference of two results as they are shown."""
    if metric.unit != "ms":
        return shown(metric, abs(round(value, metric.decimals) - round(against, metric.decimals)))
    return shown(
        metric,
        1000 * abs(round(value / 1000, decimals) - round(against / 1000, decimals)),
        decimals,
    )


@pytest.mark.parametrize("task", [Lift, Reps])
@pytest.mark.parametrize("reference", REFERENCES)
@given(attempts=RESULTS, best=st.dictionaries(st.sampled_from(["1", "2"]), st.floats(1, 3000)))
def test_an_attempt_is_compared_with_the_configured_reference_at_its_level(
    task: type[Task], reference: str, attempts: list[tuple[float, int]], best: dict[str, float]
) -> None:
    goal_texts = (
        {1: "1 second", 2: "1.1 seconds"} if task is Lift else {1: "1000.0 reps", 2: "1100.0 reps"}
    )
    words = dict(
        zip(REFERENCES, ("last time", "your best", "your average today", "the goal"), strict=True)
    )
    metric = task.metric
    goals = {1: 1000.0, 2: 1100.0}
    before: dict[int, list[float]] = {1: [], 2: []}
    levels = [0, *(level for _, level in attempts)]
    found = figures(task, attempts, reference, best)
    for (value, level), last, (situation, slots) in zip(attempts, levels, found, strict=False):
        words["last attempt"] = "last time" if level == last else "last time at this level"
        known = before[level]
        close = round(value / 1000, 2) == goals[level] / 1000 and value != goals[level]
        decimals = 3 if close else 2
        with_earlier = [*known, *([best[str(level)]] if str(level) in best else [])]
        against = {
            "last attempt": known[-1] if known else None,
            "best attempt": (min if metric.better == "lower" else max)(with_earlier, default=None),
            "session's mean": sum(known) / len(known) if known else None,
            "goal": goals[level],
        }[reference]
        if against is None:
            assert situation.endswith("_first")
            expected = (shown(metric, value, decimals), goal_texts[level])
            assert (slots["value"], slots["goal"]) == expected
        elif (apart := difference(metric, value, against, decimals)) == shown(
            metric, 0.0, decimals
        ):
            assert situation.endswith("_same")
            assert slots["reference"] == words[reference]
        else:
            better = value < against if task is Lift else value > against
            assert situation.endswith("_improved" if better else "_worsened")
            assert slots["difference"] == apart
            assert slots["change"] == (metric.improved if better else metric.worsened)
            expected = (words[reference], shown(metric, value, decimals))
            assert (slots["reference"], slots["value"]) == expected
        known.append(value)


@pytest.mark.parametrize(
    ("task", "metric", "text"), [(Reps, 1234.5, "1234,5 reps"), (Lift, 412.0, "0,41 segundos")]
)
def test_figures_are_written_as_the_language_writes_them(
    task: type[Task], metric: float, text: str
) -> None:
    theme = spelling(CATALOGUE.theme("calm", "es"))
    (found,) = spelled(Agent(task, theme).feedback_on(metric))
    assert found.slots["value"] == text


# --- where there is nothing to compare


WITHOUT_RESULT = pytest.mark.parametrize(
    ("metric", "correct", "situation"), [(500.0, 12, "accuracy"), (None, 18, "empty")]
)


@WITHOUT_RESULT
def test_an_attempt_without_a_result_reports_the_correct_trials(
    metric: float | None, correct: int, situation: str
) -> None:
    agent = Agent(Lift, spelling(VOICES[0]), "both", about="both")
    agent.feedback_on(800, sway=1.0)
    words, found = spelled(agent.feedback_on(metric, correct=correct, sway=9.0))
    assert words == (situation, {})
    assert found == (f"{situation}_figures", {"correct": str(correct), "trials": "20"})


@WITHOUT_RESULT
def test_the_tasks_remark_replaces_the_words_but_not_the_figures(
    metric: float | None, correct: int, situation: str
) -> None:
    said = {
        form: Agent(Lift, spelling(VOICES[0]), form).feedback_on(
            metric, correct=correct, remark=REMARK
        )
        for form in FORMS
    }
    assert said["qualitative"] == REMARK
    assert [part.situation for part in spelled(said["quantitative"])] == [f"{situation}_figures"]
    assert said["both"] == f"{REMARK} {said['quantitative']}"


def test_unanswered_prompts_are_answered_with_the_tasks_advice_alone() -> None:
    advice = "Lift your arm as soon as you hear the signal."
    agent = Agent(Lift, spelling(VOICES[0]), "both")
    (words,) = spelled(agent.feedback_on(None, correct=18, advice=advice))
    assert words == ("unanswered", {"advice": advice})
    remarked = Agent(Lift, VOICES[0], "qualitative")
    both = remarked.feedback_on(None, correct=18, advice=advice, remark=REMARK)
    assert both == REMARK, "the task's own remark on what went wrong says more"


@pytest.mark.parametrize(
    ("metric", "text"),
    [(412.4, "0.41 seconds"), (1000.0, "1.00 seconds"), (996.0, "0.996 seconds")],
)
def test_times_are_in_seconds_and_never_look_like_a_goal_that_they_are_not(
    metric: float, text: str
) -> None:
    (found,) = spelled(Agent(Lift, spelling(VOICES[0])).feedback_on(metric))
    assert (found.slots["value"], found.slots["goal"]) == (text, "1 second")


# --- a summary


@pytest.mark.parametrize(
    ("metric", "valence"), [(500.0, "positive"), (1005.0, "neutral"), (1500.0, "negative")]
)
def test_a_summary_reports_goals_reached_and_means(metric: float, valence: str) -> None:
    agent = Agent(Lift, spelling(VOICES[0]), "both", about="both")
    agent.feedback_on(400, sway=3.0)
    words, found = spelled(agent.feedback_on(metric, sums_up=5, reached=3, sway=9.0))
    assert words.situation == f"summary_{valence}"
    assert found == (
        "summary_figures",
        {
            "reached": "3",
            "attempts": "5",
            "value": shown(Lift.metric, metric, 3 if metric == 1005 else 2),
            "goal": "1 second",
        },
    )


def test_a_summary_without_times_gives_counts_only() -> None:
    agent = Agent(Lift, spelling(VOICES[0]), "both")
    words, found = spelled(agent.feedback_on(None, sums_up=5, reached=0))
    assert words.situation == "summary_negative"
    assert found == ("summary_empty_figures", {"reached": "0", "attempts": "5"})


# --- texts of tasks


@pytest.mark.parametrize("language", BUNDLED)
@pytest.mark.parametrize("name", CATALOGUE.task_names())
def test_text_that_a_task_adds_holds_no_number(name: str, language: str) -> None:
    kind = CATALOGUE.task(name)
    task = kind(build(kind.Parameters, {"language": language}))
    changes = [*each(task.qualities, "improved"), task.metric.improved, task.metric.worsened]
    added = [
        *changes,
        *(quality.aim for quality in task.qualities),
        *(mark.remark for mark in task.marks),
    ]
    said = [*map(task.tr, added), task.when_to_respond()]
    assert [text for text in said if holds_number(text, language)] == []
