"""A session that has just ended, beside the participant's earlier ones."""

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from datetime import date
from pathlib import Path

from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.messages import AttemptEnded
from sar_tui.progress.previous import beside_previous, line_with
from sar_tui.progress.task_level import AttemptResult
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.results import sessions_of


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
