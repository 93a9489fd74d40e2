"""The state: what an operator knows of the session, made from what the link brings. Pure: no screen, no clock."""

from collections.abc import Callable, Iterable
from typing import Any

import msgspec
from msgspec.structs import replace

from sar_tui.framework.messages import (
    Action,
    AgentActing,
    ArbiterState,
    AttemptEnded,
    CueGiven,
    Halt,
    LevelChanged,
    Operator,
    OperatorChanged,
    OutputReport,
    Prompt,
    PromptVoided,
    Role,
    SensorChanged,
    SessionEnded,
    ThemeApplied,
    TrialEnded,
    TrialMarked,
    Waiting,
)
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import (
    ACTING,
    ACTION,
    ARBITER_STATE,
    ATTEMPT_ENDED,
    CUE,
    HALT,
    LEVEL,
    MARKED,
    OPERATOR,
    PRESENCE,
    PROMPT,
    REPORT,
    SENSOR,
    SESSION_ENDED,
    THEME,
    TRIAL,
    VOIDED,
    WAITING,
)
from sar_tui.link.peer import Connection, Frame, MotionTrace, PeerEvent, Welcome
from sar_tui.operator import event_log
from sar_tui.operator.event_log import Line

PARTICIPANT = "participant"
"""The actor of what a participant does."""
_UNWELL = ("tired", "pain", "finished")
_QUIET = ("foreperiod", "storage", "response")
TRIALS_KEPT = 60
TRACE_SECONDS = 8
"""How much of the past is shown of responses, and of a hand's motion."""


class Agent(msgspec.Struct, frozen=True):
    """What the participant sees of the agent: the words that stand, what was added to them, the expression.

    ``kind`` is of the words. ``moves`` is what was last said or done, with its gesture and gaze; ``cue``: to which side
    it looks or points, until the response is there; ``still`` counts how often it was told to be still.
    """

    words: str = ""
    more: str = ""
    kind: str = ""
    face: str = "neutral"
    valence: str | None = None
    moves: Action | None = None
    cue: CueGiven | None = None
    still: int = 0


class Seat(msgspec.Struct, frozen=True):
    """How one participant does: the last trials and attempt, the last mark, how fast the hand turned (rad/s)."""

    trials: tuple[TrialEnded, ...] = ()
    attempt: AttemptEnded | None = None
    mark: str = ""
    rates: tuple[float, ...] = ()


class SessionState(msgspec.Struct, frozen=True):
    """The session as this side of the link knows it. What is None, or empty, is not known.

    ``level``: of the attempt under way; ``next_level``: of the next. ``seats``: by name. ``holder``: the operator who
    has the baton. ``pauser``: who paused it, or last said why. ``voice``: why nothing is heard, as an output told it.
    ``journal``: what happened that an operator should know, oldest first.
    """

    connection: Connection = Connection("connecting")
    welcome: Welcome | None = None
    theme: Theme | None = None
    waiting: Waiting | None = None
    prompt: Prompt | None = None
    level: int | None = None
    next_level: int | None = None
    arbiter: ArbiterState | None = None
    agent: Agent = Agent()
    acting: bool | None = None
    voice: str = ""
    sensor: SensorChanged | None = None
    seats: dict[str, Seat] = {}
    peers: dict[str, Role] = {}
    holder: str = ""
    operated: bool | None = None
    pauser: str = ""
    ended: str = ""
    log: tuple[Line, ...] = ()

    def receive(self, event: PeerEvent) -> "SessionState":
        """What is known once this has been heard."""
        if isinstance(event, Welcome):
            return SessionState(connection=self.connection, welcome=event, theme=self.theme)
        if isinstance(event, MotionTrace):
            return self._moved(event)
        if isinstance(event, Connection):
            return replace(self, connection=event)
        return self._frames(event)

    @property
    def is_connected(self) -> bool:
        """Whether what is shown is the present, and an act would arrive."""
        return self.connection.state == "connected" and self.welcome is not None

    @property
    def is_quiet(self) -> bool:
        """Whether the participant's screen stands still, because a response is awaited."""
        return bool(self.waiting and self.waiting.stage == "trial" and self.waiting.what in _QUIET)

    @property
    def is_paused(self) -> bool:
        """Whether the session stands still until somebody lets it go on."""
        return bool(self.waiting and self.waiting.stage == "paused")

    @property
    def is_their_pause(self) -> bool:
        """Whether the participant paused, or is in pain or tired; also where it is not known who paused, and why."""
        if not self.is_paused or self.waiting is None:
            return False
        reason = self.waiting.reason
        return reason in _UNWELL or (not reason and self.pauser in (PARTICIPANT, ""))

    @property
    def has_control(self) -> bool:
        """Whether this peer's acts are heeded, as far as is known."""
        mine = self.welcome.name if self.welcome else ""
        return bool(self.welcome and self.welcome.role == "operator" and self.holder in ("", mine))

    def seat(self, name: str) -> Seat:
        """How a participant does."""
        return self.seats.get(name, Seat())

    def with_seat(self, name: str, seat: Seat) -> "SessionState":
        """The same, but for how one participant does."""
        return replace(self, seats={**self.seats, name: seat})

    def _frames(self, frames: Iterable[Frame]) -> "SessionState":
        state = self
        for frame in frames:
            before = state.arbiter
            if heard := _HEARD.get(frame.topic.name):
                state = heard(state, frame.message)
            if line := event_log.line(frame, self.welcome, before):
                state = replace(state, log=event_log.kept(state.log, line))
        return state

    def _moved(self, trace: MotionTrace) -> "SessionState":
        kept = max(1, round(trace.hz * TRACE_SECONDS))
        seat = self.seat(trace.seat)
        return self.with_seat(trace.seat, replace(seat, rates=(*seat.rates, *trace.rates)[-kept:]))


# --- the task ------------------------------------------------------------------------------------------------------


def _waits(state: SessionState, waiting: Waiting) -> SessionState:
    agent = state.agent
    if waiting.stage == "trial" and waiting.what != "agent":
        agent = replace(agent, words="", more="", kind="", face="listening")
    elif waiting.stage == "answer":
        agent = replace(agent, face="thinking")
    elif agent.face == "thinking":
        agent = replace(agent, face="listening")
    if waiting.stage in ("attempt", "review") and agent.kind == "filler":
        agent = replace(agent, words="", more="", kind="", face="listening")
    level = waiting.level or state.level
    prompt = state.prompt if waiting.stage == "trial" else None
    goes_on = state.is_paused and waiting.stage != "paused"
    pauser = "" if goes_on else state.pauser
    waits = replace(state, waiting=waiting, agent=agent, level=level, prompt=prompt, pauser=pauser)
    return waits if waits.is_quiet else replace(waits, agent=replace(agent, cue=None))


def _steered(state: SessionState, act: Operator) -> SessionState:
    return replace(state, pauser=act.actor) if act.command == "pause" else state


def _prompted(state: SessionState, prompt: Prompt) -> SessionState:
    return replace(state, prompt=prompt, level=prompt.level)


def _voided(state: SessionState, _: PromptVoided) -> SessionState:
    return replace(state, prompt=None)


def _tried(state: SessionState, trial: TrialEnded) -> SessionState:
    seat = state.seat(trial.seat)
    others = tuple(t for t in seat.trials if (t.attempt, t.trial) != (trial.attempt, trial.trial))
    told = replace(seat, trials=(*others, trial)[-TRIALS_KEPT:], mark="")
    return replace(state.with_seat(trial.seat, told), prompt=None)


def _marked(state: SessionState, marked: TrialMarked) -> SessionState:
    seat = state.seat(marked.seat)
    trials = tuple(
        replace(t, correct=marked.correct) if (t.attempt, t.trial) == (marked.attempt, marked.trial) else t
        for t in seat.trials
    )
    return state.with_seat(marked.seat, replace(seat, trials=trials, mark=marked.mark))


def _attempted(state: SessionState, ended: AttemptEnded) -> SessionState:
    return state.with_seat(ended.seat, replace(state.seat(ended.seat), attempt=ended))


def _leveled(state: SessionState, changed: LevelChanged) -> SessionState:
    return replace(state, next_level=changed.level)


def _ended(state: SessionState, ended: SessionEnded) -> SessionState:
    return replace(state, ended=ended.status, prompt=None)


def _sensed(state: SessionState, changed: SensorChanged) -> SessionState:
    return replace(state, sensor=changed)


# --- the agent -----------------------------------------------------------------------------------------------------


def _said(state: SessionState, action: Action) -> SessionState:
    agent = state.agent
    if action.text and action.joins and agent.words:
        agent = replace(agent, more=f"{agent.more}\n{action.text}".lstrip(), kind=action.kind)
    elif action.text:
        agent = replace(agent, words=action.text, more="", kind=action.kind, valence=action.valence)
    return replace(state, agent=replace(agent, face=action.face or agent.face, moves=action))


def _cued(state: SessionState, cue: CueGiven) -> SessionState:
    return replace(state, agent=replace(state.agent, cue=cue))


def _halted(state: SessionState, _: Halt) -> SessionState:
    return replace(state, agent=replace(state.agent, still=state.agent.still + 1))


def _acts(state: SessionState, acting: AgentActing) -> SessionState:
    return replace(state, acting=acting.acting)


def _reported(state: SessionState, report: OutputReport) -> SessionState:
    if report.part == "say" and report.state in ("started", "failed"):
        return replace(state, voice=report.detail or "it failed" if report.state == "failed" else "")
    return state


def _stands(state: SessionState, arbiter: ArbiterState) -> SessionState:
    return replace(state, arbiter=arbiter, operated=arbiter.operated)


def _worn(state: SessionState, worn: ThemeApplied) -> SessionState:
    return replace(state, theme=worn.theme)


# --- who is there --------------------------------------------------------------------------------------------------


def _came_or_went(state: SessionState, changed: OperatorChanged) -> SessionState:
    return replace(state, peers=changed.peers, holder=changed.holder, operated=changed.operated)


_HEARD: dict[str, Callable[[SessionState, Any], SessionState]] = {
    OPERATOR.name: _steered,
    WAITING.name: _waits,
    PROMPT.name: _prompted,
    VOIDED.name: _voided,
    TRIAL.name: _tried,
    MARKED.name: _marked,
    ATTEMPT_ENDED.name: _attempted,
    LEVEL.name: _leveled,
    SESSION_ENDED.name: _ended,
    SENSOR.name: _sensed,
    ACTION.name: _said,
    CUE.name: _cued,
    HALT.name: _halted,
    ACTING.name: _acts,
    REPORT.name: _reported,
    ARBITER_STATE.name: _stands,
    THEME.name: _worn,
    PRESENCE.name: _came_or_went,
}
