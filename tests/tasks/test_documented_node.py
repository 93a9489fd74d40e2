"""The node of docs/write-a-node.md runs from the page's own code: on a bus, simulated, and
replayed as it was.
"""

import importlib
import re
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.topics import PERCEIVED, TRIAL
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Failed, make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.documented import FRAGMENTS, write_documented
from tests.edit import edit

SETTINGS = {"attempts": 2, "imu": "simulated"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the page's task and its node."""
    write_documented(tmp_path / "mytasks", "twist", "task", "twists")
    return tmp_path / "mytasks"


def test_the_documented_test_of_the_node_passes(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(folder / "twist"))
    (source,) = (each for each in FRAGMENTS if "def reported" in each)
    names: dict[str, Any] = {}
    exec(source, names)
    names["test_a_turn_is_reported_with_its_onset_and_its_peak"](importlib.import_module("twists"))
    del sys.modules["twists"]


def simulated(folder: Path, data: Path) -> list[Record]:
    """Simulate a session of the page's task, which replays identically, and return its messages."""
    catalogue = Catalogue(tasks=(folder,))
    plan = make_plan(catalogue, "twist", ["P01"], SETTINGS, theme="calm", seed=5, mode="simulated")
    session = simulate(plan, PEOPLE["average"], data, catalogue)
    with closing(connect(data)) as database:
        history = list(sessions.history(database, session))
    task = plan.task(plan.parameters)
    Session(task, catalogue.theme("calm"), VirtualClock(), 5).replay(history)
    return history


def answered(history: list[Record]) -> list[Any]:
    trials = [record.message for record in history if record.topic is TRIAL]
    return [trial for trial in trials if trial.response]


def test_simulated_people_turn_their_hand_and_the_session_replays(folder: Path, data: Path) -> None:
    trials = answered(simulated(folder, data))
    assert len(trials) > 5
    for trial in trials:
        assert trial.value == trial.reaction_time_ms
        assert 3.0 < trial.details["peak_rad_s"] < 5.0


def test_a_movement_can_stand_for_a_key(folder: Path, data: Path) -> None:
    node = folder / "twist" / "twists.py"
    source = node.read_text().replace("    ReachPerceived,\n", "    KeyPerceived,\n")
    head, _, _ = source.replace("REACH", "PERCEIVED").partition("    def timer")
    emits = 'self.emit(PERCEIVED, KeyPerceived(key="tap", at=self.began))'
    node.write_text(f"{head}    def timer(self, name, late):\n        {emits}\n")
    task = folder / "twist" / "task.py"
    edit(task, "not isinstance(percept, ReachPerceived)", 'percept.key != "tap"')
    edit(task, "            details=percept.details,\n", "")
    history = simulated(folder, data)
    keys = [record.message for record in history if record.topic is PERCEIVED]
    taps = {key.at for key in keys if key.key == "tap"}
    responses = {trial.response_at for trial in answered(history)}
    assert len(responses) > 5
    assert responses <= taps


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('name = "twists"', 'name = "perception"', "has the name perception, as another node has"),
        ('name = "twists"', "pass", "its node Twists has no name."),
        ("return (Twists(),)", "return (Twists(), Twists())", "has the name twists, as another"),
        ("return (Twists(),)", "return (Twists,)", "which is no Node."),
    ],
)
def test_nodes_have_names_of_their_own(folder: Path, old: str, new: str, says: str) -> None:
    for file in (folder / "twist").glob("*.py"):
        file.write_text(file.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    catalogue = Catalogue(tasks=(folder,))
    with pytest.raises(Failed, match=re.escape(says)):
        make_plan(catalogue, "twist", ["P01"], SETTINGS, theme="calm", seed=5, mode="simulated")
