"""A stored session by other parameters to its end: as recorded up to the first other prompt, then
modelled.
"""

import math
import sqlite3
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    STORED,
    TRIAL,
)
from sar_tui.model.messages import (
    AttemptEnded,
    Decision,
    KeyPressed,
    OperatorChanged,
    Prompt,
    SessionCommand,
    SessionStarted,
    SettingChanged,
    Stored,
    ThemeApplied,
    TrialEnded,
    Waiting,
)
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.replay.replay import check_whole
from sar_tui.replay.rescore import changes_only_scores
from sar_tui.replay.response_model import (
    FEWEST_ATTEMPTS,
    FEWEST_RESPONSES,
    Counts,
    Fit,
    Floats,
    Response,
    ResponseModel,
)
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Failed, without_outputs
from sar_tui.simulation.participant import Person, SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions

RUNS = 200
COVERAGE = 0.9
"""Least share of the runs that lie in the interval."""
_SCORES_TOO = ("attempts",)
"""Settings that change no recorded prompt beside those that change only scores."""


class Summary(msgspec.Struct, frozen=True):
    """A session in numbers. Practice does not count.

    Attributes:
        attempts: number of attempts.
        final_level: level of the last one.
        mean_level: mean of the attempts' levels.
        mean_metric: mean of the attempts' results.
        accuracy: share of correct trials.
        successes: share of attempts that reached their goal.
        positive_feedbacks: number of attempts with positive feedback.
    """

    attempts: int
    final_level: int
    mean_level: float
    mean_metric: float | None
    accuracy: float | None
    successes: float
    positive_feedbacks: int


class Forecast(msgspec.Struct, frozen=True):
    """One number of the session: as recorded, and in the runs. None: there is no such number.

    ``share``: of the runs from ``low`` to ``high``; more than the `COVERAGE` if the number has few
    values.
    """

    name: str
    recorded: float | None
    median: float | None
    low: float | None
    high: float | None
    share: float | None


class Forked(msgspec.Struct, frozen=True):
    """A session by other parameters to its end: a model, not data.

    Attributes:
        session: its id.
        what_if: the changed parameters.
        record_ends_at_attempt: the attempt with the first prompt that would have been another: from
            there on, responses are drawn from the model. None if all prompts are those of the
            record, so that nothing is modelled.
        runs: number of runs; 1 if nothing is modelled.
        seed: of the first run; the others have the numbers after it.
        coverage: least share of the runs in each interval.
        model: the model and its fit; None if nothing is modelled.
        numbers: each with its interval.
    """

    session: str
    what_if: dict[str, Any]
    record_ends_at_attempt: int | None
    runs: int
    seed: int
    coverage: float
    model: Fit | None
    numbers: tuple[Forecast, ...]


def fork(
    database: sqlite3.Connection,
    folder: Path,
    catalogue: Catalogue,
    row: sessions.Row,
    changed: Mapping[str, object],
    runs: int = RUNS,
    progress: Callable[[int], None] = lambda done: None,
) -> Forked:
    """Run a stored session by other parameters, often, with a model of its participant from the
    first other prompt on.

    Args:
        database: only read.
        folder: the data folder.
        catalogue: where the task is found.
        row: of the session, from `store.sessions.find`.
        changed: parameters, typed or as text.
        runs: number of runs.
        progress: called with the number of runs done.

    Raises:
        StoreError, PluginError: as `replay.replay`.
        ParameterError: a parameter is unknown or out of bounds.
        Failed: the session cannot be modelled: the message says why.
    """
    check_whole(database, folder, row)
    kind = catalogue.task(row["task"])
    before = without_outputs(kind, build(kind.Parameters, row["parameters"]))
    after = build(kind.Parameters, {**row["parameters"], **changed})
    _check_kind(row, before)
    record = read_responses(database, row)
    same = play(kind, before.parameters, record, row["seed"], record, None)
    if same.forked_at is not None or _scores(same.ended) != _scores(record.ended):
        raise Failed(
            f"The session {row['id']} does not come out as recorded from its responses alone: "
            "perhaps something acted "
            "on it, or the task has changed since. It cannot be forked."
        )
    model = None
    is_exact = all(changes_only_scores(kind, name) or name in _SCORES_TOO for name in changed)
    kept = record if is_exact else None
    seed = int(row["seed"])
    first = play(kind, after, record, seed, kept, None)
    if first.forked_at is None:
        ended = [first.ended]
    else:
        model = _fit(row, record)
        ended = []
        for number in range(runs):
            ended.append(
                play(
                    kind, after, record, seed, kept, model.draw(seed + number), seed + number
                ).ended
            )
            progress(number + 1)
    what_if = msgspec.to_builtins(after)
    return Forked(
        session=row["id"],
        what_if={name: what_if[name] for name in changed},
        record_ends_at_attempt=first.forked_at,
        runs=len(ended),
        seed=seed,
        coverage=COVERAGE,
        model=model.fit if model else None,
        numbers=forecasts(summary(record.ended), [summary(one) for one in ended]),
    )


def _check_kind(row: sessions.Row, task: Task) -> None:
    """Raise Failed if the people who do such sessions cannot be modelled."""
    if row["status"] != "completed":
        raise Failed(
            f"The session {row['id']} was not completed. Only a completed session can be forked."
        )
    if len(task.seats) > 1:
        raise Failed(
            "A session of two cannot be forked: how one responds depends on the other, which is "
            "not modelled."
        )
    if task.sensor_seats(task.parameters) or task.start_key:
        raise Failed(
            f"A session of {task.name} cannot be forked: there is a model of key presses only, "
            "not of movements."
        )


def _fit(row: sessions.Row, record: "Responses") -> ResponseModel:
    """Fit the model to all trials of the record. Raises Failed if there are too few."""
    responses = [
        Response(key[0], record.prompts[key].choices, trial.reaction_time_ms)
        for key, trial in record.trials.items()
        if trial.correct
        and trial.reaction_time_ms is not None
        and "anticipation" not in trial.timing.flags
    ]
    attempts = {one.attempt for one in responses}
    if len(responses) < FEWEST_RESPONSES or len(attempts) < FEWEST_ATTEMPTS:
        raise Failed(
            f"The session {row['id']} has {len(responses)} correct responses in {len(attempts)} "
            "attempts: too few for "
            f"a model, which needs {FEWEST_RESPONSES} in {FEWEST_ATTEMPTS}."
        )
    missed = sum(trial.response is None for trial in record.trials.values())
    wrong = sum(
        trial.response is not None and not trial.correct for trial in record.trials.values()
    )
    counts = Counts(
        len(record.trials), missed, wrong, len(record.offered), len(record.asked & record.offered)
    )
    return ResponseModel(responses, counts)


def _scores(ended: Sequence[AttemptEnded]) -> list[tuple[object, ...]]:
    return [
        (one.attempt, one.level, one.metric, one.accuracy, one.outcome, one.feedback)
        for one in ended
    ]


def summary(ended: Sequence[AttemptEnded]) -> Summary:
    """Return a session's attempts in numbers."""
    scored = [one for one in ended if not one.practice]
    if not scored:
        return Summary(0, 0, 0.0, None, None, 0.0, 0)
    metrics = [one.metric for one in scored if one.metric is not None]
    trials = sum(one.trials for one in scored)
    return Summary(
        attempts=len(scored),
        final_level=scored[-1].level,
        mean_level=sum(one.level for one in scored) / len(scored),
        mean_metric=sum(metrics) / len(metrics) if metrics else None,
        accuracy=sum(one.correct for one in scored) / trials if trials else None,
        successes=sum(one.outcome == "success" for one in scored) / len(scored),
        positive_feedbacks=sum(one.feedback == "positive" for one in scored),
    )


def forecasts(recorded: Summary, runs: Sequence[Summary]) -> tuple[Forecast, ...]:
    """Return each number with its median and its interval over the runs."""
    return tuple(_forecast(name, recorded, runs) for name in Summary.__struct_fields__)


def _forecast(name: str, recorded: Summary, runs: Sequence[Summary]) -> Forecast:
    values = np.sort([value for one in runs if (value := getattr(one, name)) is not None])
    if not len(values):
        return Forecast(name, getattr(recorded, name), None, None, None, None)
    low, high = _shortest_interval(values)
    share = float(np.mean((values >= low) & (values <= high)))
    return Forecast(name, getattr(recorded, name), float(np.median(values)), low, high, share)


def _shortest_interval(values: Floats) -> tuple[float, float]:
    """Return the shortest interval with `COVERAGE` of sorted values, and of equally short ones that
    with most.

    A number with few values, such as a level, gets no more of them than it needs: quantiles would
    hold too many.
    """
    count = math.ceil(COVERAGE * len(values))
    lows, highs = values[: len(values) - count + 1], values[count - 1 :]
    shortest = np.flatnonzero(highs - lows <= (highs - lows).min() + 1e-12)
    held = np.searchsorted(values, highs[shortest], "right") - np.searchsorted(
        values, lows[shortest], "left"
    )
    best = shortest[np.argmax(held)]
    return float(lows[best]), float(highs[best])


# --- a session played again from its responses


class Responses(NamedTuple):
    """The responses of a record, the prompts that they answer, and the facts with which the session
    began.

    Attributes:
        started: the facts.
        theme: the first one.
        prompts, trials: by attempt and trial.
        ended: the scored attempts.
        offered: attempts on which the participant could request feedback.
        asked: those on which they did.
    """

    started: SessionStarted
    theme: Theme
    prompts: dict[tuple[int, int], Prompt]
    trials: dict[tuple[int, int], TrialEnded]
    ended: list[AttemptEnded]
    offered: set[int]
    asked: set[int]


def read_responses(database: sqlite3.Connection, row: sessions.Row) -> Responses:
    """Read a record. Raises Failed if somebody acted on the session, so that its course is not the
    task's own.
    """
    started: SessionStarted | None = None
    theme: Theme | None = None
    prompts, trials = {}, {}
    ended: list[AttemptEnded] = []
    offered, asked = set(), set()
    ask = ("", 0)
    for one in sessions.history(database, row["id"]):
        match one.message:
            case ThemeApplied(theme=applied) if theme is None:
                theme = applied
            case SessionStarted() as message if started is None:
                started = message
            case Prompt() as message:
                prompts[message.attempt, message.trial] = message
            case TrialEnded() as message:
                trials[message.attempt, message.trial] = message
            case AttemptEnded() as message:
                ended.append(message)
            case Waiting() as message:
                ask = message.ask, message.attempt
                if message.ask:
                    offered.add(message.attempt)
            case KeyPressed(key=key) if key == ask[0]:
                asked.add(ask[1])
            case Decision() | SettingChanged() | OperatorChanged(operated=True):
                raise _acted_on(row)
            case SessionCommand(command=command) if command not in ("pause", "resume"):
                raise _acted_on(row)
    if not started or not theme or not ended:
        raise Failed(f"The session {row['id']} has no attempts: there is nothing to fork.")
    return Responses(started, theme, prompts, trials, ended, offered, asked)


def _acted_on(row: sessions.Row) -> Failed:
    return Failed(
        f"An operator or a therapist acted on session {row['id']}. It cannot be forked: there is "
        "no model of what they "
        "would have done."
    )


class _Recorded:
    """The recorded responses, up to the first prompt that is not the recorded one.

    Args:
        record: None: there are none.
        is_alone: True if nothing comes after them.

    Attributes:
        forked_at: the attempt of that prompt; None before it.
    """

    def __init__(self, record: Responses | None, *, is_alone: bool) -> None:
        self._record = record
        self._is_alone = is_alone
        self.forked_at: int | None = None

    def covers(self, prompt: Prompt) -> bool:
        was = self._record and self._record.prompts.get((prompt.attempt, prompt.trial))
        if self.forked_at is None and not (was and _is_same_prompt(was, prompt)):
            self.forked_at = prompt.attempt
        return self.forked_at is None or self._is_alone

    def response_to(self, prompt: Prompt) -> tuple[str, int] | None:
        if self._record is None or self.forked_at is not None:
            return None
        trial = self._record.trials.get((prompt.attempt, prompt.trial))
        if not trial or trial.response is None or trial.response_at is None or trial.onset is None:
            return None
        return trial.response, trial.response_at - trial.onset

    def wants_feedback(self, waiting: Waiting) -> bool | None:
        if self._record is None or self.forked_at is not None:
            return False if self._is_alone else None
        return waiting.attempt in self._record.asked


class _Acknowledger(Node):
    """Acknowledges trials as the recorder does: nothing is stored."""

    name = "acknowledger"
    emits = (STORED,)

    @on(TRIAL)
    def trial_ended(self, ended: TrialEnded) -> None:
        stored = Stored(seat=ended.seat, attempt=ended.attempt, trial=ended.trial)
        self.bus.clock.call_soon(lambda: self.emit(STORED, stored))


def _is_same_prompt(was: Prompt, now: Prompt) -> bool:
    return (was.stimulus, was.expected, was.level, was.choices, was.cue, was.frames, was.tone) == (
        now.stimulus,
        now.expected,
        now.level,
        now.choices,
        now.cue,
        now.frames,
        now.tone,
    )


class Played(NamedTuple):
    """The attempts of a session that was played, and where it was forked."""

    ended: list[AttemptEnded]
    forked_at: int | None


def play(
    kind: type[Task],
    parameters: Any,
    record: Responses,
    seed: int,
    kept: Responses | None,
    person: Person | None,
    person_seed: int = 0,
) -> Played:
    """Play a session on the virtual clock; without a person, only up to the fork.

    Args:
        kind: the task.
        parameters: of the task.
        record: the facts with which the session began.
        seed: of the session: decides its prompts.
        kept: the record whose responses are played up to the first other prompt; None for none.
        person: responds from there on.
        person_seed: decides what they do.
    """
    task = without_outputs(kind, parameters)
    clock = VirtualClock()
    recorded = _Recorded(kept, is_alone=person is None)
    # without a person, all responses are known
    model = person or PEOPLE["average"]
    participant = SimulatedParticipant(model, task, person_seed, known=recorded)
    started = record.started
    session = Session(
        task,
        record.theme,
        clock,
        seed,
        [participant, _Acknowledger()],
        best=started.best,
        others_best=started.others_best,
        names=started.names,
        done_today=started.done_today,
        steps=started.steps,
    )
    ended: list[AttemptEnded] = []
    session.bus.subscribe(ATTEMPT_ENDED, ended.append)
    session.begin()
    while not session.ended and session.broken is None and clock.step():
        if person is None and recorded.forked_at is not None:
            break
    if fault := session.broken:
        raise Failed(f"The task {task.name} failed ({fault.error}, {fault.place}).")
    return Played(ended, recorded.forked_at)
