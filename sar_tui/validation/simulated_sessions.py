"""Sessions of simulated participants in a temporary database, for validations of the agent."""

import tempfile
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

from sar_tui.loop.session import OWN_PARTS, Parts
from sar_tui.loop.task import Task
from sar_tui.model.messages import KeyPressed, Message, OutputReport, Shown, TrialEnded
from sar_tui.model.units import MS
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
    """A session: its attempts, and the agent's actions and outputs."""

    task: Task
    attempts: list[Row]
    actions: list[Row]
    reports: list[OutputReport]
    timed: dict[int, float]
    """Mean reaction time (ms) of each attempt with one, from when prompts were shown and keys
    pressed: the inputs.
    """

    @property
    def feedback(self) -> dict[int, Row]:
        """The feedback that was given, by the number of its attempt."""
        return {
            row["final"]["attempt"]: row
            for row in self.actions
            if row["kind"] == "feedback" and row["final"]
        }


class SessionRunner:
    """Runs sessions into its own database.

    Args:
        catalogue: the tasks and themes.
        folder: the folder of the database.
        known: sessions that are not run again.
    """

    def __init__(
        self, catalogue: Catalogue, folder: Path, known: dict[object, Simulated] | None = None
    ) -> None:
        self._catalogue = catalogue
        self._folder = folder
        self._kind = catalogue.task(TASK)
        self._known = known

    def run(
        self,
        user: str,
        seed: int,
        *,
        bodies: Sequence[Output] = (),
        parts: Parts | None = None,
        **parameters: Any,
    ) -> Simulated:
        """Run a session of twenty attempts.

        Args:
            user: one of `simulation.participant_model.PEOPLE`.
            seed: the seed of everything random.
            bodies: outputs of the agent besides the screen.
            parts: the classes of the framework's nodes, if not its own.
            parameters: the task's parameters that differ from the defaults.
        """
        key = user, seed, parts or OWN_PARTS, repr(sorted(parameters.items()))
        if self._known is None or bodies:  # bodies keep what they did
            return self._run(user, seed, bodies, parts, parameters)
        if key not in self._known:
            self._known[key] = self._run(user, seed, (), parts, parameters)
        return self._known[key]

    def _run(
        self,
        user: str,
        seed: int,
        bodies: Sequence[Output],
        parts: Parts | None,
        parameters: Mapping[str, Any],
    ) -> Simulated:
        values = {"attempts": 20, **parameters}
        plan = make_plan(
            self._catalogue, self._kind, ["SIM"], values, theme=THEME, seed=seed, mode="simulated"
        )
        name = simulate(
            plan, PEOPLE[user], self._folder, self._catalogue, bodies=bodies, parts=parts
        )
        database = connect(self._folder)
        with closing(database):
            messages = [record.message for record in sessions.history(database, name)]
            return Simulated(
                task=self._kind(plan.parameters),
                attempts=sessions.rows(database, "attempts", name),
                actions=sessions.rows(database, "actions", name),
                reports=[each for each in messages if isinstance(each, OutputReport)],
                timed=timed(messages),
            )


def timed(messages: Sequence[Message]) -> dict[int, float]:
    """Return the mean reaction time (ms) of each attempt that has one, from the inputs of a session
    alone.

    Which responses count is the program's judgement; when the prompt was shown and which key came
    first after it is not.
    """
    keys = [each.at for each in messages if isinstance(each, KeyPressed)]
    shown = {(each.attempt, each.trial): each.at for each in messages if isinstance(each, Shown)}
    times: dict[int, list[float]] = {}
    for each in messages:
        if isinstance(each, TrialEnded) and each.correct and each.value is not None:
            onset = shown[each.attempt, each.trial]
            times.setdefault(each.attempt, []).append(
                (keys[bisect_right(keys, onset)] - onset) / MS
            )
    return {attempt: fmean(found) for attempt, found in times.items()}


@contextmanager
def session_runner(
    catalogue: Catalogue, known: dict[object, Simulated] | None = None
) -> Iterator[SessionRunner]:
    """Provide a runner with a temporary database. ``known``: sessions to share with other runners,
    and to add to.
    """
    with tempfile.TemporaryDirectory(prefix="sar-tui-validate-") as folder:
        yield SessionRunner(catalogue, Path(folder), known)
