"""However the program ends: a clear sentence, the right exit code, the terminal restored, nothing
lost.
"""

import os
import signal
from pathlib import Path

import pytest

from sar_tui.timing.closed_loop import LEAVE_KEYS
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import (
    command,
    only_session,
    rows,
    run_command,
    see_the_summary,
)
from tests.examples import first

_LEAVE_ALTERNATE_SCREEN = b"\x1b[?1049l"


def _answer(terminal: Terminal, prompts: int) -> None:
    ScriptedParticipant(terminal, random_answers(5, 120, 180)).run(prompts)


def _see_stored(terminal: Terminal, data: Path, trials: int) -> None:
    """Wait until the program, which may be slow, has handled as many responses and shows what
    follows.
    """
    for _ in range(600):
        terminal.settle()
        if rows(data, "SELECT count(*) FROM trials") == [(trials,)]:
            return
    raise AssertionError(f"{trials} trials were not stored")


@pytest.mark.parametrize(
    ("number", "code"),
    [
        (signal.SIGQUIT, 131),
        pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow),
        pytest.param(signal.SIGINT, 130, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, 129, marks=pytest.mark.slow),
    ],
)
def test_a_signal_ends_the_session_in_order(data: Path, number: int, code: int) -> None:
    with Terminal(run_command(data, prompts_per_attempt=8, attempts=2)) as terminal:
        _answer(terminal, 3)
        _see_stored(terminal, data, 3)
        terminal.kill(number)
        assert terminal.wait() == code
        output = bytes(terminal.output)

    assert _LEAVE_ALTERNATE_SCREEN in output
    assert b"sar-tui resume" in output
    assert b"Traceback" not in output
    assert rows(data, "SELECT status FROM sessions") == [("interrupted",)]
    assert rows(data, "SELECT count(*) FROM trials") == [(3,)]


@pytest.mark.parametrize("moment", first(1, ["trial", "instructions"]))
def test_ctrl_c_exits_with_130_and_says_how_to_resume(data: Path, moment: str) -> None:
    with Terminal(run_command(data, prompts_per_attempt=8, attempts=2)) as terminal:
        before = terminal.modes()
        terminal.wait_for("Press Enter to go on.")
        if moment == "trial":
            _answer(terminal, 2)
        terminal.press("ctrl+c")
        assert terminal.wait() == 130
        assert terminal.modes() == before, "echo and line editing are back"
        assert b"Stopped with Ctrl-C." in terminal.output


def test_a_lost_terminal_ends_the_program_without_loss(data: Path) -> None:
    with Terminal(run_command(data, prompts_per_attempt=8, attempts=2)) as terminal:
        _answer(terminal, 3)
        _see_stored(terminal, data, 3)
        terminal.hang_up()
        assert terminal.process.wait(60) == 129
    assert rows(data, "SELECT count(*) FROM trials") == [(3,)]
    assert rows(data, "PRAGMA integrity_check") == [("ok",)]


@pytest.mark.slow
def test_a_participant_cannot_be_in_two_live_sessions(data: Path) -> None:
    with Terminal(run_command(data)) as first:
        first.wait_for("Press Enter to go on.")
        with Terminal(run_command(data)) as second:
            assert second.wait() == 1
            assert b"live session already" in second.output


_BRITTLE = """
import time

from sar_tui.loop.task import Metric, Result, Stimulus, Task


class Brittle(Task):
    name = "brittle"
    title = "Brittle"
    metric = Metric("reaction_time", "ms", "lower")

    @property
    def trials_per_attempt(self):
        return 3

    def instructions(self):
        return "Press what appears."

    def stimulus(self, situation):
        if situation.trial == 3:
            THIRD
        return Stimulus("j", "j", "Press: j")

    def perceived(self, trial, percept):
        return Result(response=percept.key, correct=True, response_at=percept.at, value=trial.latency_ms(percept.at))
"""


def _brittle_command(data: Path, folder: Path, third: str) -> list[str]:
    """Write a task whose third trial executes a statement; return the command that runs it."""
    task = folder / "tasks" / "brittle"
    task.mkdir(parents=True)
    (task / "task.py").write_text(_BRITTLE.replace("THIRD", third))
    words = ["run", "brittle", "-p", "P01", "--data", str(data), "--tasks", str(task.parent)]
    return command(*words, "--set=quiet_ms=40", "--set=foreperiod_max_ms=500")


@pytest.mark.parametrize(
    ("third", "error"),
    [
        ("raise RuntimeError('no third')", b"RuntimeError: no third"),
        pytest.param(
            "while True: pass", b"NotResponding: it took longer than 10 s", marks=pytest.mark.slow
        ),
    ],
)
def test_a_task_that_raises_or_never_returns_is_reported_and_finished_trials_are_stored(
    data: Path, tmp_path: Path, third: str, error: bytes
) -> None:
    with Terminal(_brittle_command(data, tmp_path, third)) as terminal:
        _answer(terminal, 2)
        terminal.wait_for("Please fetch the experimenter")
        terminal.settle()
        terminal.confirm()
        assert terminal.wait() == 1
        assert error in terminal.output
        assert b"Traceback" not in terminal.output
    assert rows(data, "SELECT count(*) FROM trials") == [(2,)]
    assert rows(data, "SELECT count(*) FROM events WHERE topic='framework/fault'") == [(1,)]


@pytest.mark.slow
def test_a_task_that_no_error_can_end_ends_the_program_with_its_name(
    data: Path, tmp_path: Path
) -> None:
    with Terminal(_brittle_command(data, tmp_path, "time.sleep(600)")) as terminal:
        before = terminal.modes()
        _answer(terminal, 2)
        assert terminal.wait() == 1
        assert terminal.modes() == before
        after = terminal.output.rpartition(_LEAVE_ALTERNATE_SCREEN)[2]
        assert b"The task brittle does not return from its own code." in after
        assert b"sar-tui resume" in after
    assert rows(data, "SELECT trial FROM trials") == [(1,)], (
        "the task never returned from the end of the second"
    )


@pytest.mark.slow
def test_a_session_that_was_quit_is_listed_and_resumed_at_the_next_trial(data: Path) -> None:
    with Terminal(run_command(data, prompts_per_attempt=4, attempts=1)) as terminal:
        _answer(terminal, 2)
        terminal.settle()
        for key in LEAVE_KEYS:
            terminal.confirm(key)
        assert terminal.wait() == 0
    with Terminal(command("resume", only_session(data)[:6], "--data", str(data))) as terminal:
        terminal.wait_for("Welcome back")
        _answer(terminal, 2)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    assert rows(data, "SELECT trial, run FROM trials") == [(1, 1), (2, 1), (3, 2), (4, 2)]
    assert os.listdir(data / "locks")
