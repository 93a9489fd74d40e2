"""Tasks and themes are loaded from folders by name, or the reason of a failure is reported."""

import shutil
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from sar_tui.loop.bus import FAULT
from sar_tui.loop.node import Node
from sar_tui.model.trial_types import Metric
from sar_tui.plugin_loader import user_folder
from sar_tui.plugins import (
    Catalogue,
    PluginError,
    load_task,
    load_theme,
    task_code,
    task_folder,
    task_source,
)
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Failed, make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.store.provenance import software
from tests.program import Call

TAPS = '''
from typing import Annotated, Any

from sar_tui.rules.declaration import meta
from sar_tui.rules.parameters import TaskParameters
from sar_tui.model.random_streams import RandomStreams
from sar_tui.loop.task import Act, Metric, Performance, Result, Situation, Stimulus, Task, Trial

from .words import INSTRUCTIONS


class TapsParameters(TaskParameters, frozen=True, kw_only=True):
    threshold: Annotated[float, meta("Goal", "taps", "More taps than this.", ge=0, le=100)] = 6.0
    neutral_band: Annotated[float, meta("Neutral band", "taps", "As good as the goal.", ge=0, le=100)] = 0.0
    response_timeout_ms: Annotated[int, meta("Time", "ms", "How long to tap.", ge=500, le=60_000)] = 3000


class Taps(Task):
    """As many taps as you can in three seconds; at a higher level, on a heavier bar."""

    name = "taps"
    title = "Tapping"
    metric = Metric("taps", unit="taps", better="higher", improved="more", worsened="fewer")
    Parameters = TapsParameters

    def instructions(self) -> str:
        return INSTRUCTIONS

    def stimulus(self, situation: Situation) -> Stimulus:
        return Stimulus("tap", expected="", text="Press: space", choices=2 ** situation.level)

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        return None

    def timed_out(self, trial: Trial) -> Result:
        taps = len(trial.percepts)
        return Result(correct=True, response=str(taps), value=float(taps), details={"taps": taps})

    def rehearse(self, stimulus: Stimulus, performance: Performance, streams: RandomStreams) -> list[Act]:
        interval = performance.reaction_ms / 2
        return [(interval * (tap + 1), "space") for tap in range(int(3000 / interval))]
'''

MINIMAL = """
from sar_tui.loop.task import Metric, Result, Stimulus, Task


class Minimal(Task):
    name = "minimal"
    title = "Minimal"
    metric = Metric("time", unit="ms", better="lower")

    def instructions(self):
        return "Press."

    def stimulus(self, situation):
        return Stimulus("f", expected="f", text="Press: f")

    def perceived(self, trial, percept):
        return Result(correct=True, response=percept.key, response_at=percept.at, value=trial.latency_ms(percept.at))
"""


def write(folder: Path, name: str, source: str, **more: str) -> Path:
    """Write a task's folder with its task.py and other modules, and return the folder."""
    task = folder / name
    task.mkdir(parents=True)
    for module, text in {"task": source, **more}.items():
        (task / f"{module}.py").write_text(text, encoding="utf-8")
    return task


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A folder of third-party tasks, outside the checkout."""
    folder = tmp_path / "my tasks"
    folder.mkdir()
    return folder


@pytest.fixture
def with_taps(own: Path) -> Catalogue:
    write(own, "taps", TAPS, words='INSTRUCTIONS = "Tap as often as you can."\n')
    return Catalogue(tasks=(own,))


def sentence(own: Path, name: str) -> str:
    with pytest.raises(PluginError) as caught:
        Catalogue(tasks=(own,)).task(name)
    return str(caught.value)


def test_shipped_tasks_and_themes_are_found(catalogue: Catalogue) -> None:
    assert "keyboard" in catalogue.task_names()
    assert {"calm", "high-contrast"} <= set(catalogue.theme_names())
    assert catalogue.task("keyboard").name == "keyboard"
    assert (task_folder(catalogue.task("keyboard")) / "README.md").is_file()


def test_a_task_is_loaded_once(catalogue: Catalogue) -> None:
    assert catalogue.task("keyboard") is catalogue.task("keyboard")


def test_a_task_in_a_named_folder_is_found_and_may_import_its_neighbours(
    with_taps: Catalogue, own: Path
) -> None:
    assert {"keyboard", "taps"} <= set(with_taps.task_names())
    taps = with_taps.task("taps")
    assert taps(build(taps.Parameters, {})).instructions() == "Tap as often as you can."
    assert task_folder(taps) == own / "taps"


def test_a_task_in_the_users_data_folder_is_found() -> None:
    write(user_folder() / "tasks", "minimal", MINIMAL)
    try:
        assert Catalogue().task("minimal").title == "Minimal"
    finally:
        shutil.rmtree(user_folder() / "tasks")


def test_a_named_folder_takes_precedence_over_shipped_tasks(own: Path) -> None:
    write(own, "keyboard", MINIMAL.replace('"minimal"', '"keyboard"'))
    assert Catalogue(tasks=(own,)).task("keyboard").title == "Minimal"
    assert Catalogue().task("keyboard").title == "Keyboard reaction"


def test_own_tasks_that_replace_a_built_in_one_are_known(own: Path) -> None:
    write(own, "keyboard", MINIMAL.replace('"minimal"', '"keyboard"'))
    write(own, "minimal", MINIMAL)
    assert Catalogue(tasks=(own,)).replaced_tasks() == {"keyboard": own / "keyboard"}
    built_in = task_folder(Catalogue().task("keyboard")).parent
    assert Catalogue(tasks=(built_in,)).replaced_tasks() == {}
    sources = [
        task_source(Catalogue(tasks=(own,)).task(name)) for name in ("keyboard", "minimal", "pairs")
    ]
    assert sources == ["own", "own", "built-in"]


def test_folders_without_a_task_are_skipped(own: Path) -> None:
    (own / "notes").mkdir()
    assert "notes" not in Catalogue(tasks=(own,)).task_names()


def test_a_missing_folder_is_reported(tmp_path: Path) -> None:
    with pytest.raises(PluginError, match=r"There is no folder .*nowhere for tasks"):
        Catalogue(tasks=(tmp_path / "nowhere",))


def test_an_unknown_name_is_reported_with_the_known_ones(catalogue: Catalogue) -> None:
    with pytest.raises(PluginError, match=r"There is no task chess\. Choose one of: .*keyboard"):
        catalogue.task("chess")
    with pytest.raises(
        PluginError, match=r"There is no theme loud\. Choose one of: calm, high-contrast"
    ):
        catalogue.theme("loud")
    with pytest.raises(PluginError, match=r"There is no task\.py in"):
        load_task(Path("nowhere"))


CURRENT = "The names of this version are in docs/task-reference.md."


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("1 / 0\n", "cannot be loaded: task.py:1: ZeroDivisionError: division by zero."),
        ("import math\nclass Garbled(:\n", "cannot be loaded: task.py:2: "),
        (
            "import nothing_of_that_name\n",
            "cannot be loaded: task.py:1: ModuleNotFoundError: No module named 'nothing_of_that_name'.",
        ),
        (
            "from sar_tui.no_such_package.imu import Imu",
            f"cannot be loaded: task.py:1: No module named 'sar_tui.no_such_package'. {CURRENT}",
        ),
        (
            "from sar_tui.loop.task import NoSuchName",
            "cannot be loaded: task.py:1: cannot import name 'NoSuchName' from 'sar_tui.loop.task'. "
            f"{CURRENT}",
        ),
        (
            "from sar_tui import no_such_package",
            f"cannot be loaded: task.py:1: cannot import name 'no_such_package' from 'sar_tui'. {CURRENT}",
        ),
    ],
)
def test_a_task_that_cannot_be_imported_is_reported(own: Path, source: str, problem: str) -> None:
    write(own, "minimal", source)
    assert sentence(own, "minimal").startswith(f"The task minimal {problem}")


@pytest.mark.parametrize(
    ("folder", "source", "problem"),
    [
        (
            "minimal",
            f"{MINIMAL}\n\nclass Other(Minimal):\n    name = 'other'\n",
            "task.py must define one Task; it defines 2.",
        ),
        (
            "minimal",
            "from sar_tui.loop.task import Task\n",
            "task.py must define one Task; it defines 0.",
        ),
        (
            "other",
            MINIMAL,
            "The task in the folder other has the name minimal; the two must be the same.",
        ),
        (
            "my-task",
            MINIMAL,
            "my-task cannot name a task's folder. Use a Python name, such as tapping.",
        ),
    ],
)
def test_a_folder_without_one_task_of_its_name_is_reported(
    own: Path, folder: str, source: str, problem: str
) -> None:
    write(own, folder, source)
    assert sentence(own, folder).endswith(problem)


def test_a_fixed_task_is_loaded_the_next_time(own: Path) -> None:
    folder = write(own, "minimal", "1 / 0\n")
    assert "cannot be loaded" in sentence(own, "minimal")
    (folder / "task.py").write_text(MINIMAL, encoding="utf-8")
    assert Catalogue(tasks=(own,)).task("minimal").title == "Minimal"


@pytest.mark.parametrize("declaration", ["name", "title", "metric"])
def test_a_missing_declaration_is_reported(own: Path, declaration: str) -> None:
    lines = [
        line for line in MINIMAL.splitlines() if not line.strip().startswith(f"{declaration} = ")
    ]
    write(own, "minimal", "\n".join(lines))
    assert sentence(own, "minimal") == f"The task minimal does not declare its {declaration}."


@pytest.mark.parametrize(
    ("declared", "problem"),
    [
        ("title = None", "its title is not a text"),
        ("summary = 5", "its summary is not a text"),
        ('metric = "reaction_time"', "its metric is not a Metric, or has values of wrong types"),
        (
            "metric = Metric(5, unit='ms', better='lower')",
            "its metric is not a Metric, or has values of wrong types",
        ),
        (
            "metric = Metric('x', unit='ms', better='lower', decimals='2')",
            "its metric is not a Metric, or has ",
        ),
        ("Parameters = dict", "its Parameters is not a subclass of TaskParameters"),
        ("Details = None", "its Details is not a subclass of Details"),
        ("sensors = 'imu'", "its sensors are not a tuple of texts"),
        ("seats = (1, 2)", "its seats are not a tuple of texts"),
        ("qualities = ('smooth',)", "its qualities are not a tuple of Quality"),
        ("marks = ('f7',)", "its marks are not a tuple of Mark"),
        ("measured = ('variability',)", "its measured are not a tuple of Measure"),
    ],
)
def test_a_declaration_of_a_wrong_type_is_reported_and_the_other_tasks_remain(
    own: Path, call: Call, declared: str, problem: str
) -> None:
    write(own, "minimal", f"{MINIMAL}\n    {declared}\n")
    assert sentence(own, "minimal").startswith(f"The task minimal cannot be used: {problem}")
    listed = call("tasks", "--tasks", own, "--json").json["tasks"]
    usable = [task["name"] for task in listed if "error" not in task]
    assert usable == sorted({*Catalogue().task_names()} - {"minimal"})


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A distribution with entry points: chess and draughts are broken, minimal works."""
    site = tmp_path / "site"
    info = site / "games-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: games\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[sar_tui.tasks]\nchess = games_missing:Chess\ndraughts = games_of_mine:NOTHING\n"
        "minimal = games_of_mine:Minimal\n"
    )
    (site / "games_of_mine.py").write_text(MINIMAL + "\n\nNOTHING = 3\n")
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.delitem(sys.modules, "games_of_mine", raising=False)
    return site


def test_an_installed_task_is_found_by_its_entry_point(installed: Path) -> None:
    assert {"chess", "draughts", "minimal"} <= set(Catalogue().task_names())
    assert task_folder(Catalogue().task("minimal")) == installed


def test_the_hash_of_an_installed_module_is_of_its_file_and_not_of_all_that_is_installed(
    installed: Path,
) -> None:
    def hashed() -> object:
        task = Catalogue().task("minimal")
        return software(
            task, task_source(task), task_code(task), installed / "games-1.0.dist-info"
        )["task"]["hash"]

    before = hashed()
    (installed / "another_package.py").write_text("x = 1\n")
    assert hashed() == before
    (installed / "games_of_mine.py").write_text("# changed\n")
    assert hashed() != before


def test_pictures_are_found_in_folders_of_tasks_and_in_packages_that_offer_one(
    installed: Path, own: Path
) -> None:
    assert not Catalogue().may_have_pictures()
    record = installed / "games-1.0.dist-info" / "RECORD"
    record.write_text("games_of_mine.py,,\ngames/queen.PNG,,\n")
    assert Catalogue().may_have_pictures()
    record.unlink()
    write(own, "minimal", MINIMAL)
    (own / "minimal" / "king.jpg").write_bytes(b"")
    assert Catalogue(tasks=(own,)).may_have_pictures()


@pytest.mark.usefixtures("installed")
def test_an_installed_task_that_cannot_be_loaded_is_reported() -> None:
    with pytest.raises(
        PluginError, match=r"The task chess .* cannot be loaded: ModuleNotFoundError"
    ):
        Catalogue().task("chess")
    with pytest.raises(PluginError, match=r"The entry point draughts .* is not a Task"):
        Catalogue().task("draughts")


def test_a_theme_in_a_named_folder_is_found(tmp_path: Path, catalogue: Catalogue) -> None:
    shutil.copytree(catalogue.theme_folder("calm"), tmp_path / "mine")
    themes = Catalogue(themes=(tmp_path,))
    assert {"calm", "mine"} <= set(themes.theme_names())
    assert themes.theme("mine") == load_theme(tmp_path / "mine")
    assert themes.theme("mine").name == "mine"


# --- a plug-in at work


def run(
    catalogue: Catalogue, task: str, data: Path, person: str = "average", **parameters: object
) -> list[sessions.Row]:
    plan = make_plan(catalogue, task, ["SIM"], parameters, seed=5, mode="simulated")
    session = simulate(plan, PEOPLE[person], data, catalogue)
    return sessions.rows(connect(data), "attempts", session)


def test_a_task_with_a_higher_is_better_metric_adapts_in_the_right_direction(
    with_taps: Catalogue, data: Path
) -> None:
    attempts = run(with_taps, "taps", data, attempts=12, threshold=6)
    assert len(attempts) == 12
    outcomes = set()
    for attempt, following in pairwise(attempts):
        success = attempt["metric"] > 6
        outcomes.add(success)
        assert attempt["outcome"] == ("success" if success else "failure")
        assert attempt["feedback"] == (
            "positive" if success else "neutral" if attempt["metric"] == 6 else "negative"
        )
        expected = min(attempt["level"] + 1, 10) if success else max(attempt["level"] - 1, 1)
        assert following["level"] == expected
    assert outcomes == {True, False}
    assert {attempt["metric_unit"] for attempt in attempts} == {"taps"}


def test_a_better_simulated_participant_reaches_a_higher_level(
    with_taps: Catalogue, data: Path
) -> None:
    levels = {}
    for person in PEOPLE:
        attempts = run(with_taps, "taps", data, person, attempts=12, threshold=6)
        levels[person] = sum(attempt["level"] for attempt in attempts[6:])
    assert levels["competent"] > levels["average"] > levels["poor"]


def test_the_details_and_texts_of_the_task_are_stored(with_taps: Catalogue, data: Path) -> None:
    settings = {"attempts": 3, "difficulty_policy": "fixed", "feedback_form": "quantitative"}
    plan = make_plan(with_taps, "taps", ["SIM"], settings, seed=5, mode="simulated")
    session = simulate(plan, PEOPLE["poor"], data, with_taps)
    trials = sessions.rows(connect(data), "trials", session)
    assert [trial["details"]["taps"] for trial in trials] == [
        int(trial["response"]) for trial in trials
    ]
    said = [
        row["final"]["text"]
        for row in sessions.rows(connect(data), "actions", session)
        if row["kind"] == "feedback"
    ]
    assert "taps" in said[0]
    assert not any("faster" in words or "slower" in words for words in said)


@pytest.mark.parametrize(
    ("method", "signature"),
    [("stimulus", "self, situation"), ("perceived", "self, trial, percept")],
)
@pytest.mark.parametrize("error", ["KeyError: 'missing'", "SystemExit: 3"])
def test_a_task_that_raises_in_a_session_is_reported_and_finished_trials_are_stored(
    own: Path, data: Path, method: str, signature: str, error: str
) -> None:
    raises = "raise {}({})".format(*error.split(": "))
    write(own, "minimal", MINIMAL + f"\n    def {method}({signature}):\n        {raises}\n")
    with pytest.raises(
        Failed, match=rf"The task minimal failed \({error}, line \d+ of task\.py\)\. What was done"
    ):
        run(Catalogue(tasks=(own,)), "minimal", data, attempts=2)
    (left,) = sessions.listing(connect(data), data)
    assert left["status"] == "interrupted"
    faults = [
        record for record in sessions.history(connect(data), left["id"]) if record.topic is FAULT
    ]
    assert len(faults) == 1


@pytest.mark.parametrize(
    ("method", "returned", "said"),
    [
        (
            "score(self, results)",
            "Score(1.0, 1.0, correct=99, trials=1)",
            "the score of an attempt has 99 right resp",
        ),
        (
            "score(self, results)",
            "Score(1.0, 1.0, correct=-5, trials=-1)",
            "the score of an attempt has -5 right ",
        ),
        (
            "score(self, results)",
            "Score(1.0, 7.0, correct=1, trials=1)",
            "the score of an attempt has an accuracy of",
        ),
        (
            "score(self, results)",
            "Score(float('inf'), 1.0, 1, 1)",
            "the Score of an attempt cannot be stored: a num",
        ),
        (
            "score(self, results)",
            "Score('fast', 1.0, 1, 1)",
            "the Score of an attempt cannot be stored: Expected ",
        ),
        ("score(self, results)", "None", "None is not a Score"),
        (
            "target(self, level)",
            "Target(float('nan'), 0.0)",
            "the Target of an attempt cannot be stored: a number ",
        ),
        (
            "perceived(self, trial, percept)",
            "{}",
            "the results of a trial are for the seats none; they are due for A",
        ),
        (
            "perceived(self, trial, percept)",
            "{'B': Result(correct=True)}",
            "the results of a trial are for the seat",
        ),
    ],
)
def test_a_result_that_cannot_be_one_stops_the_session_and_is_not_stored(
    own: Path, data: Path, method: str, returned: str, said: str
) -> None:
    source = f"from sar_tui.model.trial_types import Score, Target\n{MINIMAL}\n    def {method}:\n"
    write(own, "minimal", f"{source}        return {returned}\n")
    with pytest.raises(Failed, match=rf"The task minimal failed \(\w+: {said}"):
        run(Catalogue(tasks=(own,)), "minimal", data, attempts=2)
    assert connect(data).execute("SELECT count(*) FROM attempts").fetchone() == (0,)


def test_a_simulation_that_waits_for_ever_is_a_failure(
    own: Path, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Asleep(Node):
        name = "participant"

        def __init__(self, *_: object) -> None:
            super().__init__()

    monkeypatch.setattr("sar_tui.runs.simulate.SimulatedParticipant", Asleep)
    write(own, "minimal", MINIMAL)
    with pytest.raises(
        Failed, match="stopped before its end: the task minimal waits for something"
    ):
        run(Catalogue(tasks=(own,)), "minimal", data, attempts=2)


def test_a_task_that_cannot_be_set_up_is_reported_and_leaves_no_session(
    own: Path, data: Path
) -> None:
    write(
        own,
        "minimal",
        MINIMAL + "\n    def __init__(self, parameters):\n        raise KeyError('missing')\n",
    )
    with pytest.raises(
        Failed, match=r"The task minimal cannot be set up \(KeyError: 'missing'\)\."
    ):
        run(Catalogue(tasks=(own,)), "minimal", data, attempts=2)
    assert sessions.listing(connect(data), data) == []


@pytest.mark.parametrize(
    ("nodes", "said"),
    [
        ("1 / 0", r"\(ZeroDivisionError: "),
        ("None", r"\(TypeError: "),
        ("(5,)", ": among its nodes is 5"),
    ],
)
def test_nodes_that_a_task_cannot_make_are_reported_and_leave_no_session(
    own: Path, data: Path, call: Call, nodes: str, said: str
) -> None:
    write(own, "minimal", f"{MINIMAL}\n    def nodes(self):\n        return {nodes}\n")
    with pytest.raises(Failed, match=f"The task minimal cannot be set up ?{said}"):
        run(Catalogue(tasks=(own,)), "minimal", data, attempts=2)
    assert sessions.listing(connect(data), data) == []
    assert call("graph", "minimal", "--tasks", own).err.startswith(
        "The task minimal cannot be set up"
    )


def test_an_error_that_cannot_be_described_is_reported_by_its_type(own: Path, data: Path) -> None:
    mute = "class Mute(Exception):\n    def __str__(self):\n        raise ValueError\n"
    write(
        own, "minimal", f"{mute}{MINIMAL}\n    def stimulus(self, situation):\n        raise Mute\n"
    )
    with pytest.raises(Failed, match=r"The task minimal failed \(Mute, line \d+ of task\.py\)"):
        run(Catalogue(tasks=(own,)), "minimal", data, attempts=2)


@pytest.mark.parametrize("levels", ["None", "0", "2.5"])
def test_levels_that_are_no_number_are_refused_with_a_sentence(
    own: Path, data: Path, levels: str
) -> None:
    write(own, "minimal", MINIMAL + f"\n    levels = property(lambda self: {levels})\n")
    with pytest.raises(Failed, match=rf"its levels are {levels}, not a whole number from 1 on\."):
        run(Catalogue(tasks=(own,)), "minimal", data, attempts=2)


def test_change_is_described_correctly_in_either_direction() -> None:
    for better in ("lower", "higher"):
        metric = Metric("errors", unit="errors", better=better)  # type: ignore[arg-type]
        assert (metric.improved, metric.worsened) == ("better", "worse")
        assert metric.is_better(1, 2) is (better == "lower")
        assert not metric.is_better(1, 1)
