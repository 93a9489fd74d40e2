"""A session that has just ended beside the earlier ones that can be compared with it, for its
participant.
"""

import sqlite3
from collections.abc import Iterable, Sequence
from contextlib import closing
from datetime import date
from itertools import takewhile
from pathlib import Path

import msgspec

from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.messages import AttemptEnded
from sar_tui.model.results_for_people import beside_text, day_text, levels_beside_text, verdict_text
from sar_tui.progress.lines import (
    Line,
    Point,
    SessionResults,
    comparable,
    is_comparable,
    settings_of,
)
from sar_tui.progress.task_level import AttemptResult, places, to_level
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.results import sessions_of
from sar_tui.store.training_days import session_number


def beside_earlier_sessions(
    folder: Path, task: Task, session: str, attempts: Sequence[AttemptEnded], tr: Language
) -> str:
    """Return the comparison in words; empty if there is no earlier session like it, or the database
    cannot be read.

    Args:
        folder: the data folder.
        task: with the session's settings.
        session: its id.
        attempts: the scored attempts, without practice.
        tr: the language of the session.
    """
    results = [
        AttemptResult(attempt.level, attempt.metric, attempt.correct) for attempt in attempts
    ]
    judged = [attempt.outcome == "success" for attempt in attempts if attempt.outcome != "none"]
    try:
        with closing(connect(folder)) as database:
            codes = [row["participant"] for row in sessions.rows(database, "seats", session)]
            played = sessions_of(database, codes[0], task.name) if codes else ()
            line = line_with(played, task, session, results, sum(judged) if judged else None)
    except (StoreError, sqlite3.Error):
        return ""
    return beside_previous(line, date.today(), tr) if line else ""


def number_of(folder: Path, session: str) -> int:
    """Return the number of a session among those of its participant; 0 if the database cannot be
    read.
    """
    try:
        with closing(connect(folder)) as database:
            code = sessions.rows(database, "seats", session)[0]["participant"]
            return session_number(database, code, session)
    except (StoreError, sqlite3.Error):
        return 0


def line_with(
    played: Iterable[SessionResults],
    task: Task,
    session: str,
    results: Sequence[AttemptResult],
    reached: int | None = None,
) -> Line | None:
    """Return the line that ends with a session that has just ended; None if no earlier one can be
    compared with it.

    Args:
        played: sessions of one participant, in the order in which they were played; later ones are not
            looked at.
        task: with the settings of the session that has ended.
        session: its id, which may be among the sessions.
        results: its results.
        reached: number of its attempts that reached the goal; None if that is not known, or none
            had a goal.
    """
    settings = settings_of(task)
    until = takewhile(lambda each: each.session != session, played)
    earlier = [each for each in until if is_comparable(each, task, settings)]
    if not earlier or not results:
        return None
    ended = msgspec.structs.replace(
        earlier[-1], session=session, status="completed", results=results, reached=reached
    )
    return comparable([*earlier, ended], task)


def beside_previous(line: Line, today: date, tr: Language) -> str:
    """Return how the last session of a line went beside the earlier ones, in kind words; empty if
    that is not known.

    The verdict is that of the line. The level at goal, or the mean where the level never changed,
    stands beside that of the last completed session, unless it was better then: a difference that
    may be chance must not look like a fall.
    """
    now = line.points[-1]
    earlier = [point for point in line.points[:-1] if point.results.status == "completed"]
    then = next((point for point in reversed(earlier) if line.value(point) is not None), None)
    value, before = line.value(now), line.value(then) if then else None
    if then is None or value is None or before is None:
        return ""
    said = []
    if value >= before:
        said.append(_figures(line, now, then, day_text(then.results.began.date(), today, tr), tr))
    if value != before or line.verdict == "more":
        said.append(verdict_text(tr, is_better=line.verdict == "more"))
    return " ".join(filter(None, said))


def _figures(line: Line, now: Point, then: Point, when: str, tr: Language) -> str:
    """Return two sessions in figures; empty if a level at goal lies outside of the levels."""
    if now.estimate and then.estimate:
        rising = places(line.task) if line.task else []
        level, before = (
            to_level(rising, estimate.value) for estimate in (now.estimate, then.estimate)
        )
        return (
            "" if level is None or before is None else levels_beside_text(level, before, when, tr)
        )
    assert now.mean is not None
    assert then.mean is not None
    return beside_text(line.last.metric, now.mean, then.mean, when, tr)
