"""A simulated session waits for outputs that work in real time."""

import threading
from pathlib import Path
from typing import ClassVar

import pytest

from sar_tui.loop.node import Node
from sar_tui.loop.task import Task
from sar_tui.model.messages import ActionPart
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from sar_tui.reports.output_summary import output_summaries
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import connect


class Arm(Output):
    """Moves on a thread of its own."""

    name = "arm"
    can: ClassVar[frozenset[ActionPart]] = frozenset({"gesture"})

    def gesture(self, action: str, name: str) -> None:
        self.report(action, "gesture", "started")
        threading.Timer(0.02, self.report, (action, "gesture", "done")).start()


class Timed(Output):
    """Moves by timers of the session's clock, for so long that real time would be noticed."""

    name = "arm"
    can: ClassVar[frozenset[ActionPart]] = frozenset({"gesture"})

    def gesture(self, action: str, name: str) -> None:
        self.clock.call_at(
            self.clock.now() + 10_000 * MS, lambda: self.report(action, "gesture", "done")
        )


@pytest.mark.parametrize("output", [Arm, Timed])
def test_each_gesture_of_an_output_is_done_whatever_clock_it_follows(
    output: type[Output], data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nodes(task: Task, theme: Theme) -> list[Node]:
        return [OutputNode(output(), "arm", theme)]

    monkeypatch.setattr("sar_tui.runs.simulate.output_nodes", nodes)
    plan = make_plan(
        catalogue,
        "keyboard",
        ["P01"],
        {"attempts": 3, "prompts_per_attempt": 2, "outputs": ("screen", "speech")},
        mode="simulated",
    )
    session = simulate(plan, PEOPLE["average"], data, catalogue)
    (arm,) = [
        summary for summary in output_summaries(connect(data), session) if summary.output == "arm"
    ]
    assert arm.done >= 4
    assert (arm.aborted, arm.failed) == (0, 0)


class Stubborn(Timed):
    """Ends the program when it is closed."""

    def close(self) -> None:
        raise SystemExit("the arm is stuck")


def test_an_output_that_ends_the_program_when_closed_is_named_and_the_session_is_whole(
    data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "sar_tui.runs.simulate.output_nodes",
        lambda task, theme: [OutputNode(Stubborn(), "arm", theme)],
    )
    plan = make_plan(
        catalogue,
        "keyboard",
        ["P01"],
        {"attempts": 1, "outputs": ("screen", "speech")},
        mode="simulated",
    )
    session = simulate(plan, PEOPLE["average"], data, catalogue)
    database = connect(data)
    assert database.execute("SELECT status FROM sessions").fetchone()[0] == "completed"
    (line,) = [
        summary.line for summary in output_summaries(database, session) if summary.output == "arm"
    ]
    assert line == "arm: it was not closed (SystemExit: the arm is stuck)"
