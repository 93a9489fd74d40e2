"""`sar-tui tasks check` draws a task's view, and names what is wrong with it in one sentence."""

from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.checks.task_view import contract_problem, drawing_problem
from sar_tui.loop.bus import Record
from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue, load_task
from sar_tui.rules.parameters import TaskParameters, build
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.program import Call
from tests.sides_task import VIEW, write_sides

SEED = 3
BROKEN = {
    "It cannot be set up (RuntimeError: )": ("self.trials = 0", "raise RuntimeError"),
    "Its prompt_lines failed (ValueError: no line of the prompt holds its text, ":
        ("{prompt.text}", "your prompt"),
    "Its prompt_lines failed (TypeError: 'int' object is not iterable).": ("return [(f", "return 3 #"),
    "Its prompt_lines returned 1 lines of up to 90 characters, where there is":
        ("so far)", 'so far)" * 9 + "'),
    "Its handler of event_handler/trial failed (AttributeError: ":
        ("self.trials += 1", "self.trial += 1"),
    "Its between_attempts failed (RuntimeError": ("return lambda", "raise RuntimeError\n        return lambda"),
    "The drawing of its between_attempts failed (KeyError: 'no col": ('colors["accent"]', 'colors["no colour"]'),
    "Its facts failed (NameError: name 'attempt' is not defined)": ("for a in attempts", "for a in attempt"),
    "Its facts failed (Ty":
        ('return [f"The view counts {sum(a.trials for a in attempts)}."]', 'return "Good."'),
}  # fmt: skip
"""Sentences of the check, each with the replacement in the view that causes it."""


def settings(task: type[Task]) -> TaskParameters:
    return build(task.Parameters, {"attempts": 2})


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> list[Record]:
    """The messages of a simulated session of the task."""
    folder = tmp_path_factory.mktemp("sides")
    catalogue = Catalogue(tasks=(write_sides(folder / "mine").parent,))
    how = {"theme": "calm", "seed": SEED, "mode": "simulated"}
    plan = make_plan(catalogue, "sides", ["SIM"], {"attempts": 2}, **how)
    session = simulate(plan, PEOPLE["poor"], folder / "data", catalogue)
    with closing(connect(folder / "data")) as database:
        return list(sessions.history(database, session))


def test_a_view_that_keeps_the_contract_passes(
    tmp_path: Path, history: list[Record], calm: Theme
) -> None:
    task = load_task(write_sides(tmp_path, VIEW))
    assert contract_problem(task) == ""
    assert drawing_problem(task(settings(task)), calm, SEED, history) == ""


CLASS = "class SidesView(TaskView):"
AGAINST = [
    ("import no_such_library", "cannot be loaded: view.py:1: ModuleNotFoundError: No module"),
    (
        "from sar_tui.widgets.no_such_module import draw",
        "cannot be loaded: view.py:1: No module named 'sar_tui.widgets.no_such_module'.",
    ),
    (VIEW.replace(CLASS, "class SidesView:"), "must define one TaskView; it defines 0."),
    (
        VIEW.replace(CLASS, f"{CLASS}\n    emits = (TRIAL,)"),
        "The view may only listen, but it declares event_handler/trial.",
    ),
    (
        VIEW.replace("def facts(cls, attempts, metric, tr)", "def findings(cls, attempts)"),
        "view.py:28: findings() takes (attempts, metric), found (attempts).",
    ),
]


@pytest.mark.parametrize(
    ("broken", "says"),
    AGAINST,
    ids=["missing library", "missing module", "no view", "a view that emits", "arguments"],
)
def test_a_view_against_the_contract_is_named(tmp_path: Path, broken: str, says: str) -> None:
    assert says in contract_problem(load_task(write_sides(tmp_path, broken)))


@pytest.mark.parametrize(("says", "replacement"), BROKEN.items())
def test_a_view_that_fails_to_draw_is_named(
    tmp_path: Path, history: list[Record], calm: Theme, says: str, replacement: tuple[str, str]
) -> None:
    assert replacement[0] in VIEW
    task = load_task(write_sides(tmp_path, VIEW.replace(*replacement)))
    assert says in drawing_problem(task(settings(task)), calm, SEED, history)


def test_the_command_says_what_is_wrong_with_a_view(tmp_path: Path, call: Call) -> None:
    folder = write_sides(tmp_path, VIEW.replace("{prompt.text}", "your prompt"))
    said = "✗ draws its view in a whole session. Its prompt_lines failed (ValueError: no line of"
    call("tasks check", folder).shows(said, code=1)
