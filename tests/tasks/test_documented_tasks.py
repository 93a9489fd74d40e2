"""The tasks of docs/write-your-own-task.md run from the page's own code: simulated, and replayed as
they were.
"""

import textwrap
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any, NamedTuple

import pytest

from sar_tui.checks.task import check
from sar_tui.export.damage import Damage
from sar_tui.export.tables.results import trials
from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    KEY,
    PROMPT,
    STEP_ENDED,
    TRIAL,
    TRIAL_FEEDBACK,
    TRIAL_FEEDBACK_SHOWN,
    TYPED,
)
from sar_tui.model import trial_types
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import ParameterError, build
from sar_tui.rules.staircase import Staircase
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.documented import FILES, FRAGMENTS, TASKS, write_documented

SEED = 3
NODES = {"slider": ("task", "view"), "twist": ("task", "twists")}
"""Files of tasks that have more than one."""


class Played(NamedTuple):
    """A simulated session of a task: its messages, attempts and trials."""

    history: list[Record]
    attempts: list[sessions.Row]
    trials: list[sessions.Row]

    def all(self, topic: Any) -> list[Any]:
        return [record.message for record in self.history if record.topic is topic]


def documented(folder: Path, name: str) -> Catalogue:
    """The task of this name, written from the page into a folder of tasks."""
    write_documented(folder, name)
    return Catalogue(tasks=(folder,))


def play(tmp_path: Path, name: str, parameters: Mapping[str, object] = {}) -> Played:
    """Simulate an average person at a task of the page; the session replays identically."""
    catalogue = documented(tmp_path / "mytasks", name)
    kind = catalogue.task(name)
    values = {"attempts": 3, **parameters}
    plan = make_plan(catalogue, kind, ["P01"], values, theme="calm", seed=SEED, mode="simulated")
    session = simulate(plan, PEOPLE["average"], tmp_path / "data", catalogue)
    with closing(connect(tmp_path / "data")) as database:
        played = Played(
            list(sessions.history(database, session)),
            sessions.rows(database, "attempts", session),
            sessions.rows(database, "trials", session),
        )
    task = plan.task(plan.parameters)
    Session(task, catalogue.theme("calm"), VirtualClock(), SEED).replay(played.history)
    return played


def test_a_staircase_within_an_attempt(tmp_path: Path) -> None:
    played = play(tmp_path, "larger")
    first = [int(prompt.stimulus) for prompt in played.all(PROMPT) if prompt.attempt == 1]
    answers = [trial["correct"] for trial in played.trials if trial["attempt"] == 1]
    assert len(first) == 30
    expected = Staircase(start=24, steps=(8, 4, 2, 1), lowest=1, highest=40).track(answers)
    assert first == [round(value) for value in expected.values]
    assert [attempt["metric"] for attempt in played.attempts if attempt["metric"] is None] == []


def test_points_after_each_choice_of_a_tree_that_reverses(tmp_path: Path) -> None:
    played = play(tmp_path, "harvest")
    shown = played.all(TRIAL_FEEDBACK)
    answered = [trial for trial in played.all(TRIAL) if trial.response]
    assert {each.text for each in shown} == {"+10", "0"}
    assert [int(each.text) for each in shown if each.text != "0"] == [
        trial.value for trial in answered if trial.value
    ]
    good = [trial["stimulus"] for trial in played.trials if trial["attempt"] == 1]
    assert set(good) == {"left", "right"}
    assert len(played.all(TRIAL_FEEDBACK_SHOWN)) == len(shown)


def test_questions_between_attempts_are_answered(tmp_path: Path) -> None:
    played = play(tmp_path, "effort")
    asked = played.all(STEP_ENDED)
    assert [(each.attempt, each.name) for each in asked] == [
        (0, "read"), (1, "effort"), (2, "effort"), (3, "effort"), (3, "fun"),
    ]  # fmt: skip
    with closing(connect(tmp_path / "data")) as database:
        stored = sessions.rows(database, "answers", played.trials[0]["session"])
    assert [row["answer"] for row in stored] == [each.answer for each in asked]


def test_digits_are_typed_and_timed_from_their_first_key(tmp_path: Path) -> None:
    played = play(tmp_path, "digitspan")
    right = [trial for trial in played.trials if trial["correct"]]
    assert right
    assert all(trial["response"] == trial["stimulus"] for trial in right)
    assert all(
        len(trial["response"]) < len(trial["stimulus"])
        for trial in played.trials
        if trial not in right
    )
    typing_ms = (right[0]["response_ns"] - right[0]["onset_ns"]) / 1e6
    assert typing_ms == 250 * len(right[0]["response"])
    assert right[0]["response"] in [echoed.text for echoed in played.all(TYPED)]


def test_flankers_keep_their_congruency_with_each_trial(tmp_path: Path) -> None:
    played = play(tmp_path, "flankers")
    kept = [trial["data"]["congruent"] for trial in played.trials]
    assert kept == [prompt.data["congruent"] for prompt in played.all(PROMPT)]
    assert kept == [trial["stimulus"][0] == trial["stimulus"][2] for trial in played.trials]
    orders = [
        [trial["stimulus"] for trial in played.trials if trial["attempt"] == attempt]
        for attempt in (1, 2)
    ]
    assert [{row: order.count(row) for row in order} for order in orders] == [
        dict.fromkeys(set(orders[0]), 5)
    ] * 2
    assert orders[0] != orders[1]
    with closing(connect(tmp_path / "data")) as database:
        session = played.trials[0]["session"]
        table = trials(database, [session], {}, Damage(database, lambda _: None))
        rows = list(table.rows(database, session))
    (place,) = (
        number for number, column in enumerate(table.columns) if column.name == "data_congruent"
    )
    assert [row[place] for row in rows] == kept
    assert table.columns[place].treatment == "open"


def test_two_back_in_one_stream(tmp_path: Path) -> None:
    played = play(tmp_path, "twoback")
    prompts = [prompt for prompt in played.all(PROMPT) if prompt.attempt == 2]
    letters = [prompt.stimulus for prompt in prompts]
    targets = [bool(prompt.expected) for prompt in prompts]
    assert targets == [
        place > 1 and letter == letters[place - 2] for place, letter in enumerate(letters)
    ]
    assert any(targets)
    assert [attempt["trials"] for attempt in played.attempts] == [20, 20, 20]
    keys = [pressed.key for pressed in played.all(KEY)]
    assert keys.count("enter") == 3, "for the instructions, the first attempt, and the end"


def test_hands_that_take_turns_are_conditions(tmp_path: Path) -> None:
    played = play(tmp_path, "twohands", {"attempts": 4})
    conditions = [attempt["condition"] for attempt in played.attempts]
    assert conditions in (["left", "right"] * 2, ["right", "left"] * 2)
    keys = {"left": "asdf", "right": "jkl;"}
    for prompt in played.all(PROMPT):
        assert prompt.stimulus in keys[conditions[prompt.attempt - 1]]
    measured = [set(attempt["qualities"]) for attempt in played.attempts]
    assert measured == [set(), *[{"slower_than_other_hand_ms"}] * 3]


@pytest.mark.slow
# its pictures are not on the page
@pytest.mark.parametrize("name", [name for name in TASKS if name != "naming"])
def test_each_task_of_the_page_passes_the_check(tmp_path: Path, name: str) -> None:
    task = write_documented(tmp_path, name, *NODES.get(name, ()))
    if (name, "words.es.toml") in FILES:
        (task / "words.es.toml").write_text(FILES[name, "words.es.toml"], encoding="utf-8")
    assert [each.problems for each in check(task) if each.problems] == []


@pytest.mark.parametrize("name", ["choice", "masked", "speed", "stroop"])
def test_a_task_of_one_need_runs(tmp_path: Path, name: str) -> None:
    played = play(tmp_path, name, {"attempts": 2})
    assert fmean(trial["correct"] for trial in played.trials) > 0.7
    assert [attempt["metric"] for attempt in played.attempts if attempt["metric"] is None] == []


def test_a_sign_on_its_own_side_is_answered_sooner(tmp_path: Path) -> None:
    played = play(tmp_path, "simon", {"attempts": 4})
    for trial in played.trials:
        assert trial["details"]["agrees"] == (
            trial["stimulus"].split()[0] == trial["stimulus"].split()[-1]
        )
    assert fmean(attempt["qualities"]["simon_ms"] for attempt in played.attempts) > 0


def test_two_people_answer_each_their_own_sign(tmp_path: Path) -> None:
    played = play(tmp_path, "joint", {"attempts": 2})
    assert {trial["seat"] for trial in played.trials} == {"A", "B"}
    assert all(
        trial["stimulus"][0] == {"A": "●", "B": "■"}[trial["seat"]] for trial in played.trials
    )


def test_settings_that_conflict_are_named(tmp_path: Path) -> None:
    speed = documented(tmp_path, "speed").task("speed")
    with pytest.raises(ParameterError, match="too many for a day"):
        build(speed.Parameters, {"prompts_per_attempt": 30, "attempts": 60})


def test_the_documented_test_passes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_documented(tmp_path / "mytasks", "speed")
    monkeypatch.chdir(tmp_path)
    (source,) = (fragment for fragment in FRAGMENTS if "def judge" in fragment)
    names: dict[str, Any] = {}
    exec(source, names)
    names["test_the_expected_key_is_right"]()


@pytest.mark.parametrize("fragment", [each for each in FRAGMENTS if "def test_" not in each])
def test_each_part_of_a_task_on_the_pages_can_be_declared(fragment: str) -> None:
    """A fragment stands inside a class, or beside it."""
    names: dict[str, Any] = dict(vars(trial_types)) | {"Annotated": Annotated, "Task": Task}
    names["TurnParameters"] = Task.Parameters
    body = textwrap.indent(textwrap.dedent(fragment), "    ")
    exec(fragment if fragment.startswith("class") else f"class Fragment(Task):\n{body}", names)
