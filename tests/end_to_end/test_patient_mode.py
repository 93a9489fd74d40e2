"""Patient mode in a real terminal: signals and keys show no shell, and a lost terminal loses
nothing.
"""

import os
import signal
from pathlib import Path

import pytest

from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import QUICK, ScreenReader, command, rows

pytestmark = pytest.mark.skipif(os.name != "posix", reason="there are no pseudo-terminals")

SIGNALS = ("SIGINT", "SIGTSTP", "SIGQUIT", "SIGHUP")
_LEAVE_ALTERNATE_SCREEN = b"\x1b[?1049l"


@pytest.fixture
def prepared(data: Path) -> Path:
    Passphrase(data).set("quiet river")
    database = connect(data)
    for code in ("P01", "P77"):
        participants.add(database, code)
        settings = {"attempts": 3, "prompts_per_attempt": 2} | QUICK
        programmes.save(database, code, "keyboard", programmes.Programme(settings), after=0)
    database.close()
    return data


@pytest.mark.slow
def test_signals_and_keys_show_no_shell_and_a_lost_terminal_loses_nothing(prepared: Path) -> None:
    with Terminal(command("--patient", "p01", "--data", str(prepared))) as terminal:
        screen = ScreenReader(terminal)
        terminal.wait_for("Press Enter to start.")
        for name in SIGNALS:
            terminal.kill(getattr(signal, name))
        terminal.write(b"\x03\x1a\x1c\x11\x04\x10")
        terminal.settle()
        terminal.confirm()
        terminal.wait_for("Press Enter to go on.")
        terminal.confirm()
        terminal.wait_for("Press Enter to begin attempt 1 of 3.")
        terminal.settle()
        terminal.confirm()
        terminal.wait_for("Press: ")
        for name in SIGNALS:
            terminal.kill(getattr(signal, name))
        terminal.write(b"\x1a\x1c\x03")
        terminal.wait_for("Take your time.")
        terminal.settle()
        assert terminal.process.poll() is None
        assert _LEAVE_ALTERNATE_SCREEN not in terminal.output
        assert "P77" not in screen.text()
        terminal.hang_up()
        assert terminal.process.wait(60) == 129
    assert rows(prepared, "SELECT participant, status FROM sessions JOIN seats ON session=id") == [
        ("P01", "interrupted")
    ]
    assert rows(prepared, "PRAGMA integrity_check") == [("ok",)]
