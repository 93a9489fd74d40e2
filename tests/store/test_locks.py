"""Locks give a participant or session to one of two programs."""

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.plugins import Catalogue, PluginError
from sar_tui.runs.plan import Failed, Plan, make_plan
from sar_tui.runs.run import resume, start
from sar_tui.store import locks, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.locks import Held, hold, is_held

HOLD = """
import sys
from pathlib import Path
from sar_tui.store.locks import hold
lock = hold(Path(sys.argv[1]), sys.argv[2], sys.argv[3])
print("held", flush=True)
sys.stdin.read()
"""

KILLED = """
import os, sys
from pathlib import Path
from sar_tui.loop.clock import VirtualClock
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import start
catalogue = Catalogue()
plan = make_plan(catalogue, "keyboard", ["P01"], seed=1)
run = start(plan, Path(sys.argv[1]), catalogue, VirtualClock(), lambda task, theme, seed: [])
run.begin()
print(run.id, flush=True)
os._exit(9)
"""
"""A program that starts a session and is killed."""

Program = Callable[[str, str], subprocess.Popen[str]]


@pytest.fixture
def another_program(data: Path) -> Iterator[Program]:
    """Start a program that holds a lock until it is ended."""
    programs: list[subprocess.Popen[str]] = []

    def holding(kind: str, name: str) -> subprocess.Popen[str]:
        data.mkdir(exist_ok=True)
        program = subprocess.Popen(
            [sys.executable, "-c", HOLD, str(data), kind, name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        programs.append(program)
        assert program.stdout is not None
        assert program.stdout.readline() == "held\n"
        return program

    yield holding
    for program in programs:
        program.kill()
        program.communicate()


def test_a_lock_held_by_another_program_cannot_be_taken(
    data: Path, another_program: Program
) -> None:
    another_program("participant", "P01")
    assert is_held(data, "participant", "P01")
    with pytest.raises(Held, match="The participant P01 is in a live session already"):
        hold(data, "participant", "P01")
    hold(data, "participant", "P02").release()


def test_a_program_that_is_killed_holds_nothing(data: Path, another_program: Program) -> None:
    program = another_program("session", "abc")
    program.kill()
    program.wait()
    assert not is_held(data, "session", "abc")
    hold(data, "session", "abc").release()


def test_a_released_lock_can_be_taken_again(data: Path) -> None:
    lock = hold(data, "session", "abc")
    assert is_held(data, "session", "abc")
    lock.release()
    assert not is_held(data, "session", "abc")
    hold(data, "session", "abc").release()


def test_asking_for_a_lock_does_not_take_it(data: Path) -> None:
    assert not is_held(data, "session", "abc")
    lock = hold(data, "session", "abc")
    for _ in range(3):
        assert is_held(data, "session", "abc")
    lock.release()


def test_a_lock_that_is_soon_released_is_waited_for(data: Path, another_program: Program) -> None:
    program = another_program("session", "abc")
    end = threading.Timer(0.1, program.kill)
    end.start()
    hold(data, "session", "abc").release()
    end.join()


def test_a_folder_that_cannot_be_written_to_is_reported(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("")
    with pytest.raises(StoreError, match="cannot be written to"):
        hold(tmp_path / "data", "session", "abc")


# --- through whole sessions


def begin(plan: Plan, data: Path, catalogue: Catalogue) -> str:
    """Start and close a live session, and return its id."""
    run = start(plan, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    run.begin()
    run.recorder.write()
    run.close()
    return run.id


def test_a_participant_cannot_be_in_two_live_sessions(
    plan: Plan, data: Path, catalogue: Catalogue
) -> None:
    run = start(plan, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    with pytest.raises(Held):
        start(plan, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    assert len(sessions.listing(connect(data), data)) == 1
    run.close()
    start(plan, data, catalogue, VirtualClock(), lambda task, theme, seed: []).close()


def test_two_participants_can_be_in_live_sessions(
    plan: Plan, data: Path, catalogue: Catalogue
) -> None:
    run = start(plan, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    other = make_plan(catalogue, "keyboard", ["P02"], seed=1)
    start(other, data, catalogue, VirtualClock(), lambda task, theme, seed: []).close()
    run.close()


def test_a_session_that_is_live_cannot_be_resumed_elsewhere(
    plan: Plan, data: Path, catalogue: Catalogue
) -> None:
    run = start(plan, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    with pytest.raises(StoreError, match=f"The session {run.id} is running"):
        resume(run.id, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    run.close()


def test_a_new_session_that_is_not_locked_is_not_visible(
    plan: Plan, data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[str] = []
    create = sessions.create

    def look(database: Any, session: str, **facts: Any) -> None:
        assert is_held(data, "session", session)
        create(database, session, **facts)
        seen.append(sessions.find(database, data, session)["status"])

    monkeypatch.setattr(sessions, "create", look)
    start(plan, data, catalogue, VirtualClock(), lambda task, theme, seed: []).close()
    assert seen == ["running"]


@pytest.mark.parametrize(
    ("meanwhile", "state"),
    [("UPDATE sessions SET status='aborted'", "aborted"), ("DELETE FROM sessions", "gone")],
)
def test_a_session_that_ends_elsewhere_just_before_it_is_held_is_not_resumed(
    meanwhile: str,
    state: str,
    plan: Plan,
    data: Path,
    catalogue: Catalogue,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = begin(plan, data, catalogue)

    def late(folder: Path, kind: str, name: str) -> Any:
        connect(data).execute(meanwhile)
        return hold(folder, kind, name)

    monkeypatch.setattr(locks, "hold", late)
    with pytest.raises(StoreError, match=f"The session {session} is {state}") as caught:
        resume(session, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    assert caught.value.bad_input
    assert len(sessions.rows(connect(data), "runs", session)) == 1
    assert not is_held(data, "session", session)
    assert not is_held(data, "participant", "P01")


def test_a_session_whose_program_was_killed_is_interrupted_and_can_be_resumed(
    data: Path, catalogue: Catalogue
) -> None:
    killed = subprocess.run(
        [sys.executable, "-c", KILLED, str(data)], capture_output=True, text=True, check=False
    )
    assert killed.returncode == 9, killed.stderr
    session = killed.stdout.strip()
    database = connect(data)
    assert database.execute("SELECT status FROM sessions").fetchone() == ("running",)
    assert sessions.find(database, data, session)["status"] == "interrupted"
    run = resume(session, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    assert run.number == 2
    assert sessions.find(database, data, session)["status"] == "running"
    run.close()
    assert sessions.find(database, data, session)["status"] == "interrupted"


def test_a_session_that_cannot_be_resumed_leaves_its_participant_free(
    plan: Plan, data: Path, catalogue: Catalogue
) -> None:
    session = begin(plan, data, catalogue)
    connect(data).execute(
        "UPDATE messages SET message=json_replace(message, '$[6]', 4)"
        " WHERE topic=(SELECT id FROM topics WHERE name='event_handler/waiting')"
    )
    with pytest.raises(Failed, match="cannot be resumed") as caught:
        resume(session, data, catalogue, VirtualClock(), lambda task, theme, seed: [])
    assert "has changed since" in str(caught.value)
    assert not locks.is_held(data, "participant", "P01")
    start(plan, data, catalogue, VirtualClock(), lambda task, theme, seed: []).close()


def test_a_session_whose_parameters_the_task_no_longer_takes_is_reported(
    plan: Plan, data: Path, catalogue: Catalogue
) -> None:
    session = begin(plan, data, catalogue)
    connect(data).execute("""UPDATE sessions SET parameters='{"attempts": 2, "speed": 3}'""")
    with pytest.raises(Failed, match=r"cannot be resumed\. There is no parameter speed"):
        resume(session, data, catalogue, VirtualClock(), lambda task, theme, seed: [])


def test_a_theme_that_is_not_there_leaves_no_session_and_no_lock(
    plan: Plan, data: Path, catalogue: Catalogue
) -> None:
    with pytest.raises(PluginError):
        start(
            msgspec.structs.replace(plan, theme="loud"),
            data,
            catalogue,
            VirtualClock(),
            lambda task, theme, seed: [],
        )
    assert not locks.is_held(data, "participant", "P01")
    assert sessions.listing(connect(data), data) == []
