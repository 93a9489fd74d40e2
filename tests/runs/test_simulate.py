"""A simulated session waits for outputs that work in real time; it may be of another day, or left."""

import threading
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import ClassVar

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.task import Task
from sar_tui.model.messages import ActionPart
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from sar_tui.reports.output_summary import output_summaries
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import participants, sessions
from sar_tui.store.database import connect
from sar_tui.store.integrity import flaws
from tests import played


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
        end = self.clock.now() + 10_000 * MS
        self.clock.call_at(end, lambda: self.report(action, "gesture", "done"))


class Stubborn(Timed):
    """Ends the program when it is closed."""

    def close(self) -> None:
        raise SystemExit("the arm is stuck")


@pytest.mark.parametrize(
    ("output", "line"),
    [(Arm, None), (Timed, None), (Stubborn, "not closed (SystemExit: the arm is stuck)")],
)
def test_each_gesture_of_an_output_is_done_whatever_clock_it_follows_and_however_it_ends(
    output: type[Output],
    line: str | None,
    data: Path,
    catalogue: Catalogue,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def nodes(task: Task, theme: Theme) -> list[Node]:
        return [OutputNode(output(), "arm", theme)]

    monkeypatch.setattr("sar_tui.runs.simulate.output_nodes", nodes)
    short = {"attempts": 3, "prompts_per_attempt": 2, "outputs": ("screen", "speech")}
    plan = make_plan(catalogue, "keyboard", ["P01"], short, mode="simulated")
    session = simulate(plan, PEOPLE["average"], data, catalogue)
    database = connect(data)
    assert database.execute("SELECT status FROM sessions").fetchone()[0] == "completed"
    (arm,) = [one for one in output_summaries(database, session) if one.output == "arm"]
    if line:
        assert line in arm.line
    else:
        assert arm.done >= 4
        assert (arm.aborted, arm.failed) == (0, 0)


def test_a_simulated_session_of_another_day_has_all_its_times_of_that_day(
    data: Path, catalogue: Catalogue
) -> None:
    began = datetime(2026, 1, 5, 9, 30, tzinfo=UTC)
    short = {"attempts": 3, "prompts_per_attempt": 2}
    plan = make_plan(catalogue, "keyboard", ["P01"], short, seed=1, mode="demonstration")
    session = simulate(plan, PEOPLE["average"], data, catalogue, began=began)
    with closing(connect(data)) as database:
        row = sessions.find(database, data, session)
        (run,) = sessions.rows(database, "runs", session)
        last = sessions.rows(database, "attempts", session)[-1]
        assert datetime.fromisoformat(row["started_at"]) == began
        assert datetime.fromisoformat(run["clock_anchor"]["utc"]) == began
        lasted = datetime.fromisoformat(row["ended_at"]) - began
        assert timedelta(seconds=last["ended_ns"] / SECOND) <= lasted < timedelta(minutes=5)
        assert list(flaws(database)) == []
        assert participants.codes(database) == ["P01"]


def test_a_session_that_a_simulated_participant_leaves_goes_on_where_it_stopped(
    data: Path, catalogue: Catalogue
) -> None:
    short = {"attempts": 4, "prompts_per_attempt": 2}
    plan = make_plan(catalogue, "keyboard", ["P01"], short, seed=1, mode="demonstration")
    session = simulate(plan, PEOPLE["average"], data, catalogue, leave_after=2)
    clock = VirtualClock(SECOND)
    played.play(resume(session, data, catalogue, clock, played.somebody), clock)
    with closing(connect(data)) as database:
        assert [row["attempt"] for row in sessions.rows(database, "attempts", session)] == [
            1, 2, 3, 4
        ]  # fmt: skip
        assert sessions.find(database, data, session)["status"] == "completed"
