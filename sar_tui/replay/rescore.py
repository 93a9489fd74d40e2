"""A stored session scored by other parameters, as far as its prompts would have been the same."""

import sqlite3
from collections import deque
from collections.abc import Iterable, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.loop.bus import Record
from sar_tui.loop.replay_comparison import is_same
from sar_tui.loop.task import Task
from sar_tui.model.messages import AttemptEnded, PendingApproval, Prompt, TrialEnded
from sar_tui.plugins import Catalogue
from sar_tui.replay.replay import new_session, replay
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import fields
from sar_tui.runs.plan import Failed
from sar_tui.store import sessions

_GROUPS = ("Difficulty", "Feedback")
_TIMED = ("feedback_delay_ms",)
"""Settings of these groups that change when something happens, so that the recorded times would not
fit.
"""
_DETECTION = ("detector",)
"""Settings of tasks that change how a movement is analysed, and not when it is over."""


class Score(msgspec.Struct, frozen=True):
    """Score of an attempt, with the names of the table ``attempts``."""

    metric: float | None
    accuracy: float | None
    goal: float | None
    outcome: str
    feedback: str


class RescoredAttempt(msgspec.Struct, frozen=True):
    """An attempt with its score then and now."""

    attempt: int
    seat: str
    practice: bool
    level: int
    recorded: Score
    rescored: Score


class Rescored(msgspec.Struct, frozen=True):
    """A session scored by other rules.

    Attributes:
        session: its id.
        what_if: the changed parameters.
        attempts: those that can be scored from the record.
        ends_at_attempt: the attempt in which the course of the session would have been another one:
            with another prompt, or another end of a trial, or something else for an operator to
            decide on. It and those after it are not scored. None if there is none.
        other_feedback_from: the first attempt with feedback of another kind: positive, neutral,
            negative or none. Responses after it are those of a person who had other feedback. None
            if there is none.
    """

    session: str
    what_if: dict[str, Any]
    attempts: tuple[RescoredAttempt, ...]
    ends_at_attempt: int | None
    other_feedback_from: int | None


def rescore(
    database: sqlite3.Connection,
    folder: Path,
    catalogue: Catalogue,
    row: sessions.Row,
    changed: Mapping[str, object],
) -> Rescored:
    """Score the responses of a stored session by other parameters.

    Args:
        database: only read.
        folder: the data folder.
        catalogue: where the task is found.
        row: of the session, from `store.sessions.find`.
        changed: parameters, typed or as text.

    Raises:
        StoreError, PluginError: as `replay`.
        ParameterError: a parameter is unknown, out of bounds, or changes more than the scores.
        Failed: the session differs from its record without any change, or its task cannot be set
            up.
    """
    kind = catalogue.task(row["task"])
    declared = {field.name for field in fields(kind.Parameters)}
    if wrong := [
        name for name in changed if name in declared and not changes_only_scores(kind, name)
    ]:
        raise ParameterError(
            {
                name: f"{name} changes more than scores: the recorded inputs would not fit. "
                "--fork models what follows."
                for name in wrong
            }
        )
    session = new_session(row, catalogue, changed)
    if not replay(database, folder, catalogue, row).identical:
        raise Failed(
            f"The session {row['id']} differs from its record without any change: `sar-tui replay "
            f"{row['id']}` shows "
            "where. It cannot be told what another parameter would change."
        )
    trace = _Trace()
    with closing(session.derive(sessions.history(database, row["id"]))) as derived:
        for record, cascade in derived:
            if not trace.add(record, cascade):
                break
    ends_at = trace.ends_at()
    attempts = tuple(
        RescoredAttempt(
            was.attempt, was.seat, was.practice, was.level, _score(was), _score(trace.now[key])
        )
        for key, was in trace.was.items()
        if key in trace.now and (ends_at is None or was.attempt < ends_at)
    )
    other = [one.attempt for one in attempts if one.recorded.feedback != one.rescored.feedback]
    what_if = msgspec.to_builtins(session.task.parameters)
    return Rescored(
        session=row["id"],
        what_if={name: what_if[name] for name in changed},
        attempts=attempts,
        ends_at_attempt=ends_at,
        other_feedback_from=min(other, default=None),
    )


def changes_only_scores(kind: type[Task], name: str) -> bool:
    """Return True if a parameter changes scores, and prompts only by them: recorded inputs fit up
    to another prompt.
    """
    scores = {
        field.name
        for field in fields(kind.Parameters)
        if field.group in _GROUPS or field.name in _DETECTION
    }
    return name in scores and name not in _TIMED


class _Trace:
    """Compares the course of a session with the record: prompts, ends of trials and attempts, what
    operators decide on.

    Attributes:
        was: the recorded results of attempts, by attempt and seat.
        now: those that follow now.
    """

    def __init__(self) -> None:
        self.was: dict[tuple[int, str], AttemptEnded] = {}
        self.now: dict[tuple[int, str], AttemptEnded] = {}
        self._recorded: deque[_Step] = deque()
        self._derived: deque[_Step] = deque()
        self._attempt = 1

    def add(self, record: Record, cascade: Iterable[Record]) -> bool:
        """Add a recorded message and what follows from it now. Return False if the course is
        another one.
        """
        if record.topic.origin == "input" and (self._recorded or self._derived):
            return False
        for records, steps, results in (
            ([record], self._recorded, self.was),
            (cascade, self._derived, self.now),
        ):
            messages = [one.message for one in records]
            steps.extend(message for message in messages if isinstance(message, _Step))
            results.update(
                {(one.attempt, one.seat): one for one in messages if isinstance(one, AttemptEnded)}
            )
        while (
            self._recorded and self._derived and _is_same_step(self._recorded[0], self._derived[0])
        ):
            self._attempt = _attempt(self._recorded.popleft()) or self._attempt
            self._derived.popleft()
        return not (self._recorded and self._derived)

    def ends_at(self) -> int | None:
        """Return the attempt of the first step that differs, or is on one side only; None if there
        is none.
        """
        first = [*list(self._recorded)[:1], *list(self._derived)[:1]]
        return min((_attempt(step) or self._attempt for step in first), default=None)


_Step = Prompt | TrialEnded | AttemptEnded | PendingApproval


def _attempt(step: _Step) -> int | None:
    """Return the attempt of a step; None if it is between attempts."""
    return None if isinstance(step, PendingApproval) else step.attempt


def _is_same_step(recorded: _Step, derived: _Step) -> bool:
    match recorded, derived:
        case Prompt(), Prompt():
            return is_same(recorded, derived)
        case TrialEnded(), TrialEnded():
            return (recorded.attempt, recorded.trial, recorded.seat) == (
                derived.attempt,
                derived.trial,
                derived.seat,
            )
        case AttemptEnded(), AttemptEnded():
            return (recorded.attempt, recorded.seat) == (derived.attempt, derived.seat)
        case PendingApproval(), PendingApproval():
            was, now = recorded.proposal, derived.proposal
            return (was.id, was.kind, recorded.level) == (now.id, now.kind, derived.level)
    return False


def _score(ended: AttemptEnded) -> Score:
    return Score(ended.metric, ended.accuracy, ended.goal, ended.outcome, ended.feedback)
