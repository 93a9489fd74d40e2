"""However the program ends: a clear sentence, the right exit code, the terminal restored, nothing
lost.
"""

import signal
from pathlib import Path

import pytest

from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import command, rows, run_command

_LEAVE_ALTERNATE_SCREEN = b"\x1b[?1049l"


def _answer(terminal: Terminal, prompts: int) -> None:
    ScriptedParticipant(terminal, random_answers(5, 120, 180)).run(prompts)


def _begin_session(data: Path, terminal: Terminal) -> None:
    """Answer three prompts, and wait until the program, which may be slow, has stored them and
    shows what follows.
    """
    _answer(terminal, 3)
    for _ in range(600):
        terminal.settle()
        if rows(data, "SELECT count(*) FROM trials") == [(3,)]:
            return
    raise AssertionError("3 trials were not stored")


@pytest.mark.parametrize(
    ("end", "code"),
    [
        ("ctrl+c", 130),
        pytest.param(signal.SIGINT, 130, marks=pytest.mark.slow),
        pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow),
        pytest.param(signal.SIGQUIT, 131, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, 129, marks=pytest.mark.slow),
    ],
)
def test_a_signal_or_ctrl_c_ends_the_session_in_order(
    data: Path, end: str | signal.Signals, code: int
) -> None:
    with Terminal(run_command(data, prompts_per_attempt=8, attempts=2)) as terminal:
        before = terminal.modes()
        _begin_session(data, terminal)
        if isinstance(end, str):
            terminal.press(end)
        else:
            terminal.kill(end)
        assert terminal.wait() == code
        assert terminal.modes() == before, "echo and line editing are back"
        output = bytes(terminal.output)

    assert _LEAVE_ALTERNATE_SCREEN in output
    assert b"sar-tui resume" in output
    assert b"Traceback" not in output
    assert rows(data, "SELECT status FROM sessions") == [("interrupted",)]
    assert rows(data, "SELECT count(*) FROM trials") == [(3,)]


@pytest.mark.slow
def test_a_lost_terminal_ends_the_program_without_loss(data: Path) -> None:
    with Terminal(run_command(data, prompts_per_attempt=8, attempts=2)) as terminal:
        _begin_session(data, terminal)
        terminal.hang_up()
        assert terminal.process.wait(60) == 129
    assert rows(data, "SELECT count(*) FROM trials") == [(3,)]
    assert rows(data, "PRAGMA integrity_check") == [("ok",)]


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
            time.sleep(600)
        return Stimulus("j", "j", "Press: j")

    def perceived(self, trial, percept):
        return Result(response=percept.key, correct=True, response_at=percept.at, value=trial.latency_ms(percept.at))
"""


@pytest.mark.slow
def test_a_task_that_no_error_can_end_ends_the_program_with_its_name(
    data: Path, tmp_path: Path
) -> None:
    task = tmp_path / "tasks" / "brittle"
    task.mkdir(parents=True)
    (task / "task.py").write_text(_BRITTLE)
    words = ["run", "brittle", "-p", "P01", "--data", str(data), "--tasks", str(task.parent)]
    quick = ("--set=quiet_ms=40", "--set=foreperiod_max_ms=500")
    with Terminal(command(*words, *quick)) as terminal:
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
