"""Reaches at a real pseudo-terminal, hand and sensor simulated in the program itself; also when it
is killed.
"""

import json
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.analysis import Finding
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
from tests.examples import QUICK
from tests.tasks.reaching import reaching_driver

KILLS = 1 if QUICK else 3
REACHED = 2200 * MS
"""So long after the prompt the simulated hand is back."""
Row = dict[str, Any]


def run_command(data: Path, **parameters: object) -> list[str]:
    settings = [f"--set={name}={value}" for name, value in parameters.items()]
    place = ["-p", "P01", "--data", str(data), "--seed", "7"]
    return command("run", "reaching", *place, "--imu", "simulated", *settings)


def press(terminal: Terminal, key: str) -> int:
    """Press a key when the screen has come to rest; returns how much was on it before."""
    terminal.settle(silence_ms=100, seconds=0.6)
    seen = len(terminal.output)
    (terminal.confirm if key == "enter" else terminal.press)(key)
    return seen


def begin(terminal: Terminal) -> int:
    """From the start of the program to where the first reach can be started."""
    terminal.wait_for("Check the sensor")
    terminal.wait_for("Simulated hand")
    seen = press(terminal, "enter")
    terminal.wait_for("Press Enter to go on.", since=seen)
    return begin_attempt(terminal, press(terminal, "enter"), "Press Enter to begin")


def begin_attempt(terminal: Terminal, seen: int, offer: str) -> int:
    """From where an attempt is offered to where its first reach can be started."""
    terminal.wait_for(offer, since=seen)
    return to_start(terminal, press(terminal, "enter"))


def to_start(terminal: Terminal, seen: int) -> int:
    return terminal.wait_for("Press Space to start.", since=seen)


def start(terminal: Terminal) -> int:
    """Start the reach that waits; returns how much was on the screen when the prompt was."""
    return terminal.wait_for("Reach: ", since=press(terminal, "space"))


def rest(terminal: Terminal, duration: int) -> None:
    """Let time pass, and read meanwhile."""
    until = time.monotonic_ns() + duration
    while time.monotonic_ns() < until and not terminal.ended:
        terminal.read(until)


def reach(terminal: Terminal) -> int:
    """Space, out and back by itself, space; returns how much was on the screen before it was
    over.
    """
    rest(terminal, 300 * MS)
    seen = start(terminal)
    rest(terminal, REACHED)
    terminal.press("space")
    return seen


def trials(data: Path) -> list[Row]:
    """Return the stored row of each reach."""
    names = (
        "attempt",
        "trial",
        "run",
        "correct",
        "onset_ns",
        "response_ns",
        "reaction_time_ms",
        "details",
    )
    query = f"SELECT {', '.join(names)} FROM trials ORDER BY attempt, trial"
    found = [dict(zip(names, row, strict=True)) for row in rows(data, query)]
    return [row | {"details": json.loads(row["details"])} for row in found]


def analysed_again(data: Path, trial: Row) -> Finding:
    """A reach, analysed from the samples that were kept, as its row names."""
    details = trial["details"]
    with closing(connect(data)) as database:
        measured = imu.samples(
            database,
            only_session(data),
            details["window_from_ns"],
            details["window_to_ns"],
            trial["run"],
        )
    return reaching_driver.analysed_again(measured, details)


def check_reaches(data: Path) -> None:
    """Every row is what its samples say."""
    for trial in trials(data):
        found = analysed_again(data, trial)
        assert found.details.items() <= trial["details"].items()
        assert found.details["samples"] > 500
        if trial["correct"]:
            assert (found.onset_ns, found.end_ns) == (trial["onset_ns"], trial["response_ns"])
            assert 500 < trial["details"]["reach_time_ms"] < 3000


@pytest.mark.slow
def test_stored_reaches_agree_with_their_samples(data: Path) -> None:
    with Terminal(run_command(data, attempts=2)) as terminal:
        begin(terminal)
        begin_attempt(terminal, reach(terminal), "Press Enter for attempt 2")
        reach(terminal)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0

    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    assert [(trial["attempt"], trial["trial"]) for trial in trials(data)] == [(1, 1), (2, 1)]
    assert {trial["reaction_time_ms"] for trial in trials(data)} == {None}
    assert any(trial["correct"] for trial in trials(data)), (
        "a simulated hand hardly ever stays where it is"
    )
    check_reaches(data)
    ((stream, run, source, rate),) = rows(
        data, "SELECT stream, run, source, rate_hz FROM imu_streams"
    )
    assert (stream, run, source, rate) == (1, 1, "simulated", 250.0)
    (seqs,) = rows(data, "SELECT min(seq), max(seq), count(*) FROM imu_chunks")
    assert seqs[0] == 1
    assert seqs[1] == seqs[2]


@pytest.mark.slow
def test_a_kill_during_a_reach_loses_few_samples_and_the_session_is_resumed(data: Path) -> None:
    for kill in range(KILLS):
        words = (
            run_command(data, attempts=1)
            if kill == 0
            else command("resume", only_session(data), "--data", str(data))
        )
        with Terminal(words) as terminal:
            if kill == 0:
                begin(terminal)
            else:
                terminal.wait_for("Welcome back")
                to_start(terminal, press(terminal, "enter"))
            start(terminal)
            started = time.monotonic_ns()
            rest(
                terminal,
                round((0.8 + 1.0 * RandomStreams("kill", kill).uniform("moment")) * SECOND),
            )
            terminal.kill()
            terminal.wait()
        assert rows(data, "PRAGMA integrity_check") == [("ok",)]
        assert rows(data, "SELECT count(*) FROM trials") == [(0,)], "it was in mid-reach"
        ((measured,),) = rows(
            data, "SELECT t1_ns FROM imu_chunks ORDER BY stream DESC, seq DESC LIMIT 1"
        )
        assert measured > started, "samples of the reach itself are there"

    with Terminal(command("resume", only_session(data), "--data", str(data))) as terminal:
        terminal.wait_for("Welcome back")
        to_start(terminal, press(terminal, "enter"))
        reach(terminal)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0

    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    assert [(trial["attempt"], trial["trial"], trial["run"]) for trial in trials(data)] == [
        (1, 1, KILLS + 1)
    ]
    assert any(trial["correct"] for trial in trials(data)), (
        "a simulated hand hardly ever stays where it is"
    )
    check_reaches(data)
    streams = rows(data, "SELECT stream, run, source, rate_hz FROM imu_streams ORDER BY stream")
    assert streams == [(run, run, "simulated", 250.0) for run in range(1, KILLS + 2)]
    seqs = [seq for (seq,) in rows(data, "SELECT seq FROM events ORDER BY seq")]
    assert seqs == list(range(1, len(seqs) + 1))
    assert replays_identically(data)
