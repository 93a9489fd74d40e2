"""Patient mode in a real terminal: signals and keys show no shell, and a lost terminal loses
nothing.
"""

import os
import random
import signal
from pathlib import Path

import pytest

from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.timing.pty import Terminal
from tests.app.test_patient_input import strings
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


def patient_command(data: Path) -> list[str]:
    return command("--patient", "p01", "--data", str(data))


def test_signals_and_keys_show_no_shell_and_a_lost_terminal_loses_nothing(prepared: Path) -> None:
    with Terminal(patient_command(prepared)) as terminal:
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


@pytest.mark.slow
def test_random_bytes_from_a_terminal_never_show_another_screen(prepared: Path) -> None:
    draw = random.Random(5)
    with Terminal(patient_command(prepared)) as terminal:
        screen = ScreenReader(terminal)
        terminal.wait_for("Press Enter to start.")
        for number, data in enumerate(strings(2_000, 9)):
            terminal.write(data)
            if number % 20 == 0:
                terminal.kill(getattr(signal, draw.choice(SIGNALS)))
                terminal.read(len(terminal.output))
            if number % 100 == 0:
                terminal.settle(silence_ms=200)
                shown = screen.text()
                assert "P77" not in shown
                assert "Sessions of" not in shown
                assert terminal.process.poll() is None, terminal.output[-2_000:]
        assert _LEAVE_ALTERNATE_SCREEN not in terminal.output
        terminal.hang_up()
        assert terminal.process.wait(60) == 129
    assert {code for (code,) in rows(prepared, "SELECT participant FROM seats")} <= {"P01"}
    assert rows(prepared, "PRAGMA integrity_check") == [("ok",)]


def test_the_passphrase_leads_to_the_first_screen(prepared: Path) -> None:
    with Terminal(patient_command(prepared)) as terminal:
        terminal.wait_for("Press Enter to start.")
        terminal.write(b"\x1b[24~")
        terminal.wait_for("Please enter the passphrase.")
        terminal.settle()
        terminal.write(b"quiet river")
        terminal.confirm()
        terminal.wait_for("New participant")
        terminal.settle()
        terminal.press("ctrl+q")
        assert terminal.wait() == 0
