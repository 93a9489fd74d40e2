"""Projections of the log: functions from a message to a row that follows from it.

A projection is pure: what it is given is the message, and where it came from. The recorder stores
its rows, and the examination of a log (`store.log_examination`) derives the same ones again.
"""

from collections.abc import Callable
from operator import attrgetter
from typing import Any, NamedTuple

import msgspec

from sar_tui.loop.bus import Record
from sar_tui.model import messages as m
from sar_tui.store import imu, log_hashes, records
from sar_tui.store.messages import Numbers, encoder
from sar_tui.store.tables import (
    ACTIONS,
    ANSWERS,
    ATTEMPTS,
    LOG_HASHES,
    MESSAGES,
    NOTES,
    TRIALS,
    Table,
)

Row = tuple[Any, ...]
Rows = dict[str, list[Row]]
"""Rows by the names of the statements that store them."""


class Origin(NamedTuple):
    """Source of a message.

    ``at``: the time of its cascade (ns). ``now``: the time of day at which it is stored, UTC.
    """

    session: str
    run: int
    at: int
    now: str


class Projection(NamedTuple):
    """The rows of a table that follow from messages of a kind.

    ``statement`` stores a row; ``row`` makes it, or returns None if nothing follows.
    """

    table: str
    kind: type[m.Message]
    statement: str
    row: Callable[[Origin, Any], Row | None]


def rows_of(session: str, run: int, records: list[Record], numbers: Numbers, now: str) -> Rows:
    """Return the rows of messages, by the names of the statements in ``SQL``.

    ``now``: the time at which they are stored, UTC.
    """
    rows = rows_beside(session, run, records, now)
    rows["messages"] = [
        (numbers.session, seq, run, at, numbers.topics[topic.name], encoder(topic)(message))
        for seq, at, topic, message in records
    ]
    return rows


def rows_beside(session: str, run: int, records: list[Record], now: str) -> Rows:
    """Return the rows of other tables that follow from messages, by the names of the statements in
    ``SQL``. ``now`` as in `rows_of`.
    """
    rows: Rows = {name: [] for name in SQL}
    for _, at, _, message in records:
        for name, projection in _BY_KIND.get(type(message), ()):
            row = projection.row(Origin(session, run, at, now), message)
            if row is not None:
                rows[name].append(row)
            if rows["marks"] and isinstance(message, m.TrialEnded):
                # earlier marks are in the trial's row already
                here = (session, message.attempt, message.trial, message.seat)
                rows["marks"] = [mark for mark in rows["marks"] if mark[-len(here) :] != here]
    return rows


_json = msgspec.json.Encoder()


def _text(value: object) -> str | None:
    return None if value is None else _json.encode(value).decode()


# --- tables whose columns are fields of one message

_OF_ORIGIN = ("session", "run")


def _declared(
    table: Table,
    kind: type[m.Message],
    how: str = "INSERT",
    **others: Callable[[Origin, Any], object],
) -> Projection:
    """Return the projection of a table whose columns are fields of a message (`tables.Column`).

    ``others``: columns that are made in another way.
    """
    of_origin = [name for name in _OF_ORIGIN if name in table.names]
    first = (*of_origin, *others)
    columns = [column for column in table.columns if column.name not in first]
    as_json = [place for place, column in enumerate(columns) if column.type == "json"]
    fields = attrgetter(*(column.field or column.name for column in columns))

    def row(origin: Origin, message: Any) -> Row:
        values = list(fields(message))
        for place in as_json:
            values[place] = _text(values[place])
        made = [make(origin, message) for make in others.values()]
        return (*origin[: len(of_origin)], *made, *values)

    statement = table.insert(*first, *(column.name for column in columns), how=how)
    return Projection(table.name, kind, statement, row)


# --- actions: proposed, decided on and carried out, each by a message of its own

_FIRST = (*ACTIONS.key, "kind", "proposed", "proposed_ns")
"""Columns of an action that later messages leave as they are."""


def _put(*names: str) -> str:
    """Return the statement that stores these columns of an action, or changes those of one that is
    there.
    """
    changed = ", ".join(f"{name}=excluded.{name}" for name in names if name not in _FIRST)
    return f"{ACTIONS.insert(*names)} ON CONFLICT DO UPDATE SET {changed}"


def _change(values: str) -> str:
    """Return the statement that changes an action, and does nothing if it is not there, such as a
    tone that nobody proposed.
    """
    return f"UPDATE actions SET {values} WHERE session=? AND id=?"


def _pending(origin: Origin, pending: m.PendingApproval) -> Row:
    return (*_proposal(origin, pending.proposal), pending.mode, pending.deadline)


def _proposal(origin: Origin, proposed: m.Proposal) -> Row:
    return (origin.session, proposed.id, proposed.kind, _text(proposed), origin.at)


def _decision(origin: Origin, action: m.Action) -> Row:
    return (
        origin.session,
        action.id,
        action.kind,
        _text(action),
        action.decision,
        action.actor,
        action.decided or origin.at,
        action.mode,
        action.ground,
    )


def _level_decision(origin: Origin, decided: m.LevelDecided) -> Row:
    final = None if decided.decision == "rejected" else _text({"level": decided.level})
    return (
        origin.session,
        decided.id,
        "difficulty",
        final,
        decided.decision,
        decided.actor,
        decided.at,
        decided.ground,
    )


_GROUNDS: dict[str, m.Ground] = {
    "vetoed": "operator",
    "expired": "deadline",
    "no operator": "no operator",
}
"""The ground of the decision to drop a proposal, by the reason."""


def _drop(origin: Origin, dropped: m.Dropped) -> Row:
    """Return the decision on a dropped proposal. Its actor is ``stop`` if the stop key was pressed
    by nobody who is an operator; an operator's stop key is an operator's decision.
    """
    decision, actor = "dropped", dropped.actor
    ground = _GROUNDS.get(dropped.reason, "mode")
    if dropped.reason == "vetoed":
        decision = "rejected"
    elif dropped.reason == "stopped" and actor == "agent":
        actor = "stop"
    elif dropped.reason == "stopped":
        ground = "operator"
    return (decision, actor, origin.at, dropped.reason, ground, origin.session, dropped.id)


def _start(origin: Origin, report: m.OutputReport) -> Row | None:
    if report.state != "started":
        return None
    return (report.at, origin.session, report.action)


def _end(origin: Origin, report: m.OutputReport) -> Row | None:
    if report.state not in ("done", "aborted", "failed"):
        return None
    return (report.at, origin.session, report.action)


# --- what a session leaves elsewhere

_TOLD_IN_PAUSES = {"pain": "pain", "tired": "tiredness"}
"""The kind of record that a pause leaves, by its reason."""


def _pause(origin: Origin, command: m.SessionCommand) -> Row | None:
    if command.command != "pause" or command.reason not in _TOLD_IN_PAUSES:
        return None
    id = f"{origin.session}-{origin.at}"
    kind = _TOLD_IN_PAUSES[command.reason]
    return (id, origin.session, command.seat, kind, origin.now)


def _taken_answer(origin: Origin, taken: m.TakenBack) -> Row | None:
    return (origin.session, taken.number) if taken.what == "answer" else None


def _taken_note(origin: Origin, taken: m.TakenBack) -> Row | None:
    return (origin.session, taken.done, taken.actor) if taken.what == "note" else None


def _refusal(origin: Origin, ended: m.SessionEnded) -> Row | None:
    """Keep nothing of those who did not agree, but their answer."""
    return (origin.session,) if ended.status == "refused" else None


PROJECTIONS = {
    "trials": _declared(TRIALS, m.TrialEnded),
    "marks": Projection(
        "trials",
        m.TrialMarked,
        "UPDATE trials SET correct=?, details=json_set(details, '$.mark', ?)"
        " WHERE session=? AND attempt=? AND trial=? AND seat=?",
        lambda origin, mark: (
            mark.correct, mark.mark or None, origin.session, mark.attempt, mark.trial, mark.seat,
        ),
    ),
    "attempts": _declared(ATTEMPTS, m.AttemptEnded, "INSERT OR REPLACE"),
    "answers": _declared(ANSWERS, m.StepEnded, "INSERT OR REPLACE"),
    "notes": _declared(NOTES, m.NoteAdded, at_ns=lambda origin, note: note.at or origin.at),
    "answers_taken_back": Projection(
        "answers", m.TakenBack, "DELETE FROM answers WHERE session=? AND number=?", _taken_answer
    ),
    "notes_taken_back": Projection(
        "notes",
        m.TakenBack,
        "DELETE FROM notes WHERE session=? AND at_ns=? AND author=?",
        _taken_note,
    ),
    "proposals": Projection(
        "actions",
        m.Proposal,
        ACTIONS.insert("session", "id", "kind", "proposed", "proposed_ns"),
        _proposal,
    ),
    "pending": Projection(
        "actions",
        m.PendingApproval,
        _put("session", "id", "kind", "proposed", "proposed_ns", "mode", "deadline_ns"),
        _pending,
    ),
    "seen": Projection(
        "actions",
        m.ProposalSeen,
        _change("shown_ns=MIN(?, COALESCE(shown_ns, 9e18))"),
        lambda origin, seen: (seen.at, origin.session, seen.action),
    ),
    "decisions": Projection(
        "actions",
        m.Action,
        _put("session", "id", "kind", "final", "decision", "actor", "decided_ns", "mode", "ground"),
        _decision,
    ),
    "drops": Projection(
        "actions",
        m.Dropped,
        _change(
            "final=NULL, decision=?, actor=?, decided_ns=?, reason=?,"
            " mode=COALESCE(mode, 'autonomous'), ground=?"
        ),
        _drop,
    ),
    "level_decisions": Projection(
        "actions",
        m.LevelDecided,
        _put("session", "id", "kind", "final", "decision", "actor", "decided_ns", "ground"),
        _level_decision,
    ),
    "starts": Projection(
        "actions", m.OutputReport, _change("started_ns=MIN(?, COALESCE(started_ns, 9e18))"), _start
    ),
    "ends": Projection(
        "actions", m.OutputReport, _change("ended_ns=MAX(?, COALESCE(ended_ns, 0))"), _end
    ),
    "pauses": Projection("records", m.SessionCommand, records.PAUSES, _pause),
    "refusals": Projection(
        "records", m.SessionEnded, "DELETE FROM records WHERE session=?", _refusal
    ),
    "session_ends": Projection(
        "sessions",
        m.SessionEnded,
        "UPDATE sessions SET status=?, ended_at=? WHERE id=?",
        lambda origin, ended: (ended.status, origin.now, origin.session),
    ),
}  # fmt: skip
"""All projections, in the order in which the rows of a batch are stored."""

SQL = {
    "messages": MESSAGES.insert(),
    "streams": imu.INSERT_STREAM,
    "chunks": imu.INSERT_CHUNK,
    **{name: projection.statement for name, projection in PROJECTIONS.items()},
    "log_hashes": LOG_HASHES.insert(),
    "last_hashes": log_hashes.SET_LAST,
}
"""The statements for the rows of a batch, in order of execution."""

_BY_KIND = {
    kind: [(name, each) for name, each in PROJECTIONS.items() if each.kind is kind]
    for kind in {each.kind for each in PROJECTIONS.values()}
}
KINDS = frozenset(_BY_KIND)
"""Messages that become more than a row of ``messages``: a small part of all."""
