"""Reads the record of an intervention from the database."""

import sqlite3
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from sar_tui.framework import messages as m
from sar_tui.framework import topics
from sar_tui.reports import logged_messages
from sar_tui.reports.deviations import deviations
from sar_tui.reports.intervention import Acts, Record
from sar_tui.reports.logged_messages import LoggedMessage, peers
from sar_tui.reports.pauses import pauses
from sar_tui.store import adverse_events, programmes, sessions
from sar_tui.store.results import sessions_of
from sar_tui.store.selection import Selection

_TOPICS = (
    topics.SESSION, topics.WAITING, topics.COMMAND, topics.SETTING, topics.MODE, topics.PRESENCE, topics.REFUSED,
    topics.LATE_DECISION, topics.LEVEL, topics.GOAL, topics.OUTPUT,
)  # fmt: skip
_THERAPIST = "therapist"
"""The actor of what is done on the participant's terminal with the therapist's keys."""
_PERSONS = ("operator", "mark", _THERAPIST)
"""Reasons of changes of level that persons made."""


def read(database: sqlite3.Connection, folder: Path, selection: Selection, progress: Callable[[], None]) -> Record:
    """Read what an intervention report needs of the chosen sessions.

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
    codes = selection.participants
    return Record(
        rows=selection.sessions,
        results={
            code: [each for each in sessions_of(database, code, folder=folder) if each.session in chosen]
            for code in codes
        },
        acts=acts,
        feedback=_feedback(database, selection.ids),
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
    outputs = set()
    for _, _, message in messages:
        match message:
            case m.LevelChanged(reason=reason) if reason in _PERSONS:
                acts.by_person[session] += 1
            case m.LevelChanged():
                (acts.up if message.level > message.previous else acts.down)[session] += 1
            case m.GoalChanged():
                acts.goals[session] += 1
            case m.SettingChanged():
                acts.deviations[_role(message.actor), f"setting {message.name}"] += 1
            case m.SessionCommand(command="skip", reason="attempt"):
                acts.skipped += 1
            case m.OutputOpened():
                outputs.add(message.address.partition(":")[0] or message.output)
    acts.outputs.update(outputs)


def _role(actor: str) -> str:
    """Return the role of who acted: the part of a name before its point."""
    return actor.partition(".")[0] or "program"


def _feedback(database: sqlite3.Connection, ids: Sequence[str]) -> Counter[str]:
    found = Counter[str]()
    for session in ids:
        found.update(
            dict(
                database.execute(
                    "SELECT feedback, count(*) FROM attempts WHERE session=? AND NOT practice GROUP BY feedback",
                    (session,),
                ).fetchall()
            )
        )
    return found
