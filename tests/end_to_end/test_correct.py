"""Reaches are corrected in a real pseudo-terminal: the program is killed, and nothing is lost."""

import shutil
import signal
import sys
from pathlib import Path

import pytest

import sar_tui
from sar_tui.inputs.label_file import beside, read_labels
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import ScreenReader, command

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")

SAMPLE = Path(sar_tui.__file__).parent.parent / "data" / "table-4.1.csv"


@pytest.mark.slow
def test_corrections_are_there_after_a_kill_and_the_next_reach_is_shown(tmp_path: Path) -> None:
    recording = tmp_path / "monday.csv"
    shutil.copy(SAMPLE, recording)
    correct = command("detect", str(recording), "--correct", "--data", str(tmp_path / "data"))
    with Terminal(correct) as terminal:
        ScreenReader(terminal)
        terminal.wait_for("Reach 1 of 8")
        terminal.settle()
        terminal.press("a")
        terminal.settle()
        terminal.press("d")
        terminal.wait_for("2 looked at")
        terminal.settle(silence_ms=500)
        terminal.kill(signal.SIGKILL)
        terminal.wait()
    states = [label.state for label in read_labels(beside(recording)).reaches]
    assert states[:3] == ["accepted", "dropped", "found"]
    with Terminal(correct) as terminal:
        screen = ScreenReader(terminal)
        terminal.wait_for("Reach 3 of 8")
        terminal.settle()
        assert "2 looked at" in screen.text()
        terminal.press("escape")
        assert terminal.wait() == 0
