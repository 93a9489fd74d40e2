"""A session played in advance by a simulated person who does as a participant did: nothing of it is
stored.

All functions that play are generators, so that a screen can do them in slices between its own work.
"""

import itertools
import statistics
from collections.abc import Generator, Sequence
from typing import Any, ClassVar, Literal, NamedTuple, TypeVar

import msgspec

from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import ATTEMPT_ENDED, STORED, TRIAL
from sar_tui.model.messages import AttemptEnded, Stored, TrialEnded
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Metric
from sar_tui.progress.lines import SessionResults, comparable
from sar_tui.progress.task_level import AttemptResult
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.difficulty import TargetSettings
from sar_tui.rules.level_choice import bounds, moves_goal
from sar_tui.rules.parameters import TaskParameters, build
from sar_tui.rules.policies import DIFFICULTY, own_settings
from sar_tui.runs.plan import Failed, set_up
from sar_tui.runs.simulate import goes_on, people
from sar_tui.runs.start_level import start_after
from sar_tui.simulation.participant_model import PEOPLE, Person

T = TypeVar("T")

ATTEMPTS = 20
"""Attempts that are played."""
SEED = 5
"""The same for all, so that settings are compared on the same luck, and nothing flickers."""
LOOKED_AT = 3
"""Newest sessions that a stand-in is made from."""
FEWEST = 5
"""Fewest results that a stand-in is made from."""
_MATCHED_ON = 16
"""Most attempts that are played at once to find out how fast a stand-in is."""
_TRIES = 4
_CLOSE = 0.02
"""A stand-in is near enough if its mean is within this share of the person's."""
_AVERAGE = PEOPLE["average"]
_LEFT_OUT: dict[str, Any] = {
    "attempts": ATTEMPTS,
    "practice_attempts": 0,
    "rest_every": 0,
    "ask_wellbeing": False,
    "questions": (),
    "session_minutes": 0,
    "rest_after_attempts": 0,
    "rest_after_minutes": 0,
    "outputs": ("screen",),
    "operator_feedback": "autonomous",
    "operator_encouragement": "autonomous",
    "operator_instruction": "autonomous",
    "operator_gesture": "autonomous",
    "operator_difficulty": "autonomous",
}
"""Settings that have nothing to do with levels and results, as a preview has them."""


class StandIn(msgspec.Struct, frozen=True):
    """A simulated person in a participant's place.

    Args:
        person: who plays.
        sessions: number of the participant's sessions that they were made from; 0 for an average
            person.
        is_like: False if there are sessions, but no simulated person does as the participant did.
    """

    person: Person = _AVERAGE
    sessions: int = 0
    is_like: bool = True


class Played(NamedTuple):
    """An attempt that was played.

    Attributes:
        level: of the attempt.
        reached: True if it reached its goal; None without one.
        goal: in the metric's unit; None without one.
        prompts: number of prompts.
        prompts_reached: number of prompts answered right and better than the goal.
    """

    level: int
    reached: bool | None
    goal: float | None
    prompts: int = 0
    prompts_reached: int = 0


class Preview(msgspec.Struct, frozen=True):
    """Attempts that were played.

    Args:
        attempts: in order.
        levels: the highest level that can be reached.
        follows: the level or the goal, if one of them changes with the person.
        metric: of the results and goals.
        aim: the share of attempts, or of prompts, that the rule aims at; 0 if it aims at none, None
            if that is not known.
        aims_at_prompts: True if the level follows the share of prompts that reach the goal.
        why_start: where the level of the first attempt is from; empty if there is nothing to say.
    """

    attempts: tuple[Played, ...]
    levels: int
    follows: Literal["level", "goal", ""]
    metric: Metric
    aim: float | None = None
    aims_at_prompts: bool = False
    why_start: str = ""

    @property
    def highest(self) -> int:
        """The highest level that was played."""
        return max(played.level for played in self.attempts)

    @property
    def with_goal(self) -> int:
        """Number of attempts that had a goal."""
        return sum(played.reached is not None for played in self.attempts)

    @property
    def reached(self) -> int:
        """Number of attempts that reached their goal."""
        return sum(bool(played.reached) for played in self.attempts)

    @property
    def share_of_prompts(self) -> float | None:
        """Share of prompts that reached the goal; None if the rule does not aim at it."""
        prompts = sum(played.prompts for played in self.attempts)
        if not (self.aims_at_prompts and prompts):
            return None
        return sum(played.prompts_reached for played in self.attempts) / prompts


def finish(work: Generator[None, None, T]) -> T:
    """Do all of a work at once."""
    while True:
        try:
            next(work)
        except StopIteration as done:
            found: T = done.value
            return found


def play_ahead(
    kind: type[Task],
    parameters: TaskParameters,
    theme: Theme,
    sessions: Sequence[SessionResults],
    stand_in: StandIn,
) -> Generator[None, None, Preview]:
    """Play the attempts of a participant's next session.

    Args:
        kind: the task.
        parameters: its settings.
        theme: of the session; it does not change the result.
        sessions: the participant's newest sessions of the task, by which the level starts.
        stand_in: who plays.

    Raises:
        Failed: the task cannot be set up, or fails.
    """
    task = set_up(kind, msgspec.structs.replace(parameters, **_LEFT_OUT))
    start = start_after(task, sessions)
    started = msgspec.structs.replace(task.parameters, start_level=start.level, start_from="fixed")
    task = set_up(kind, started)
    session = yield from _play(task, theme, stand_in.person)
    attempts = tuple(
        _played(
            list(seats), [trial for trial in session.trials if trial.attempt == number], kind.metric
        )
        for number, seats in itertools.groupby(session.attempts, key=lambda ended: ended.attempt)
    )
    follows: Literal["level", "goal", ""] = (
        "level" if len({played.level for played in attempts}) > 1 else ""
    )
    return Preview(
        attempts=attempts,
        levels=bounds(task.parameters, task.levels).highest,
        follows="goal" if moves_goal(task.parameters) else follows,
        metric=kind.metric,
        aim=_aim(parameters),
        aims_at_prompts=_aims_at_prompts(parameters),
        why_start=start.why,
    )


def _aim(parameters: TaskParameters) -> float | None:
    policy = DIFFICULTY[parameters.difficulty_policy]
    return policy.aim(own_settings(policy.settings, parameters)) if policy.aim else None


def _aims_at_prompts(parameters: TaskParameters) -> bool:
    target = own_settings(TargetSettings, parameters)
    return parameters.difficulty_policy == "target" and target.target_of == "prompts"


def _played(seats: Sequence[AttemptEnded], trials: Sequence[TrialEnded], metric: Metric) -> Played:
    """Return an attempt; with two seats it reached its goal if both did."""
    goal = seats[0].goal
    if any(ended.outcome == "none" for ended in seats) or goal is None:
        return Played(seats[0].level, None, None)
    values = [trial.value for trial in trials if trial.correct and trial.value is not None]
    return Played(
        level=seats[0].level,
        reached=all(ended.outcome == "success" for ended in seats),
        goal=goal,
        prompts=len(trials),
        prompts_reached=sum(metric.is_better(value, goal) for value in values),
    )


class _Session(NamedTuple):
    """Attempts and trials of a session, in order."""

    attempts: list[AttemptEnded]
    trials: list[TrialEnded]


class _Acknowledge(Node):
    """Acknowledges each trial as stored."""

    name = "no storage"
    emits: ClassVar[tuple[Topic[Any], ...]] = (STORED,)

    @on(TRIAL)
    def ended(self, trial: TrialEnded) -> None:
        self.emit(STORED, Stored(attempt=trial.attempt, trial=trial.trial))


def _play(task: Task, theme: Theme, person: Person) -> Generator[None, None, _Session]:
    """Play a session of the loop on a virtual clock. Raises Failed."""
    clock = VirtualClock()
    nodes = [*people(person, task, SEED, clock), _Acknowledge()]
    session = Session(task, theme, clock, SEED, nodes)
    found = _Session([], [])
    session.bus.subscribe(ATTEMPT_ENDED, found.attempts.append)
    session.bus.subscribe(TRIAL, found.trials.append)
    session.begin()
    try:
        while goes_on(session) and clock.step():
            yield
    finally:
        session.detach()
    if session.broken or not found.attempts:
        raise Failed(f"The task {task.name} could not be played in advance.")
    return found


# --- a stand-in


def make_stand_in(
    kind: type[Task], sessions: Sequence[SessionResults], theme: Theme
) -> Generator[None, None, StandIn]:
    """Return a simulated person whose results have the mean and the spread of a participant's, at
    the levels that they played.

    The simulated times are multiplied until the means agree, and then their spread; the share of
    wrong responses is the participant's. Results do not depend on the goal, so that sessions with
    another one count, too.

    Args:
        kind: the task.
        sessions: the participant's newest sessions of the task, oldest first.
        theme: of the session that is played.
    """
    found = _newest_alike(kind, sessions)
    if found is None:
        return StandIn()
    task, alike = found
    results = [
        result for each in alike for result in each.results if _is_usable(result, task.levels)
    ][-_MATCHED_ON:]
    if len(results) < FEWEST:
        return StandIn()
    trials = sum(each.trials for each in alike)
    wrong = 1 - sum(each.right for each in alike) / trials if trials else _AVERAGE.errors
    person = msgspec.structs.replace(
        _AVERAGE, errors=min(0.5, max(0.0, wrong - _AVERAGE.misses)), practice=0.0
    )
    matched = yield from _matched(task, theme, person, results)
    if matched is None:
        return StandIn(is_like=False)
    return StandIn(matched, len(alike))


def _is_usable(result: AttemptResult, levels: int) -> bool:
    return result.metric is not None and 1 <= result.level <= levels


def _newest_alike(
    kind: type[Task], sessions: Sequence[SessionResults]
) -> tuple[Task, list[SessionResults]] | None:
    """Return the newest sessions that can be compared, and the task with their settings."""
    for newest in reversed(sessions):
        try:
            task = set_up(kind, build(kind.Parameters, newest.parameters))
        except (ParameterError, Failed):
            continue
        if line := comparable(sessions, task, at_any_goal=True):
            return task, [point.results for point in line.points[-LOOKED_AT:]]
    return None


def _matched(
    task: Task, theme: Theme, person: Person, results: Sequence[AttemptResult]
) -> Generator[None, None, Person | None]:
    """Return the person with times that lead to such results; None if none do."""
    levels = tuple(result.level for result in results)
    fixed = {
        **_LEFT_OUT,
        "attempts": len(levels),
        "difficulty_policy": "sequence",
        "level_sequence": levels,
        "min_level": 1,
        "max_level": task.levels,
    }
    as_then = set_up(type(task), msgspec.structs.replace(task.parameters, **fixed))
    wanted = [(result.level, result.metric) for result in results if result.metric is not None]
    mean = statistics.fmean(value for _, value in wanted)
    slowness, tried = 1.0, list[tuple[float, float]]()
    best: tuple[float, Person, float] | None = None
    for _ in range(_TRIES):
        slow = _slowed(person, slowness)
        played = yield from _play(as_then, theme, slow)
        made = [
            (each.level, each.metric)
            for each in played.attempts
            if each.metric is not None and each.seat == "A"
        ]
        if not made:
            break
        reached = statistics.fmean(value for _, value in made)
        tried.append((slowness, reached))
        if best is None or abs(reached - mean) < best[0]:
            spread = _spread(wanted) / (_spread(made) or 1.0)
            best = abs(reached - mean), slow, min(2.0, max(0.5, spread or 1.0))
        if abs(reached - mean) <= _CLOSE * abs(mean):
            break
        slowness = min(4.0, max(0.25, _next_try(tried, mean, task.metric.better)))
    if best is None or best[0] > max(0.1 * abs(mean), _spread(wanted)):
        return None
    _, slow, spread = best
    return msgspec.structs.replace(
        slow,
        sigma_ms=slow.sigma_ms * spread,
        tau_ms=slow.tau_ms * spread,
        pace_sd=slow.pace_sd * spread,
    )


def _slowed(person: Person, slowness: float) -> Person:
    """Return a person all of whose times are longer by a factor."""
    return msgspec.structs.replace(
        person,
        base_ms=person.base_ms * slowness,
        per_bit_ms=person.per_bit_ms * slowness,
        sigma_ms=person.sigma_ms * slowness,
        tau_ms=person.tau_ms * slowness,
        pace=person.pace * slowness,
    )


def _next_try(
    tried: Sequence[tuple[float, float]], wanted: float, better: Literal["lower", "higher"]
) -> float:
    """Return the slowness to try next: by the last two tries, or at first by the ratio of
    means.
    """
    slowness, reached = tried[-1]
    if len(tried) > 1:
        before, then = tried[-2]
        if abs(reached - then) > 1e-9:
            return slowness + (wanted - reached) * (slowness - before) / (reached - then)
    ratio = wanted / reached if reached and wanted / reached > 0 else 1.0
    return slowness * (ratio if better == "lower" else 1 / ratio)


def _spread(results: Sequence[tuple[int, float]]) -> float:
    """Return the standard deviation of results about the mean of their level; of all, if no level
    was played often.
    """
    by_level: dict[int, list[float]] = {}
    for level, value in results:
        by_level.setdefault(level, []).append(value)
    spare = sum(len(values) - 1 for values in by_level.values())
    if spare >= FEWEST - 1:
        squares = sum(
            (value - statistics.fmean(values)) ** 2
            for values in by_level.values()
            for value in values
        )
        return float((squares / spare) ** 0.5)
    return statistics.stdev(value for _, value in results)
