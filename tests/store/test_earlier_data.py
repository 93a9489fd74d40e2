"""A database written by an earlier program stays readable, and its interrupted session can be
resumed.

``earlier.db.gz`` holds, at schema version 4: a simulated keyboard session with an operator, a
completed and an interrupted live keyboard session of P01 and P02 (killed after the third trial), a
simulated session of pairs, and one of reaching in Spanish. P01 has saved settings.
"""

import gzip
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.topics import KEY, SESSION
from sar_tui.model.messages import KeyPressed, SessionStarted
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import programmes, sessions
from sar_tui.store.database import connect
from tests.program import Call

OPERATED, COMPLETED, INTERRUPTED, PAIRS, REACHING = (
    "c8c2b66260", "8e9df2059c", "6ee4440dd4", "f72d38a87f", "ea597fb6b4",
)  # fmt: skip
ALL = (OPERATED, COMPLETED, INTERRUPTED, PAIRS, REACHING)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A data folder with the earlier database; the same that ``call`` uses."""
    folder = tmp_path / "data"
    folder.mkdir()
    packed = Path(__file__).with_name("earlier.db.gz").read_bytes()
    (folder / "sar-tui.db").write_bytes(gzip.decompress(packed))
    return folder


def test_sessions_are_listed(call: Call, data: Path) -> None:
    rows = {row["id"]: row for row in call("sessions", "--json").json["sessions"]}
    assert {name: (row["status"], row["mode"], row["attempts"]) for name, row in rows.items()} == {
        OPERATED: ("completed", "simulated", 3),
        COMPLETED: ("completed", "live", 2),
        INTERRUPTED: ("interrupted", "live", 1),
        PAIRS: ("completed", "simulated", 2),
        REACHING: ("completed", "simulated", 1),
    }


@pytest.mark.parametrize("session", ALL)
def test_a_session_is_shown(call: Call, data: Path, session: str) -> None:
    called = call("show", session)
    assert (called.code, called.err) == (0, "")
    assert session in called.out


def test_an_operators_work_is_reported(call: Call, data: Path) -> None:
    report = call("report", "wizard", OPERATED, "--json")
    assert report.code == 0
    shown = call("report", "wizard", OPERATED).out
    assert "3 accepted" in shown
    assert "1 edited" in shown


@pytest.mark.parametrize("session", ALL)
def test_a_session_comes_out_the_same_when_replayed(
    data: Path, catalogue: Catalogue, session: str
) -> None:
    database = connect(data)
    row = sessions.find(database, data, session)
    kind = catalogue.task(row["task"])
    parameters = build(kind.Parameters, row["parameters"])
    theme = catalogue.theme(row["theme"], parameters.language)
    replayed = Session(kind(parameters), theme, VirtualClock(), row["seed"])
    replayed.replay(sessions.history(database, session))
    database.close()
    assert replayed.ended == (session != INTERRUPTED)


def test_the_interrupted_session_is_resumed_and_completed(data: Path, catalogue: Catalogue) -> None:
    clock = VirtualClock(1000 * SECOND)
    run = resume(
        INTERRUPTED,
        data,
        catalogue,
        clock,
        lambda task, theme, seed: [SimulatedParticipant(PEOPLE["average"], task, 7)],
    )
    run.begin()
    while not run.session.ended:
        assert clock.step()
    run.recorder.write()
    run.close()
    database = connect(data)
    row = sessions.find(database, data, INTERRUPTED)
    trials = sessions.rows(database, "trials", INTERRUPTED)
    database.close()
    assert row["status"] == "completed"
    assert [(trial["attempt"], trial["trial"], trial["run"]) for trial in trials] == [
        (1, 1, 1), (1, 2, 1), (2, 1, 1), (2, 2, 2), (3, 1, 2), (3, 2, 2),
    ]  # fmt: skip


def test_saved_settings_make_a_plan(data: Path, catalogue: Catalogue) -> None:
    database = connect(data)
    saved = programmes.newest(database, "P01", "keyboard")
    database.close()
    plan = make_plan(catalogue, "keyboard", ["P01"], saved=saved)
    assert (plan.parameters.attempts, plan.theme) == (2, "calm")


def test_its_messages_are_read_as_they_were_after_it_is_brought_up_to_date(
    call: Call, data: Path
) -> None:
    before = events(data)
    assert call("sessions").code == 0
    assert events(data) == before


def test_an_earlier_program_whose_session_is_under_way_goes_on_storing_it(data: Path) -> None:
    under_way = sqlite3.connect(data / "sar-tui.db")
    connect(data).close()
    (seq,) = under_way.execute(
        "SELECT max(seq) FROM events WHERE session=?", (INTERRUPTED,)
    ).fetchone()
    row = (INTERRUPTED, seq + 1, 1, 7, "input/key", '{"key":"f","at":7}')
    under_way.execute(
        "INSERT INTO events (session, seq, run, at_ns, topic, message) VALUES (?,?,?,?,?,?)", row
    )
    under_way.commit()
    under_way.close()
    assert events(data)[-1] == row
    database = connect(data)
    last = list(sessions.history(database, INTERRUPTED))[-1]
    database.close()
    assert (last.seq, last.at, last.topic, last.message) == (
        seq + 1,
        7,
        KEY,
        KeyPressed(key="f", at=7),
    )


def test_opening_it_again_changes_nothing(call: Call, data: Path) -> None:
    call("sessions")
    before = contents(data)
    call("sessions")
    call("show", OPERATED)
    assert contents(data) == before


def events(data: Path) -> list[tuple[object, ...]]:
    """Return all messages, those of the interrupted session last."""
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        query = (
            "SELECT session, seq, run, at_ns, topic, message FROM events ORDER BY session=?, "
            "session, seq"
        )
        return database.execute(query, (INTERRUPTED,)).fetchall()


def contents(data: Path) -> list[str]:
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        return list(database.iterdump())


def test_an_earlier_session_keeps_its_rules(call: Call, data: Path, catalogue: Catalogue) -> None:
    database = connect(data)
    row = sessions.find(database, data, INTERRUPTED)
    kind = catalogue.task(row["task"])
    parameters = build(kind.Parameters, row["parameters"])
    session = Session(
        kind(parameters), catalogue.theme(row["theme"]), VirtualClock(10**15), row["seed"]
    )
    session.replay(sessions.history(database, INTERRUPTED))
    database.close()
    started: list[SessionStarted] = []
    session.bus.subscribe(SESSION, started.append)
    session.begin(2)
    assert started[-1].rules == 1
    plan = call("report", "wizard", OPERATED, "--json").json["plan"]
    assert (plan["operator_time_ms"], plan["operator_ms_per_word"]) == (4000, 0)
