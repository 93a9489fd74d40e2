"""Messages about the agent: its proposals, the decisions on them, and its actions."""

from typing import Literal

from sar_tui.model.messages.base import (
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
    """Words and expression that belong together. ``text`` is shown, ``spoken`` is said; either may
    be empty.

    ``face``, ``gesture``, ``gaze`` and ``tone`` come from the theme; empty for none. ``joins``: it
    is added to the text on the screen instead of replacing it; encouragement replaces it once it
    was read. ``priority``: higher first. ``policy``: ``queue`` (waits for its turn), ``interrupt``
    (replaces the current action unless that has a higher priority), ``drop`` (left out if the
    session continues before its turn). ``due``: not before this time (ns). ``evidence``: the
    changes that it reports, each beside its MDC95, for the therapist; empty if it reports none.
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
    evidence: str = ""


class Proposal(Utterance, frozen=True, kw_only=True):
    """An utterance that the agent would like to make."""


class Action(Utterance, frozen=True, kw_only=True):
    """An utterance that was decided on: by ``actor``, in ``mode``, for the reason ``ground``.

    ``decision``: ``accepted`` (as proposed), ``edited``, ``initiated`` (an operator's own).
    ``decided``: time of the decision (ns); 0 if it is that of this message.
    """

    decision: Literal["accepted", "edited", "initiated"]
    actor: str
    mode: Mode = "autonomous"
    ground: Ground = "mode"
    decided: int = 0


class PendingApproval(Message, frozen=True, kw_only=True):
    """A proposal waits for an operator's decision.

    ``deadline`` (ns): ``otherwise`` happens then; None to wait until the next attempt begins.
    ``level``: the new level, if the proposal is a change of level.
    """

    proposal: Proposal
    mode: Mode
    deadline: int | None = None
    otherwise: Literal["act", "drop"] = "drop"
    level: int | None = None


class LevelDecided(Message, frozen=True, kw_only=True):
    """A change of level that waited for an operator is decided: ``level`` is that of the next
    attempt.

    ``decision``: ``accepted``, ``edited`` (to a level that was not proposed), ``rejected`` (the
    level stays).
    """

    id: str
    level: int
    decision: Literal["accepted", "edited", "rejected"]
    actor: str
    ground: Ground
    at: int


class ArbiterState(Message, frozen=True, kw_only=True):
    """Complete state of the arbiter, published after each change, for an operator who joins.

    ``operated``: True if there is an operator, so that the ``modes`` apply. ``pending``: waits for
    a decision. ``queued``: decided, waits for its turn. ``current``: under way.
    """

    modes: dict[ControlledKind, Mode]
    operated: bool
    pending: tuple[PendingApproval, ...] = ()
    queued: tuple[Action, ...] = ()
    current: Action | None = None


class UnsaidFeedbackRequest(Message, frozen=True, kw_only=True):
    """Ask which seats have not been given their feedback on an attempt: it is pending or queued."""

    attempt: int


class UnsaidFeedback(Message, frozen=True, kw_only=True):
    """Reply to UnsaidFeedbackRequest."""

    seats: tuple[str, ...]


class FillerDue(Message, frozen=True, kw_only=True):
    """The feedback ``id`` has been awaited for a while: a filler may cover the wait."""

    id: str


class Dropped(Message, frozen=True, kw_only=True):
    """A proposal was left out.

    ``reason``: ``late`` (the session had continued), ``stopped`` (by the stop key), ``amended``
    (the attempt was scored again before the feedback was given), ``vetoed`` (by ``actor``),
    ``expired`` (nobody decided in time), ``no operator``, ``manual`` (only the operator acts).
    """

    id: str
    reason: Literal["late", "stopped", "amended", "vetoed", "expired", "no operator", "manual"]
    actor: str = "agent"


class Halt(Message, frozen=True, kw_only=True):
    """Outputs must stop. ``action``: the one to stop (empty: all); ``asked``: when this was
    requested (ns).
    """

    action: str = ""
    reason: Literal["stopped", "interrupted", "left", "vetoed"]
    asked: int


class OutputOpened(Message, frozen=True, kw_only=True):
    """An output is available in this run. ``can``: the parts it supports; ``address``: as
    configured.
    """

    output: str
    address: str
    can: tuple[ActionPart, ...]


class AgentActing(Message, frozen=True, kw_only=True):
    """The agent began or stopped speaking or moving; no prompt is shown while ``acting``.

    ``awaits_operator``: True if the session waits for an operator to decide by a deadline.
    """

    acting: bool
    awaits_operator: bool = False
