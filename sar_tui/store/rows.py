"""Turns messages into rows of the database."""

from datetime import UTC, datetime
from typing import Any

import msgspec

from sar_tui.loop.bus import Record
from sar_tui.model import messages as m
from sar_tui.store import imu, log_hashes, wellbeing
from sar_tui.store.messages import Numbers, encoder

Rows = dict[str, list[tuple[Any, ...]]]

SQL = {
    "messages": "INSERT INTO messages (session_number, seq, run, at_ns, topic, message) VALUES "
    "(?,?,?,?,?,?)",
    "trials": (
        "INSERT INTO trials (session, attempt, trial, seat, run, stimulus, response, correct, "
        "onset_ns, response_ns,"
        " reaction_time_ms, timing, details, data) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?)"
    ),
    "marks": (
        "UPDATE trials SET correct=?, details=json_set(details, '$.mark', ?)"
        " WHERE session=? AND attempt=? AND trial=? AND seat=?"
    ),
    "streams": imu.INSERT_STREAM,
    "chunks": imu.INSERT_CHUNK,
    "attempts": (
        "INSERT OR REPLACE INTO attempts (session, attempt, seat, run, practice, level, metric, "
        "metric_unit, accuracy,"
        " correct, trials, outcome, feedback, started_ns, ended_ns, goal, qualities, choice,"
        " condition) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)"
    ),
    "proposals": "INSERT INTO actions (session, id, kind, proposed, proposed_ns) VALUES "
    "(?,?,?,?,?)",
    "pending": (
        "INSERT INTO actions (session, id, kind, proposed, proposed_ns, mode, deadline_ns) VALUES "
        "(?,?,?,?,?,?,?)"
        " ON CONFLICT DO UPDATE SET mode=excluded.mode, deadline_ns=excluded.deadline_ns"
    ),
    "seen": "UPDATE actions SET shown_ns=MIN(?, COALESCE(shown_ns, 9e18)) WHERE session=? AND id=?",
    "decisions": (
        "INSERT INTO actions (session, id, kind, final, decision, actor, decided_ns, mode, ground)"
        " VALUES (?,?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET final=excluded.final, "
        "decision=excluded.decision,"
        " actor=excluded.actor, decided_ns=excluded.decided_ns, mode=excluded.mode, "
        "ground=excluded.ground"
    ),
    "drops": (
        "UPDATE actions SET final=NULL, decision=?, actor=?, decided_ns=?, reason=?, "
        "mode=COALESCE(mode, 'autonomous'),"
        " ground=? WHERE session=? AND id=?"
    ),
    "level_decisions": (
        "INSERT INTO actions (session, id, kind, final, decision, actor, decided_ns, ground)"
        " VALUES (?,?,'difficulty',?,?,?,?,?) ON CONFLICT DO UPDATE SET final=excluded.final,"
        " decision=excluded.decision, actor=excluded.actor, decided_ns=excluded.decided_ns, "
        "ground=excluded.ground"
    ),
    "answers": (
        "INSERT OR REPLACE INTO answers (session, number, run, attempt, seat, step, kind, text, "
        "labels, status, answer,"
        " shown_ns, answered_ns) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)"
    ),
    "notes": "INSERT INTO notes (session, at_ns, author, text, label) VALUES (?,?,?,?,?)",
    "starts": "UPDATE actions SET started_ns=MIN(?, COALESCE(started_ns, 9e18)) WHERE session=? "
    "AND id=?",
    "ends": "UPDATE actions SET ended_ns=MAX(?, COALESCE(ended_ns, 0)) WHERE session=? AND id=?",
    "pauses": wellbeing.PAUSES,
    "refusals": "DELETE FROM wellbeing WHERE session=?",
    "log_hashes": log_hashes.INSERT,
    "last_hashes": log_hashes.SET_LAST,
    "session_ends": "UPDATE sessions SET status=?, ended_at=? WHERE id=?",
}
"""The statements for the rows of a batch, in order of execution."""

_json = msgspec.json.Encoder()


def _text(value: object) -> str:
    return _json.encode(value).decode()


_OF_ATTEMPTS = {m.TrialEnded, m.TrialMarked, m.AttemptEnded, m.StepEnded}
_OF_ACTIONS = {
    m.Proposal,
    m.PendingApproval,
    m.ProposalSeen,
    m.Action,
    m.Dropped,
    m.LevelDecided,
    m.OutputReport,
}
_OF_SESSIONS = {m.NoteAdded, m.SessionCommand, m.SessionEnded}
KINDS = frozenset(_OF_ATTEMPTS | _OF_ACTIONS | _OF_SESSIONS)
"""Messages that become more than a row of ``messages``: a small part of all."""


def rows_of(session: str, run: int, records: list[Record], numbers: Numbers) -> Rows:
    """Return the rows of messages, by the names of the statements in ``SQL``."""
    rows = rows_beside(session, run, records)
    rows["messages"] = [
        (numbers.session, seq, run, at, numbers.topics[topic.name], encoder(topic)(message))
        for seq, at, topic, message in records
    ]
    return rows


def rows_beside(session: str, run: int, records: list[Record]) -> Rows:
    """Return the rows of other tables that follow from messages, by the names of the statements in
    ``SQL``.
    """
    rows: Rows = {kind: [] for kind in SQL}
    for _, at, _, message in records:
        kind = type(message)
        if kind in _OF_ATTEMPTS:
            _add_attempts(rows, session, run, message)
        elif kind in _OF_ACTIONS:
            _add_actions(rows, session, at, message)
        elif kind in _OF_SESSIONS:
            _add_to_session(rows, session, at, message)
    return rows


_SAID_IN_PAUSES = {"pain": "pain", "tired": "fatigue"}
"""The question that a pause answers, by its reason."""


def _add_to_session(rows: Rows, session: str, at: int, message: m.Message) -> None:
    match message:
        case m.NoteAdded() as n:
            rows["notes"].append((session, n.at or at, n.actor, n.text, n.label))
        case m.SessionCommand(command="pause") as c if c.reason in _SAID_IN_PAUSES:
            rows["pauses"].append((session, c.seat, _SAID_IN_PAUSES[c.reason], wellbeing.now()))
        case m.SessionEnded() as e:
            rows["session_ends"].append((e.status, datetime.now(UTC).isoformat(), session))
            # nothing is kept of those who did not agree, but their answer
            if e.status == "refused":
                rows["refusals"].append((session,))


def _add_attempts(rows: Rows, session: str, run: int, message: m.Message) -> None:
    match message:
        case m.TrialEnded() as t:
            # earlier marks are in the trial's row already
            here = (
                session,
                t.attempt,
                t.trial,
                t.seat,
            )
            rows["marks"] = [mark for mark in rows["marks"] if mark[2:] != here]
            rows["trials"].append(
                (session, t.attempt, t.trial, t.seat, run, t.stimulus, t.response, t.correct, t.onset,
                 t.response_at, t.reaction_time_ms, _text(t.timing), _text(t.details), _text(t.data))
            )  # fmt: skip
        case m.TrialMarked() as k:
            rows["marks"].append((k.correct, k.mark or None, session, k.attempt, k.trial, k.seat))
        case m.StepEnded() as s:
            answer = None if s.answer is None else _text(s.answer)
            rows["answers"].append(
                (session, s.number, run, s.attempt, s.seat, s.name, s.kind, s.text, _text(s.labels), s.status, answer,
                 s.shown, s.ended)
            )  # fmt: skip
        case m.AttemptEnded() as a:
            rows["attempts"].append(
                (session, a.attempt, a.seat, run, a.practice, a.level, a.metric, a.metric_unit, a.accuracy,
                 a.correct, a.trials, a.outcome, a.feedback, a.started, a.ended, a.goal, _text(a.qualities),
                 _text(a.choice), a.condition)
            )  # fmt: skip


def _add_actions(rows: Rows, session: str, at: int, message: m.Message) -> None:
    match message:
        case m.Proposal() as p:
            rows["proposals"].append((session, p.id, p.kind, _text(p), at))
        case m.PendingApproval() as o:
            p = o.proposal
            rows["pending"].append((session, p.id, p.kind, _text(p), at, o.mode, o.deadline))
        case m.ProposalSeen() as s:
            rows["seen"].append((s.at, session, s.action))
        case m.Action() as a:
            decided = a.decided or at
            rows["decisions"].append(
                (session, a.id, a.kind, _text(a), a.decision, a.actor, decided, a.mode, a.ground)
            )
        case m.Dropped() as d:
            rows["drops"].append((*_dropped(d), at, d.reason, _ground(d), session, d.id))
        case m.LevelDecided() as r:
            final = None if r.decision == "rejected" else _text({"level": r.level})
            rows["level_decisions"].append(
                (session, r.id, final, r.decision, r.actor, r.at, r.ground)
            )
        case m.OutputReport(state="started") as r:
            rows["starts"].append((r.at, session, r.action))
        case m.OutputReport(state="done" | "aborted" | "failed") as r:
            rows["ends"].append((r.at, session, r.action))


_GROUNDS: dict[str, m.Ground] = {
    "vetoed": "operator",
    "expired": "deadline",
    "no operator": "no operator",
}
"""The ground of the decision to drop a proposal, by the reason."""


def _ground(dropped: m.Dropped) -> m.Ground:
    """Return the ground of a dropped proposal. An operator's stop key is an operator's decision."""
    is_operators = dropped.reason == "stopped" and dropped.actor != "agent"
    return "operator" if is_operators else _GROUNDS.get(dropped.reason, "mode")


def _dropped(dropped: m.Dropped) -> tuple[str, str]:
    """Return the decision on a dropped proposal and its actor: ``stop`` for the stop key if no
    operator pressed it.
    """
    if dropped.reason == "vetoed":
        return "rejected", dropped.actor
    is_stop_key = dropped.reason == "stopped" and dropped.actor == "agent"
    return "dropped", "stop" if is_stop_key else dropped.actor
