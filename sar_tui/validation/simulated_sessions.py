"""Sessions of simulated participants in a temporary database, for validations of the agent."""

import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple

from sar_tui.framework.messages import KeyPressed
from sar_tui.framework.session_phase import REQUEST_KEY
from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.validation.report import Row

TASK, THEME = "keyboard", "calm"
SEEDS = range(1, 11)
"""Seeds with which a claim about users is tested."""


class Simulated(NamedTuple):
    """A session: its attempts, the agent's actions, and the times at which the participant requested feedback (ns)."""

    task: Task
    attempts: list[Row]
    actions: list[Row]
    asked: list[int]

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

    def run(self, user: str, seed: int, **parameters: object) -> Simulated:
        """Run a session of twenty attempts.

        Args:
            user: one of `simulation.participant_model.PEOPLE`.
            seed: the seed of everything random.
            parameters: the task's parameters that differ from the defaults.
        """
        values = {"attempts": 20, **parameters}
        plan = make_plan(self._catalogue, self._kind, ["SIM"], values, theme=THEME, seed=seed, mode="simulated")
        name = simulate(plan, PEOPLE[user], self._folder, self._catalogue)
        database = connect(self._folder)
        with closing(database):
            return Simulated(
                task=self._kind(plan.parameters),
                attempts=sessions.rows(database, "attempts", name),
                actions=sessions.rows(database, "actions", name),
                asked=[
                    record.message.at
                    for record in sessions.history(database, name)
                    if isinstance(record.message, KeyPressed) and record.message.key == REQUEST_KEY
                ],
            )


@contextmanager
def session_runner(catalogue: Catalogue) -> Iterator[SessionRunner]:
    """Provide a runner with a temporary database."""
    with tempfile.TemporaryDirectory(prefix="sar-tui-validate-") as folder:
        yield SessionRunner(catalogue, Path(folder))
