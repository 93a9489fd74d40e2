"""A data folder with people of whom there is something in every place, each with words to search."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any
from unittest.mock import patch

from sar_tui.inputs.imu import Info
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import NOTE_ADDED, REMARK, SENSOR
from sar_tui.model.messages import NoteAdded, Remark, SensorChanged
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import start
from sar_tui.runs.simulate import people
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import participants, people_events, programmes
from sar_tui.store.backup import back_up
from sar_tui.store.database import connect
from sar_tui.store.people_events import Details, new_event
from tests.played import catalogue, simulated
from tests.recorded import event, score, told

CANARY = b"CANARY"
"""Beginning of all words that must not be found after an erasure."""


def played(folder: Path, task: str, *codes: str, word: str = "", **settings: object) -> str:
    """Play a live session to its end, with notes and a remark, and return its id."""
    clock = VirtualClock()
    plan = make_plan(catalogue(), task, list(codes), settings, seed=7)
    run = start(
        plan,
        folder,
        catalogue(),
        clock,
        lambda task, theme, seed: people(PEOPLE["average"], task, seed, clock),
    )
    run.begin()
    bus = run.session.bus
    for text in (f"{word}-NOTE", f"{word}-LATER") if word else ():
        bus.publish(NOTE_ADDED, NoteAdded(text=text, label=f"{word}-LABEL", actor="operator.a"))
        said = Remark(text=f"{word}-REMARK", source="free text", actor="operator.a")
        bus.publish(REMARK, said)
    if word:
        bus.publish(SENSOR, SensorChanged(state="detached", at=0, source=f"{word}-SOURCE"))
    while not run.session.ended:
        assert clock.step()
    run.recorder.write()
    run.close()
    return run.id


def fill(folder: Path, code: str = "P07", word: str = CANARY.decode()) -> list[str]:
    """Store something of a person in every table, and return the ids of their sessions alone."""
    settings = {"attempts": 1, "prompts_per_attempt": 3}
    with closing(connect(folder)) as database:
        participants.add(database, code)
    alone = [
        played(folder, "keyboard", code, word=word, questions=["remark"], questions_every=1,
               **settings),
        _with_sensor(folder, code, f"{word}-SOURCE"),
    ]  # fmt: skip
    with closing(connect(folder)) as database:
        saved = programmes.Programme({"attempts": 2}, "calm")
        programmes.save(
            database,
            code,
            "keyboard",
            saved,
            after=0,
            author=f"{word}-AUTHOR",
            reason=f"{word}-WHY",
        )
        told(database, code, "before", "pain", "2", session=alone[0])
        event(
            database, code, "2026-03-01", what=f"{word}-WHAT", severity="mild", author=f"{word}-BY"
        )
        score(database, code, "FMA-UE", "2026-03-01", 42, note=f"{word}-NOTE")
        for what, data in (("withdrawn", "keep"), ("resumed", "")):
            reason = f"{word}-REASON"
            details = Details(data=data)  # type: ignore[arg-type]
            people_events.add(
                database,
                new_event(what, code, author=f"{word}-BY", reason=reason, details=details),  # type: ignore[arg-type]
            )
        # a page that is free, and still has what was in it
        database.execute("CREATE TABLE rest (words TEXT)")
        database.execute("INSERT INTO rest VALUES (?)", (f"{word}-FREE " * 3000,))
        database.execute("DROP TABLE rest")
    return alone


def _with_sensor(folder: Path, code: str, source: str) -> str:
    """Simulate a session with a sensor whose source has a name, and return its id."""

    def named(**given: Any) -> Info:
        return Info(**{**given, "source": source})

    with patch("sar_tui.inputs.simulated_sensor.Info", named):
        return simulated(
            folder, "reaching", code, seed=5, user="competent", attempts=1, reaches_per_attempt=2
        )


def copies(folder: Path) -> list[Path]:
    """Make a backup, a rescue file and one that was brought back, and a copy of an upgrade."""
    made = [back_up(folder).path]
    for name in ("sar-tui-rescue-abc.db", "sar-tui-rescued-abc.db", "sar-tui-v200-20260101.db"):
        shutil.copyfile(made[0], folder / name)
        made.append(folder / name)
    with closing(sqlite3.connect(made[1])) as rescue:
        rescue.execute("PRAGMA journal_mode=WAL")
    return made


def holding(folder: Path, word: bytes = CANARY) -> list[str]:
    """Return the names of the files in a folder in which a word is."""
    return sorted(
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file() and word in path.read_bytes()
    )
