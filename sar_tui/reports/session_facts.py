"""Lines on what happened in a session: levels, rests, skipped attempts, feedback."""

import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec

from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    COMMAND,
    GOAL,
    LEVEL,
    STEP_ENDED,
    TAKEN_BACK,
    WAITING,
)
from sar_tui.model.messages import (
    AttemptEnded,
    GoalChanged,
    LevelChanged,
    SessionCommand,
    StepEnded,
    TakenBack,
    Waiting,
)
from sar_tui.model.units import SECOND
from sar_tui.store.records import Record

_LEVELS_READ = {ATTEMPT_ENDED.name: AttemptEnded, LEVEL.name: LevelChanged, GOAL.name: GoalChanged}


def level_changes(database: sqlite3.Connection, session: str) -> list[str]:
    """Return a line for each change of level or goal in a session, in order."""
    rows = database.execute(
        "SELECT topic, message FROM events WHERE session=? AND topic IN "
        f"({','.join('?' * len(_LEVELS_READ))}) ORDER BY seq",
        (session, *_LEVELS_READ),
    )
    attempt, found = 0, []
    for topic, text in rows:
        match msgspec.json.decode(text, type=_LEVELS_READ[topic]):
            case AttemptEnded() as ended:
                attempt = ended.attempt
            case LevelChanged() as change:
                found.append(
                    f"After attempt {attempt}: level {change.previous} → {change.level}. "
                    f"{change.why}".rstrip()
                )
            case GoalChanged() as change:
                values = f"{change.previous:.4g} → {change.goal:.4g} {change.unit}".rstrip()
                found.append(f"After attempt {attempt}: goal {values}. {change.why}")
    return found


_WAITS_READ = {WAITING.name: Waiting, COMMAND.name: SessionCommand}


def rests(database: sqlite3.Connection, session: str) -> list[str]:
    """Return a line for each rest of a session, in order: its length, pauses included, and who
    ended it early.
    """
    rows = database.execute(
        "SELECT run, at_ns, topic, message FROM events WHERE session=? AND topic IN (?, ?) ORDER "
        "BY seq",
        (session, *_WAITS_READ),
    )
    found: list[str] = []
    began: tuple[int, int, int] | None = None
    ended_by = ""
    for run, at, topic, text in rows:
        message = msgspec.json.decode(text, type=_WAITS_READ[topic])
        if began and began[0] != run:
            began = None
        if isinstance(message, SessionCommand):
            is_end = message.command == "skip" and message.reason != "attempt"
            ended_by = message.actor if is_end and began else ended_by
        elif message.stage == "rest" and began is None:
            began, ended_by = (run, at, message.attempt - 1), ""
        elif began and message.stage not in ("rest", "paused"):
            early = f", ended by the {ended_by}" if ended_by else ""
            found.append(
                f"After attempt {began[2]}: a rest of {(at - began[1]) / SECOND:.0f} s{early}."
            )
            began = None
    return found


def skipped_attempts(database: sqlite3.Connection, session: str) -> list[str]:
    """Return a line for each attempt of a session that was left out, by whom and when, or that
    began again.
    """
    rows = database.execute(
        "SELECT topic, message FROM events WHERE session=? AND topic IN (?, ?, ?) ORDER BY seq",
        (session, *_WAITS_READ, TAKEN_BACK.name),
    )
    found: list[str] = []
    was_taken_back = False
    last = Waiting(what="nothing", stage="instructions")
    left_out: tuple[Waiting, str] | None = None
    restarts = 0
    for topic, text in rows:
        if topic == TAKEN_BACK.name:
            was_taken_back = True
            continue
        message = msgspec.json.decode(text, type=_WAITS_READ[topic])
        if isinstance(message, SessionCommand):
            was_taken_back = False
            is_skip = message.command == "skip" and message.reason == "attempt"
            left_out = (last, message.actor) if is_skip else None
            continue
        if message.restarts > restarts:
            restarts = message.restarts
            why = "begun by mistake" if was_taken_back else "interrupted"
            found.append(
                f"Attempt {message.attempt - 1} was {why}; attempt {message.attempt} began it again."
            )
        if left_out and message.stage in ("attempt", "review", "answer"):
            at, actor = left_out
            done = (
                f"after {at.trial - 1} of {at.trials} trials"
                if at.trial > 1
                else "before its first trial ended"
            )
            found.append(f"Attempt {at.attempt} was skipped by the {actor}, {done}.")
        last, left_out = message, None
    return found


_TAKEN_BACK = {
    "level": "a change of level",
    "hold": "a held level, or its release",
    "setting": "a setting",
    "mark": "a mark",
    "note": "a note",
}


def taken_back(database: sqlite3.Connection, session: str) -> list[str]:
    """Return a line for each act in a session that was taken back, in order, except attempts, of
    which `skipped_attempts` tells.
    """
    rows = database.execute(
        "SELECT topic, message FROM events WHERE session=? AND topic IN (?, ?) ORDER BY seq",
        (session, STEP_ENDED.name, TAKEN_BACK.name),
    )
    found, last = [], ""
    for topic, text in rows:
        if topic == STEP_ENDED.name:
            last = msgspec.json.decode(text, type=StepEnded).name
            continue
        taken = msgspec.json.decode(text, type=TakenBack)
        if taken.what != "attempt":
            what = _TAKEN_BACK.get(taken.what, f"the answer to {last}")
            found.append(f"Taken back by the {taken.actor}: {what}.")
    return found


def reported_changes(actions: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return a line for each feedback that was said and reported a change, in order.

    Args:
        actions: rows of a session, as `store.sessions.rows` returns them.
    """
    said = [row["final"] for row in actions if row["kind"] == "feedback" and row["final"]]
    return [
        f"After attempt {final['attempt']}, feedback reported: {evidence}."
        for final in said
        if (evidence := final.get("evidence"))
    ]


# --- answers to questions between attempts


_STATUSES = {"declined": "would rather not say", "skipped": "skipped by an operator"}


def lines(answers: Sequence[Record], practice: int) -> list[str]:
    """Return a line for each question that was asked; several participants are told apart by their
    seats.

    Args:
        answers: records of the kind ``answer``.
        practice: the number of attempts before the first that counts, as attempts are counted with
            them.
    """
    several = len({answer.seat for answer in answers}) > 1
    asked = [answer for answer in answers if answer.content["status"] != "done"]
    return [_line(answer, several, practice) for answer in asked]


def _line(answer: Record, several: bool, practice: int) -> str:
    content = answer.content
    attempt = int(content["attempt"])
    when = f"After attempt {attempt + practice}" if attempt else "Before the first attempt"
    who = f", seat {answer.seat}" if several else ""
    said = _STATUSES.get(str(content["status"])) or _said(answer)
    return f"{when}{who}: {content['question']} {said}"


def _said(answer: Record) -> str:
    """Return a number with its word, an option, several, or a text in quotation marks."""
    content = answer.content
    chosen = str(content.get("chosen", ""))
    if "words" in content:
        return f'"{content["words"]}"'
    if "value" in content:
        return f"{content['value']:g}{f' ({chosen})' if chosen else ''}"
    return chosen
