"""Output to a terminal that stops taking it."""

import contextlib
import os
import threading
from collections.abc import Iterator

import pytest

if os.name != "posix":
    pytest.skip("pseudo-terminals of POSIX systems", allow_module_level=True)

import tty

from sar_tui.tui import terminal_output
from sar_tui.tui.terminal_output import RESET, TerminalOutput
from sar_tui.tui.timestamps import OnsetWatch, WatchedFile

LONG = "x" * 4000
PROMPT = "Press: f"


class Line:
    """A pseudo-terminal whose far end reads when it is told to."""

    def __init__(self) -> None:
        self.far, self._near = os.openpty()
        tty.setraw(self._near)
        os.set_blocking(self.far, False)
        self.recovered, self.gone = threading.Event(), threading.Event()
        self.output = TerminalOutput(self._near, self.recovered.set, self.gone.set)

    def write(self, text: str) -> None:
        self.output.write(text)
        self.output.flush()

    def fill(self) -> None:
        """Write until nothing more is taken."""
        while not self.output.is_stalled:
            self.write(LONG)

    def read(self) -> bytes:
        """Read all that has arrived."""
        parts = []
        try:
            while part := os.read(self.far, 65536):
                parts.append(part)
        except (BlockingIOError, OSError):
            pass
        return b"".join(parts)

    def close(self) -> None:
        self.output.end()
        for each in (self.far, self._near):
            with contextlib.suppress(OSError):
                os.close(each)


@pytest.fixture
def line(monkeypatch: pytest.MonkeyPatch) -> Iterator[Line]:
    monkeypatch.setattr(terminal_output, "STALLED_AFTER_S", 0.02)
    monkeypatch.setattr(terminal_output, "_LOOK_S", 0.01)
    line = Line()
    yield line
    line.close()


def test_text_arrives_with_the_flush(line: Line) -> None:
    line.output.write("half ")
    assert line.read() == b""
    line.write("whole: ¿qué tal?")
    assert line.read().decode() == "half whole: ¿qué tal?"


def test_a_stalled_terminal_does_not_block_the_program(line: Line) -> None:
    line.fill()
    for _ in range(1000):
        line.write(LONG)
    assert line.output.is_stalled


def test_a_terminal_that_goes_on_is_drawn_again(line: Line) -> None:
    line.fill()
    line.write("dropped")
    while not line.recovered.is_set():
        line.read()
    line.read()
    line.write("here again")
    assert line.read().endswith(b"here again")
    assert not line.output.is_stalled


def test_a_stalled_terminal_is_restored_at_the_end_for_when_it_goes_on(line: Line) -> None:
    line.fill()
    line.output.end()
    line.write("the driver's own goodbye, which is dropped")
    line.output.restore()
    assert line.read().endswith(RESET)


def test_a_terminal_that_is_not_stalled_gets_nothing_more_at_the_end(line: Line) -> None:
    line.output.end()
    line.write("goodbye")
    line.output.restore()
    assert line.read() == b"goodbye"


def test_a_lost_terminal_is_told_once(line: Line) -> None:
    os.close(line.far)
    line.write("nobody")
    assert line.gone.is_set()
    line.gone.clear()
    line.write("reads it")
    assert not line.gone.is_set()


def test_a_prompt_that_was_dropped_has_no_onset_until_it_is_drawn(line: Line) -> None:
    onsets: list[int] = []
    watch = OnsetWatch()
    file = WatchedFile(line.output, watch, lambda: None)  # type: ignore[arg-type]
    line.fill()
    watch.arm(PROMPT, onsets.append)
    file.write(PROMPT)
    file.flush()
    assert onsets == []
    while not line.recovered.is_set():
        line.read()
    file.write("something else")
    file.flush()
    assert onsets == []
    file.write(PROMPT)
    file.flush()
    assert len(onsets) == 1
