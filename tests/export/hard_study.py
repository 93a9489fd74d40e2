"""A study with all that is hard to export: misses, gaps, cut-off and resumed sessions, operators,
questions, notes.
"""

from contextlib import closing
from pathlib import Path

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.operator import PROFILES
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import participants, sessions
from sar_tui.store.database import connect
from tests.export.resumed import resumed
from tests.recorded import score, told

NOTE = '"¿Te duele?", dijo;\r\nno, no:\tdescansa \\ ñ'
_PLAYED = (
    (
        "keyboard",
        ["P01"],
        {
            "attempts": 2,
            "practice_attempts": 1,
            "response_timeout_ms": 500,
            "operator_feedback": "approve",
            "questions": "effort remark",
        },
    ),
    (
        "reaching",
        ["P01"],
        {"attempts": 1, "reaches_per_attempt": 2, "operator_feedback": "approve"},
    ),
    ("pairs", ["P02", "P-3"], {"attempts": 1, "operator_feedback": "approve"}),
)
INTERRUPTED, EMPTY = "1nterrupt", "empty"


def store_study(data: Path, catalogue: Catalogue) -> None:
    """Store the study: the keyboard session is live, the others are simulated."""
    for number, (task, codes, settings) in enumerate(_PLAYED):
        plan = make_plan(catalogue, task, codes, settings, seed=3 + number, mode="simulated")
        simulate(plan, PEOPLE["poor"], data, catalogue, operator=PROFILES["careful"])
    resumed(data)
    with closing(connect(data)) as database:
        database.execute("UPDATE sessions SET mode='live' WHERE task='keyboard'")
        for id in (INTERRUPTED, EMPTY):
            sessions.create(
                database, id, task="keyboard", theme="calm", participant="P01", seed=1,
                parameters={}, software={"sar_tui": "0"}, machine={}, mode="live",
            )  # fmt: skip
            sessions.begin_run(database, id, software={}, machine={}, clock_ns=5_000_000_000)
        for trial, stimulus in enumerate(('"', "\\", "never", "NA", "n", "true", "ñ"), 1):
            onset = None if stimulus == "never" else 5_000_000_000 + trial * 10**9
            values = (INTERRUPTED, 1, trial, "A", 1, stimulus, None, 0, onset, None, None, "{}")
            database.execute(
                "INSERT INTO trials (session, attempt, trial, seat, run, stimulus, response, "
                "correct, onset_ns,"
                f" response_ns, reaction_time_ms, timing) VALUES ({','.join('?' * 12)})",
                values,
            )
        database.execute(
            "INSERT INTO notes (session, at_ns, author, text, label)"
            " SELECT id, 1, 'operator.ana', ?, 'pausa' FROM sessions",
            (NOTE,),
        )
        for code in ("P01", "P02"):
            participants.add(database, code)
        score(database, "P01", "ARAT", "2026-01-10", 20, NOTE)
        score(database, "P01", "ARAT", "2026-03-10", 31.5)
        score(database, "P02", "BBT", "2026-03-10", 12)
        (keyboard,) = database.execute(
            "SELECT id FROM sessions WHERE task='keyboard' LIMIT 1"
        ).fetchone()
        told(database, "P01", "before", "pain", "3", session=keyboard)
        told(database, "P01", "after", "tiredness", "not said", session=keyboard)
        told(database, "P01", "before", "pain", "8")  # too much to begin a session
