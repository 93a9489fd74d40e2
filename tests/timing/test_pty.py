"""A program at a real pseudo-terminal, and a scripted participant in front of it."""

import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest

from sar_tui.timing.closed_loop import BASELINE, Block, run_block
from sar_tui.timing.pty import Terminal, encode, read_together, visible
from sar_tui.timing.scripted_participant import NoPrompt, ScriptedParticipant, random_answers

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="there are no pseudo-terminals on Windows"
)


def python(program: str) -> list[str]:
    return [sys.executable, "-c", program]


@pytest.fixture
def baseline(tmp_path: Path) -> Iterator[Terminal]:
    """Run the baseline program with twelve prompts."""
    options = ["--prompts", "12", "--shortest-ms", "50", "--longest-ms", "60"]
    with Terminal(
        [sys.executable, "-m", "sar_tui.timing.baseline", str(tmp_path / "trials"), *options]
    ) as terminal:
        yield terminal


def rows(folder: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (folder / "trials").read_text().splitlines()]


# --- the terminal


def test_a_program_sees_a_terminal_of_the_size_asked_for_and_no_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("TMUX", "somewhere")
    monkeypatch.setenv("SSH_CONNECTION", "far away")
    monkeypatch.setenv("COLUMNS", "3")
    report = (
        "import os, shutil; print(os.isatty(0), *shutil.get_terminal_size(), os.environ['TERM'],"
    )
    report += " os.environ['OWN'], sorted({'TMUX', 'SSH_CONNECTION'} & set(os.environ)), 'over')"
    with Terminal(python(report), columns=100, rows=30, environment={"OWN": "thing"}) as terminal:
        assert terminal.wait() == 0
    assert "True 100 30 xterm-256color thing [] over" in terminal.output.decode()


@pytest.mark.parametrize(
    ("key", "sent"), [("f", b"f"), ("é", "é".encode()), ("enter", b"\r"), ("ctrl+q", b"\x11")]
)
def test_a_key_is_encoded_or_refused(key: str, sent: bytes) -> None:
    assert encode(key) == sent
    with pytest.raises(ValueError, match="no key any"):
        encode("any")


def test_control_c_interrupts_as_in_any_terminal() -> None:
    waits = "import time; print('ready', flush=True); any(time.sleep(0.01) for _ in range(6000))"
    with Terminal(
        python(waits)
    ) as terminal:  # one long sleep may begin just after the signal, and last
        terminal.wait_for("ready")
        terminal.press("ctrl+c")
        assert terminal.wait() in (1, -signal.SIGINT)
    assert "KeyboardInterrupt" in terminal.output.decode()


def test_a_terminal_that_is_taken_away_hangs_up() -> None:
    with Terminal(python("print('ready', flush=True); import time; time.sleep(60)")) as terminal:
        terminal.wait_for("ready")
        terminal.hang_up()
        assert terminal.process.wait(60) == -signal.SIGHUP


def test_a_program_still_running_is_killed_at_the_end_and_its_output_kept() -> None:
    with Terminal(python("print('ready', flush=True); import time; time.sleep(60)")) as terminal:
        terminal.wait_for("ready")
    assert terminal.process.returncode == -signal.SIGKILL
    assert b"ready" in terminal.output
    with pytest.raises(ProcessLookupError):
        os.kill(terminal.process.pid, 0)


def test_programs_that_are_read_together_do_not_block_each_other() -> None:
    talks = "print('x' * 200_000, 'that is all', flush=True)"
    with (
        Terminal(python("print('begun'); input(); print('over')")) as one,
        Terminal(python(talks)) as other,
    ):
        read_together(one, other)
        one.wait_for("begun")
        until = time.monotonic() + 60
        while not other.ended and time.monotonic() < until:
            one.read(time.monotonic_ns() + 10_000_000)
        assert b"that is all" in other.output
        one.press("enter")
        one.wait_for("over")
        assert b"that is all" not in one.output


def test_a_time_out_quotes_the_output() -> None:
    with (
        Terminal(python("print('something else')")) as terminal,
        pytest.raises(TimeoutError, match="something else"),
    ):
        terminal.wait_for("the thing")


def test_a_program_that_does_not_exist_is_an_error_at_once() -> None:
    # its kind depends on the folders of PATH
    with pytest.raises(OSError, match="no-such-program-anywhere"):
        Terminal(["no-such-program-anywhere"])


@pytest.mark.parametrize(
    ("output", "seen"),
    [
        (b"\x1b[?1049h\x1b[?2026$p\x1b[>1u\x1b[2J  \r\n", ""),
        (b"\x1b[38;2;1;2;3mReady\x1b[0m  ", "Ready"),
        (b"\x1b]0;title\x07\x1b(B", ""),
        (b"\x1b[38;2;", ""),
    ],
)
def test_only_text_is_visible(output: bytes, seen: str) -> None:
    assert visible(output) == seen


# --- the participant


def test_every_press_is_a_row_right_or_wrong_as_pressed(baseline: Terminal, tmp_path: Path) -> None:
    presses = ScriptedParticipant(baseline, random_answers(7, 1, 30, error_rate=0.4)).run(12)
    assert baseline.wait() == 0
    recorded = rows(tmp_path)
    assert [row["stimulus"] for row in recorded] == [press.expected for press in presses]
    assert [row["response"] for row in recorded] == [press.key for press in presses]
    assert [row["correct"] for row in recorded] == [
        press.key == press.expected for press in presses
    ]
    assert {row["correct"] for row in recorded} == {True, False}
    stimuli = [press.expected for press in presses]
    assert any(first == second for first, second in pairwise(stimuli)), "the same twice in a row"


def test_a_press_comes_no_sooner_than_planned(baseline: Terminal) -> None:
    participant = ScriptedParticipant(baseline, random_answers(3, 5, 40))
    for press in participant.run(4):
        assert press.reaction_time_ms >= 5
    delays = [random_answers(3, 5, 40)(number, "f")[0] for number in range(4)]
    assert all(
        press.reaction_time_ms >= delay
        for press, delay in zip(participant.presses, delays, strict=True)
    )


def test_a_participant_can_stop_and_go_on(baseline: Terminal, tmp_path: Path) -> None:
    participant = ScriptedParticipant(baseline, random_answers(1, 1, 2))
    assert len(participant.run(3)) == 3
    assert len(participant.run(12)) == 12
    assert baseline.wait() == 0
    assert len(rows(tmp_path)) == 12


def test_a_prompt_that_somebody_else_has_read_is_answered(
    baseline: Terminal, tmp_path: Path
) -> None:
    participant = ScriptedParticipant(baseline, random_answers(1, 1, 2))
    participant.run(1)
    baseline.settle(silence_ms=300)
    participant.run(12)
    assert baseline.wait() == 0
    assert [row["response"] for row in rows(tmp_path)] == [
        press.expected for press in participant.presses
    ]


def test_a_participant_stops_at_the_given_time_even_before_responding(baseline: Terminal) -> None:
    participant = ScriptedParticipant(baseline, random_answers(1, 60_000, 60_000))
    baseline.wait_for("Enter")
    assert participant.run(until=time.monotonic_ns() + 500_000_000) == []
    assert not baseline.ended


def test_a_participant_leaves_when_the_program_is_killed(baseline: Terminal) -> None:
    def answer(number: int, expected: str) -> tuple[float, str]:
        if number == 2:
            baseline.kill()
            baseline.wait()
        return 5, expected

    assert len(ScriptedParticipant(baseline, answer).run(12)) == 2


def test_a_word_is_a_key_too() -> None:
    program = (
        "import tty, os; tty.setraw(0); print('Press: left \\r'); print('got', os.read(0, "
        "3).hex(), 'end')"
    )
    with Terminal(python(program)) as terminal:
        (press,) = ScriptedParticipant(terminal, random_answers(1, 1, 2)).run(1)
        terminal.wait_for("got 1b5b44 end")
    assert press.key == press.expected == "left"


def test_enter_is_pressed_even_where_something_moves_all_the_time() -> None:
    program = (
        "import os, select, tty; tty.setraw(0); print('Press Enter\\r')\n"
        "while not select.select([0], [], [], 0.05)[0]: print('.', end='', flush=True)\n"
        "os.read(0, 1); print('Press: f \\r', flush=True); os.read(0, 1)\n"
    )
    with Terminal(python(program)) as terminal:
        assert len(ScriptedParticipant(terminal, random_answers(1, 1, 2)).run(1)) == 1


def test_a_program_that_asks_for_nothing_is_reported() -> None:
    with (
        Terminal(python("import time; time.sleep(60)")) as terminal,
        pytest.raises(NoPrompt, match=r"for 0\.3 s"),
    ):
        ScriptedParticipant(terminal, random_answers(1, 1, 2)).run(1, patience_s=0.3)


@pytest.mark.slow
def test_the_closed_loop_joins_trials_with_their_truth_while_a_companion_runs(
    tmp_path: Path,
) -> None:
    marks: list[str] = []

    @contextmanager
    def companion(folder: Path, terminal: Terminal) -> Iterator[None]:
        marks.append("begins" if folder.is_dir() and b"Press:" not in terminal.output else "late")
        yield
        marks.append("ends" if folder.is_dir() and terminal.process.poll() == 0 else "early")

    program = msgspec.structs.replace(BASELINE, companion=companion)
    assert len(run_block(program, Block(prompts=4, seed=2), tmp_path)) == 4
    assert marks == ["begins", "ends"]
    assert not list(tmp_path.iterdir()), "nothing is left behind"
