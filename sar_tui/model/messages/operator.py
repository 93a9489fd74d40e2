"""Acts of operators: commands to the session, and decisions on the agent's proposals."""

from typing import Literal

from sar_tui.model.messages.base import ControlledKind, Json, Message, Mode, Role, Valence
from sar_tui.model.protocol import WizardProtocol

__all__ = [
    "ActAnswered",
    "ActOutcome",
    "Decision",
    "Erased",
    "LateDecision",
    "ModeChanged",
    "NoteAdded",
    "OperatorAct",
    "OperatorChanged",
    "PeerRequestRefused",
    "ProposalSeen",
    "ProtocolChosen",
    "ProtocolDue",
    "ProtocolTicked",
    "ReasonGiven",
    "RecordChange",
    "RecordChanged",
    "Remark",
    "SessionCommand",
    "SettingChanged",
    "VisitDecided",
    "VisitRequested",
]


class OperatorAct(Message, frozen=True, kw_only=True):
    """Base of the acts of operators.

    ``actor``: who acts. ``at``: time stamp of the key, on the session's clock. ``id``: random text
    that the answer names, see `ActAnswered`; empty if nobody waits for an answer.
    """

    actor: str = "operator"
    at: int = 0
    id: str = ""


class SessionCommand(OperatorAct, frozen=True, kw_only=True):
    """A command that controls the session.

    ``command``: ``pause``, ``resume``, ``end``, ``skip`` (this prompt, or what ``reason`` says),
    ``repeat`` (this prompt), ``level`` (sets it to ``value``), ``hold`` (attempts leave the level
    as it is), ``release`` (they change it again), ``mark`` (the current trial, else the last),
    ``undo`` (the actor's last act, see `loop.undo`), ``stop`` (everything the agent says and does;
    ``at`` is the time stamp of the key), ``dismiss`` (the participant declines or ends a
    visit, see `VisitDecided`). ``reason``:
    for a pause, how the participant is: ``tired``, ``pain``, ``finished``, or empty; for a mark,
    its name (see `trial_types.Mark`); for ``skip``, ``rest`` if a rest that must be taken is to be
    ended, ``attempt`` if the attempt that is under way or comes next is to be left out, ``step`` if
    the step between attempts whose number is ``value`` is to be, and no other.
    """

    command: Literal[
        "pause",
        "resume",
        "end",
        "skip",
        "repeat",
        "level",
        "hold",
        "release",
        "mark",
        "undo",
        "stop",
        "dismiss",
    ]
    actor: str = "participant"
    reason: str = ""
    value: int | None = None


class SettingChanged(OperatorAct, frozen=True, kw_only=True):
    """A therapist changes a setting, by its name, from the next attempt on (see
    `loop.attempts`).
    """

    name: str
    value: int | float
    actor: str = "therapist"


class Decision(OperatorAct, frozen=True, kw_only=True):
    """An operator decides on a proposal, by its id (``action``), while it is pending or queued.

    ``edit`` replaces parts of the proposal: ``text``, ``valence`` (with its face, gesture and
    tone), ``gesture``; None keeps a part, an empty text removes it. ``level``: the level to set, if
    the proposal changes the level.
    """

    action: str
    verdict: Literal["accept", "veto", "edit"]
    text: str | None = None
    valence: Valence | None = None
    gesture: str | None = None
    level: int | None = None


class Remark(OperatorAct, frozen=True, kw_only=True):
    """An operator makes the agent say or do something.

    ``valence``: gives face, gesture and tone, except a ``gesture`` or ``face`` given here.
    ``source``: where the text comes from.
    """

    text: str = ""
    valence: Valence | None = None
    gesture: str = ""
    face: str = ""
    gaze: str = ""
    source: Literal["phrase", "free text", "gesture"] = "phrase"


class ModeChanged(OperatorAct, frozen=True, kw_only=True):
    """The mode of a kind of action changes, also for proposals that are pending."""

    kind: ControlledKind
    mode: Mode


class ProposalSeen(Message, frozen=True, kw_only=True):
    """A proposal was shown on an operator's screen."""

    action: str
    actor: str = "operator"
    at: int = 0


class NoteAdded(OperatorAct, frozen=True, kw_only=True):
    """An operator's note, for the record only. ``label``: one word, if it marks an event."""

    text: str = ""
    label: str = ""


class ProtocolChosen(OperatorAct, frozen=True, kw_only=True):
    """An operator works by a protocol from here on, in place of an earlier one.

    ``practised``: recorded sessions on which the operator has practised this protocol, as far as
    the operator's data folder knows.
    """

    protocol: WizardProtocol
    practised: int = 0


class ProtocolDue(Message, frozen=True, kw_only=True):
    """A step or a rule of the operator's protocol is due ``at`` (ns) (derived). If the session is
    resumed, what is still due is told again, with the time of the new run.

    ``id``: that a tick names. ``number``: of the step or the rule in the protocol, from 1.
    ``attempt``: begun last.
    """

    id: str
    what: Literal["step", "rule"]
    number: int
    attempt: int
    do: str
    at: int = 0


class ProtocolTicked(OperatorAct, frozen=True, kw_only=True):
    """An operator has done what was due, by its id, or will not do it.

    ``act``: id of the act that the same key did, if it did one.
    """

    due: str
    outcome: Literal["done", "not done"]
    act: str = ""


class ReasonGiven(OperatorAct, frozen=True, kw_only=True):
    """An operator's reason for a veto or an edit, of the proposal with this id (``action``).

    ``digit``, ``text``: the reason, as the protocol lists it.
    """

    action: str
    verdict: Literal["veto", "edit"]
    digit: int
    text: str


ActOutcome = Literal["done", "refused", "late"]


class ActAnswered(Message, frozen=True, kw_only=True):
    """Answer to an operator's act that carries an ``id`` (derived). There is one for each act.

    ``outcome``: ``done``; ``refused`` (it was not carried out, or failed); ``late`` (what it was
    meant for was over). ``why``: a sentence, or ``removed`` if a mark was taken off. ``at``: when
    the act arrived.
    """

    id: str
    actor: str
    outcome: ActOutcome
    why: str = ""
    at: int


class OperatorChanged(Message, frozen=True, kw_only=True):
    """A peer joined the link, left it, or was lost.

    ``state``: ``joined``, ``left``, ``lost`` (``detail`` says why), ``baton`` (the peer took
    control), ``unproven`` (the peer is connected, but nothing proves that a person's terminal is;
    ``detail`` says why). ``operated``: True if an operator is in control now. ``holder``: that
    operator's name, or empty. ``peers``: the peers present, by name.
    """

    actor: str
    role: Role = "operator"
    state: Literal["joined", "left", "lost", "baton", "unproven"]
    operated: bool
    holder: str = ""
    detail: str = ""
    peers: dict[str, Role] = {}


class VisitRequested(Message, frozen=True, kw_only=True):
    """Somebody at the clinic asks to watch a session at home, or no longer does (``withdrawn``).

    ``actor``: who asks. The participant is asked as soon as no response is awaited, see
    `VisitDecided`; whoever may watch joins by `OperatorChanged`.
    """

    actor: str
    state: Literal["asked", "withdrawn"]


class VisitDecided(Message, frozen=True, kw_only=True):
    """The participant decided about visits to this session (derived).

    ``agreed``: those who asked (``peers``) may watch. ``declined``: nobody may, in this run of the
    session. ``ended``: those who watch may not any longer, and nobody else may.
    """

    outcome: Literal["agreed", "declined", "ended"]
    peers: tuple[str, ...] = ()


class PeerRequestRefused(Message, frozen=True, kw_only=True):
    """A request of a peer was refused: a connection or an act. ``count``: such refusals since the
    last message.
    """

    actor: str
    what: str
    why: str
    count: int = 1


class LateDecision(Message, frozen=True, kw_only=True):
    """An operator's decision had no effect, because it came too late (derived)."""

    actor: str
    what: str
    why: str


RecordChange = Literal["dismissed", "discarded", "restored", "moved", "redacted", "erased"]
"""``dismissed``: nobody goes on with the interrupted session. ``discarded``: it was begun by
mistake, and does not count. ``restored``: neither any longer. ``moved``: it is of another
participant. ``redacted``: texts were erased. ``erased``: the part of the participant at ``seat`` was.
"""


class RecordChanged(Message, frozen=True, kw_only=True):
    """Something was done to a session's record after the session.

    ``actor``: who did it, the login name. ``at``: when, UTC. ``details``: for ``moved``, the
    participant ``before`` and ``after``; for ``redacted`` and ``erased``, by the number of each message,
    and by the name of each row beside them, its hash as it was and that of what remains of it.
    """

    change: RecordChange
    actor: str = ""
    at: str
    reason: str = ""
    details: Json = {}


class Erased(Message, frozen=True, kw_only=True):
    """A message that was erased, of which `RecordChanged` keeps the hash."""
