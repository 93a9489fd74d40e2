"""Tasks and themes are loaded from folders by name, or the reason of a failure is reported."""

import re
import shutil
import sys
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


def sentence(own: Path, name: str) -> str:
    with pytest.raises(PluginError) as caught:
        Catalogue(tasks=(own,)).task(name)
    return str(caught.value)


def test_tasks_of_named_folders_come_before_the_users_and_the_built_in_ones(own: Path) -> None:
    source = MINIMAL.replace('return "Press."', "return INSTRUCTIONS")
    words = 'INSTRUCTIONS = "Tap as often as you can."'
    write(own, "minimal", f"from .words import INSTRUCTIONS\n{source}", words=words)
    write(own, "keyboard", MINIMAL.replace('"minimal"', '"keyboard"'))
    (own / "notes").mkdir()
    write(user_folder() / "tasks", "of_the_user", MINIMAL.replace('"minimal"', '"of_the_user"'))
    try:
        found = Catalogue(tasks=(own,))
        assert found.task("of_the_user").title == "Minimal"
    finally:
        shutil.rmtree(user_folder() / "tasks")
    assert {"keyboard", "minimal"} <= set(found.task_names())
    assert "notes" not in found.task_names()
    minimal = found.task("minimal")
    assert found.task("minimal") is minimal
    assert minimal(build(minimal.Parameters, {})).instructions() == "Tap as often as you can."
    assert task_folder(minimal) == own / "minimal"
    assert found.task("keyboard").title == "Minimal"
    built_in = Catalogue().task("keyboard")
    assert built_in.title == "Keyboard reaction"
    assert found.replaced_tasks() == {"keyboard": own / "keyboard"}
    assert Catalogue(tasks=(task_folder(built_in).parent,)).replaced_tasks() == {}
    sources = [task_source(found.task(name)) for name in ("keyboard", "minimal", "pairs")]
    assert sources == ["own", "own", "built-in"]


def test_an_unknown_name_is_reported_with_the_known_ones(catalogue: Catalogue) -> None:
    with pytest.raises(PluginError, match=r"There is no task chess\. Choose one of: .*keyboard"):
        catalogue.task("chess")
    with pytest.raises(
        PluginError, match=r"There is no theme loud\. Choose one of: calm, high-contrast"
    ):
        catalogue.theme("loud")
    with pytest.raises(PluginError, match=r"There is no task\.py in"):
        load_task(Path("nowhere"))
    with pytest.raises(PluginError, match=r"There is no folder nowhere for tasks"):
        Catalogue(tasks=(Path("nowhere"),))


CURRENT = "The names of this version are in docs/task-reference.md."
OTHER = f"{MINIMAL}\n\nclass Other(Minimal):\n    name = 'other'\n"


@pytest.mark.parametrize(
    ("folder", "source", "problem"),
    [
        ("minimal", "1 / 0\n", "cannot be loaded: task.py:1: ZeroDivisionError: division by zero."),
        ("minimal", "import math\nclass Garbled(:\n", "cannot be loaded: task.py:2: "),
        ("minimal", "import no_such_module\n", "cannot be loaded: task.py:1: ModuleNotFoundError: No module named"),
        (
            "minimal", "from sar_tui.no_such_package.imu import Imu",
            f"cannot be loaded: task.py:1: No module named 'sar_tui.no_such_package'. {CURRENT}",
        ),
        (
            "minimal", "from sar_tui.loop.task import NoSuchName",
            f"cannot be loaded: task.py:1: cannot import name 'NoSuchName' from 'sar_tui.loop.task'. {CURRENT}",
        ),
        ("minimal", OTHER, "task.py must define one Task; it defines 2."),
        ("minimal", "from sar_tui.loop.task import Task\n", "task.py must define one Task; it defines 0."),
        ("other", MINIMAL, "The task in the folder other has the name minimal; the two must be the same."),
        ("my-task", MINIMAL, "my-task cannot name a task's folder. Use a Python name, such as tapping."),
        *(
            ("minimal", re.sub(rf"    {name} = .*\n", "", MINIMAL), f"The task minimal does not declare its {name}.")
            for name in ("name", "title", "metric")
        ),
    ],
)  # fmt: skip
def test_a_folder_without_one_task_of_its_name_is_reported_until_it_can_be_loaded(
    own: Path, folder: str, source: str, problem: str
) -> None:
    written = write(own, folder, source)
    assert problem in sentence(own, folder)
    if "cannot be loaded" in problem:
        (written / "task.py").write_text(MINIMAL, encoding="utf-8")
        assert Catalogue(tasks=(own,)).task("minimal").title == "Minimal"


def test_a_declaration_of_a_wrong_type_is_reported_and_the_other_tasks_remain(
    own: Path, call: Call
) -> None:
    rows = [
        ("title = None", "its title is not a text"),
        ("summary = 5", "its summary is not a text"),
        ('metric = "reaction_time"', "its metric is not a Metric, or has values of wrong types"),
        ("metric = Metric(5, 'ms', 'lower')", "its metric is not a Metric, or has values"),
        ("metric = Metric('x', 'ms', 'lower', decimals='2')", "its metric is not a Metric, or has"),
        ("Parameters = dict", "its Parameters is not a subclass of TaskParameters"),
        ("Details = None", "its Details is not a subclass of Details"),
        ("sensors = 'imu'", "its sensors are not a tuple of texts"),
        ("seats = (1, 2)", "its seats are not a tuple of texts"),
        ("qualities = ('smooth',)", "its qualities are not a tuple of Quality"),
        ("marks = ('f7',)", "its marks are not a tuple of Mark"),
        ("measured = ('variability',)", "its measured are not a tuple of Measure"),
    ]
    for number, (declared, problem) in enumerate(rows):
        folder = own / str(number)
        write(folder, "minimal", f"{MINIMAL}\n    {declared}\n")
        assert sentence(folder, "minimal").startswith(f"The task minimal cannot be used: {problem}")
    listed = call("tasks", "--tasks", folder, "--json").json["tasks"]
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


def test_an_installed_task_is_found_by_its_entry_point_and_hashed_without_other_packages(
    installed: Path,
) -> None:
    assert {"chess", "draughts", "minimal"} <= set(Catalogue().task_names())
    with pytest.raises(PluginError, match=r"task chess .* cannot be loaded: ModuleNotFoundError"):
        Catalogue().task("chess")
    with pytest.raises(PluginError, match=r"The entry point draughts .* is not a Task"):
        Catalogue().task("draughts")
    task = Catalogue().task("minimal")
    assert task_folder(task) == installed

    def hashed() -> object:
        info = installed / "games-1.0.dist-info"
        return software(task, task_source(task), task_code(task), info)["task"]["hash"]

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
    picture = installed / "games" / "queen.PNG"  # Python 3.12 lists only files that are there
    picture.parent.mkdir()
    picture.touch()
    assert Catalogue().may_have_pictures()
    record.unlink()
    write(own, "minimal", MINIMAL)
    (own / "minimal" / "king.jpg").write_bytes(b"")
    assert Catalogue(tasks=(own,)).may_have_pictures()


def test_a_theme_in_a_named_folder_is_found(tmp_path: Path, catalogue: Catalogue) -> None:
    shutil.copytree(catalogue.theme_folder("calm"), tmp_path / "mine")
    themes = Catalogue(themes=(tmp_path,))
    assert {"calm", "mine"} <= set(themes.theme_names())
    assert themes.theme("mine") == load_theme(tmp_path / "mine")
    assert themes.theme("mine").name == "mine"


# --- a plug-in at work


def run(own: Path, data: Path, source: str) -> None:
    """Simulate two attempts of the minimal task with more source."""
    folder = write(
        own, "minimal", f"from sar_tui.model.trial_types import Score, Target\n{MINIMAL}{source}"
    )
    try:
        catalogue = Catalogue(tasks=(own,))
        plan = make_plan(catalogue, "minimal", ["SIM"], {"attempts": 2}, seed=5, mode="simulated")
        simulate(plan, PEOPLE["average"], data, catalogue)
    finally:
        shutil.rmtree(folder)


def method(signature: str, body: str) -> str:
    return f"\n    def {signature}:\n        {body}\n"


MUTE = """
        class Mute(Exception):
            def __str__(self):
                raise ValueError
        raise Mute
"""
SCORE, TARGET = "score(self, results)", "target(self, level)"
PERCEIVED, STIMULUS = "perceived(self, trial, percept)", "stimulus(self, situation)"


@pytest.mark.parametrize(
    ("signature", "body", "said"),
    [
        (PERCEIVED, "raise SystemExit(3)", r"SystemExit: 3, line \d+ of task\.py\)\. What was done"),
        (STIMULUS, "raise KeyError('missing')", r"KeyError: 'missing', line \d+ of task\.py\)\. What was"),
        (STIMULUS, MUTE, r"Mute, line \d+ of task\.py\)"),
        (SCORE, "return Score(1.0, 1.0, correct=99, trials=1)", "the score of an attempt has 99 right "),
        (SCORE, "return Score(1.0, 1.0, correct=-5, trials=-1)", "the score of an attempt has -5 right "),
        (SCORE, "return Score(1.0, 7.0, correct=1, trials=1)", "the score of an attempt has an accuracy of"),
        (SCORE, "return Score(float('inf'), 1.0, 1, 1)", "the Score of an attempt cannot be stored: a num"),
        (SCORE, "return Score('fast', 1.0, 1, 1)", "the Score of an attempt cannot be stored: Expected "),
        (SCORE, "return None", "None is not a Score"),
        (TARGET, "return Target(float('nan'), 0.0)", "the Target of an attempt cannot be stored: a num"),
        (PERCEIVED, "return {}", "the results of a trial are for the seats none; they are due for A"),
        (PERCEIVED, "return {'B': Result(correct=True)}", "the results of a trial are for the seat"),
    ],
)  # fmt: skip
def test_an_error_or_a_result_that_cannot_be_one_stops_the_session_and_is_not_stored(
    own: Path, data: Path, signature: str, body: str, said: str
) -> None:
    with pytest.raises(Failed, match=rf"The task minimal failed \((\w+: )?{said}"):
        run(own, data, method(signature, body))
    database = connect(data)
    assert database.execute("SELECT count(*) FROM attempts").fetchone() == (0,)
    (left,) = sessions.listing(database, data)
    assert left["status"] == "interrupted"
    history = sessions.history(database, left["id"])
    assert len([record for record in history if record.topic is FAULT]) == 1


def test_a_simulation_that_waits_for_ever_is_a_failure(
    own: Path, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Asleep(Node):
        name = "participant"

        def __init__(self, *_: object) -> None:
            super().__init__()

    monkeypatch.setattr("sar_tui.runs.simulate.SimulatedParticipant", Asleep)
    said = "stopped before its end: the task minimal waits for something"
    with pytest.raises(Failed, match=said):
        run(own, data, "")


@pytest.mark.parametrize(
    ("source", "said"),
    [
        (method("__init__(self, parameters)", "raise KeyError('missing')"), r" \(KeyError: 'missing'\)\."),
        (method("nodes(self)", "return 1 / 0"), r" \(ZeroDivisionError: "),
        (method("nodes(self)", "return None"), r" \(TypeError: "),
        (method("nodes(self)", "return (5,)"), ": among its nodes is 5"),
        *(
            (f"\n    levels = property(lambda self: {levels})\n", f": its levels are {levels}, not a whole number")
            for levels in ("None", "0", "2.5")
        ),
    ],
)  # fmt: skip
def test_a_task_that_cannot_be_set_up_is_reported_and_leaves_no_session(
    own: Path, data: Path, call: Call, source: str, said: str
) -> None:
    with pytest.raises(Failed, match=f"The task minimal cannot be set up{said}"):
        run(own, data, source)
    assert sessions.listing(connect(data), data) == []
    write(own, "minimal", f"{MINIMAL}{source}")
    begins = "The task minimal cannot be set up"
    assert call("graph", "minimal", "--tasks", own).err.startswith(begins)


def test_change_is_described_correctly_in_either_direction() -> None:
    for better in ("lower", "higher"):
        metric = Metric("errors", unit="errors", better=better)  # type: ignore[arg-type]
        assert (metric.improved, metric.worsened) == ("better", "worse")
        assert metric.is_better(1, 2) is (better == "lower")
        assert not metric.is_better(1, 1)
    assert [Metric("taps", unit, "higher").label for unit in ("ms", "")] == ["taps (ms)", "taps"]
