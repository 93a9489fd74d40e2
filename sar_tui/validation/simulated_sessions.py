"""Sessions of simulated participants in a temporary database, for validations of the agent."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from sar_tui.framework.messages import KeyPressed, OutputReport
from sar_tui.framework.session_phase import REQUEST_KEY
from sar_tui.framework.task import Task
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.validation.report import Row

TASK, THEME = "keyboard", "calm"


class Simulated(NamedTuple):
    """A session: its attempts, the agent's actions and outputs, and when the participant requested feedback (ns)."""

    task: Task
    attempts: list[Row]
    actions: list[Row]
    asked: list[int]
    reports: list[OutputReport]

    @property
    def feedback(self) -> dict[int, Row]:
        """The feedback that was given, by the number of its attempt."""
        return {row["final"]["attempt"]: row for row in self.actions if row["kind"] == "feedback" and row["final"]}


class SessionRunner:
    """Runs sessions into its own database.

    Args:
        catalogue: the tasks and themes.
        folder: the folder of the database.
    """

    def __init__(self, catalogue: Catalogue, folder: Path) -> None:
        self._catalogue = catalogue
        self._folder = folder
        self._kind = catalogue.task(TASK)

    def run(self, user: str, seed: int, *, bodies: Sequence[Output] = (), **parameters: Any) -> Simulated:
        """Run a session of twenty attempts.

        Args:
            user: one of `simulation.participant_model.PEOPLE`.
            seed: the seed of everything random.
            bodies: outputs of the agent besides the screen.
            parameters: the task's parameters that differ from the defaults.
        """
        values = {"attempts": 20, **parameters}
        plan = make_plan(self._catalogue, self._kind, ["SIM"], values, theme=THEME, seed=seed, mode="simulated")
        name = simulate(plan, PEOPLE[user], self._folder, self._catalogue, bodies=bodies)
        database = connect(self._folder)
        with closing(database):
            messages = [record.message for record in sessions.history(database, name)]
            return Simulated(
                task=self._kind(plan.parameters),
                attempts=sessions.rows(database, "attempts", name),
                actions=sessions.rows(database, "actions", name),
                asked=[each.at for each in messages if isinstance(each, KeyPressed) and each.key == REQUEST_KEY],
                reports=[each for each in messages if isinstance(each, OutputReport)],
            )


@contextmanager
def session_runner(catalogue: Catalogue) -> Iterator[SessionRunner]:
    """Provide a runner with a temporary database."""
    with tempfile.TemporaryDirectory(prefix="sar-tui-validate-") as folder:
        yield SessionRunner(catalogue, Path(folder))
