"""Makes the golden database of this release: ``python -m tests.store.make_golden``.

It has rows in every table. Make it anew while the release is not out; afterwards never.
"""

import gzip
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui import __version__
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.topics import COMMAND, NOTE_ADDED
from sar_tui.model.messages import NoteAdded, SessionCommand
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import start
from sar_tui.simulation.operator import PROFILES, SimulatedOperator
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import (
    adverse_events,
    exports,
    instrument_scores,
    programmes,
    sites,
    wellbeing,
)
from sar_tui.store.database import FILE, connect, transaction
from sar_tui.store.instrument_scores import Score
from tests.replay.make_golden import make as make_sessions

GOLDEN = Path(__file__).parent / "golden"
RELEASES = sorted(path.name.removesuffix(".db.gz") for path in GOLDEN.glob("*.db.gz"))


def unpack(release: str, folder: Path) -> Path:
    """Put the golden database of a release into a data folder, and return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    packed = (GOLDEN / f"{release}.db.gz").read_bytes()
    (folder / FILE).write_bytes(gzip.decompress(packed))
    return folder


def make(folder: Path) -> None:
    """Fill all tables of a database in a data folder."""
    make_sessions(folder)
    session = _play_interrupted(folder)
    with closing(connect(folder)) as database:
        saved = programmes.Programme({"attempts": 2}, "calm")
        programmes.save(database, "P01", "keyboard", saved, after=0, author="ana", reason="Short.")
        wellbeing.save(database, "P01", "before", "pain", "2", session=session)
        adverse_events.report(
            database, "P01", onset="2026-11-02", what="Dizzy for a minute.", severity="mild"
        )
        score = Score("fma-ue", "2026-11-02", 42.0, "")
        instrument_scores.add(database, "P01", score, author="ana")
        exports.record(
            database,
            author="ana",
            recipient="",
            format="csv",
            sessions=[session],
            options={},
            manifest="0" * 64,
        )
        sites.set_own(database, "ZURICH")
        with transaction(database) as connection:
            connection.execute("INSERT INTO same_people VALUES ('P01@BERN', 'P02')")
            connection.execute("INSERT INTO conflicts VALUES ('participant', 'P01', 'abc', x'00')")


def _play_interrupted(folder: Path) -> str:
    """Play a session with questions, an operator, a note and a pause, until its power fails."""

    def participants(task: Any, theme: Any, seed: int) -> list[Node]:
        operator = SimulatedOperator(PROFILES["careful"], seed)
        return [SimulatedParticipant(PEOPLE["average"], task, seed), operator]

    settings = {
        "attempts": 3,
        "prompts_per_attempt": 4,
        "questions": ["effort", "remark"],
        "questions_every": 1,
        "operator_feedback": "approve",
    }
    clock = VirtualClock()
    plan = make_plan(Catalogue(), "keyboard", ["P01"], settings, seed=9)
    run = start(plan, folder, Catalogue(), clock, participants)
    run.begin()
    run.session.bus.publish(NOTE_ADDED, NoteAdded(text="Sits well.", actor="operator.ana"))
    for _ in range(55):
        assert clock.step()
    run.session.bus.publish(COMMAND, SessionCommand(command="pause", reason="pain"))
    run.session.bus.publish(COMMAND, SessionCommand(command="resume"))
    assert not run.session.ended
    run.recorder.write()
    run.close()
    return run.id


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make(folder)
        with closing(sqlite3.connect(folder / FILE)) as database:
            database.execute("VACUUM INTO ?", (str(folder / "packed.db"),))
        packed = gzip.compress((folder / "packed.db").read_bytes(), mtime=0)
    (GOLDEN / f"{__version__}.db.gz").write_bytes(packed)


if __name__ == "__main__":
    main()
