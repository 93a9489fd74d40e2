"""State of the session as the panel knows it, computed from what the link brings. Pure: no screen,
no clock.
"""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import msgspec
from msgspec.structs import replace

from sar_tui.link.peer import Connection, Frame, MotionTrace, PeerEvent, Welcome
from sar_tui.loop import agent_state
from sar_tui.loop.agent_state import AgentState
from sar_tui.loop.marks import TrialMark
from sar_tui.loop.topics import (
    ACTION,
    ARBITER_STATE,
    ATTEMPT_ENDED,
    COMMAND,
    HALT,
    LEVEL,
    MARKED,
    OUTPUT,
    PRESENCE,
    PROMPT,
    PROTOCOL,
    PROTOCOL_DUE,
    PROTOCOL_TICKED,
    REPORT,
    SENSOR,
    SESSION_ENDED,
    STOPPED,
    THEME,
    TRIAL,
    VOIDED,
    WAITING,
)
from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.messages import (
    Action,
    ArbiterState,
    AttemptEnded,
    Halt,
    LevelChanged,
    OperatorChanged,
    OutputOpened,
    OutputReport,
    OutputStopped,
    Prompt,
    PromptVoided,
    ProtocolChosen,
    ProtocolDue,
    ProtocolTicked,
    Role,
    SensorChanged,
    SessionCommand,
    SessionEnded,
    ThemeApplied,
    TrialEnded,
    TrialMarked,
    Waiting,
)
from sar_tui.model.protocol import WizardProtocol
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.event_text import (
    PAUSE_REASONS,
    Line,
    Tone,
    append,
    event_line,
    session_text,
    stopper,
)

PARTICIPANT = "participant"
"""Actor of a participant's acts."""
MAX_STOPS = 10
"""Number of stops that are kept."""
MAX_TRIALS = 60
"""Number of trials that are kept for each participant."""
MAX_ATTEMPTS = 100
"""Number of attempts that are kept for each participant."""
TRACE_SECONDS = 8
"""Seconds of a hand's motion that are kept."""


class Seat(msgspec.Struct, frozen=True):
    """Results of one participant: the last trials, attempts and mark, and the hand's angular speed
    (rad/s).
    """

    trials: tuple[TrialEnded, ...] = ()
    attempts: tuple[AttemptEnded, ...] = ()
    mark: str = ""
    rates: tuple[float, ...] = ()

    @property
    def attempt(self) -> AttemptEnded | None:
        """The last attempt."""
        return self.attempts[-1] if self.attempts else None


UNCONFIRMED = 3 * SECOND
"""An output that has not reported by then is named. Outputs give up earlier (see
`outputs.node.STOP_TIMEOUT`).
"""


class Stop(NamedTuple):
    """A stop of the agent, from the key until every output has reported that it is still.

    Attributes:
        at: when it was requested (ns, session clock).
        by: who pressed the key, for the log.
        awaited: outputs that have not reported.
        failed: outputs that could not stop, with the reason.
        still_at: when the last output was still (ns).
        is_past: the agent has acted since.
        tr: language of the panel.
    """

    at: int
    by: str
    awaited: frozenset[str] = frozenset()
    failed: tuple[tuple[str, str], ...] = ()
    still_at: int = 0
    is_past: bool = False
    tr: Language = ENGLISH

    def reported(self, stopped: OutputStopped) -> "Stop":
        """Return the stop after an output has reported."""
        if stopped.output not in self.awaited:
            return self
        failed = (*self.failed, (stopped.output, stopped.detail)) if stopped.detail else self.failed
        awaited = self.awaited - {stopped.output}
        return self._replace(
            awaited=awaited, failed=failed, still_at=max(self.still_at, stopped.at)
        )

    def is_awaited(self, now: int) -> bool:
        """Return True while the outcome may change without a message of the session."""
        return bool(self.awaited) and now - self.at <= 2 * UNCONFIRMED

    def outcome(self, now: int, *, tells_time: bool = True) -> tuple[str, Tone]:
        """Return what is known at ``now`` (ns): stopping, stopped, or which output has not
        confirmed it. ``tells_time``: with the time that stopping took.
        """
        tr = self.tr
        late = sorted(self.awaited) if now - self.at > UNCONFIRMED else []
        if names := ", ".join([*(name for name, _ in self.failed), *late]):
            if why := " ".join(session_text(detail, tr) for _, detail in self.failed):
                return tr("not confirmed: {names} ({why})").format(names=names, why=why), "bad"
            return tr("not confirmed: {names}").format(names=names), "bad"
        if self.awaited:
            names = ", ".join(sorted(self.awaited))
            return tr("stopping {names} …").format(names=names), "plain"
        if not self.still_at:
            return tr("no output is open"), "plain"
        if not tells_time:
            return tr("stopped"), "good"
        ms = round(max(0, self.still_at - self.at) / MS)
        return tr("stopped after {ms} ms", ms=ms), "good"

    def line(self, now: int) -> Line:
        """Return its line of the log."""
        text, tone = self.outcome(now)
        return Line(self.at, f"{self.by}: {text}", tone)


class SessionState(msgspec.Struct, frozen=True):
    """Session as this side of the link knows it. None or empty: not known.

    Attributes:
        tr: language of the panel.
        level, next_level: levels of the current and of the next attempt.
        arbiter: pending proposals, queue and modes.
        voice: why speech fails, as the output reported it.
        outputs: names of the outputs that are open.
        stops: of the agent, oldest first.
        trial_mark: the trial that a mark is put on, and its mark.
        seats: results by seat.
        peers: roles by name.
        holder: name of the operator who has control.
        operated: True if there is an operator.
        pauser: actor who paused the session, or gave the last reason.
        protocol: by which the operators work.
        due: what is due by it and not ticked, oldest first.
        past_steps: numbers of the protocol's steps that have been due.
        ended: final status of the session.
        log: events that an operator should know about, oldest first.
    """

    tr: Language = ENGLISH
    connection: Connection = Connection("connecting")
    welcome: Welcome | None = None
    theme: Theme | None = None
    waiting: Waiting | None = None
    prompt: Prompt | None = None
    level: int | None = None
    next_level: int | None = None
    arbiter: ArbiterState | None = None
    agent: AgentState = AgentState()
    voice: str = ""
    outputs: frozenset[str] = frozenset()
    stops: tuple[Stop, ...] = ()
    trial_mark: TrialMark = TrialMark()
    sensor: SensorChanged | None = None
    seats: dict[str, Seat] = {}
    peers: dict[str, Role] = {}
    holder: str = ""
    operated: bool | None = None
    pauser: str = ""
    protocol: WizardProtocol | None = None
    due: tuple[ProtocolDue, ...] = ()
    past_steps: frozenset[int] = frozenset()
    ended: str = ""
    log: tuple[Line, ...] = ()

    @property
    def scheduled(self) -> Action | None:
        """The decided action that is held back until it is due, if any."""
        queued = self.arbiter.queued if self.arbiter and self.is_connected else ()
        return next((each for each in queued if each.due), None)

    def receive(self, event: PeerEvent) -> "SessionState":
        """Return the state after an event of the link."""
        if isinstance(event, Welcome):
            return SessionState(
                tr=self.tr,
                connection=self.connection,
                welcome=event,
                theme=self.theme,
                trial_mark=event.trial_mark,
            )
        if isinstance(event, MotionTrace):
            return self._add_motion(event)
        if isinstance(event, Connection):
            return replace(self, connection=event)
        return self._apply(event)

    @property
    def is_connected(self) -> bool:
        """True if the state is current and an act would arrive."""
        return self.connection.state == "connected" and self.welcome is not None

    @property
    def is_quiet(self) -> bool:
        """True while a response is awaited and the participant's screen must not move."""
        return bool(
            self.waiting
            and self.waiting.stage == "trial"
            and self.waiting.what in agent_state.AWAITED
        )

    @property
    def is_paused(self) -> bool:
        """True while the session is paused."""
        return bool(self.waiting and self.waiting.stage == "paused")

    @property
    def is_their_pause(self) -> bool:
        """True if the participant paused or gave a reason, or if it is not known who paused and
        why.
        """
        if not self.is_paused or self.waiting is None:
            return False
        reason = self.waiting.reason
        return reason in PAUSE_REASONS or (not reason and self.pauser in (PARTICIPANT, ""))

    @property
    def has_control(self) -> bool:
        """True if this peer's acts are accepted, as far as is known."""
        mine = self.welcome.name if self.welcome else ""
        return bool(self.welcome and self.welcome.role == "operator" and self.holder in ("", mine))

    def seat(self, name: str) -> Seat:
        """Return the results of a participant."""
        return self.seats.get(name, Seat())

    def with_seat(self, name: str, seat: Seat) -> "SessionState":
        """Return the state with other results for one participant."""
        return replace(self, seats={**self.seats, name: seat})

    def _apply(self, frames: Iterable[Frame]) -> "SessionState":
        state = self
        for frame in frames:
            before = state.arbiter
            agent = agent_state.step(state.agent, frame.message)
            trial_mark = state.trial_mark.after(frame.message)
            if agent is not state.agent or trial_mark is not state.trial_mark:
                state = replace(state, agent=agent, trial_mark=trial_mark)
            if handler := _HANDLERS.get(frame.topic.name):
                state = handler(state, frame.message)
            if line := event_line(frame, self.welcome, before, self.tr):
                state = replace(state, log=append(state.log, line))
        return state

    def _add_motion(self, trace: MotionTrace) -> "SessionState":
        length = max(1, round(trace.hz * TRACE_SECONDS))
        seat = self.seat(trace.seat)
        return self.with_seat(
            trace.seat, replace(seat, rates=(*seat.rates, *trace.rates)[-length:])
        )


# --- the task


def _on_waiting(state: SessionState, waiting: Waiting) -> SessionState:
    level = waiting.level or state.level
    prompt = state.prompt if waiting.stage == "trial" else None
    has_resumed = state.is_paused and waiting.stage != "paused"
    pauser = "" if has_resumed else state.pauser
    return replace(state, waiting=waiting, level=level, prompt=prompt, pauser=pauser)


def _on_command(state: SessionState, act: SessionCommand) -> SessionState:
    if act.command == "stop":
        by = stopper(act.actor, state.welcome, state.tr)
        stop = Stop(act.at, by, state.outputs, tr=state.tr)
        return replace(state, stops=(*state.stops, stop)[-MAX_STOPS:])
    return replace(state, pauser=act.actor) if act.command == "pause" else state


def _on_prompt(state: SessionState, prompt: Prompt) -> SessionState:
    return replace(state, prompt=prompt, level=prompt.level)


def _on_prompt_voided(state: SessionState, _: PromptVoided) -> SessionState:
    return replace(state, prompt=None)


def _on_trial(state: SessionState, trial: TrialEnded) -> SessionState:
    seat = state.seat(trial.seat)
    others = tuple(t for t in seat.trials if (t.attempt, t.trial) != (trial.attempt, trial.trial))
    seat = replace(seat, trials=(*others, trial)[-MAX_TRIALS:], mark="")
    return replace(state.with_seat(trial.seat, seat), prompt=None)


def _on_mark(state: SessionState, marked: TrialMarked) -> SessionState:
    seat = state.seat(marked.seat)
    trials = tuple(
        replace(t, correct=marked.correct, details={**t.details, "mark": marked.mark})
        if (t.attempt, t.trial) == (marked.attempt, marked.trial)
        else t
        for t in seat.trials
    )
    return state.with_seat(marked.seat, replace(seat, trials=trials, mark=marked.mark))


def _on_attempt(state: SessionState, ended: AttemptEnded) -> SessionState:
    seat = state.seat(ended.seat)
    others = tuple(each for each in seat.attempts if each.attempt != ended.attempt)
    return state.with_seat(ended.seat, replace(seat, attempts=(*others, ended)[-MAX_ATTEMPTS:]))


def _on_level(state: SessionState, changed: LevelChanged) -> SessionState:
    return replace(state, next_level=changed.level)


def _on_session_ended(state: SessionState, ended: SessionEnded) -> SessionState:
    return replace(state, ended=ended.status, prompt=None)


def _on_sensor(state: SessionState, changed: SensorChanged) -> SessionState:
    return replace(state, sensor=changed)


# --- the agent


def _on_report(state: SessionState, report: OutputReport) -> SessionState:
    if report.part == "say" and report.state in ("started", "failed"):
        why = report.detail or state.tr("it failed")
        return replace(state, voice=why if report.state == "failed" else "")
    return state


def _on_output_opened(state: SessionState, opened: OutputOpened) -> SessionState:
    return replace(state, outputs=state.outputs | {opened.output})


def _on_action(state: SessionState, _: Action) -> SessionState:
    return (
        replace(state, stops=tuple(stop._replace(is_past=True) for stop in state.stops))
        if state.stops
        else state
    )


def _on_halt(state: SessionState, halt: Halt) -> SessionState:
    """Take over the time of a stop whose key had no time stamp."""
    if halt.reason != "stopped" or not state.stops:
        return state
    return replace(state, stops=(*state.stops[:-1], state.stops[-1]._replace(at=halt.asked)))


def _on_output_stopped(state: SessionState, stopped: OutputStopped) -> SessionState:
    return replace(state, stops=tuple(stop.reported(stopped) for stop in state.stops))


def _on_arbiter_state(state: SessionState, arbiter: ArbiterState) -> SessionState:
    return replace(state, arbiter=arbiter, operated=arbiter.operated)


def _on_theme(state: SessionState, applied: ThemeApplied) -> SessionState:
    return replace(state, theme=applied.theme)


# --- operators and observers


def _on_presence(state: SessionState, changed: OperatorChanged) -> SessionState:
    return replace(state, peers=changed.peers, holder=changed.holder, operated=changed.operated)


# --- the operators' protocol


def _on_protocol(state: SessionState, chosen: ProtocolChosen) -> SessionState:
    return replace(state, protocol=chosen.protocol, due=(), past_steps=frozenset())


def _on_due(state: SessionState, due: ProtocolDue) -> SessionState:
    past = state.past_steps | {due.number} if due.what == "step" else state.past_steps
    return replace(state, due=(*state.due, due), past_steps=past)


def _on_ticked(state: SessionState, ticked: ProtocolTicked) -> SessionState:
    return replace(state, due=tuple(each for each in state.due if each.id != ticked.due))


_HANDLERS: dict[str, Callable[[SessionState, Any], SessionState]] = {
    COMMAND.name: _on_command,
    WAITING.name: _on_waiting,
    PROMPT.name: _on_prompt,
    VOIDED.name: _on_prompt_voided,
    TRIAL.name: _on_trial,
    MARKED.name: _on_mark,
    ATTEMPT_ENDED.name: _on_attempt,
    LEVEL.name: _on_level,
    SESSION_ENDED.name: _on_session_ended,
    SENSOR.name: _on_sensor,
    REPORT.name: _on_report,
    OUTPUT.name: _on_output_opened,
    ACTION.name: _on_action,
    HALT.name: _on_halt,
    STOPPED.name: _on_output_stopped,
    ARBITER_STATE.name: _on_arbiter_state,
    THEME.name: _on_theme,
    PRESENCE.name: _on_presence,
    PROTOCOL.name: _on_protocol,
    PROTOCOL_DUE.name: _on_due,
    PROTOCOL_TICKED.name: _on_ticked,
}
