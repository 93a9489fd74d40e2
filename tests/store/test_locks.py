"""Locks give a participant or session to one of two programs."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.plugins import PluginError
from sar_tui.runs.plan import Failed, Plan, make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.store import locks, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.locks import Held, hold, is_held
from tests.played import catalogue, play
from tests.store.by_hand import sql


class Here(NamedTuple):
    """A data folder with a plan for it."""

    data: Path
    plan: Plan

    def start(self, **other: Any) -> Run:
        plan = msgspec.structs.replace(self.plan, **other)
        return start(plan, self.data, catalogue(), VirtualClock(), lambda *_: [])

    def begin(self) -> str:
        """Start and leave a live session, and return its id."""
        return play(self.start(), VirtualClock(), steps=0)

    def resume(self, session: str) -> Run:
        return resume(session, self.data, catalogue(), VirtualClock(), lambda *_: [])

    def status(self, session: str) -> str:
        return str(sessions.find(connect(self.data), self.data, session)["status"])


@pytest.fixture
def here(data: Path, plan: Plan) -> Here:
    return Here(data, plan)


HOLD = """
import sys
from pathlib import Path
from sar_tui.store.locks import hold
lock = hold(Path(sys.argv[1]), sys.argv[2], sys.argv[3])
print("held", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def another_program(data: Path) -> Iterator[subprocess.Popen[str]]:
    """A program that holds the lock of a session until it is ended."""
    data.mkdir()
    command = [sys.executable, "-c", HOLD, str(data), "session", "abc"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "held\n"
        yield program
        program.kill()


def test_a_released_lock_can_be_taken_again_and_asking_takes_none(data: Path) -> None:
    assert not is_held(data, "session", "abc")
    lock = hold(data, "session", "abc")
    for _ in range(3):
        assert is_held(data, "session", "abc")
    lock.release()
    assert not is_held(data, "session", "abc")
    hold(data, "session", "abc").release()


def test_nobody_can_be_in_two_live_sessions_and_two_people_can(here: Here) -> None:
    run = here.start()
    with pytest.raises(Held):
        here.start()
    with pytest.raises(StoreError, match=f"The session {run.id} is running"):
        here.resume(run.id)
    assert len(sessions.listing(connect(here.data), here.data)) == 1
    other = make_plan(catalogue(), "keyboard", ["P02"], seed=1)
    here._replace(plan=other).start().close()
    run.close()
    here.start().close()


def test_a_lock_another_program_holds_cannot_be_taken_until_it_is_killed(
    data: Path, another_program: subprocess.Popen[str]
) -> None:
    assert is_held(data, "session", "abc")
    with pytest.raises(Held, match="The session abc is in a live session already"):
        hold(data, "session", "abc")
    hold(data, "participant", "abc").release()
    another_program.kill()
    another_program.wait()
    assert not is_held(data, "session", "abc")
    hold(data, "session", "abc").release()


def test_a_lock_that_is_soon_released_is_waited_for(
    data: Path, another_program: subprocess.Popen[str]
) -> None:
    end = threading.Timer(0.1, another_program.kill)
    end.start()
    hold(data, "session", "abc").release()
    end.join()


def test_a_folder_that_cannot_be_written_to_is_reported(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("")
    with pytest.raises(StoreError, match="cannot be written to"):
        hold(tmp_path / "data", "session", "abc")


def test_a_new_session_that_is_not_locked_is_not_visible(
    here: Here, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[str] = []
    create = sessions.create

    def look(database: Any, session: str, **facts: Any) -> None:
        assert is_held(here.data, "session", session)
        create(database, session, **facts)
        seen.append(sessions.find(database, here.data, session)["status"])

    monkeypatch.setattr(sessions, "create", look)
    here.start().close()
    assert seen == ["running"]


@pytest.mark.parametrize(
    ("meanwhile", "state"),
    [("UPDATE sessions SET status='aborted'", "aborted"), ("DELETE FROM sessions", "gone")],
)
def test_a_session_that_ends_elsewhere_just_before_it_is_held_is_not_resumed(
    meanwhile: str, state: str, here: Here, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = here.begin()

    def late(folder: Path, kind: str, name: str) -> Any:
        sql(here.data, meanwhile)
        return hold(folder, kind, name)

    monkeypatch.setattr(locks, "hold", late)
    with pytest.raises(StoreError, match=f"The session {session} is {state}") as caught:
        here.resume(session)
    assert caught.value.bad_input
    assert len(sessions.rows(connect(here.data), "runs", session)) == 1
    assert not is_held(here.data, "session", session)
    assert not is_held(here.data, "participant", "P01")


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ("UPDATE messages SET message=json_replace(message, '$[6]', 4)"
         " WHERE topic=(SELECT id FROM topics WHERE name='event_handler/waiting')", "has changed since"),
        ("""UPDATE sessions SET parameters='{"attempts": 2, "speed": 3}'""", "There is no parameter speed"),
    ],
)  # fmt: skip
def test_a_session_that_cannot_be_resumed_leaves_its_participant_free(
    here: Here, change: str, why: str
) -> None:
    session = here.begin()
    sql(here.data, change)
    with pytest.raises(Failed, match=f"(?s)cannot be resumed.*{why}"):
        here.resume(session)
    assert not locks.is_held(here.data, "participant", "P01")
    here.start().close()


def test_a_theme_that_is_not_there_leaves_no_session_and_no_lock(here: Here) -> None:
    with pytest.raises(PluginError):
        here.start(theme="loud")
    assert not locks.is_held(here.data, "participant", "P01")
    assert sessions.listing(connect(here.data), here.data) == []
