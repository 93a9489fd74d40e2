"""An output on the bus: hands actions over to it, and reports what becomes of them."""

import contextlib
from typing import Any, ClassVar, NamedTuple, get_args

from sar_tui.framework import messages as m
from sar_tui.framework.bus import Bus, Topic
from sar_tui.framework.clock import MS, SECOND, Handle
from sar_tui.framework.messages import ActionPart, PartState
from sar_tui.framework.node import Node, on
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import ACTION, ATTEMPT_ENDED, CUE, HALT, OUTPUT, PROMPT, REPORT, STOPPED, THEME
from sar_tui.outputs.output import Output, OutputError, Report
from sar_tui.outputs.report_validation import heard, told_by, words

GIVES_UP = 20 * SECOND
"""An output that has not told what became of a part by then is told to stop; speaking takes longer with the text."""
PER_CHARACTER = 150 * MS
STILL = 2 * SECOND
"""What an output has not told to be over by then, after it was told to stop, is taken to have failed."""
_OVER: tuple[PartState, ...] = ("done", "aborted", "failed")
_Key = tuple[str, ActionPart]
"""An action, and which part of it."""


class _Open(NamedTuple):
    """A part that is not over: since when, and what gives it up."""

    since: int
    give_up: Handle


class _Stop:
    """A stop that was asked for: since when, what is not over yet, when the last of it was, and what went wrong."""

    def __init__(self, asked: int, now: int) -> None:
        self.asked = asked
        self.left: dict[_Key, _Open] = {}
        self.at = now
        self.details: list[str] = []


class OutputNode(Node):
    """Stands between the loop and an output: each part is reported as ``queued``, and once as over, whatever it does.

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
        self._open: dict[_Key, _Open] = {}
        self._stopping: _Stop | None = None
        self._unopened = ""
        self._closed = False

    def attach(self, bus: Bus) -> None:
        """Join a bus, open the output, and say what it can do."""
        super().attach(bus)
        try:
            self.output.open(self._theme, bus.clock, self._hear)
        except Exception as error:
            self._unopened = f"It could not be opened ({told_by(error)})."
        self.emit(OUTPUT, m.OutputOpened(output=self.name, address=self._address, can=tuple(sorted(self._can))))

    def detach(self) -> None:
        """Let go of the output; what it has not brought to its end is aborted with that."""
        if not self._closed and hasattr(self, "bus"):
            for key in [key for key in self._open if key[1] != "show"]:
                self._end(*key, "aborted", "The session was left.")
            self._closed = True
            with contextlib.suppress(Exception):  # the session is over, and the other outputs have to be let go of
                self.output.close()

    @on(THEME)
    def apply_theme(self, worn: m.ThemeApplied) -> None:
        self.output.apply_theme(worn.theme)

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

    @on(CUE)
    def cued(self, cue: m.CueGiven) -> None:
        """Look or point before a prompt, at once."""
        if cue.gaze:
            self._do(cue.id, "gaze", cue.gaze)
        if cue.gesture:
            self._do(cue.id, "gesture", cue.gesture)

    @on(PROMPT)
    def prompted(self, prompt: m.Prompt) -> None:
        if "go" in self._cues:
            self._begin(f"go-{prompt.attempt}-{prompt.trial}-{prompt.presentation}", "tone", "go")

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        """An attempt that is scored once more has ended before; that of two ends for both of them at once."""
        id = f"end-{ended.attempt}"
        if "end" in self._cues and ended.ended == self.now and (id, "tone") not in self._open:
            self._begin(id, "tone", "end")

    @on(HALT)
    def halt(self, halt: m.Halt) -> None:
        """Be still; how long that took, and whether it failed, is told once nothing of it is under way any more."""
        clock = self.bus.clock
        halted = {key: held for key, held in self._open.items() if halt.action in ("", key[0])}
        lasting = {key: held for key, held in halted.items() if key[1] != "show"}  # words may stay where they are
        if halt.reason == "stopped":
            self._stopping = self._stopping or _Stop(halt.asked, clock.now())
            self._stopping.left |= lasting
        try:
            self.output.stop(halt.action)
        except Exception as error:
            why = words(error) if isinstance(error, OutputError) else f"It could not be stopped ({told_by(error)})."
            if self._stopping and halt.reason == "stopped":
                self._stopping.details.append(why)
            for key in halted:
                self._end(*key, "failed", why)
        if lasting:
            clock.call_at(clock.now() + STILL, lambda: self._never_still(lasting))
        self._tell_if_still()

    def _do(self, action: str, part: ActionPart, *what: str) -> None:
        if part in self._can:
            self._begin(action, part, *what)

    def _begin(self, action: str, part: ActionPart, *what: str) -> None:
        now = self.bus.clock.now()
        self._report(action, part, "queued", now)
        limit = GIVES_UP + PER_CHARACTER * (len(what[0]) if part == "say" else 0)
        give_up = self.bus.clock.call_at(now + limit, lambda: self._give_up(action, part))
        if part == "show":  # words stand for as long as nothing takes their place
            give_up.cancel()
        self._open[action, part] = _Open(now, give_up)
        if self._unopened:
            self._end(action, part, "failed", self._unopened)
            return
        try:
            getattr(self.output, part)(action, *what)
        except Exception as error:
            self._end(action, part, "failed", f"{told_by(error)}.")

    # --- what the output tells -------------------------------------------------------------------------------

    def _hear(self, report: Report) -> None:
        """From any thread."""
        self.bus.clock.call_soon(lambda: self._told(report))

    def _told(self, report: Report) -> None:
        if self._closed:
            return
        for key, held in self._meant(report).items():
            if (said := heard(report, held.since, self.bus.clock.now())) is None:
                self._end(*key, "failed", "It reported what cannot be understood.")
            elif said.state in _OVER:
                self._end(*key, said.state, said.detail, said.at)
            else:
                self._report(*key, said.state, said.at, said.detail)

    def _meant(self, report: Report) -> dict[_Key, _Open]:
        """Which parts a report is about: all of its action, where there is no such part."""
        action, part = getattr(report, "action", None), getattr(report, "part", None)
        known = isinstance(part, str) and part in get_args(ActionPart)
        return {key: held for key, held in self._open.items() if key[0] == action and (key[1] == part or not known)}

    def _end(self, action: str, part: ActionPart, state: PartState, detail: str = "", at: int | None = None) -> None:
        if held := self._open.pop((action, part), None):
            held.give_up.cancel()
            ended = self.bus.clock.now() if at is None else at
            self._report(action, part, state, ended, detail)
            stop = self._stopping
            if stop and stop.left.pop((action, part), None):
                stop.at = max(stop.at, ended)
                if state != "done" and detail:
                    stop.details.append(detail)
                self._tell_if_still()

    def _give_up(self, action: str, part: ActionPart) -> None:
        if (action, part) in self._open and not self._closed:
            self._end(action, part, "failed", "It did not tell what became of it.")
            with contextlib.suppress(Exception):  # it has failed already
                self.output.stop(action)

    def _never_still(self, halted: dict[_Key, _Open]) -> None:
        for key, held in halted.items():
            if self._open.get(key) is held and not self._closed:
                self._end(*key, "failed", "It did not become still.")

    def _tell_if_still(self) -> None:
        """Tell once what came of a stop: when all that was under way then is over."""
        if (stop := self._stopping) and not stop.left:
            self._stopping = None
            detail = " ".join(dict.fromkeys(stop.details))
            self.bus.post(STOPPED, m.OutputStopped(output=self.name, asked=stop.asked, at=stop.at, detail=detail))

    def _report(self, action: str, part: ActionPart, state: PartState, at: int, detail: str = "") -> None:
        self.bus.post(
            REPORT, m.OutputReport(action=action, output=self.name, part=part, state=state, at=at, detail=detail)
        )
