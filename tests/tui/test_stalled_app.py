"""An app in a terminal that stops taking output, and goes on."""

import os
import sys
import time
from pathlib import Path

import pytest

from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import ScreenReader

pytestmark = pytest.mark.skipif(os.name != "posix", reason="pseudo-terminals of POSIX systems")


def wait_for(diary: Path, line: str, terminal: Terminal, *, resizes: bool = False) -> None:
    """Wait, without reading the terminal, until the app has written a line; meanwhile have it drawn
    anew.
    """
    deadline, columns = time.monotonic() + 60, 300
    while not diary.exists() or line not in diary.read_text().splitlines():
        assert time.monotonic() < deadline, f"no {line!r}"
        if resizes:
            columns = 601 - columns
            terminal.resize(columns, 90)
        time.sleep(0.02)


@pytest.mark.slow
def test_a_terminal_that_goes_on_shows_what_changed_meanwhile(tmp_path: Path) -> None:
    diary = tmp_path / "diary"
    with Terminal(
        [sys.executable, "-m", "tests.tui.counting_app", str(diary)], columns=300, rows=90
    ) as terminal:
        terminal.wait_for("Counted 0 times.")
        wait_for(diary, "stalled", terminal, resizes=True)
        terminal.press("a")
        wait_for(diary, "counted 1", terminal)
        reader, deadline = ScreenReader(terminal, 300, 90), time.monotonic() + 60
        while "Counted 1 times." not in reader.text():
            assert time.monotonic() < deadline, reader.text()
            terminal.settle(silence_ms=20)
        terminal.press("ctrl+c")
        assert terminal.wait() == 130
