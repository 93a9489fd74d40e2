"""Reads the record of an intervention from the database."""

import sqlite3
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Literal

from sar_tui.loop import topics
from sar_tui.model import messages as m
from sar_tui.reports import logged_messages
from sar_tui.reports.deviations import deviations
from sar_tui.reports.intervention import Acts, Record
from sar_tui.reports.logged_messages import LoggedMessage, peers
from sar_tui.reports.pauses import pauses
from sar_tui.store import adverse_events, programmes, sessions
from sar_tui.store.results import sessions_of
from sar_tui.store.selection import Selection

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
        events=[event for code in codes for event in adverse_events.listing(database, code)],
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
                    yield from _changes(message.level - last.level, changes)
                last = message


def _changes(
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
