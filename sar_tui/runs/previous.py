"""A session that has just ended, beside the participant's last one."""

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from datetime import date
from pathlib import Path

from sar_tui.framework.language import Language
from sar_tui.framework.messages import AttemptEnded
from sar_tui.framework.task import Task
from sar_tui.progress.previous import beside_previous, earlier_sessions, kind_word
from sar_tui.progress.task_level import AttemptResult
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.results import sessions_of


def beside_last_session(folder: Path, task: Task, session: str, attempts: Sequence[AttemptEnded], tr: Language) -> str:
    """Return the comparison in words; empty if there is no earlier session like it, or the database cannot be read.

    Args:
        folder: the data folder.
        task: with the session's settings.
        session: its id.
        attempts: the scored attempts, without practice.
        tr: the language of the session.
    """
    try:
        with closing(connect(folder)) as database:
            codes = [row["participant"] for row in sessions.rows(database, "seats", session)]
            played = sessions_of(database, codes[0], task.name) if codes else ()
            earlier = earlier_sessions(played, task, before=session)
    except (StoreError, sqlite3.Error):
        return ""
    if not earlier or not attempts:
        return ""
    results = [AttemptResult(attempt.level, attempt.metric, attempt.correct) for attempt in attempts]
    words = beside_previous(results, earlier[-1], date.today(), tr)
    return f"{words} {kind_word(results, earlier, tr)}".strip() if words else ""
