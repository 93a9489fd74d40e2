"""A reach at a real pseudo-terminal, hand and sensor simulated in the program itself; also when it
is killed.
"""

import json
import time
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.model.units import MS
from sar_tui.store import imu
from sar_tui.store.database import connect
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import (
    command,
    only_session,
    replays_identically,
    rows,
    see_the_summary,
)
from tests.tasks.reaching import reaching_driver

IN_REACH = 1200 * MS
"""So long after the prompt the simulated hand is under way."""
REACHED = 2200 * MS
"""So long after the prompt the simulated hand is back."""


def press(terminal: Terminal, key: str) -> int:
    """Press a key when the screen has come to rest; return how much was on it before."""
    terminal.settle(silence_ms=100, seconds=0.6)
    seen = len(terminal.output)
    (terminal.confirm if key == "enter" else terminal.press)(key)
    return seen


def start_reach(terminal: Terminal, seen: int) -> None:
    """Start the reach that is offered after ``seen``."""
    terminal.wait_for("Press Space to start.", since=seen)
    rest(terminal, 300 * MS)
    terminal.wait_for("Reach: ", since=press(terminal, "space"))


def rest(terminal: Terminal, duration: int) -> None:
    """Let time pass, and read meanwhile."""
    until = time.monotonic_ns() + duration
    while time.monotonic_ns() < until and not terminal.ended:
        terminal.read(until)


@pytest.mark.slow
def test_a_kill_during_a_reach_keeps_its_samples_and_the_resumed_reach_agrees_with_its_own(
    data: Path,
) -> None:
    where = ("--data", str(data))
    words = ("run", "reaching", "-p", "P01", *where, "--seed", "7", "--imu", "simulated")
    with Terminal(command(*words, "--set=attempts=1")) as terminal:
        terminal.wait_for("Check the sensor")
        terminal.wait_for("Simulated hand")
        terminal.wait_for("Press Enter to go on.", since=press(terminal, "enter"))
        terminal.wait_for("Press Enter to begin", since=press(terminal, "enter"))
        start_reach(terminal, press(terminal, "enter"))
        started = time.monotonic_ns()
        rest(terminal, IN_REACH)
        terminal.kill()
        terminal.wait()
    assert rows(data, "PRAGMA integrity_check") == [("ok",)]
    assert rows(data, "SELECT count(*) FROM trials") == [(0,)], "it was in mid-reach"
    ((measured,),) = rows(
        data, "SELECT t1_ns FROM imu_chunks ORDER BY stream DESC, seq DESC LIMIT 1"
    )
    assert measured > started, "samples of the reach itself are there"

    with Terminal(command("resume", only_session(data), *where)) as terminal:
        terminal.wait_for("Welcome back")
        start_reach(terminal, press(terminal, "enter"))
        rest(terminal, REACHED)
        terminal.press("space")
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0

    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    check_the_reach(data)
    streams = rows(data, "SELECT stream, run, source, rate_hz FROM imu_streams ORDER BY stream")
    assert streams == [(1, 1, "simulated", 250.0), (2, 2, "simulated", 250.0)]
    for stream in (1, 2):
        seqs = rows(data, "SELECT seq FROM imu_chunks WHERE stream=? ORDER BY seq", stream)
        assert seqs == [(seq,) for seq in range(1, len(seqs) + 1)]
    seqs = rows(data, "SELECT seq FROM events ORDER BY seq")
    assert seqs == [(seq,) for seq in range(1, len(seqs) + 1)]
    assert replays_identically(data)


def check_the_reach(data: Path) -> None:
    """Check that the only trial, of the second run, is what its samples say."""
    ((attempt, trial, run, correct, onset, end, reaction_time, text),) = rows(
        data,
        "SELECT attempt, trial, run, correct, onset_ns, response_ns, reaction_time_ms, details "
        "FROM trials",
    )
    details = json.loads(text)
    with closing(connect(data)) as database:
        window = details["window_from_ns"], details["window_to_ns"]
        measured = imu.samples(database, only_session(data), *window, run)
    found = reaching_driver.analysed_again(measured, details)
    assert (attempt, trial, run, reaction_time) == (1, 1, 2, None)
    assert correct, "a simulated hand hardly ever stays where it is"
    assert found.details.items() <= details.items()
    assert found.details["samples"] > 500
    assert (found.onset_ns, found.end_ns) == (onset, end)
    assert 500 < details["reach_time_ms"] < 3000
