"""Outputs that bridge to a real device, in a simulated session: they are told of it, and of what
goes wrong.
"""

import asyncio
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.loop.bus import Bus
from sar_tui.loop.clock import LiveClock, VirtualClock
from sar_tui.loop.task import Task
from sar_tui.loop.topics import REPORT
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.outputs.test_outputs import entry
from tests.plugged_in import offer

Outcomes = Callable[[Output], set[tuple[str, str]]]


class Bridge(Output):
    """Sends gestures to a robot that is not there, and limits the time for its answer by the
    session's clock.
    """

    name = "bridge"
    can = frozenset({"gesture"})

    def gesture(self, action: str, name: str) -> None:
        self.clock.call_at(
            self.clock.now() + 30 * SECOND, lambda: self.report(action, "gesture", "failed", "late")
        )


class ConsiderateBridge(Bridge):
    """Leaves the robot alone in a simulation."""

    def gesture(self, action: str, name: str) -> None:
        if self.simulated:
            self.report(action, "gesture", "started")
            self.report(action, "gesture", "done")
        else:
            super().gesture(action, name)


@pytest.fixture
def outcomes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, keyboard: type[Task], catalogue: Catalogue
) -> Outcomes:
    """Return a function that tells how the gestures of a simulated session ended, and why."""

    def run(bridge: Output) -> set[tuple[str, str]]:
        offer(monkeypatch, "sar_tui.outputs", [entry("bridge", lambda text: bridge)])
        settings = {"attempts": 1, "prompts_per_attempt": 2, "outputs": ["screen", "bridge"]}
        plan = make_plan(catalogue, keyboard, ["P01"], settings, seed=1, mode="simulated")
        session = simulate(plan, PEOPLE["average"], tmp_path, catalogue)
        with closing(connect(tmp_path)) as database:
            history = list(sessions.history(database, session))
        reports = [one.message for one in history if one.topic is REPORT]
        its = [one for one in reports if one.output == "bridge" and one.state != "queued"]
        return {(one.state, one.detail) for one in its}

    return run


def test_a_bridge_that_limits_its_time_by_the_clock_is_told_why_it_fails(
    outcomes: Outcomes,
) -> None:
    ((state, why),) = outcomes(Bridge())
    assert state == "failed"
    assert "In this simulation time jumped over its work" in why
    assert "self.simulated" in why


def test_a_bridge_can_leave_its_robot_alone_in_a_simulation(outcomes: Outcomes) -> None:
    assert outcomes(ConsiderateBridge()) == {("started", ""), ("done", "")}


@pytest.mark.parametrize("is_live", [True, False])
async def test_an_output_knows_that_the_session_is_simulated_when_it_is_opened(
    is_live: bool, calm: Theme
) -> None:
    told: list[bool] = []

    class Asking(Bridge):
        def apply_theme(self, theme: Theme) -> None:
            told.append(self.simulated)

    clock = LiveClock(asyncio.get_running_loop()) if is_live else VirtualClock()
    OutputNode(Asking(), "bridge", calm).attach(Bus(clock))
    assert told == [not is_live]
