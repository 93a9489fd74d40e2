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
from sar_tui.letterbox import letterbox
from sar_tui.letterbox.exchange import exchange
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.topics import COMMAND, NOTE_ADDED
from sar_tui.model.messages import NoteAdded, SessionCommand
from sar_tui.model.study_place import StudyPlace
from sar_tui.model.units import SECOND
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume, start
from sar_tui.simulation.operator import PROFILES, SimulatedOperator
from sar_tui.store import exports, people_events, programmes, sites
from sar_tui.store.database import FILE, connect, transaction
from sar_tui.store.merge import conflicts
from sar_tui.store.passphrase import Passphrase
from sar_tui.store.tables import PROGRAMMES
from sar_tui.study import ledger
from sar_tui.study.plan import parse_plan
from tests.played import catalogue, play, simulated, somebody
from tests.recorded import event, score, told
from tests.study.plans import TWO_GROUPS

GOLDEN = Path(__file__).parent / "golden"
FEW = {"prompts_per_attempt": 4}
RELEASES = sorted(path.name.removesuffix(".db.gz") for path in GOLDEN.glob("*.db.gz"))


def unpack(release: str, folder: Path) -> Path:
    """Put the golden database of a release into a data folder, and return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    packed = (GOLDEN / f"{release}.db.gz").read_bytes()
    (folder / FILE).write_bytes(gzip.decompress(packed))
    return folder


def make(folder: Path) -> None:
    """Fill all tables of a database in a data folder."""
    _play_sessions(folder)
    session = play_interrupted(folder)
    with closing(connect(folder)) as database:
        saved = programmes.Programme({"attempts": 2}, "calm")
        programmes.save(database, "P01", "keyboard", saved, after=0, author="ana", reason="Short.")
        told(database, "P01", "before", "pain", "2", session=session)
        event(database, "P01", "2026-11-02", what="Dizzy for a minute.", severity="mild")
        score(database, "P01", "FMA-UE", "2026-11-02", 42)
        export = {"recipient": "", "format": "csv", "sessions": [session], "options": {}}
        exports.record(database, author="ana", manifest="0" * 64, **export)
        people_events.add(
            database, people_events.new_event("withdrawn", "P02", author="ana", reason="")
        )
        ledger.freeze(
            database, TWO_GROUPS, parse_plan(TWO_GROUPS, "plan"), {}, commitment="0" * 64,
            mode="live", author="ana",
        )  # fmt: skip
        sites.set_own(database, "ZURICH")
        with transaction(database) as connection:
            connection.execute("INSERT INTO same_people VALUES ('P01@BERN', 'P02')")
            _contradict(connection)
    _write_letters(folder)


def _contradict(connection: sqlite3.Connection) -> None:
    """Keep another version of the programme aside, as if it came from another database."""
    listed = ", ".join(PROGRAMMES.names)
    (row,) = connection.execute(f"SELECT {listed} FROM programmes").fetchall()
    other = dict(zip(PROGRAMMES.names, row, strict=True))
    other |= {"participant": "P01@ZURICH", "reason": "Longer.", "site": "ZURICH"}
    content = {"programmes": [other]}
    conflicts.keep(connection, "main", "programme", conflicts.key_of("programme", content), content)


def _write_letters(folder: Path) -> None:
    """Exchange letters with a home of P01."""
    with tempfile.TemporaryDirectory() as elsewhere:
        box, home = Path(elsewhere) / "box", Path(elsewhere) / "home"
        letterbox.new(folder, "Zürich", box)
        Passphrase(folder).set("kornblume")
        invited = letterbox.invite(folder, "P01")
        letterbox.join(home, invited.file.read_bytes(), invited.code, box)
        exchange(home)
        exchange(folder)


def _play_sessions(folder: Path) -> None:
    """Simulate two keyboard sessions, one of them with an operator, one of reaching and one of pairs
    with an operator; and play a live one that is interrupted and resumed.
    """
    operated = {**FEW, "operator_feedback": "approve", "operator": "careful"}
    simulated(folder, "keyboard", "P01", seed=5, attempts=4, **FEW)
    simulated(folder, "keyboard", "P02", seed=5, user="poor", attempts=3, threshold=700, **operated)
    simulated(
        folder, "reaching", "P01", seed=5, user="competent", attempts=1, reaches_per_attempt=2
    )
    simulated(folder, "pairs", "P01", "P02", seed=5, attempts=2, **operated)
    clock = VirtualClock()
    place = StudyPlace(
        study="praise", version=1, visit="first", block="baseline", condition="unpraised"
    )
    plan = make_plan(catalogue(), "keyboard", ["P01"], {"attempts": 3, **FEW}, seed=4, study=place)
    session = play(start(plan, folder, catalogue(), clock, somebody), clock, steps=20)
    clock = VirtualClock(1000 * SECOND)
    play(resume(session, folder, catalogue(), clock, somebody), clock)


def operated(task: Any, theme: Any, seed: int) -> list[Node]:
    """Return the nodes of a participant and an operator."""
    return [*somebody(task, theme, seed), SimulatedOperator(PROFILES["careful"], seed)]


def play_interrupted(folder: Path) -> str:
    """Play a session with questions, an operator, a note and a pause, until its power fails."""
    settings = {"attempts": 3, "prompts_per_attempt": 4, "questions": ["effort", "remark"],
                "questions_every": 1, "operator_feedback": "approve"}  # fmt: skip
    clock = VirtualClock()
    plan = make_plan(catalogue(), "keyboard", ["P01"], settings, seed=9)
    run = start(plan, folder, catalogue(), clock, operated)
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
