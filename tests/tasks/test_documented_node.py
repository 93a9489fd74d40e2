"""The node of docs/write-a-node.md runs from the page's own code: on a bus, simulated, live, and
replayed as it was.
"""

import importlib
import re
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from sar_tui.loop.bus import Bus, Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import IMU, PERCEIVED, REACH, TRIAL
from sar_tui.model.messages import ImuBlock
from sar_tui.model.units import MS
from sar_tui.motion.samples import SAMPLE, pack
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Failed, make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.app.app_driver import open_app
from tests.documented import FRAGMENTS, write_documented

SETTINGS = {"attempts": 2, "imu": "simulated"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the page's task and its node."""
    write_documented(tmp_path / "mytasks", "twist", "task", "twists")
    return tmp_path / "mytasks"


@pytest.fixture
def twists(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    monkeypatch.syspath_prepend(str(folder / "twist"))
    yield importlib.import_module("twists")
    del sys.modules["twists"]


def recorded(data: Path, session: str) -> list[Record]:
    with closing(connect(data)) as database:
        return list(sessions.history(database, session))


def replay(kind: type[Task], catalogue: Catalogue, history: list[Record], seed: int) -> None:
    """Derive the messages of a session anew; they are the same."""
    Session(
        kind(build(kind.Parameters, SETTINGS)), catalogue.theme("calm"), VirtualClock(), seed
    ).replay(history)


def test_the_documented_test_of_the_node_passes(twists: ModuleType) -> None:
    (source,) = (each for each in FRAGMENTS if "def reported" in each)
    names: dict[str, Any] = {}
    exec(source, names)
    names["test_a_turn_is_reported_with_its_onset_and_its_peak"](twists)


def test_samples_in_one_block_or_in_many_are_the_same_turn(twists: ModuleType) -> None:
    made = np.zeros(60, SAMPLE)
    made["at"] = np.arange(60) * 10 * MS
    made["rate"][20:26, 2] = (0.5, 1.5, 3.0, 3.5, 2.0, 1.0)
    found = []
    for size in (1, 7, 60):
        clock = VirtualClock()
        bus = Bus(clock)
        node = twists.Twists()
        node.attach(bus)
        node.is_prompted = True
        bus.subscribe(REACH, found.append)
        for begin in range(0, 60, size):
            bus.publish(IMU, ImuBlock(samples=pack(made[begin : begin + size])))
        clock.advance(1000 * MS)
    assert [each.at for each in found] == [210 * MS] * 3
    assert len({each.details["peak_rad_s"] for each in found}) == 1


def test_simulated_people_turn_their_hand_and_the_session_replays(
    folder: Path, tmp_path: Path
) -> None:
    catalogue = Catalogue(tasks=(folder,))
    plan = make_plan(catalogue, "twist", ["P01"], SETTINGS, theme="calm", seed=5, mode="simulated")
    history = recorded(
        tmp_path / "data", simulate(plan, PEOPLE["average"], tmp_path / "data", catalogue)
    )
    trials = [record.message for record in history if record.topic is TRIAL]
    answered = [trial for trial in trials if trial.response]
    assert len(answered) > 5
    assert all(trial.value == trial.reaction_time_ms for trial in answered)
    assert all(3.0 < trial.details["peak_rad_s"] < 5.0 for trial in answered)
    replay(catalogue.task("twist"), catalogue, history, 5)


@pytest.mark.slow
async def test_a_live_session_with_a_simulated_hand_replays(folder: Path, data: Path) -> None:
    catalogue = Catalogue(tasks=(folder,))
    plan = make_plan(catalogue, "twist", ["P01"], SETTINGS | {"attempts": 1}, theme="calm", seed=7)
    async with open_app(data, catalogue, plan) as driver:
        await driver.wait(300)
        await driver.press("enter")
        await driver.to_first_prompt()
        assert driver.sees("Turn your hand")
        await driver.wait(15_000)
        assert driver.waiting.stage == "review"
        await driver.see_the_summary()
        session = driver.session_id
        assert driver.session.faults == []
    history = recorded(data, session)
    turns = [record.message for record in history if record.topic is REACH]
    trials = [record.message for record in history if record.topic is TRIAL]
    assert len(trials) == 5
    assert [trial.response_at for trial in trials if trial.response] == [turn.at for turn in turns]
    kind = catalogue.task("twist")
    parameters = build(kind.Parameters, SETTINGS | {"attempts": 1})
    Session(kind(parameters), catalogue.theme("calm"), VirtualClock(), 7).replay(history)


def test_a_movement_can_stand_for_a_key(folder: Path, tmp_path: Path) -> None:
    node = folder / "twist" / "twists.py"
    source = node.read_text().replace("    ReachPerceived,\n", "    KeyPerceived,\n")
    source = source.replace("REACH", "PERCEIVED")
    head, _, _ = source.partition("    def timer")
    emits = (
        "    def timer(self, name, late):\n        self.emit(PERCEIVED, "
        'KeyPerceived(key="tap", at=self.began))\n'
    )
    node.write_text(head + emits)
    task = folder / "twist" / "task.py"
    text = task.read_text().replace(
        "not isinstance(percept, ReachPerceived)", 'percept.key != "tap"'
    )
    task.write_text(text.replace("            details=percept.details,\n", ""))
    catalogue = Catalogue(tasks=(folder,))
    plan = make_plan(catalogue, "twist", ["P01"], SETTINGS, theme="calm", seed=5, mode="simulated")
    history = recorded(
        tmp_path / "data", simulate(plan, PEOPLE["average"], tmp_path / "data", catalogue)
    )
    trials = [record.message for record in history if record.topic is TRIAL]
    assert len([trial for trial in trials if trial.response]) > 5
    taps = [
        each.message for each in history if each.topic is PERCEIVED and each.message.key == "tap"
    ]
    assert {trial.response_at for trial in trials if trial.response} <= {tap.at for tap in taps}
    replay(catalogue.task("twist"), catalogue, history, 5)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            'name = "twists"',
            'name = "perception"',
            "its node Twists has the name perception, as another node has.",
        ),
        ('name = "twists"', "pass", "its node Twists has no name."),
        (
            "return (Twists(),)",
            "return (Twists(), Twists())",
            "its node Twists has the name twists, as another node has.",
        ),
        ("return (Twists(),)", "return (Twists,)", "which is no Node."),
    ],
)
def test_nodes_have_names_of_their_own(folder: Path, old: str, new: str, says: str) -> None:
    for file in (folder / "twist").glob("*.py"):
        file.write_text(file.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    catalogue = Catalogue(tasks=(folder,))
    with pytest.raises(Failed, match=re.escape(says)):
        make_plan(catalogue, "twist", ["P01"], SETTINGS, theme="calm", seed=5, mode="simulated")
