"""Sessions with all that makes an export hard: several tasks, an operator, misses, lost samples,
odd texts, a cut.
"""

from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.played import simulated
from tests.store.by_hand import insert, sql

NOTE = 'Dice: "me duele",\r\ny descansa; ñ 🙂'


def varied(data: Path) -> None:
    """Simulate sessions of three tasks with an operator, alter them, and add one that was cut
    off.
    """
    for task in ("keyboard", "reaching", "pairs"):
        codes = ("SIM-A", "SIM-B") if task == "pairs" else ("SIM",)
        asked: Any = {"questions": "exertion remark", "operator_feedback": "approve"}
        simulated(data, task, *codes, user="poor", operator="careful", attempts=1, **asked)
    sql(data, "UPDATE trials SET stimulus=?, response=NULL WHERE trial=2", '¿"Sí"?\r\nno, no')
    sql(data, "UPDATE attempts SET metric=9e999 WHERE attempt=1")
    for (id,) in sql(data, "SELECT id FROM sessions"):
        insert(data, "notes", session=id, at_ns=1, author="operator.ana", text=NOTE, label="pausa")
    store_trials(data, [{"stimulus": "f", "details": None}])


def store_trials(data: Path, rows: list[dict[str, Any]]) -> None:
    """Store a session with these trials, which was cut off in its first attempt."""
    with closing(connect(data)) as database:
        sessions.create(
            database, "s1", task="keyboard", theme="calm", participant="P01", seed=1,
            parameters={}, software={"sar_tui": "0"}, machine={}, mode="live",
        )  # fmt: skip
        for number, row in enumerate(rows, 1):
            insert(database, "trials", session="s1", trial=number, timing="{}", **row)
