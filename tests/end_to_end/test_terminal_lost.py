"""A terminal that is frozen or stalled: its operator is lost in time, and its program ends when it
is asked to.
"""

import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from sar_tui.link.discovery import JoinableSession, announce, folder_name
from sar_tui.timing.pty import Terminal, visible
from sar_tui.tui.terminal_output import RESET
from tests.end_to_end.operator_terminal import Panel, SessionTerminals
from tests.end_to_end.participant_terminal import command

if sys.platform != "win32":
    import fcntl
    import termios

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="pseudo-terminals as of Linux")

LOST_MS = 3000
ANA = "operator.ana"
SETTINGS = {
    "attempts": 2,
    "prompts_per_attempt": 1,
    "outputs": "",
    "encouragement": "no",
    "filler": "never",
    "operator_feedback": "approve",
    "operator_time_ms": 60_000,
    "operator_lost_ms": LOST_MS,
}


@pytest.mark.slow
def test_an_operator_behind_a_frozen_connection_is_lost_and_comes_back(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant = terminals.participant("--operator", **SETTINGS)
        relay = [sys.executable, "-m", "tests.end_to_end.terminal_relay"]
        wizard = command("wizard", "--wait", "--name", "ana", "--data", str(data))
        panel = Panel(terminals, terminals.start_program([*relay, *wizard], 100, 30))
        participant.terminal.wait_for("Press Enter to go on.")
        terminals.until(lambda: terminals.is_operated, "the operator steers")
        participant.answer(1)
        panel.wait_for_proposal()

        panel.kill(signal.SIGUSR1)
        terminals.until(lambda: (ANA, "lost") in terminals.presence(), "the operator is lost")
        terminals.until(
            lambda: terminals.actions("feedback")[0]["decided_ns"], "the agent goes on alone"
        )
        (row,) = terminals.actions("feedback")
        assert (row["decision"], row["actor"], row["ground"]) == (
            "accepted",
            "agent",
            "no operator",
        )
        (lost,) = [
            each for each in terminals.reported("operator/presence") if each["state"] == "lost"
        ]
        assert (lost["operated"], lost["detail"]) == (
            False,
            f"Its terminal did not answer for {LOST_MS} ms.",
        )

        panel.kill(signal.SIGUSR2)
        terminals.until(lambda: terminals.is_operated, "the operator is back")
        terminals.until(lambda: "This terminal did not answer for" in panel.sees(), "and is told")
        participant.answer(1)
        panel.wait_for_proposal(row["id"])
        panel.does("approve")
        terminals.until(
            lambda: terminals.actions("feedback")[-1]["decided_ns"], "a decision is accepted again"
        )
        assert terminals.actions("feedback")[-1]["actor"] == ANA
        states = [state for actor, state in terminals.presence() if actor == ANA]
    assert states == ["joined", "baton", "lost", "joined", "baton"]


@pytest.fixture
def program(
    request: pytest.FixtureRequest, data: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[list[str]]:
    """Command line of a program that shows something until it is ended."""
    runtime = Path(tempfile.mkdtemp(prefix="sar-"))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(runtime))
    commands = {
        "wizard": command("wizard", "--wait", "--data", str(data)),
        "agent": command("agent", "5ab1e", "--data", str(data)),
    }
    live = JoinableSession("5ab1e", "keyboard", "5ab1e", os.getpid(), data=folder_name(data))
    with announce(live):
        yield commands[request.param]
    shutil.rmtree(runtime)


_FULL = 4000
"""Bytes that Linux offers of a pseudo-terminal that holds more."""


@pytest.mark.parametrize("program", ["wizard", "agent"], indirect=True)
def test_a_signal_restores_the_terminal(program: list[str]) -> None:
    with Terminal(program) as terminal:
        before = terminal.modes()
        terminal.wait_for("\x1b[?2004h")
        terminal.settle()
        terminal.kill(signal.SIGTERM)
        assert terminal.wait() == 143, visible(bytes(terminal.output))
        assert terminal.modes() == before, "echo and line editing are back"
        assert b"\x1b[?1049l" in terminal.output
        assert b"Traceback" not in terminal.output


def fill(terminal: Terminal) -> None:
    """Have the program draw its screen often, without reading, until the terminal takes no more."""
    columns, deadline = 300, time.monotonic() + 60
    while unread(terminal) < _FULL:
        assert time.monotonic() < deadline, "the terminal takes everything"
        columns = 601 - columns
        terminal.resize(columns, 90)
        time.sleep(0.02)


def unread(terminal: Terminal) -> int:
    """Return the number of bytes that can be read."""
    return int.from_bytes(fcntl.ioctl(terminal.fileno(), termios.FIONREAD, bytes(4)), sys.byteorder)


@pytest.mark.parametrize("program", ["wizard"], indirect=True)
def test_a_signal_while_the_first_screen_is_made_ends_it_in_order(program: list[str]) -> None:
    with Terminal(program) as terminal:
        terminal.wait_for("\x1b[?2004h")
        terminal.kill(signal.SIGTERM)
        assert terminal.wait() == 143, visible(bytes(terminal.output))
        assert b"\x1b[?1049l" in terminal.output


@pytest.mark.slow
@pytest.mark.parametrize("program", ["wizard"], indirect=True)
def test_a_stalled_terminal_does_not_keep_a_program_from_ending(program: list[str]) -> None:
    with Terminal(program, columns=300, rows=90) as terminal:
        before = terminal.modes()
        terminal.wait_for("\x1b[?2004h")
        terminal.settle()
        fill(terminal)
        terminal.kill(signal.SIGTERM)
        assert terminal.process.wait(60) == 143
        assert terminal.modes() == before
        terminal.wait()
        assert RESET in terminal.output
