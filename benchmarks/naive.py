"""A naive reaction task in Textual: onset stamped at ``update()``, response in the key handler."""

import time

from textual import events
from textual.app import App, ComposeResult
from textual.widgets import Static

from sar_tui.timing.baseline import Procedure


class Naive(App[None]):
    """Shows each prompt in a Static."""

    def __init__(self, procedure: Procedure) -> None:
        super().__init__()
        self._procedure = procedure
        self._trial = -1
        self._onset: int | None = None

    def compose(self) -> ComposeResult:
        yield Static("Press Enter to begin")

    def on_key(self, event: events.Key) -> None:
        response = time.monotonic_ns()
        if self._trial < 0 and event.key == "enter":
            self._next()
        elif self._onset is not None:
            self._procedure.record(
                self._trial, event.character or event.key, (response - self._onset) / 1e6
            )
            self._next()

    def _next(self) -> None:
        self._trial += 1
        self._onset = None
        self.query_one(Static).update("")
        if self._trial == self._procedure.prompts:
            self.exit()
        else:
            self.set_timer(self._procedure.foreperiod(self._trial), self._show)

    def _show(self) -> None:
        self.query_one(Static).update(f"Press: {self._procedure.key(self._trial)}")
        self._onset = time.monotonic_ns()


if __name__ == "__main__":
    Naive(Procedure()).run()
