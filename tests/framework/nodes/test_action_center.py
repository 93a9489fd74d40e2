"""Given an attempt and what memory holds, when feedback is due, then the agent's words fit both."""

import re
from collections.abc import Iterator
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework.bus import Bus, Topic
from sar_tui.framework.clock import VirtualClock
from sar_tui.framework.messages import AttemptEnded, Feedback, Message, Proposal
from sar_tui.framework.node import Node, on
from sar_tui.framework.nodes.action_center import ActionCenter
from sar_tui.framework.nodes.memory import Memory
from sar_tui.framework.parameters import build
from sar_tui.framework.policies import feedback
from sar_tui.framework.task import Score, Task
from sar_tui.framework.theme import QUALITATIVE, QUANTITATIVE, Theme, holds_number
from sar_tui.framework.topics import ATTEMPT_ENDED, FEEDBACK, PROPOSED
from sar_tui.plugins import Catalogue
from tests.lifting import Lift

THEMES = ("calm", "high-contrast")
FORMS = ("qualitative", "quantitative", "both")

PRAISE = (
    r"well done|very good|excellent|good work|great|goal reached|reached the goal|inside the goal|congratul|perfect"
)
BLAME = r"\bnot\b|\bmissed\b|\bfail|\boff\b|\btry\b|\btrying\b|\bnearly\b|\byet\b|\bhard\b|\bbut\b|\bunfortunately\b"


class Done(Message, frozen=True, kw_only=True):
    """An attempt, as if a task had just ended it."""

    attempt: int
    level: int
    metric: float | None
    correct: int = 20
    trials: int = 20
    practice: bool = False
    qualities: dict[str, float] = {}


DONE = Topic("test/done", Done, origin="input")


class Judge(Node):
    """Stands in for the event handler: attempt first, feedback after it."""

    name = "judge"
    emits = (ATTEMPT_ENDED, FEEDBACK)

    def __init__(self, task: Task) -> None:
        super().__init__()
        self.task = task

    @on(DONE)
    def done(self, done: Done) -> None:
        accuracy = done.correct / done.trials
        score = Score(done.metric, accuracy, done.correct, done.trials)
        verdict = feedback.judge(score, self.task.metric, self.task.target(done.level), 0.8)
        facts = {"attempt": done.attempt, "level": done.level, "metric": done.metric, "accuracy": accuracy}
        counts = {"correct": done.correct, "trials": done.trials, "qualities": done.qualities}
        self.emit(
            ATTEMPT_ENDED,
            AttemptEnded(
                **facts,
                **counts,
                practice=done.practice,
                metric_unit="ms",
                outcome=verdict.outcome,
                feedback=verdict.valence,
                started=0,
                ended=0,
            ),
        )
        self.emit(FEEDBACK, Feedback(**facts, **counts, goal=1000.0, valence=verdict.valence, reason=verdict.reason))


class Agent:
    """Memory and action center, told of attempts one after the other."""

    def __init__(
        self, task: type[Task], theme: Theme, form: str = "quantitative", seed: int = 1, **parameters: object
    ) -> None:
        built = task(build(task.Parameters, {"feedback_form": form, **parameters}))
        self.bus = Bus(VirtualClock())
        self.count = 0
        self.said: list[Proposal] = []
        for node in (Memory(), Judge(built), ActionCenter(built, theme, seed)):
            node.attach(self.bus)
        self.bus.subscribe(PROPOSED, self.said.append)

    def hears_of(
        self,
        metric: float | None,
        level: int = 1,
        correct: int = 20,
        practice: bool = False,
        **qualities: float,
    ) -> str:
        self.count += 1
        told = {"level": level, "metric": metric, "correct": correct, "practice": practice, "qualities": qualities}
        self.bus.publish(DONE, Done(attempt=self.count, **told))
        return self.said[-1].text


@pytest.fixture
def agent(keyboard: type[Task], calm: Theme) -> Agent:
    return Agent(keyboard, calm)


def every_wording(catalogue: Catalogue) -> Iterator[tuple[str, str]]:
    for name in catalogue.theme_names():
        for situation, wordings in catalogue.theme(name).phrases.items():
            for wording in wordings:
                yield situation, wording


def test_the_first_attempt_gives_the_result_and_the_goal(agent: Agent) -> None:
    said = agent.hears_of(812.4)
    assert "812 ms" in said
    assert "1000 ms" in said
    assert "last time" not in said


def test_a_later_attempt_is_compared_with_the_last_at_that_level(agent: Agent) -> None:
    agent.hears_of(812)
    assert "32 ms faster than last time" in agent.hears_of(780)
    assert "50 ms slower than last time" in agent.hears_of(830)


def test_the_first_attempt_at_a_new_level_gives_the_result_and_the_goal_again(agent: Agent) -> None:
    agent.hears_of(812, level=1)
    said = agent.hears_of(900, level=2)
    assert "900 ms" in said
    assert "1000 ms" in said
    assert "last time" not in said


def test_back_at_a_level_the_last_attempt_there_is_what_is_compared_with(agent: Agent) -> None:
    agent.hears_of(800, level=1)
    agent.hears_of(700, level=1)
    agent.hears_of(1200, level=2)
    assert "60 ms faster than last time" in agent.hears_of(640, level=1)


def test_practice_is_never_compared_with(agent: Agent) -> None:
    agent.hears_of(600, practice=True)
    assert "last time" not in agent.hears_of(700)


def test_an_attempt_without_a_result_is_passed_over(agent: Agent) -> None:
    agent.hears_of(800)
    agent.hears_of(None, correct=20)
    assert "100 ms faster" in agent.hears_of(700)


def test_no_difference_that_can_be_seen_is_none(agent: Agent) -> None:
    agent.hears_of(800.0)
    assert "the same as last time" in agent.hears_of(800.4)


def test_low_accuracy_is_named_with_its_figures(agent: Agent, keyboard: type[Task], calm: Theme) -> None:
    said = agent.hears_of(500, correct=12)
    assert "accuracy" in said.lower()
    assert "12 of 20" in said
    assert "accuracy" in Agent(keyboard, calm, "qualitative").hears_of(500, correct=12).lower()
    assert agent.said[-1].valence == "negative"


def test_the_words_given_are_those_of_the_form(keyboard: type[Task], calm: Theme) -> None:
    qualitative, quantitative, both = (Agent(keyboard, calm, form).hears_of(700) for form in FORMS)
    assert qualitative in calm.phrases["positive"]
    assert "700 ms" in quantitative
    assert any(both.startswith(wording) for wording in calm.phrases["positive"])
    assert "700 ms" in both


ATTEMPTS = st.lists(
    st.tuples(
        st.one_of(st.none(), st.floats(150, 3000), st.sampled_from([990.0, 1000.0, 1010.0])),
        st.integers(1, 3),
        st.integers(0, 20),
    ),
    min_size=1,
    max_size=15,
)


@given(ATTEMPTS, st.sampled_from(THEMES), st.integers(0, 1000))
def test_qualitative_feedback_never_holds_a_number(
    catalogue: Catalogue, attempts: list[tuple[float | None, int, int]], theme: str, seed: int
) -> None:
    agent = Agent(catalogue.task("keyboard"), catalogue.theme(theme), "qualitative", seed)
    for metric, level, correct in attempts:
        assert not holds_number(agent.hears_of(metric, level, correct))


@given(ATTEMPTS, st.sampled_from(THEMES), st.integers(0, 1000))
def test_quantitative_feedback_always_gives_a_figure_and_compares_rightly(
    catalogue: Catalogue, attempts: list[tuple[float | None, int, int]], theme: str, seed: int
) -> None:
    agent = Agent(catalogue.task("keyboard"), catalogue.theme(theme), "quantitative", seed)
    last: dict[int, float] = {}
    for metric, level, correct in attempts:
        said = agent.hears_of(metric, level, correct)
        assert re.search(r"\d", said)
        if metric is not None and correct >= 16:
            before = last.get(level)
            change = None if before is None else f"{abs(metric - before):.0f}"
            if before is None:
                assert f"{metric:.0f} ms" in said
                assert "last time" not in said
            elif change == "0":
                assert "the same as last time" in said
            else:
                assert f"{change} ms {'faster' if metric < before else 'slower'} than last time" in said
        if metric is not None:
            last[level] = metric


@given(ATTEMPTS, st.sampled_from(THEMES), st.integers(0, 1000))
def test_nothing_is_said_twice_running_where_there_is_a_choice(
    catalogue: Catalogue, attempts: list[tuple[float | None, int, int]], theme: str, seed: int
) -> None:
    look = catalogue.theme(theme)
    agent = Agent(catalogue.task("keyboard"), look, "qualitative", seed)
    said = [agent.hears_of(metric, level, correct) for metric, level, correct in attempts]
    for situation in QUALITATIVE:
        spoken = [words for words in said if words in look.phrases[situation]]
        assert len(look.phrases[situation]) == 1 or all(one != other for one, other in pairwise(spoken))


@given(st.integers(0, 1000))
def test_figures_too_are_not_given_in_the_same_words_twice_running(catalogue: Catalogue, seed: int) -> None:
    agent = Agent(catalogue.task("keyboard"), catalogue.theme("calm"), "quantitative", seed)
    said = [agent.hears_of(700, level) for level in range(1, 9)]
    assert all(one != other for one, other in pairwise(said))


@pytest.mark.parametrize(("form", "situation"), [("qualitative", "positive"), ("quantitative", "positive_first")])
def test_every_wording_gets_its_turn(keyboard: type[Task], calm: Theme, form: str, situation: str) -> None:
    said = {Agent(keyboard, calm, form, seed).hears_of(700) for seed in range(30)}
    assert said == {wording.format(value="700 ms", goal="1000 ms") for wording in calm.phrases[situation]}


def test_the_same_seed_says_the_same(keyboard: type[Task], calm: Theme) -> None:
    def session() -> list[str]:
        agent = Agent(keyboard, calm, "both", seed=9)
        return [agent.hears_of(700 + 10 * attempt) for attempt in range(10)]

    assert session() == session()


def test_words_of_praise_are_for_success_and_words_of_trying_again_for_failure(catalogue: Catalogue) -> None:
    for situation, wording in every_wording(catalogue):
        if situation.startswith("positive"):
            assert not re.search(BLAME, wording.lower()), wording
        if situation.startswith(("negative", "accuracy", "empty")):
            assert not re.search(PRAISE, wording.lower()), wording
        if situation.startswith("neutral"):
            assert not re.search(f"{PRAISE}|{BLAME}", wording.lower()), wording


def test_figures_that_point_the_other_way_are_put_right_in_the_same_breath(catalogue: Catalogue) -> None:
    """Slower, yet a success; faster, yet a failure: the words say which it is."""
    for situation, wording in every_wording(catalogue):
        if situation == "positive_worsened":
            assert re.search(PRAISE, wording.lower()), wording
        if situation == "negative_improved":
            assert "goal" in wording.lower(), wording
            assert re.search(r"\bnot\b", wording.lower()), wording
        if situation in QUANTITATIVE and situation.endswith(("_improved", "_worsened")):
            assert "{difference} {change} than last time" in wording, wording


def test_the_face_goes_with_the_valence(agent: Agent) -> None:
    for metric in (700.0, 1005.0, 1500.0):
        agent.hears_of(metric)
    assert [(said.valence, said.face) for said in agent.said] == [
        ("positive", "happy"),
        ("neutral", "neutral"),
        ("negative", "encouraging"),
    ]


# --- knowledge of performance: how it was done ---------------------------------------------------------------


def watcher(theme: Theme, form: str = "both", about: str = "performance", seed: int = 1) -> Agent:
    """An agent that answers how a weight was lifted: its sway matters in steps of 2, its grip in steps of 5."""
    return Agent(Lift, theme, form, seed, about=about)


def spoken(theme: Theme, situation: str, words: str) -> set[str]:
    return {wording.format(aim=words, change=words) for wording in theme.phrases[situation]}


def ends_with_one_of(said: str, wordings: set[str]) -> bool:
    return any(said.endswith(wording) for wording in wordings)


def test_the_first_time_the_agent_says_what_to_heed(calm: Theme) -> None:
    said = watcher(calm).hears_of(900, sway=10.0, grip=50.0)
    assert ends_with_one_of(said, spoken(calm, "performance_first", "with a steady arm"))


@pytest.mark.parametrize(
    ("sway", "grip", "situation", "words"),
    [
        (8.0, 50.0, "performance_improved", "steadier"),
        (8.1, 50.0, "performance_same", "with a steady arm"),
        (10.0, 55.0, "performance_improved", "firmer"),
        (12.0, 55.0, "performance_improved", "firmer"),
        (7.0, 56.0, "performance_improved", "steadier"),
        (7.0, 60.0, "performance_improved", "firmer"),
        (12.0, 50.0, "performance_worsened", "with a steady arm"),
        (10.0, 45.0, "performance_worsened", "with a firm grip"),
        (12.0, 40.0, "performance_worsened", "with a firm grip"),
        (11.9, 45.1, "performance_same", "with a steady arm"),
        (10.0, 50.0, "performance_same", "with a steady arm"),
    ],
)
def test_what_got_better_most_is_told_else_what_got_worse_most(
    calm: Theme, sway: float, grip: float, situation: str, words: str
) -> None:
    agent = watcher(calm)
    agent.hears_of(900, sway=10.0, grip=50.0)
    aims = {"with a steady arm", "with a firm grip"} if situation == "performance_same" else {words}
    wanted = {wording for aim in aims for wording in spoken(calm, situation, aim)}
    assert ends_with_one_of(agent.hears_of(900, sway=sway, grip=grip), wanted)


def test_only_attempts_alike_are_compared_in_how_they_were_done(calm: Theme) -> None:
    """A slower movement has more of everything: that is no worsening."""
    agent = watcher(calm)
    agent.hears_of(900, sway=10.0)
    slower = agent.hears_of(1200, sway=20.0)
    assert ends_with_one_of(slower, spoken(calm, "performance_first", "with a steady arm"))
    assert ends_with_one_of(agent.hears_of(950, sway=7.0), spoken(calm, "performance_improved", "steadier"))


def test_how_it_was_done_is_compared_with_the_last_time_at_that_level(calm: Theme) -> None:
    agent = watcher(calm)
    agent.hears_of(900, sway=10.0)
    first_there = agent.hears_of(900, level=2, sway=30.0)
    assert ends_with_one_of(first_there, spoken(calm, "performance_first", "with a steady arm"))
    assert ends_with_one_of(agent.hears_of(900, sway=7.0), spoken(calm, "performance_improved", "steadier"))
    assert ends_with_one_of(
        agent.hears_of(900, level=2, sway=40.0), spoken(calm, "performance_worsened", "with a steady arm")
    )


def test_how_practice_was_done_is_not_compared_with(calm: Theme) -> None:
    agent = watcher(calm)
    agent.hears_of(900, practice=True, sway=30.0)
    assert ends_with_one_of(agent.hears_of(900, sway=10.0), spoken(calm, "performance_first", "with a steady arm"))


def test_only_what_was_measured_both_times_is_compared(calm: Theme) -> None:
    agent = watcher(calm)
    agent.hears_of(900, sway=10.0)
    said = agent.hears_of(900, sway=10.5, grip=99.0)
    aims = ("with a steady arm", "with a firm grip")
    assert ends_with_one_of(said, {wording for aim in aims for wording in spoken(calm, "performance_same", aim)})
    assert ends_with_one_of(agent.hears_of(900, grip=50.0), spoken(calm, "performance_worsened", "with a firm grip"))


@pytest.mark.parametrize("form", FORMS)
def test_where_nothing_of_how_was_measured_the_result_is_told(calm: Theme, form: str) -> None:
    assert watcher(calm, form).hears_of(900) == watcher(calm, form, about="results").hears_of(900)


def test_what_is_told_is_what_the_task_asks_for(calm: Theme) -> None:
    """In figures where the result is told, and none where only the movement is."""
    said = {about: watcher(calm, "quantitative", about).hears_of(900, sway=1.0) for about in ("results", "both")}
    how = spoken(calm, "performance_first", "with a steady arm")
    assert "900 ms" in said["results"]
    assert not ends_with_one_of(said["results"], how)
    assert "900 ms" in said["both"]
    assert ends_with_one_of(said["both"], how)
    assert watcher(calm, "quantitative").hears_of(900, sway=1.0) in how


@pytest.mark.parametrize("about", ["performance", "both"])
def test_words_on_how_come_after_words_on_how_well_or_alone(calm: Theme, about: str) -> None:
    said = watcher(calm, "both", about).hears_of(900, sway=1.0)
    assert any(said.startswith(wording) for wording in calm.phrases["positive"]) == (about == "both")
    assert ends_with_one_of(said, spoken(calm, "performance_first", "with a steady arm"))
    assert ("900 ms" in said) == (about == "both")


@given(st.lists(st.tuples(st.floats(0, 50), st.floats(0, 99)), min_size=1, max_size=10), st.sampled_from(THEMES))
def test_words_on_how_hold_no_number_and_no_empty_slot(
    catalogue: Catalogue, lifts: list[tuple[float, float]], theme: str
) -> None:
    agent = watcher(catalogue.theme(theme), "qualitative")
    for sway, grip in lifts:
        said = agent.hears_of(900, sway=sway, grip=grip)
        assert not holds_number(said)
        assert not re.search(r"[{}]", said)
