"""State of the agent: words, expression, gesture, gaze and mouth, derived from a session's
messages.

Pure and immutable. Used by the participant's screen, the agent in its own window and the operator's
panel.
"""

import msgspec
from msgspec.structs import replace

from sar_tui.model.messages import (
    Action,
    AgentActing,
    CueGiven,
    Halt,
    Message,
    OutputReport,
    Waiting,
)

AWAITED = ("foreperiod", "storage", "response", "result")
"""Waits of a trial during which nothing on a screen may move, and the agent begins nothing."""


PAUSED_FACES = {
    "": "encouraging",
    "tired": "sleeping",
    "pain": "encouraging",
    "finished": "encouraging",
}
"""Expressions in a person's pauses, by their reasons."""
_CLEARING_PAUSES = ("tired", "pain")
"""Reasons of pauses in which what the agent said before would not fit."""


class AgentState(msgspec.Struct, frozen=True):
    """The agent as a screen shows it.

    ``words``: the text on the screen, until it is replaced or cleared; ``more``: text added below
    it. ``kind``: of the latest text. ``valence``: of ``words``; it sets their colour. ``moves``:
    the last action, with its gesture and gaze. ``cue``: the side to look or point to until the
    response. ``halts``: number of halts so far. ``sounding``: the voices that are audible, as
    (output, action). ``acting``: from the last `AgentActing`; None before the first.
    ``paused_from``: the expression before a pause; empty if there is none.
    """

    words: str = ""
    more: str = ""
    kind: str = ""
    face: str = "neutral"
    valence: str | None = None
    moves: Action | None = None
    cue: CueGiven | None = None
    halts: int = 0
    sounding: frozenset[tuple[str, str]] = frozenset()
    acting: bool | None = None
    paused_from: str = ""

    @property
    def is_speaking(self) -> bool:
        """True while a voice sounds: the mouth moves with it."""
        return bool(self.sounding)

    def silenced(self) -> "AgentState":
        """Return the state without voices, for a lost link: their end would not be reported."""
        return replace(self, sounding=frozenset())


def step(state: AgentState, message: Message) -> AgentState:  # noqa: PLR0911
    """Return the state after a message; unchanged if the message does not concern the agent."""
    match message:
        case Action():
            return _acted(state, message)
        case Waiting():
            return _waited(state, message)
        case OutputReport():
            return _reported(state, message)
        case CueGiven():
            return replace(state, cue=message)
        case Halt():
            return replace(state, halts=state.halts + 1)
        case AgentActing():
            return replace(
                state,
                acting=message.acting,
                sounding=state.sounding if message.acting else frozenset(),
            )
    return state


def _acted(state: AgentState, action: Action) -> AgentState:
    if action.text and action.joins and state.words:
        state = replace(state, more=f"{state.more}\n{action.text}".lstrip(), kind=action.kind)
    elif action.text:
        state = replace(state, words=action.text, more="", kind=action.kind, valence=action.valence)
    return replace(state, face=action.face or state.face, moves=action)


def _waited(state: AgentState, waiting: Waiting) -> AgentState:
    """Clear the words before a trial, and a filler when the wait it covered is over."""
    if not (waiting.stage == "trial" and waiting.what in AWAITED):
        state = replace(state, cue=None)
    if waiting.stage == "paused" and waiting.reason in PAUSED_FACES:
        state = replace(
            state, face=PAUSED_FACES[waiting.reason], paused_from=state.paused_from or state.face
        )
        return replace(state, words="", more="", kind="") if clears_words(state, waiting) else state
    if state.paused_from:
        face = state.face if state.face not in PAUSED_FACES.values() else state.paused_from
        state = replace(state, face=face, paused_from="")
    if clears_words(state, waiting):
        return replace(state, words="", more="", kind="", face="listening")
    if waiting.stage == "answer":
        return replace(state, face="thinking")
    return replace(state, face="listening") if state.face == "thinking" else state


def clears_words(state: AgentState, waiting: Waiting) -> bool:
    """Return True if the words are cleared when the session waits for this."""
    if waiting.stage == "trial":
        return waiting.what != "agent"
    if waiting.stage == "paused":
        return waiting.reason in _CLEARING_PAUSES
    return waiting.stage in ("attempt", "review") and state.kind == "filler"


def _reported(state: AgentState, report: OutputReport) -> AgentState:
    """Add a voice that starts, or remove one that ends; several outputs may have one."""
    if report.part != "say" or report.state == "queued":
        return state
    voice = (report.output, report.action)
    if report.state == "started":
        return replace(state, sounding=state.sounding | {voice})
    return replace(state, sounding=state.sounding - {voice})
