"""What the agent would say and do, what it does, and what became of it."""

from typing import Literal

from sar_tui.framework.messages.base import Deed, Degree, Kind, Message, Policy, Valence


class Saying(Message, frozen=True, kw_only=True):
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


class Proposal(Saying, frozen=True, kw_only=True):
    """What the agent would say."""


class Action(Saying, frozen=True, kw_only=True):
    """What is said, and who decided it."""

    decision: Literal["accepted", "edited", "rejected"]
    actor: str


class Dropped(Message, frozen=True, kw_only=True):
    """A proposal came to nothing: ``late`` (the session had gone on), ``stopped`` (by the stop key), ``amended`` (the
    attempt was scored anew before its answer was given).
    """

    id: str
    reason: Literal["late", "stopped", "amended"]


class Halt(Message, frozen=True, kw_only=True):
    """Outputs: be still. ``action``: which (empty: all); ``asked``: since when (ns)."""

    action: str = ""
    reason: Literal["stopped", "interrupted", "left"]
    asked: int


class OutputOpened(Message, frozen=True, kw_only=True):
    """An output is there for this run, and what it can do; ``address`` is how it was asked for."""

    output: str
    address: str
    can: tuple[Deed, ...]


class AgentActing(Message, frozen=True, kw_only=True):
    """Whether the agent speaks or moves, so that no prompt is shown meanwhile."""

    acting: bool
