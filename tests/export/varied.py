"""Sessions with all that makes an export hard: several tasks, an operator, misses, lost samples,
odd texts, a cut.
"""

from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.program import Call

NOTE = 'Dice: "me duele",\r\ny descansa; ñ 🙂'


def varied(call: Call, data: Path) -> None:
    """Simulate sessions of three tasks with an operator, alter them, and add one that was cut
    off.
    """
    for task in ("keyboard", "reaching", "pairs"):
        asked = ("--set", "questions=effort remark")
        call(
            "simulate",
            task,
            "--user",
            "poor",
            "--attempts",
            1,
            "--seed",
            3,
            "--operator",
            "careful",
            *asked,
        )
    with closing(connect(data)) as database:
        database.execute(
            "UPDATE trials SET stimulus=?, response=NULL WHERE trial=2", ('¿"Sí"?\r\nno, no',)
        )
        database.execute("UPDATE attempts SET metric=9e999 WHERE attempt=1")
        database.execute(
            "INSERT INTO notes (session, at_ns, author, text, label) SELECT id, 1, "
            "'operator.ana', ?, 'pausa'"
            " FROM sessions",
            (NOTE,),
        )
    store_trials(data, [{"stimulus": "f", "details": None}])


def store_trials(data: Path, rows: list[dict[str, Any]]) -> None:
    """Store a session with these trials, which was cut off in its first attempt."""
    with closing(connect(data)) as database:
        sessions.create(
            database, "s1", task="keyboard", theme="calm", participant="P01", seed=1,
            parameters={}, software={"sar_tui": "0"}, machine={}, mode="live",
        )  # fmt: skip
        for number, row in enumerate(rows, 1):
            values = {
                "session": "s1",
                "attempt": 1,
                "trial": number,
                "seat": "A",
                "run": 1,
                "timing": "{}",
                **row,
            }
            database.execute(
                f"INSERT INTO trials ({', '.join(values)}) VALUES ({', '.join('?' * len(values))})",
                tuple(values.values()),
            )
