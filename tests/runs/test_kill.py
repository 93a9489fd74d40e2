"""kill -9 at hundreds of moments: nothing acknowledged is lost, and what was under way can be done
again.
"""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.model.random_streams import RandomStreams
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.store.rescue import bring_back, rescue_files
from sar_tui.store.safeguard import losses
from tests.examples import first
from tests.store.test_rescue import rescued

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")

Trial = tuple[int, int]


class Killable:
    """The program, whose parts are killed."""

    def __init__(self) -> None:
        self._program = subprocess.Popen(
            [sys.executable, "-m", "tests.runs.killable_program"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=Path(__file__).parents[2],
        )

    def kill(self, after: int, later_ms: float, *part: object) -> list[str]:
        """Begin a part, kill it some time after a number of lines, and return all its lines. It may
        end before.
        """
        assert self._program.stdin
        print(*part, file=self._program.stdin, flush=True)
        child = int(self._read())
        said: list[str] = []
        while (line := self._read()) != "gone":
            said.append(line)
            if len(said) == after:
                self._kill(child, later_ms)
        return said

    def kill_soon(self, later_ms: float, *part: object) -> None:
        """Begin a part, and kill it after some time. It may end before."""
        assert self._program.stdin
        print(*part, file=self._program.stdin, flush=True)
        self._kill(int(self._read()), later_ms)
        while self._read() != "gone":
            pass

    def time_of(self, *part: object) -> float:
        """Do a part, and return how long it took, in ms."""
        began = time.monotonic()
        assert self.kill(0, 0, *part) == ["end"]
        return (time.monotonic() - began) * 1000

    def _kill(self, child: int, later_ms: float) -> None:
        until = time.monotonic_ns() + round(later_ms * 1e6)
        while time.monotonic_ns() < until:
            pass
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)

    def _read(self) -> str:
        assert self._program.stdout
        line = self._program.stdout.readline()
        assert line, "the program has ended"
        return line.strip()

    def close(self) -> None:
        self._program.kill()
        self._program.communicate()


@pytest.fixture(scope="module")
def killable() -> Iterator[Killable]:
    program = Killable()
    yield program
    program.close()


def trials(data: Path) -> list[Trial]:
    with closing(connect(data)) as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert losses(database, data) == []
        return database.execute("SELECT attempt, trial FROM trials ORDER BY rowid").fetchall()


@pytest.mark.slow
@pytest.mark.parametrize("seed", first(1, range(12)))
def test_twenty_kills_of_a_session_lose_no_acknowledged_trial(
    data: Path, killable: Killable, seed: int
) -> None:
    acknowledged: list[Trial] = []
    for kill in range(20):
        moments = RandomStreams("kill", seed, kill)
        session = () if kill == 0 else (sessions_of(data),)
        lines = killable.kill(
            1 + int(moments.uniform("trials") * 5),
            moments.uniform("moment") * 6,
            "play",
            data,
            seed,
            *session,
        )
        acknowledged += [(int(a), int(t)) for a, t in map(str.split, lines)]
        stored = trials(data)
        assert stored[: len(acknowledged)] == acknowledged
        assert len(stored) <= len(acknowledged) + 1, (
            "at most the last was not acknowledged any more"
        )
        acknowledged = stored
    while lines[-1:] != ["end"]:
        lines = killable.kill(0, 0, "play", data, seed, sessions_of(data))
    assert trials(data) == [(attempt, trial) for attempt in range(1, 41) for trial in range(1, 11)]


def sessions_of(data: Path) -> str:
    """Return the id of the only session."""
    with closing(connect(data)) as database:
        ((session,),) = database.execute("SELECT id FROM sessions").fetchall()
    return str(session)


@pytest.mark.slow
@pytest.mark.parametrize("kills", first(1, [2, 20]))
def test_kills_while_a_rescue_file_is_brought_back_lose_nothing(
    tmp_path: Path, killable: Killable, data: Path, kills: int
) -> None:
    recorded = rescued(data)
    shutil.copytree(data, tmp_path / "whole")
    whole_ms = killable.time_of("bring_back", tmp_path / "whole")
    for kill in range(kills):
        folder = tmp_path / str(kill)
        shutil.copytree(data, folder)
        killable.kill_soon(whole_ms * kill / kills, "bring_back", folder)
        bring_back(folder)
        assert rescue_files(folder) == []
        with closing(connect(folder)) as database:
            assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
            assert list(sessions.history(database, recorded.id)) == recorded.records
