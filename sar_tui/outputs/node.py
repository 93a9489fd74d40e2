"""An output on the bus: passes actions to it, and reports the state of each part."""

from typing import Any, ClassVar, NamedTuple, get_args

from sar_tui.loop.bus import Bus, Topic
from sar_tui.loop.clock import Handle, PacedClock, VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import (
    ACTION,
    ATTEMPT_ENDED,
    CUE,
    HALT,
    OUTPUT,
    PROMPT,
    REPORT,
    STOPPED,
    THEME,
)
from sar_tui.model import messages as m
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.output import Output, OutputError, Report

TIMEOUT = 20 * SECOND
"""An output that has not reported the outcome of a part by then is stopped; longer texts get more
time.
"""
PER_CHARACTER = 150 * MS
STOP_TIMEOUT = 2 * SECOND
"""A part that is not over by then, after a stop, has failed."""
_NO_OUTCOME = "It did not report the outcome."
_NO_OUTCOME_SIMULATED = (
    f"{_NO_OUTCOME} In this simulation time jumped over its work, because it requested a timer of "
    "self.clock. If it waits for a device, let it request none when self.simulated is True, or "
    "report without the device."
)
CLOSE = "close"
"""Place of a `Fault` of an output that could not be closed."""
_OVER: tuple[PartState, ...] = ("done", "aborted", "failed")
_Key = tuple[str, ActionPart]
"""An action's id and a part of it."""


class _Open(NamedTuple):
    """A part that is not over: when it began, and the timer that gives it up."""

    since: int
    give_up: Handle


class _Unstopped(NamedTuple):
    """The last action whose part is over for the session, but may go on, and why."""

    action: str
    why: str


class _Stop:
    """A stop under way: when it was requested, the parts that are left, when the last one ended,
    and failures.
    """

    def __init__(self, asked: int, now: int) -> None:
        self.asked = asked
        self.left: dict[_Key, _Open] = {}
        self.at = now
        self.details: list[str] = []


class OutputNode(Node):
    """Connects the loop to an output. Reports each part as ``queued``, and once as over, whatever
    the output does.

    An output that raises or never reports has failed; the session continues. In a simulation an
    output that requests no timer of the clock works on a thread of its own: the clock keeps real
    time until it reports.

    Args:
        output: the medium.
        address: its address in the settings.
        theme: the first theme.
        cues: for an output of tones, those of `theme.TONES` that it plays: ``go`` with each prompt,
            ``end`` after an attempt, ``success`` with praise.
    """

    emits: ClassVar[tuple[Topic[Any], ...]] = (OUTPUT, REPORT, STOPPED)

    def __init__(
        self, output: Output, address: str, theme: Theme, cues: tuple[str, ...] = ()
    ) -> None:
        super().__init__()
        self.name = output.name
        self.output = output
        self._address = address
        self._theme = theme
        self._cues = cues
        self._can = output.can if not cues or "success" in cues else output.can - {"tone"}
        self._open: dict[_Key, _Open] = {}
        self._stopping: _Stop | None = None
        self._unstopped: dict[ActionPart, _Unstopped] = {}
        self._open_error = ""
        self._closed = False
        self._uses_clock = False

    def attach(self, bus: Bus) -> None:
        """Join a bus, open the output, and announce its parts."""
        super().attach(bus)
        try:
            self.output.simulated = isinstance(bus.clock, VirtualClock)
            self.output.open(self._theme, bus.clock, self._receive)
        except BaseException as error:
            self._raise_if_interrupted(error)
            self._open_error = f"It could not be opened ({describe(error)})."
        self.emit(
            OUTPUT,
            m.OutputOpened(output=self.name, address=self._address, can=tuple(sorted(self._can))),
        )

    def detach(self) -> None:
        """Close the output; parts that are not over are aborted."""
        if not self._closed and hasattr(self, "bus"):
            for key in [key for key in self._open if key[1] != "show"]:
                self._end(*key, "aborted", "The session was left.")
            self._closed = True
            try:
                self.output.close()
            except (
                BaseException
            ) as error:  # the session is over, and the other outputs must still be closed
                self._raise_if_interrupted(error)
                self.bus.report(self.name, CLOSE, error)

    @on(THEME)
    def apply_theme(self, applied: m.ThemeApplied) -> None:
        self.output.apply_theme(applied.theme)

    @on(ACTION)
    def act(self, action: m.Action) -> None:
        """Request the parts of an action that this output can do: the look and the tone first."""
        self._do(action.id, "show", action.text, action.face)
        self._do(action.id, "gaze", action.gaze)
        self._do(action.id, "tone", action.tone)
        self._do(action.id, "gesture", action.gesture)
        self._do(action.id, "say", action.spoken)

    @on(CUE)
    def cued(self, cue: m.CueGiven) -> None:
        """Look or point before a prompt, at once."""
        self._do(cue.id, "gaze", cue.gaze)
        self._do(cue.id, "gesture", cue.gesture)

    @on(PROMPT)
    def prompted(self, prompt: m.Prompt) -> None:
        if "go" in self._cues:
            self._begin(f"go-{prompt.attempt}-{prompt.trial}-{prompt.presentation}", "tone", "go")

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        """Play the end tone once, even if the attempt is scored again or has two participants."""
        id = f"end-{ended.attempt}"
        if "end" in self._cues and ended.ended == self.now and (id, "tone") not in self._open:
            self._begin(id, "tone", "end")

    @on(HALT)
    def halt(self, halt: m.Halt) -> None:
        """Stop the output. The outcome and the duration are reported when every part is over."""
        clock = self.bus.clock
        halted = {key: opened for key, opened in self._open.items() if halt.action in ("", key[0])}
        # text may stay on the screen
        lasting = {key: opened for key, opened in halted.items() if key[1] != "show"}
        if halt.reason == "stopped":
            self._stopping = self._stopping or _Stop(halt.asked, clock.now())
            self._stopping.left |= lasting
        try:
            self.output.stop(halt.action)
        except BaseException as error:
            self._raise_if_interrupted(error)
            why = (
                as_text(error)
                if isinstance(error, OutputError)
                else f"It could not be stopped ({describe(error)})."
            )
            if self._stopping and halt.reason == "stopped":
                self._stopping.details.append(why)
            for key in halted:
                self._end(*key, "failed", why)
        if lasting:
            clock.call_at(clock.now() + STOP_TIMEOUT, lambda: self._not_stopped(lasting))
        self._report_stop()

    def _raise_if_interrupted(self, error: BaseException) -> None:
        """Raise a Ctrl-C during a simulation. In a live session none is raised; the error is the
        output's own.
        """
        if isinstance(error, KeyboardInterrupt) and isinstance(self.bus.clock, VirtualClock):
            raise error

    def _do(self, action: str, part: ActionPart, *what: str) -> None:
        """Request a part of an action, unless it is empty or this output cannot do it."""
        if part in self._can and any(what):
            self._begin(action, part, *what)

    def _begin(self, action: str, part: ActionPart, *what: str) -> None:
        now = self.bus.clock.now()
        self._report(action, part, "queued", now)
        limit = TIMEOUT + PER_CHARACTER * (len(what[0]) if part == "say" else 0)
        give_up = self.bus.clock.call_at(now + limit, lambda: self._give_up(action, part))
        if part == "show":  # a text stays until another replaces it
            give_up.cancel()
        self._open[action, part] = _Open(now, give_up)
        if self._open_error:
            self._end(action, part, "failed", self._open_error)
            return
        clock = self.bus.clock
        timers = clock.timers if isinstance(clock, PacedClock) else 0
        try:
            getattr(self.output, part)(action, *what)
        except BaseException as error:
            self._raise_if_interrupted(error)
            why = as_text(error) if isinstance(error, OutputError) else f"{describe(error)}."
            self._end(action, part, "failed", why)
            return
        if isinstance(clock, PacedClock) and part != "show":
            self._uses_clock = self._uses_clock or clock.timers > timers
            if not self._uses_clock:
                clock.begin_work((self.name, action, part))

    # --- reports of the output

    def _receive(self, report: Report) -> None:
        """Called from any thread."""
        self.bus.clock.call_soon(lambda: self._reported(report))

    def _reported(self, report: Report) -> None:
        if self._closed:
            return
        self._forget_unstopped(report)
        for key, opened in self._parts_of(report).items():
            if (checked := valid_report(report, opened.since, self.bus.clock.now())) is None:
                self._end(*key, "failed", "Its report could not be understood.")
                continue
            if _is_proof(checked.state, checked.detail):  # the one before is over, too
                self._unstopped.pop(key[1], None)
            if checked.state in _OVER:
                self._end(*key, checked.state, checked.detail, checked.at)
            else:
                self._report(*key, checked.state, checked.at, checked.detail)

    def _forget_unstopped(self, report: Report) -> None:
        """Forget a part that may go on when the output reports, late, that it is over."""
        action, part, state, detail = (
            getattr(report, name, None) for name in ("action", "part", "state", "detail")
        )
        if state in _OVER and _is_proof(state, detail):
            self._unstopped = {
                key: late
                for key, late in self._unstopped.items()
                if (late.action, key) != (action, part)
            }

    def _parts_of(self, report: Report) -> dict[_Key, _Open]:
        """Return the open parts that a report is about: all parts of its action if it names none
        that exists.
        """
        action, part = getattr(report, "action", None), getattr(report, "part", None)
        known = isinstance(part, str) and part in get_args(ActionPart)
        return {
            key: opened
            for key, opened in self._open.items()
            if key[0] == action and (key[1] == part or not known)
        }

    def _end(
        self,
        action: str,
        part: ActionPart,
        state: PartState,
        detail: str = "",
        at: int | None = None,
    ) -> None:
        if opened := self._open.pop((action, part), None):
            opened.give_up.cancel()
            if isinstance(self.bus.clock, PacedClock):
                self.bus.clock.end_work((self.name, action, part))
            ended = self.bus.clock.now() if at is None else at
            self._report(action, part, state, ended, detail)
            if state == "aborted" and detail and part != "show":
                self._unstopped[part] = _Unstopped(action, detail)
            stop = self._stopping
            if stop and stop.left.pop((action, part), None):
                stop.at = max(stop.at, ended)
                if state != "done" and detail:
                    stop.details.append(detail)
                self._report_stop()

    def _give_up(self, action: str, part: ActionPart) -> None:
        if (action, part) in self._open and not self._closed:
            self._fail_unstopped(
                action, part, _NO_OUTCOME_SIMULATED if self._uses_clock else _NO_OUTCOME
            )
            try:
                self.output.stop(action)
            except BaseException as error:  # it has failed already
                self._raise_if_interrupted(error)

    def _not_stopped(self, halted: dict[_Key, _Open]) -> None:
        for key, opened in halted.items():
            if self._open.get(key) is opened and not self._closed:
                self._fail_unstopped(*key, "It did not stop in time.")

    def _fail_unstopped(self, action: str, part: ActionPart, why: str) -> None:
        self._unstopped[part] = _Unstopped(action, why)
        self._end(action, part, "failed", why)

    def _report_stop(self) -> None:
        """Report a stop once, when everything that was under way is over."""
        if (stop := self._stopping) and not stop.left:
            self._stopping = None
            detail = " ".join(
                dict.fromkeys([*stop.details, *(late.why for late in self._unstopped.values())])
            )
            self.bus.post(
                STOPPED,
                m.OutputStopped(output=self.name, asked=stop.asked, at=stop.at, detail=detail),
            )

    def _report(
        self, action: str, part: ActionPart, state: PartState, at: int, detail: str = ""
    ) -> None:
        self.bus.post(
            REPORT,
            m.OutputReport(
                action=action, output=self.name, part=part, state=state, at=at, detail=detail
            ),
        )


def _is_proof(state: PartState, detail: object) -> bool:
    """Return True if a report proves that nothing before it goes on: it began, or it ended without
    a doubt.
    """
    return state in ("started", "done") or (state == "aborted" and not detail)


LONGEST_DETAIL = 500
"""Longer details are cut to this many characters."""
AHEAD = SECOND
"""Largest time by which a report may be ahead of the session's clock."""


def valid_report(report: Any, since: int, now: int) -> Report | None:
    """Return a report that can be stored; None if it is invalid.

    Args:
        report: the output's report.
        since, now: the range of valid times (ns).
    """
    try:
        value = Report(
            report.action, report.part, report.state, int(report.at), as_text(report.detail)
        )
        known = value.part in get_args(ActionPart) and value.state in get_args(PartState)
    except Exception:
        return None
    return value if known and since <= value.at <= now + AHEAD else None


def as_text(value: object) -> str:
    """Return a value as text that any file can hold, shortened if it is long."""
    try:
        text = str(value)
    except Exception:
        text = f"a {type(value).__name__} that cannot be read"
    return text[:LONGEST_DETAIL].encode("utf-8", "replace").decode()


def describe(error: BaseException) -> str:
    """Describe an exception for use in a sentence."""
    return as_text(f"{type(error).__name__}: {as_text(error)}")
