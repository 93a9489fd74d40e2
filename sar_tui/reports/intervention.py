"""The intervention that was given in some sessions, as a paper must report it."""

import sqlite3
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import date, datetime
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any, Literal

import msgspec

from sar_tui.loop import topics
from sar_tui.model import messages as m
from sar_tui.progress.lines import SessionResults
from sar_tui.records.kind import of_group
from sar_tui.reports import logged_messages
from sar_tui.reports.deviations import deviations, pauses
from sar_tui.reports.dose import planned_attempts
from sar_tui.reports.logged_messages import LoggedMessage, peers
from sar_tui.rules.wellbeing import SEVERE
from sar_tui.store import programmes, records, sessions
from sar_tui.store.programmes import Programme
from sar_tui.store.records import Record as PersonRecord
from sar_tui.store.results import sessions_of
from sar_tui.store.selection import Selection
from sar_tui.store.training_days import trained_at

_WEEK = 7
_CHALLENGE = (
    "difficulty_policy",
    "start_from",
    "min_level",
    "max_level",
    "threshold",
    "min_accuracy",
)
_FEEDBACK = (
    "feedback_schedule",
    "feedback_form",
    "feedback_compared_with",
    "feedback_delay_ms",
    "outputs",
    "language",
)
_ACCESS = {
    "switch": "none",
    "scan_interval_ms": 0,
    "bounce_ms": 0,
    "system_keys": "not asked",
    "added_delay_ms": 0,
}
"""Settings of access, which are told if they are used: those of nobody."""
_DOSE = (
    "attempts", "prompts_per_attempt", "reaches_per_attempt", "practice_attempts",
    "planned_attempts_a_day", "attempts_a_day", "minutes_a_day", "session_minutes",
    "days_between_visits", "rest_every", "rest_after_attempts", "rest_seconds",
)  # fmt: skip


class Spread(msgspec.Struct, frozen=True):
    """Median, least and greatest of some values."""

    median: float
    least: float
    most: float


class TaskGiven(msgspec.Struct, frozen=True):
    """A task that was given.

    Attributes:
        versions: of the task, in all sessions.
        settings: values of each setting of dose, challenge and feedback, the commonest first.
    """

    task: str
    title: str
    versions: list[str]
    sessions: int
    settings: dict[str, list[Any]]


class PersonDose(msgspec.Struct, frozen=True):
    """The dose that a participant got.

    Attributes:
        days: on which they trained; ``span_days``: from the first of them to the last.
        sessions_a_week: None in less than a week.
        planned, done: attempts without practice.
        repetitions: prompts or reaches in the attempts done.
        time_on_task_min: in attempts.
        time_in_sessions_min: with instructions, feedback and rests; None if it is not known, as of
            simulated sessions.
    """

    participant: str
    sessions: int
    days: int
    span_days: int
    sessions_a_week: float | None
    planned: int
    done: int
    repetitions: int
    time_on_task_min: float
    time_in_sessions_min: float | None


class PersonChallenge(msgspec.Struct, frozen=True):
    """The challenge that a participant met in a task, and how it progressed.

    Attributes:
        first_level, last_level: of the first attempt of the first session, and of the last attempt
            of the last.
        lowest, highest: levels that were played.
        reached_share: of the attempts, that reached the goal; ``right_share``: of the responses,
            that were right.
        up, down: changes of level by the rule; ``by_person``: by a therapist or operator.
        goals: changes of the goal otherwise than with the level. All only if an attempt was played
            with them.
    """

    participant: str
    task: str
    sessions: int
    first_level: int
    last_level: int
    lowest: int
    highest: int
    reached_share: float | None
    right_share: float | None
    up: int
    down: int
    by_person: int
    goals: int


class ProgrammeChange(msgspec.Struct, frozen=True):
    """A version of a participant's programme, from its second on: the settings it changed, and
    why.
    """

    participant: str
    task: str
    version: int
    saved_at: str
    changed: dict[str, Any]
    reason: str


class Harms(msgspec.Struct, frozen=True):
    """Adverse events by severity, and what participants said of pain and tiredness.

    Attributes:
        sessions_with_pain: with pain of 1 or more, or told in a pause; ``severe``: with 7 or more
            of 10.
        asked: sessions in which something is known of pain.
    """

    events: dict[str, int]
    asked: int
    sessions_with_pain: int
    severe: int
    worst_pain: int | None
    worst_tiredness: int | None


class Acts(msgspec.Struct):
    """Counts over the messages of sessions.

    Attributes:
        up, down, by_person, goals: changes of level and goal, by session.
        deviations: by actor and type.
        skipped: attempts left out; ``pauses``: of participants, by reason.
        outputs: addresses, or names, of what showed and said it.
    """

    up: Counter[str] = msgspec.field(default_factory=Counter)
    down: Counter[str] = msgspec.field(default_factory=Counter)
    by_person: Counter[str] = msgspec.field(default_factory=Counter)
    goals: Counter[str] = msgspec.field(default_factory=Counter)
    deviations: Counter[tuple[str, str]] = msgspec.field(default_factory=Counter)
    skipped: int = 0
    pauses: Counter[str] = msgspec.field(default_factory=Counter)
    outputs: Counter[str] = msgspec.field(default_factory=Counter)


class InterventionReport(msgspec.Struct, frozen=True):
    """The intervention over some sessions.

    Attributes:
        first, last: local days of the first and last session.
        modes, statuses, feedback: numbers of sessions by mode and status; of attempts by feedback.
        software: versions of the program.
        operated: sessions with an operator.
        dose: by participant; ``repetitions_a_session``, ``minutes_a_session`` (time on task): over
            all sessions.
        adherence: done of the planned attempts; None if none was planned.
        challenge: by participant and task. ``reached_share``: over all attempts.
        programmes: changes of programmes. ``differing``: settings with more than one value, by
            task.
        deviations: number by who caused them and what they were.
    """

    sessions: list[str]
    participants: list[str]
    first: str
    last: str
    modes: dict[str, int]
    statuses: dict[str, int]
    software: list[str]
    tasks: list[TaskGiven]
    outputs: dict[str, int]
    operated: int
    dose: list[PersonDose]
    repetitions_a_session: Spread | None
    minutes_a_session: Spread | None
    adherence: float | None
    challenge: list[PersonChallenge]
    reached_share: float | None
    feedback: dict[str, int]
    programmes: list[ProgrammeChange]
    deviations: dict[str, dict[str, int]]
    skipped: int
    pauses: dict[str, int]
    harms: Harms


class Record(msgspec.Struct, frozen=True):
    """The record of the sessions.

    Attributes:
        rows: as `store.sessions.listing` returns them, in the order in which they were played.
        results: of each participant in these sessions, in their order.
        acts: counted in their messages.
        feedback: number of attempts by feedback.
        operated: sessions with an operator.
        programmes: versions of programmes by participant and task.
        events: adverse events of the participants.
    """

    rows: Sequence[Mapping[str, Any]]
    results: Mapping[str, Sequence[SessionResults]]
    acts: Acts
    feedback: Mapping[str, int]
    operated: int
    programmes: Mapping[tuple[str, str], Sequence[Programme]]
    events: Sequence[PersonRecord]


def intervention(record: Record) -> InterventionReport:
    """Report on an intervention from its record. There is at least one session."""
    rows, acts = record.rows, record.acts
    days = [_began(row).date() for row in rows]
    played = [each for results in record.results.values() for each in results]
    dose = [_dose(code, results, rows) for code, results in record.results.items() if results]
    planned = sum(each.planned for each in dose)
    deviations: dict[str, dict[str, int]] = {}
    for (actor, what), n in sorted(acts.deviations.items()):
        deviations.setdefault(actor, {})[what] = n
    return InterventionReport(
        sessions=[row["id"] for row in rows],
        participants=list(record.results),
        first=min(days).isoformat(),
        last=max(days).isoformat(),
        modes=dict(Counter(row["mode"] for row in rows)),
        statuses=dict(Counter(row["status"] for row in rows)),
        software=sorted({str(row["software"].get("sar_tui", "")) for row in rows} - {""}),
        tasks=_tasks(rows),
        outputs=dict(acts.outputs),
        operated=record.operated,
        dose=dose,
        repetitions_a_session=_spread([each.trials for each in played]),
        minutes_a_session=_spread([round(each.seconds / 60, 2) for each in played]),
        adherence=round(sum(each.done for each in dose) / planned, 4) if planned else None,
        challenge=[
            each
            for code, results in record.results.items()
            for each in _challenge(code, results, acts)
        ],
        reached_share=_reached_share(played),
        feedback=dict(record.feedback),
        programmes=list(_changes(record.programmes)),
        deviations=deviations,
        skipped=acts.skipped,
        pauses=dict(acts.pauses),
        harms=_harms(played, record.events),
    )


def _began(row: Mapping[str, Any]) -> datetime:
    return trained_at(row["started_at"], row.get("utc_offset_s"))


def _minutes(row: Mapping[str, Any]) -> float:
    """Return how long a session took, in min; 0 if it has no end."""
    if not row["ended_at"]:
        return 0.0
    took = datetime.fromisoformat(row["ended_at"]) - datetime.fromisoformat(row["started_at"])
    return max(0.0, took.total_seconds() / 60)


def _reached_share(played: Sequence[SessionResults]) -> float | None:
    """Return the share of attempts that reached their goal, of sessions whose attempts had one;
    None without any.
    """
    judged = [each for each in played if each.reached is not None]
    attempts = sum(len(each.results) for each in judged)
    return round(sum(each.reached or 0 for each in judged) / attempts, 4) if attempts else None


def _spread(values: Sequence[float]) -> Spread | None:
    return Spread(round(median(values), 2), min(values), max(values)) if values else None


def _tasks(rows: Sequence[Mapping[str, Any]]) -> list[TaskGiven]:
    made = []
    for task in dict.fromkeys(row["task"] for row in rows):
        own = [row for row in rows if row["task"] == task]
        about = [row["software"].get("task") or {} for row in own]
        made.append(
            TaskGiven(
                task=task,
                title=str(about[-1].get("title") or task),
                versions=sorted({str(each.get("version", "")) for each in about} - {""}),
                sessions=len(own),
                settings={
                    name: values
                    for name in (*_DOSE, *_CHALLENGE, *_FEEDBACK, *_ACCESS)
                    if (values := _values(row["parameters"].get(name) for row in own))
                    and values != [_ACCESS.get(name, "")]
                },
            )
        )
    return made


def _values(given: Iterable[Any]) -> list[Any]:
    """Return the different values, the commonest first; a setting that no session has has none."""
    counted: dict[str, tuple[int, Any]] = {}
    for value in given:
        if value is not None:
            count, _ = counted.get(repr(value), (0, None))
            counted[repr(value)] = (count + 1, value)
    return [value for _, value in sorted(counted.values(), key=lambda pair: -pair[0])]


def _dose(
    code: str, results: Sequence[SessionResults], rows: Sequence[Mapping[str, Any]]
) -> PersonDose:
    days = sorted({each.began.date() for each in results})
    span = (days[-1] - days[0]).days + 1
    own = {each.session for each in results}
    on_task = sum(each.seconds for each in results) / 60
    in_sessions = sum(_minutes(row) for row in rows if row["id"] in own)
    return PersonDose(
        participant=code,
        sessions=len(results),
        days=len(days),
        span_days=span,
        sessions_a_week=round(len(results) / span * _WEEK, 2) if span >= _WEEK else None,
        planned=sum(map(planned_attempts, results)),
        done=sum(len(each.results) for each in results),
        repetitions=sum(each.trials for each in results),
        time_on_task_min=round(on_task, 2),
        time_in_sessions_min=round(in_sessions, 2) if in_sessions >= on_task else None,
    )


def _challenge(
    code: str, results: Sequence[SessionResults], acts: Acts
) -> Iterable[PersonChallenge]:
    for task in dict.fromkeys(each.task for each in results):
        own = [each for each in results if each.task == task and each.results]
        if not own:
            continue
        levels = [result.level for each in own for result in each.results]
        trials = sum(each.trials for each in own)
        yield PersonChallenge(
            participant=code,
            task=task,
            sessions=len(own),
            first_level=levels[0],
            last_level=levels[-1],
            lowest=min(levels),
            highest=max(levels),
            reached_share=_reached_share(own),
            right_share=round(sum(each.right for each in own) / trials, 4) if trials else None,
            up=sum(acts.up[each.session] for each in own),
            down=sum(acts.down[each.session] for each in own),
            by_person=sum(acts.by_person[each.session] for each in own),
            goals=sum(acts.goals[each.session] for each in own),
        )


def _changes(
    programmes: Mapping[tuple[str, str], Sequence[Programme]],
) -> Iterable[ProgrammeChange]:
    for (participant, task), versions in programmes.items():
        for before, after in pairwise(versions):
            names = {*before.parameters, *after.parameters}
            changed = {
                name: after.parameters.get(name)
                for name in sorted(names)
                if before.parameters.get(name) != after.parameters.get(name)
            }
            yield ProgrammeChange(
                participant, task, after.version, after.created_at, changed, after.reason
            )


def _harms(played: Sequence[SessionResults], events: Sequence[PersonRecord]) -> Harms:
    pain = [each.felt.pain for each in played if each.felt.pain is not None]
    return Harms(
        events=dict(Counter(str(event.content["severity"]) for event in events)),
        asked=len(pain),
        sessions_with_pain=sum(one > 0 for one in pain),
        severe=sum(one >= SEVERE for one in pain),
        worst_pain=max(pain, default=None),
        worst_tiredness=max(
            (each.felt.fatigue for each in played if each.felt.fatigue is not None), default=None
        ),
    )


def days_between(first: str, last: str) -> int:
    """Return the number of days from one to another, both counted."""
    return (date.fromisoformat(last) - date.fromisoformat(first)).days + 1


_TOPICS = (
    topics.SESSION, topics.WAITING, topics.COMMAND, topics.SETTING, topics.MODE, topics.PRESENCE,
    topics.REFUSED, topics.LATE_DECISION, topics.LEVEL, topics.GOAL, topics.OUTPUT,
    topics.ATTEMPT_STARTED, topics.ATTEMPT_ENDED,
)  # fmt: skip
_THERAPIST = "therapist"
"""The actor of what is done on the participant's terminal with the therapist's keys."""
_PERSONS = ("operator", "mark", _THERAPIST)
"""Reasons of changes of level that persons made."""


def read(
    database: sqlite3.Connection, folder: Path, selection: Selection, progress: Callable[[], None]
) -> Record:
    """Read what an intervention report needs of the chosen sessions.

    If those of one participant were asked for, nothing of a partner in them is read.

    Args:
        database: only read.
        folder: the data folder.
        selection: the sessions.
        progress: called after each session.

    Raises:
        StoreError: this version of the program cannot read a message.
    """
    chosen = set(selection.ids)
    acts = Acts()
    for session in selection.ids:
        _count(logged_messages.read_topics(database, session, _TOPICS), session, acts)
        progress()
    operated = sessions.operators(database)
    kinds = [kind.name for kind in of_group("event")]
    codes = [selection.of] if selection.of else selection.participants
    return Record(
        rows=selection.sessions,
        results={
            code: [
                each
                for each in sessions_of(database, code, folder=folder)
                if each.session in chosen
            ]
            for code in codes
        },
        acts=acts,
        feedback=_feedback(database, selection.ids, codes),
        operated=sum(session in operated for session in chosen),
        programmes={
            (code, task): programmes.versions(database, code, task)
            for code in codes
            for task in programmes.tasks(database, code)
            if task in selection.tasks
        },
        events=[
            event
            for code in codes
            for event in records.listing(database, kinds=kinds, participant=code)
        ],
    )


def _count(messages: Sequence[LoggedMessage], session: str, acts: Acts) -> None:
    """Add what happened in a session."""
    operators = [*peers(messages, "operator"), _THERAPIST]
    for each in deviations(messages, operators):
        acts.deviations[_role(each.actor), each.what] += each.count
    for pause in pauses(messages, operators):
        acts.pauses[pause.reason] += 1
    for change in changes_played(each.message for each in messages):
        getattr(acts, change)[session] += 1
    outputs = set()
    for _, _, message in messages:
        match message:
            case m.SettingChanged():
                acts.deviations[_role(message.actor), f"setting {message.name}"] += 1
            case m.SessionCommand(command="skip", reason="attempt"):
                acts.skipped += 1
            case m.OutputOpened():
                outputs.add(message.address.partition(":")[0] or message.output)
    acts.outputs.update(outputs)


def changes_played(
    messages: Iterable[m.Message],
) -> Iterator[Literal["up", "down", "by_person", "goals"]]:
    """Yield the changes of level and goal of a session that an attempt was played with; practice is
    left out.

    A change after the last attempt, or one that was taken back before the next, was never played.
    """
    coming: list[m.Message] = []
    """Changes since the last attempt began."""
    changes: list[m.Message] = []
    """Changes before the attempt that is under way."""
    last: m.AttemptEnded | None = None
    for message in messages:
        match message:
            case m.LevelChanged() | m.GoalChanged():
                coming.append(message)
            case m.AttemptStarted():
                changes, coming = coming, []
            case m.AttemptEnded(practice=False):
                if last and message.attempt != last.attempt:
                    yield from _level_changes(message.level - last.level, changes)
                last = message


def _level_changes(
    rise: int, changes: Sequence[m.Message]
) -> Iterator[Literal["up", "down", "by_person", "goals"]]:
    reasons = [change.reason for change in changes if isinstance(change, m.LevelChanged)]
    if rise:
        yield "by_person" if reasons and reasons[-1] in _PERSONS else "up" if rise > 0 else "down"
    if any(isinstance(change, m.GoalChanged) for change in changes):
        yield "goals"


def _role(actor: str) -> str:
    """Return the role of who acted: the part of a name before its point."""
    return actor.partition(".")[0] or "program"


def _feedback(
    database: sqlite3.Connection, ids: Sequence[str], codes: Sequence[str]
) -> Counter[str]:
    """Return the number of attempts of some participants in some sessions, by feedback."""
    found = Counter[str]()
    query = (
        "SELECT feedback, count(*) FROM attempts JOIN seats USING (session, seat) WHERE session=? "
        f"AND NOT practice AND participant IN ({','.join('?' * len(codes))}) GROUP BY feedback"
    )
    for session in ids:
        found.update(dict(database.execute(query, (session, *codes)).fetchall()))
    return found
