"""Small app that counts the key a, and writes down what happens to it: ``python -m
tests.tui.counting_app DIARY``.
"""

import sys
from pathlib import Path

from textual import events
from textual.app import ComposeResult
from textual.widgets import Static

from sar_tui.tui.base_app import BaseApp
from sar_tui.tui.terminal_output import TerminalOutput


class Counting(BaseApp):
    presses = 0
    was_stalled = False

    def compose(self) -> ComposeResult:
        yield Static("Counted 0 times.", id="count")

    def on_mount(self) -> None:
        self.set_interval(0.05, self.look)

    def look(self) -> None:
        """Write down that the terminal is stalled, once."""
        output = getattr(self._driver, "_output", None)
        assert isinstance(output, TerminalOutput)
        if output.is_stalled and not self.was_stalled:
            self.was_stalled = True
            write_down("stalled")

    def on_key(self, event: events.Key) -> None:
        if event.key == "a":
            self.presses += 1
            self.query_one(Static).update(f"Counted {self.presses} times.")
            self.call_after_refresh(write_down, f"counted {self.presses}")


def write_down(line: str) -> None:
    with Path(sys.argv[1]).open("a") as diary:
        diary.write(f"{line}\n")


if __name__ == "__main__":
    sys.exit(Counting().run_here())
