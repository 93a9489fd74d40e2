"""An output on the bus: hands actions over to it, and reports what becomes of them."""

import contextlib
from typing import Any, ClassVar

from sar_tui.framework import messages as m
from sar_tui.framework.bus import Bus, Topic
from sar_tui.framework.clock import MS, SECOND, Handle
from sar_tui.framework.messages import Deed, DeedState
from sar_tui.framework.node import Node, on
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import ACTION, ATTEMPT_ENDED, HALT, OUTPUT, PROMPT, REPORT, STOPPED, THEME
from sar_tui.outputs.output import Output, Report

GIVES_UP = 20 * SECOND
"""An output that has not told what became of a deed by then is told to stop; speaking takes longer with the text."""
PER_CHARACTER = 150 * MS
STILL = 2 * SECOND
"""An output that has not told by then that it is still is taken to have failed at it."""
_OVER: tuple[DeedState, ...] = ("done", "aborted", "failed")


class OutputNode(Node):
    """Stands between the loop and an output: each deed is reported as ``queued``, and once as over, whatever it does.

    An output that raises, or never answers, has failed; the session goes on.

    Args:
        output: the medium.
        address: how it was asked for.
        theme: to begin with.
        cues: for an output of tones: which of `theme.TONES` it sounds; ``go`` with each prompt, ``end`` after an
            attempt, ``success`` with praise.
    """

    emits: ClassVar[tuple[Topic[Any], ...]] = (OUTPUT, REPORT, STOPPED)

    def __init__(self, output: Output, address: str, theme: Theme, cues: tuple[str, ...] = ()) -> None:
        super().__init__()
        self.name = output.name
        self.output = output
        self._address = address
        self._theme = theme
        self._cues = cues
        self._can = output.can if not cues or "success" in cues else output.can - {"tone"}
        self._open: dict[tuple[str, Deed], Handle] = {}
        self._stopping: tuple[int, Handle] | None = None
        self._last_end = 0
        self._unopened = ""
        self._closed = False

    def attach(self, bus: Bus) -> None:
        """Join a bus, open the output, and say what it can do."""
        super().attach(bus)
        try:
            self.output.open(self._theme, bus.clock, self._hear)
        except Exception as error:
            self._unopened = f"It could not be opened ({_told_by(error)})."
        self.emit(OUTPUT, m.OutputOpened(output=self.name, address=self._address, can=tuple(sorted(self._can))))

    def detach(self) -> None:
        """Let go of the output."""
        if not self._closed and hasattr(self, "bus"):
            self._closed = True
            with contextlib.suppress(Exception):  # the session is over, and the other outputs have to be let go of
                self.output.close()

    @on(THEME)
    def wear(self, worn: m.ThemeWorn) -> None:
        self.output.wear(worn.theme)

    @on(ACTION)
    def act(self, action: m.Action) -> None:
        """Do of an action what this output can: the look and the tone first, then the rest."""
        if action.text or action.face:
            self._do(action.id, "show", action.text, action.face)
        if action.gaze:
            self._do(action.id, "gaze", action.gaze)
        if action.tone:
            self._do(action.id, "tone", action.tone)
        if action.gesture:
            self._do(action.id, "gesture", action.gesture)
        if action.spoken:
            self._do(action.id, "say", action.spoken)

    @on(PROMPT)
    def prompted(self, prompt: m.Prompt) -> None:
        if "go" in self._cues:
            self._begin(f"go-{prompt.attempt}-{prompt.trial}-{prompt.presentation}", "tone", "go")

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        """An attempt that is scored once more has ended before."""
        if "end" in self._cues and ended.ended == self.now:
            self._begin(f"end-{ended.attempt}", "tone", "end")

    @on(HALT)
    def halt(self, halt: m.Halt) -> None:
        """Be still; how long that took is told once nothing is under way any more."""
        if halt.reason == "stopped" and self._stopping is None:
            failed = self.bus.clock.call_at(self.bus.clock.now() + STILL, self._never_still)
            self._stopping = (halt.asked, failed)
        self._last_end = self.bus.clock.now()
        try:
            self.output.stop(halt.action)
        except Exception as error:
            why = f"It could not be stopped ({_told_by(error)})."
            self._tell_stopped(self.bus.clock.now(), why)
            for action, deed in list(self._open):
                if halt.action in ("", action):
                    self._end(action, deed, "failed", why)
        self._tell_if_still()

    def _do(self, action: str, deed: Deed, *what: str) -> None:
        if deed in self._can:
            self._begin(action, deed, *what)

    def _begin(self, action: str, deed: Deed, *what: str) -> None:
        self._report(action, deed, "queued", self.bus.clock.now())
        limit = GIVES_UP + PER_CHARACTER * (len(what[0]) if deed == "say" else 0)
        give_up = self.bus.clock.call_at(self.bus.clock.now() + limit, lambda: self._give_up(action, deed))
        if deed == "show":  # words stand for as long as nothing takes their place
            give_up.cancel()
        self._open[action, deed] = give_up
        if self._unopened:
            self._end(action, deed, "failed", self._unopened)
            return
        try:
            getattr(self.output, deed)(action, *what)
        except Exception as error:
            self._end(action, deed, "failed", f"{_told_by(error)}.")

    # --- what the output tells -------------------------------------------------------------------------------

    def _hear(self, report: Report) -> None:
        """From any thread."""
        self.bus.clock.call_soon(lambda: self._told(report))

    def _told(self, report: Report) -> None:
        if self._closed or (report.action, report.deed) not in self._open:
            return
        if report.state in _OVER:
            self._end(report.action, report.deed, report.state, report.detail, report.at)
        else:
            self._report(report.action, report.deed, report.state, report.at, report.detail)

    def _end(self, action: str, deed: Deed, state: DeedState, detail: str = "", at: int | None = None) -> None:
        if give_up := self._open.pop((action, deed), None):
            give_up.cancel()
            ended = self.bus.clock.now() if at is None else at
            self._last_end = max(self._last_end, ended)
            self._report(action, deed, state, ended, detail)
            self._tell_if_still()

    def _give_up(self, action: str, deed: Deed) -> None:
        if (action, deed) in self._open and not self._closed:
            self._end(action, deed, "failed", "It did not tell what became of it.")
            with contextlib.suppress(Exception):  # it has failed already
                self.output.stop(action)

    def _tell_if_still(self) -> None:
        """Words may stay where they are; nothing else may go on."""
        if all(deed == "show" for _, deed in self._open):
            self._tell_stopped(self._last_end)

    def _never_still(self) -> None:
        if not self._closed:
            self._tell_stopped(self.bus.clock.now(), "It did not tell that it is still.")

    def _tell_stopped(self, at: int, detail: str = "") -> None:
        """Tell once what came of a stop, if one was asked for."""
        if self._stopping:
            asked, never = self._stopping
            never.cancel()
            self._stopping = None
            self.bus.post(STOPPED, m.OutputStopped(output=self.name, asked=asked, at=at, detail=detail))

    def _report(self, action: str, deed: Deed, state: DeedState, at: int, detail: str = "") -> None:
        self.bus.post(
            REPORT, m.OutputReport(action=action, output=self.name, deed=deed, state=state, at=at, detail=detail)
        )


def _told_by(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
