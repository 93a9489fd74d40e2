"""The line that tells how far a command is."""

import io
import sys
import time
from collections.abc import Callable
from pathlib import Path
from threading import Event

import pytest

from sar_tui.cli.progress_line import in_words, progress_line
from sar_tui.cli.visible_output import VisibleStream
from tests.program import Call


class Clock:
    """A clock that stands still until it is told the time."""

    at = 0.0

    def __call__(self) -> float:
        return self.at


Patched = Callable[[bool], io.StringIO]
RECORDING = Path(__file__).parents[2] / "data" / "table-4.1.csv"


@pytest.fixture
def stderr_to(monkeypatch: pytest.MonkeyPatch) -> Patched:
    """``stderr_to(True)``: from here on standard error is a terminal; returns what is written to
    it.
    """

    def patch(is_terminal: bool) -> io.StringIO:
        stream = io.StringIO()
        stream.isatty = lambda: is_terminal  # type: ignore[method-assign]
        monkeypatch.setattr(sys, "stderr", VisibleStream(stream))
        return stream

    return patch


def count(seconds: int, *, piped: bool = False) -> None:
    """Do one of a hundred things a second, for some seconds."""
    clock = Clock()
    with progress_line("Counting", piped=piped, still=True, now=clock) as show:
        for done in range(seconds + 1):
            clock.at = float(done)
            show("Counting", done, 100)


def test_a_command_that_takes_long_tells_the_share_and_the_time_left_and_leaves_no_line(
    stderr_to: Patched,
) -> None:
    terminal = stderr_to(True)
    count(40)
    lines = terminal.getvalue().split("\r")
    assert lines[1] == "Counting … 1 %, about 2 min left", "nothing in the first second"
    assert lines[40].rstrip() == "Counting … 40 %, about 1 min left"
    assert [line.strip() for line in lines[-2:]] == ["", ""], "it is erased"


def test_a_short_command_and_an_error_leave_no_line(stderr_to: Patched) -> None:
    terminal = stderr_to(True)
    clock = Clock()
    with progress_line("Counting", still=True, now=clock) as show:
        for done in range(100):
            clock.at = done * 0.009
            show("Counting", done, 100)
    assert terminal.getvalue() == ""

    def stopped() -> None:
        clock.at = 0
        with progress_line("Counting", still=True, now=clock) as show:
            clock.at = 2
            show("Counting", 0, 0)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert terminal.getvalue().split("\r")[1:] == ["Counting … 2 s", " " * 14, ""]


def test_nothing_is_written_where_output_is_piped_unless_the_command_takes_minutes(
    stderr_to: Patched,
) -> None:
    stderr = stderr_to(False)
    count(40)
    assert stderr.getvalue() == ""
    count(25, piped=True)
    said = "Counting … 10 %, about 2 min left\nCounting … 20 %, about 1 min left\n"
    assert stderr.getvalue() == said


def test_the_time_left_is_that_of_the_step_that_goes_on(stderr_to: Patched) -> None:
    terminal = stderr_to(True)
    clock = Clock()
    with progress_line("Counting", still=True, now=clock) as show:
        for at, step, done, of in (
            (0, "Copying", 0, 10),
            (100, "Copying", 10, 10),
            (100, "Reading\x1b[2J", 0, 4),
            (110, "Reading\x1b[2J", 1, 4),
        ):
            clock.at = at
            show(step, done, of)
    assert "about 30 s left" in terminal.getvalue()
    assert "\x1b" not in terminal.getvalue()


def test_a_step_that_tells_nothing_shows_that_time_goes_on(stderr_to: Patched) -> None:
    terminal = stderr_to(True)
    clock = Clock()
    with progress_line("Checking", now=clock):
        clock.at = 7
        deadline = time.monotonic() + 60
        while "Checking … 7 s" not in terminal.getvalue() and time.monotonic() < deadline:
            Event().wait(0.01)
    assert terminal.getvalue().startswith("\rChecking … 7 s")


def test_times_are_told_as_people_say_them() -> None:
    told = [in_words(seconds) for seconds in (0.2, 59, 119, 7200)]
    assert told == ["about 1 s", "about 59 s", "about 2 min", "about 2.0 h"]


SIMULATE = "simulate keyboard --user average --attempts 1 --seed 1 --set prompts_per_attempt=2"
REACH = "simulate reaching --user average --attempts 1 --seed 1 --set reaches_per_attempt=1"
COMMON = f"""
Simulating …: {SIMULATE}
Copying …: backup
Checking …: check
Exporting …: export --all --simulated
Replaying …: replay last
table-4.1 …: validate --only table-4.1
"""
OTHERS = f"""
Trying the copy …: backup --verify
Repairing …: check --repair
Scoring …: replay last --what-if threshold=900
Simulating …: replay last --what-if threshold=900 --fork --runs 20
Reading …: report wizard --all --simulated
Reading …: report intervention --all --simulated
Simulating …: {REACH}
Analysing …: reanalyse last
Merging …: merge other
Finding reaches: detect {RECORDING}
Counting repetitions …: detect {RECORDING} --repetitions
"""


@pytest.mark.parametrize(
    "commands", [COMMON, pytest.param(OTHERS, marks=pytest.mark.slow)], ids=["common", "others"]
)
def test_each_command_that_may_take_long_tells_it(
    call: Call,
    tmp_path: Path,
    stderr_to: Patched,
    monkeypatch: pytest.MonkeyPatch,
    commands: str,
) -> None:
    for name in ("_FROM_S", "_ON_TERMINAL_S"):
        monkeypatch.setattr(f"sar_tui.cli.progress_line.{name}", 0.0)
    monkeypatch.chdir(tmp_path)
    call(f"{SIMULATE} --data other")
    call(SIMULATE)
    for line in commands.strip().splitlines():
        said, _, command = line.partition(": ")
        terminal = stderr_to(True)
        call(command)
        assert said in terminal.getvalue(), command
        shown = terminal.getvalue().rpartition("\r")[0].rpartition("\r")[2]
        assert not shown.strip(), f"{command}: the line is gone"
