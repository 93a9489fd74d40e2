"""Lists of 10 and of 1,000 sessions, bytes a trial, and the resume of a long session."""

import sqlite3
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from datetime import date
from pathlib import Path
from typing import Any

from sar_tui.app.home.contents import read_card, read_day, read_sessions
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume, start
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import log_hashes, participants
from sar_tui.store.database import FILE, connect

FEW, MANY = 10, 1000
"""Numbers of sessions, of 400 trials each."""
MOST_RATIO = 1.5
MOST_RESUME_S = 1.0
_TABLES = ("seats", "runs", "attempts", "trials", "actions", "notes")
REPEATED = 7
_WHO = "BENCH"


def measure(many: int, trials: int, folder: Path, measured: Callable[[], None]) -> dict[str, Any]:
    """Measure lists of few and ``many`` sessions, alternately, and the resume of a session of
    ``trials`` trials.
    """
    catalogue = Catalogue()
    few, full = folder / "few", folder / "many"
    for data, count in ((few, FEW), (full, many)):
        fill(data, catalogue, count)
    times: dict[str, tuple[list[float], list[float]]] = {name: ([], []) for name in _LOOKS}
    for _ in range(REPEATED):
        for name, look in _LOOKS.items():
            for data, taken in zip((few, full), times[name], strict=True):
                began = time.perf_counter()
                look(data)
                taken.append(time.perf_counter() - began)
        measured()
    looks = {name: [statistics.median(taken) for taken in both] for name, both in times.items()}
    resume_s = _resume(folder / "long", catalogue, trials)
    return {
        "sessions": [FEW, many],
        "looks_s": looks,
        "bytes_a_trial": (full / FILE).stat().st_size / (400 * many),
        "trials": trials,
        "resume_s": resume_s,
        "checks": {
            **{
                f"{name}: at most {MOST_RATIO} x": slow <= MOST_RATIO * fast
                for name, (fast, slow) in looks.items()
            },
            f"resume: at most {MOST_RESUME_S:.0f} s": resume_s <= MOST_RESUME_S,
        },
    }


def _home(data: Path) -> None:
    catalogue = Catalogue()
    with closing(connect(data)) as database:
        today, tr = date.today(), Language()
        read_day(database, data, today, tr)
        read_sessions(database, data, catalogue, _WHO, tr)
        read_card(database, data, catalogue, _WHO, catalogue.task("keyboard"), today, tr)


def _program(*words: str) -> Callable[[Path], None]:
    def run(data: Path) -> None:
        command = [sys.executable, "-m", "sar_tui", *words, "--data", str(data)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    return run


_LOOKS: dict[str, Callable[[Path], None]] = {
    "home": _home,
    "sessions": _program("sessions"),
    "show": _program("show", "last"),
}


def fill(data: Path, catalogue: Catalogue, count: int, ids: str = "c0de") -> None:
    """Store a simulated session and copies of it, whose ids begin with ``ids``, as sessions of one
    participant.
    """
    plan = make_plan(catalogue, "keyboard", [_WHO], seed=1, mode="simulated")
    session = simulate(plan, PEOPLE["average"], data, catalogue)
    with closing(connect(data)) as database:
        database.execute("BEGIN")
        for number in range(2, count + 1):
            _copy(database, session, f"{ids}{number:06}")
        database.execute("UPDATE sessions SET mode='live'")
        database.execute("DELETE FROM log_hashes")  # of the first session, as it was before
        for name, ended in database.execute("SELECT id, ended_at FROM sessions").fetchall():
            log_hashes.begin(database, name)
            log_hashes.extend(database, name, ["run", 1], ["ended", ended])
        database.execute("COMMIT")
        participants.add(database, _WHO)


def _copy(database: sqlite3.Connection, session: str, copy: str) -> None:
    def insert(table: str, key: str) -> None:
        names = [
            name for _, name, *_ in database.execute(f"PRAGMA table_info({table})") if name != key
        ]
        columns = ", ".join(names)
        database.execute(
            f"INSERT INTO {table} ({key}, {columns}) SELECT ?, {columns} FROM {table} WHERE "
            f"{key}=? ORDER BY rowid",
            (copy, session),
        )

    insert("sessions", "id")
    for table in _TABLES:
        insert(table, "session")
    database.execute("INSERT INTO session_numbers (id) VALUES (?)", (copy,))
    database.execute(
        "INSERT INTO messages SELECT last_insert_rowid(), seq, run, at_ns, topic, message FROM "
        "messages WHERE session_number=(SELECT number FROM session_numbers WHERE id=?)",
        (session,),
    )


def _resume(data: Path, catalogue: Catalogue, trials: int) -> float:
    """Return the seconds that it takes to resume a session that was interrupted after ``trials``
    trials.
    """
    prompts = min(trials, 200)
    # more than are played
    settings = {
        "attempts": trials // prompts + 10,
        "prompts_per_attempt": prompts,
    }
    plan = make_plan(catalogue, "keyboard", [_WHO], settings, seed=1)

    def nodes(task: Task, theme: Theme, seed: int) -> list[Node]:
        return [SimulatedParticipant(PEOPLE["average"], task, seed)]

    run = start(plan, data, catalogue, clock := VirtualClock(), nodes)
    run.begin()
    with closing(connect(data)) as database:
        done = 0
        while done < trials:
            for _ in range(1000):
                clock.step()
            run.recorder.write()
            (done,) = database.execute("SELECT count(*) FROM trials").fetchone()
    run.close()
    began = time.perf_counter()
    resume(run.id, data, catalogue, VirtualClock(), nodes).close()
    return time.perf_counter() - began
