"""A study with all that is hard to export: misses, gaps, cut-off and resumed sessions, operators,
questions, notes.
"""

from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.store import participants, sessions
from sar_tui.store.database import connect
from tests.export.resumed import resumed
from tests.played import simulated
from tests.recorded import score, told
from tests.store.by_hand import insert, sql, value

NOTE = '"¿Te duele?", dijo;\r\nno, no:\tdescansa \\ ñ'
_PLAYED = (
    ("keyboard", ["P01"], {"attempts": 2, "practice_attempts": 1, "response_timeout_ms": 500,
                           "questions": "exertion remark"}),
    ("reaching", ["P01"], {"attempts": 1, "reaches_per_attempt": 2}),
    ("pairs", ["P02", "P-3"], {"attempts": 1}),
)  # fmt: skip
INTERRUPTED, EMPTY = "1nterrupt", "empty"


def store_study(data: Path) -> None:
    """Store the study: the keyboard session is live, the others are simulated."""
    with_operator: Any = {"user": "poor", "operator": "careful", "operator_feedback": "approve"}
    for number, (task, codes, settings) in enumerate(_PLAYED):
        simulated(data, task, *codes, seed=3 + number, **with_operator, **settings)
    resumed(data)
    with closing(connect(data)) as database:
        sql(database, "UPDATE sessions SET mode='live' WHERE task='keyboard'")
        for id in (INTERRUPTED, EMPTY):
            sessions.create(
                database, id, task="keyboard", theme="calm", participant="P01", seed=1,
                parameters={}, software={"sar_tui": "0"}, machine={}, mode="live",
            )  # fmt: skip
            sessions.begin_run(database, id, software={}, machine={}, clock_ns=5_000_000_000)
        for trial, stimulus in enumerate(('"', "\\", "never", "NA", "n", "true", "ñ"), 1):
            row: Any = {"trial": trial, "stimulus": stimulus, "correct": 0, "timing": "{}"}
            row["onset_ns"] = None if stimulus == "never" else 5_000_000_000 + trial * 10**9
            insert(database, "trials", session=INTERRUPTED, **row)
        for (id,) in sql(database, "SELECT id FROM sessions"):
            note = {"at_ns": 1, "author": "operator.ana", "text": NOTE, "label": "pausa"}
            insert(database, "notes", session=id, **note)
        for code in ("P01", "P02"):
            participants.add(database, code)
        score(database, "P01", "ARAT", "2026-01-10", 20, NOTE)
        score(database, "P01", "ARAT", "2026-03-10", 31.5)
        score(database, "P02", "BBT", "2026-03-10", 12)
        keyboard = value(database, "SELECT id FROM sessions WHERE task='keyboard' LIMIT 1")
        told(database, "P01", "before", "pain", "3", session=keyboard)
        told(database, "P01", "after", "tiredness", "not said", session=keyboard)
        told(database, "P01", "before", "pain", "8")  # too much to begin a session
