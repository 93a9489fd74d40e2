"""What operators do: steer the session, and rule over what the agent says."""

from typing import Literal

from sar_tui.framework.messages.base import ControlledKind, Message, Mode, Role, Valence

__all__ = [
    "ActMissed",
    "ActRefused",
    "Decision",
    "ModeChanged",
    "NoteAdded",
    "Operator",
    "OperatorChanged",
    "ProposalSeen",
    "Remark",
]


class Operator(Message, frozen=True, kw_only=True):
    """An act that steers the session.

    ``command``: ``pause``, ``resume``, ``end``, ``skip`` (this prompt), ``repeat`` (this prompt), ``level``
    (``value``), ``mark`` (the trial under way, else the last), ``stop`` (everything the agent says and does; ``at`` is
    the key's stamp). ``reason``: for a pause, how the person is: ``tired``,
    ``pain``, ``finished``, or empty; for a mark, which (see `task.Mark`).
    """

    command: Literal["pause", "resume", "end", "skip", "repeat", "level", "mark", "stop"]
    actor: str = "participant"
    reason: str = ""
    value: int | None = None
    at: int = 0


class Decision(Message, frozen=True, kw_only=True):
    """An operator decides on a proposal (``action`` is its id): one that waits for it, or one that has its turn yet.

    ``edit`` puts what is given here in the place of what was proposed: ``text``, ``valence`` (whose face, gesture and
    tone then go with it), ``gesture``; None leaves a part as it is, empty takes it away. ``level``: of one that changes
    it. ``at``: the stamp of the operator's key, on the session's clock.
    """

    action: str
    verdict: Literal["accept", "veto", "edit"]
    text: str | None = None
    valence: Valence | None = None
    gesture: str | None = None
    level: int | None = None
    actor: str = "operator"
    at: int = 0


class Remark(Message, frozen=True, kw_only=True):
    """An operator has the agent say or do something of their own.

    ``valence``: its face, gesture and tone go with the words, but a ``gesture`` or ``face`` that is named goes first.
    ``source``: where the words come from.
    """

    text: str = ""
    valence: Valence | None = None
    gesture: str = ""
    face: str = ""
    gaze: str = ""
    source: Literal["phrase", "free text", "gesture"] = "phrase"
    actor: str = "operator"
    at: int = 0


class ModeChanged(Message, frozen=True, kw_only=True):
    """From here on proposals of a kind are decided in another way; those that wait, too."""

    kind: ControlledKind
    mode: Mode
    actor: str = "operator"
    at: int = 0


class ProposalSeen(Message, frozen=True, kw_only=True):
    """A proposal stands on an operator's screen."""

    action: str
    actor: str = "operator"
    at: int = 0


class NoteAdded(Message, frozen=True, kw_only=True):
    """An operator's remark for the record, which nobody else sees. ``label``: of an event mark, a word."""

    text: str = ""
    label: str = ""
    actor: str = "operator"
    at: int = 0


class OperatorChanged(Message, frozen=True, kw_only=True):
    """Somebody came to the link or left it, or is no longer heard.

    ``state``: ``joined``, ``left``, ``lost`` (``detail`` says how that was seen), ``baton`` (they hold it from here
    on). ``operated``: whether there is an operator with the baton now. ``holder``: who that is, by name; empty where
    there is none. ``peers``: who is there, by name.
    """

    actor: str
    role: Role = "operator"
    state: Literal["joined", "left", "lost", "baton"]
    operated: bool
    holder: str = ""
    detail: str = ""
    peers: dict[str, Role] = {}


class ActRefused(Message, frozen=True, kw_only=True):
    """What a peer sent was not done. ``count``: so many of the kind since it was last told."""

    actor: str
    what: str
    why: str
    count: int = 1


class ActMissed(Message, frozen=True, kw_only=True):
    """An operator's act came to nothing, because what it was about was over (derived)."""

    actor: str
    what: str
    why: str
