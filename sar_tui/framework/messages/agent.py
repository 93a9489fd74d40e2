"""What the agent would say and do, what it does, and what became of it."""

from typing import Literal

from sar_tui.framework.messages.base import (
    ActionPart,
    ControlledKind,
    Degree,
    Ground,
    Kind,
    Message,
    Mode,
    Policy,
    Valence,
)

__all__ = [
    "Action",
    "AgentActing",
    "ArbiterState",
    "Dropped",
    "FillerDue",
    "Halt",
    "LevelDecided",
    "OutputOpened",
    "PendingApproval",
    "Proposal",
    "UnsaidFeedback",
    "UnsaidFeedbackRequest",
    "Utterance",
]


class Utterance(Message, frozen=True, kw_only=True):
    """What the agent says and does at once. ``text`` is shown, ``spoken`` said; where one is empty it is left out.

    ``face``, ``gesture``, ``gaze`` and ``tone`` are the theme's; empty where there is none. ``joins``: it adds to what
    stands on the screen instead of taking its place. ``priority``: the higher comes first. ``policy``: ``queue`` (waits
    its turn), ``interrupt`` (what is under way, if that is no more important), ``drop`` (if its turn does not come
    before the session goes on). ``due``: not before this time (ns).
    """

    id: str
    kind: Kind
    text: str
    spoken: str = ""
    face: str = ""
    gesture: str = ""
    gaze: str = ""
    tone: str = ""
    valence: Valence | None = None
    degree: Degree | None = None
    attempt: int = 0
    joins: bool = False
    priority: int = 0
    policy: Policy = "queue"
    due: int = 0


class Proposal(Utterance, frozen=True, kw_only=True):
    """What the agent would say."""


class Action(Utterance, frozen=True, kw_only=True):
    """What is said, who decided it, in what mode, on what ground and when (``decided``, ns; 0: when its turn came).

    ``decision``: ``accepted`` (as proposed), ``edited``, ``initiated`` (an operator's own).
    """

    decision: Literal["accepted", "edited", "initiated"]
    actor: str
    mode: Mode = "autonomous"
    ground: Ground = "mode"
    decided: int = 0


class PendingApproval(Message, frozen=True, kw_only=True):
    """A proposal waits for an operator.

    ``deadline`` (ns): when it is decided without one, as ``otherwise`` says; None where it waits for as long as the
    session stands still. ``level``: what the level would be, of one that would change it.
    """

    proposal: Proposal
    mode: Mode
    deadline: int | None = None
    otherwise: Literal["act", "drop"] = "drop"
    level: int | None = None


class LevelDecided(Message, frozen=True, kw_only=True):
    """A change of level that waited for an operator is decided: ``level`` is that of the next attempt.

    ``decision``: ``accepted``, ``edited`` (to another than was proposed), ``rejected`` (it stays).
    """

    id: str
    level: int
    decision: Literal["accepted", "edited", "rejected"]
    actor: str
    ground: Ground
    at: int


class ArbiterState(Message, frozen=True, kw_only=True, rename={"pending": "offers"}):
    """How the arbiter stands, whole, after each change: what an operator who has just come has to know.

    ``modes``: as they are set; ``operated``: whether there is an operator, so that they hold. ``pending`` wait for one;
    ``queued`` is decided and waits for its turn; ``current`` is under way.
    """

    modes: dict[ControlledKind, Mode]
    operated: bool
    pending: tuple[PendingApproval, ...] = ()
    queued: tuple[Action, ...] = ()
    current: Action | None = None


class UnsaidFeedbackRequest(Message, frozen=True, kw_only=True):
    """Ask whose answer to an attempt is still to be said: it waits for an operator, or for its turn."""

    attempt: int


class UnsaidFeedback(Message, frozen=True, kw_only=True):
    """The answer to Unsaid, by seat."""

    seats: tuple[str, ...]


class FillerDue(Message, frozen=True, kw_only=True):
    """An answer (``id``) has been owed for a while: something may cover the wait."""

    id: str


class Dropped(Message, frozen=True, kw_only=True):
    """A proposal came to nothing: ``late`` (the session had gone on), ``stopped`` (by the stop key), ``amended`` (the
    attempt was scored anew before its answer was given), ``vetoed`` (by ``actor``), ``expired`` (nobody decided in
    time), ``no operator`` (there was none to decide), ``manual`` (only the operator acts).
    """

    id: str
    reason: Literal["late", "stopped", "amended", "vetoed", "expired", "no operator", "manual"]
    actor: str = "agent"


class Halt(Message, frozen=True, kw_only=True):
    """Outputs: be still. ``action``: which (empty: all); ``asked``: since when (ns)."""

    action: str = ""
    reason: Literal["stopped", "interrupted", "left", "vetoed"]
    asked: int


class OutputOpened(Message, frozen=True, kw_only=True):
    """An output is there for this run, and what it can do; ``address`` is how it was asked for."""

    output: str
    address: str
    can: tuple[ActionPart, ...]


class AgentActing(Message, frozen=True, kw_only=True, rename={"awaits_operator": "owing"}):
    """Whether the agent speaks or moves; no prompt is shown meanwhile.

    ``awaits_operator``: an operator has a set time to decide on feedback or on the level, and the session waits.
    """

    acting: bool
    awaits_operator: bool = False
