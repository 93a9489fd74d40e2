"""Small outputs for tests: one that a test controls, and one that takes a while and is done."""

from collections.abc import Callable

from sar_tui.loop.clock import Clock, Handle
from sar_tui.model.messages import ActionPart
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from sar_tui.outputs.output import Output, Report

EVERYTHING: frozenset[ActionPart] = frozenset({"say", "show", "gesture", "gaze", "tone"})


class FakeOutput(Output):
    """Records requests, and reports only what a test has it report.

    Args:
        name, can: as those of any output.
        breaks: methods that raise.
        error: how they do.
    """

    def __init__(
        self,
        name: str = "fake",
        can: frozenset[ActionPart] = EVERYTHING,
        breaks: tuple[str, ...] = (),
        error: type[BaseException] = RuntimeError,
    ) -> None:
        self.name = name
        self.can = can
        self.asked: list[tuple[str, ...]] = []
        self._breaks = breaks
        self._error = error

    def apply_theme(self, theme: Theme) -> None:
        super().apply_theme(theme)
        self._note("apply_theme", theme.name)

    def say(self, action: str, text: str) -> None:
        self._note("say", action, text)

    def show(self, action: str, text: str, face: str) -> None:
        self._note("show", action, text, face)

    def gesture(self, action: str, name: str) -> None:
        self._note("gesture", action, name)

    def gaze(self, action: str, where: str) -> None:
        self._note("gaze", action, where)

    def tone(self, action: str, name: str) -> None:
        self._note("tone", action, name)

    def stop(self, action: str = "") -> None:
        self._note("stop", action)

    def close(self) -> None:
        self._note("close")

    def _note(self, *what: str) -> None:
        self.asked.append(what)
        if what[0] in self._breaks:
            raise self._error(f"no {what[0]} today")


class Speaker(Output):
    """Takes a set time for each utterance, one after the other, and stops at once."""

    name = "speech"
    can = frozenset({"say"})

    def __init__(self, takes_ms: float = 1000) -> None:
        self.takes_ms = takes_ms
        self.said: list[tuple[int, str]] = []
        self._queue: list[tuple[str, str]] = []
        self._done: Handle | None = None

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        super().open(theme, clock, report)
        self._queue.clear()
        self._done = None

    def say(self, action: str, text: str) -> None:
        self._queue.append((action, text))
        if len(self._queue) == 1:
            self._begin()

    def stop(self, action: str = "") -> None:
        gone = [entry for entry in self._queue if action in ("", entry[0])]
        if self._queue and self._queue[0] in gone and self._done:
            self._done.cancel()
        was = self._queue[0] if self._queue else None
        self._queue = [entry for entry in self._queue if entry not in gone]
        for name, _ in gone:
            self.report(name, "say", "aborted")
        if self._queue and self._queue[0] != was:
            self._begin()

    def _begin(self) -> None:
        action, text = self._queue[0]
        self.said.append((self.clock.now(), text))
        self.report(action, "say", "started")
        self._done = self.clock.call_at(self.clock.now() + round(self.takes_ms * MS), self._end)

    def _end(self) -> None:
        action, _ = self._queue.pop(0)
        self.report(action, "say", "done")
        if self._queue:
            self._begin()
