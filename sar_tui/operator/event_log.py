"""The journal: what happened that an operator should know of, a short line each."""

from typing import Any, Literal, NamedTuple

from msgspec.structs import replace

from sar_tui.framework.bus import Topic
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import (
    Action,
    ActMissed,
    ActRefused,
    ArbiterState,
    Dropped,
    LevelChanged,
    LevelDecided,
    Message,
    Operator,
    OperatorChanged,
    SensorChanged,
    StorageChanged,
)
from sar_tui.framework.topics import (
    ACTION,
    DECISION,
    DROPPED,
    LEVEL,
    LEVEL_DECIDED,
    MISSED,
    MODE,
    NOTE_ADDED,
    OPERATOR,
    PRESENCE,
    PROPOSAL_SEEN,
    REFUSED,
    REMARK,
    SENSOR,
    STORAGE,
)
from sar_tui.link.peer import Frame, Welcome
from sar_tui.operator.text_charts import cut

KEPT = 40
_LONGEST = 56
SLOW = 3 * SECOND
"""An act that the session does not confirm for so long may never have arrived."""
Tone = Literal["plain", "good", "bad"]

_DROPPED = {
    "late": "The {what} came too late: the session had gone on.",
    "stopped": "What waited was stopped.",
    "amended": "The {what} fell away: the attempt was scored anew.",
    "expired": "The {what} expired: nobody decided in time.",
    "no operator": "The {what} fell away: there was no operator.",
}
_SENSOR = {
    "attached": ("The motion sensor is there.", "good"),
    "detached": ("The motion sensor is gone.", "bad"),
    "stalled": ("Nothing comes from the motion sensor.", "bad"),
    "flowing": ("The motion sensor sends again.", "good"),
    "ended": ("The recording that stands for the sensor has ended.", "plain"),
}
UNWELL = {"tired": "tired", "pain": "in pain", "finished": "wants to end"}
"""Why a participant pauses."""
_ACTS = {
    OPERATOR.name: "an act",
    DECISION.name: "a decision",
    REMARK.name: "words or a gesture",
    MODE.name: "another mode",
    NOTE_ADDED.name: "a note",
    PROPOSAL_SEEN.name: "a sign of having seen",
}
_WHY_LEVEL = {"success": "goal reached", "failure": "goal missed", "operator": "an operator", "mark": "a mark"}


class Line(NamedTuple):
    """One line: when (ns, on the session's clock), what, whether it is good news, and how often it was told running."""

    at: int
    text: str
    tone: Tone = "plain"
    times: int = 1

    @property
    def words(self) -> str:
        """The text; of what came again and again, how often."""
        return f"{self.times} times: {self.text}" if self.times > 1 else self.text


class Act(NamedTuple):
    """An act: what it is called, what was sent, and how long (ns) after its key the session had it, once it has."""

    words: str
    topic: str
    message: Any
    latency: int | None = None
    refused: bool = False

    @property
    def is_pending(self) -> bool:
        """Whether nothing is known of it yet."""
        return self.latency is None and not self.refused

    def line(self, now: int) -> Line:
        """As it stands in the log."""
        words = cut(self.words, _LONGEST)  # what became of it has to fit on the line, too
        if self.refused:
            return Line(self.message.at, f"{words}: refused", "bad")
        if self.latency is None and now - self.message.at > SLOW:
            return Line(self.message.at, f"{words}: the session has not confirmed it", "bad")
        if self.latency is None:
            return Line(self.message.at, f"{words} …")
        return Line(self.message.at, f"{words} · link {max(0, self.latency) / MS:.0f} ms", "good")


class ActLog:
    """The acts of one operator, oldest first, and what became of them here."""

    def __init__(self) -> None:
        self.acts: list[Act] = []
        self._reports: list[Line] = []

    def lines(self, now: int) -> list[Line]:
        """All of it, as it stands now."""
        return [*(act.line(now) for act in self.acts), *self._reports]

    def report(self, at: int, words: str) -> None:
        """Something was not done, and the operator has to know why."""
        self._reports = [*self._reports, Line(at, words, "bad")][-KEPT:]

    def add(self, words: str, topic: Topic[Any], message: Message) -> None:
        """An act was sent."""
        self.acts = [*self.acts, Act(words, topic.name, message)][-KEPT:]

    def receive(self, frame: Frame, me: str) -> None:
        """A message of the session's: perhaps it is one of these, arrived, or tells that one was refused.

        The session puts in who it was and may set the time right, so these two do not tell which act it is.
        """
        if getattr(frame.message, "actor", None) != me:
            return
        refused = frame.message.what if isinstance(frame.message, ActRefused) else ""
        for index, act in enumerate(self.acts):
            if act.is_pending and act.topic == refused:
                self.acts[index] = act._replace(refused=True)
                return
            if (
                act.is_pending
                and act.topic == frame.topic.name
                and _without_sender(act.message) == _without_sender(frame.message)
            ):
                self.acts[index] = act._replace(latency=frame.at - act.message.at)
                return


def _without_sender(message: Any) -> Any:
    return replace(message, actor="", at=0)


def kept(lines: tuple[Line, ...], line: Line) -> tuple[Line, ...]:
    """The journal after one more line: what comes again and again keeps one line, and pushes nothing else out."""
    if lines and (lines[-1].text, lines[-1].tone) == (line.text, line.tone):
        return (*lines[:-1], line._replace(times=lines[-1].times + 1))
    return (*lines, line)[-KEPT:]


def short(name: str) -> str:
    """A peer's name without its role: ``anna`` of ``operator.anna``."""
    return name.partition(".")[2] or name


def line(frame: Frame, me: Welcome | None, before: ArbiterState | None) -> Line | None:
    """What a message is worth in the journal, if anything.

    Args:
        frame: the message.
        me: the reader is told "you".
        before: what waited until then.
    """
    if isinstance(frame.message, Operator):
        told = _steered(frame.message, me)
    else:
        told = _words(frame.topic.name, frame.message, me.name if me else "", before)
    return Line(frame.at, *told) if told else None


def _words(topic: str, message: Any, me: str, before: ArbiterState | None) -> tuple[str, Tone] | None:
    told: tuple[str, Tone] | None = None
    if topic == REFUSED.name:
        told = _refused(message, me), "bad"
    elif topic == MISSED.name:
        told = _missed(message, me), "bad"
    elif topic == PRESENCE.name:
        told = _presence(message, me)
    elif topic == DROPPED.name:
        told = _dropped(message, before)
    elif topic == LEVEL_DECIDED.name:
        told = _level_ruled(message, me, before)
    elif topic == ACTION.name:
        told = _let_go(message)
    elif topic == LEVEL.name:
        told = _level(message)
    elif topic == SENSOR.name:
        told = _sensor(message)
    elif topic == STORAGE.name:
        told = _storage(message)
    return told


def _steered(act: Operator, me: Welcome | None) -> tuple[str, Tone] | None:
    """A pause, and its end, if it is not the reader's own act: that stands in the log already."""
    if me is None or act.actor == me.name or act.command not in ("pause", "resume"):
        return None
    who = participant(me) if act.actor == "participant" else short(act.actor)
    if act.command == "resume":
        return f"{who} let it go on.", "plain"
    why = f": {UNWELL[act.reason]}" if act.reason in UNWELL else ""
    return f"{who} paused{why}.", "bad" if why or act.actor == "participant" else "plain"


def participant(me: Welcome) -> str:
    """Who pressed a key at the participant's: by code, where there is one alone."""
    return next(iter(me.participants.values())) if len(me.participants) == 1 else "A participant"


def _who(actor: str, me: str) -> str:
    return "you" if actor == me else short(actor)


def _refused(refused: ActRefused, me: str) -> str:
    times = f" ({refused.count} times)" if refused.count > 1 else ""
    whose = "" if refused.actor == me else f" of {short(refused.actor)}"
    return f"Refused{whose}: {_ACTS.get(refused.what, refused.what)}{times}. {refused.why}"


def _missed(missed: ActMissed, me: str) -> str:
    whose = "" if missed.actor == me else f" of {short(missed.actor)}"
    return f"Too late{whose}: {missed.what}. {missed.why}"


def _presence(changed: OperatorChanged, me: str) -> tuple[str, Tone]:
    who = _who(changed.actor, me).capitalize() if changed.actor == me else short(changed.actor)
    you = changed.actor == me
    match changed.state:
        case "baton":
            return (f"{who} {'hold' if you else 'holds'} the baton.", "good" if you else "plain")
        case "joined":
            return f"{who} came{' to watch' if changed.role == 'observer' else ''}.", "plain"
        case "left":
            return f"{who} left.", "plain"
    why = f": {changed.detail.rstrip('.')}" if changed.detail else ""
    return f"{who} {'were' if you else 'is'} no longer heard{why}.", "bad"


def _dropped(dropped: Dropped, before: ArbiterState | None) -> tuple[str, Tone] | None:
    """A veto, and what only the operator does, are nobody's news; nor is a filler that was not needed."""
    waited = (*(approval.proposal for approval in before.pending), *before.queued) if before else ()
    kind = next((each.kind for each in waited if each.id == dropped.id), "proposal")
    words = _DROPPED.get(dropped.reason)
    if not words or kind == "filler":
        return None
    return words.format(what=kind), "bad" if dropped.reason in ("late", "expired") else "plain"


def _let_go(action: Action) -> tuple[str, Tone] | None:
    """What was to be approved, and nobody did, is an operator's news; all else that is said is seen and heard."""
    if action.ground == "deadline" and action.mode == "approve":
        return f"Nobody decided in time: the {action.kind} went out as it was.", "bad"
    return None


def _level_ruled(ruled: LevelDecided, me: str, before: ArbiterState | None) -> tuple[str, Tone] | None:
    """What becomes of a change of level, unless that goes without saying.

    What an operator approved stands in the log already, as their act; what they did not stop needs none of them.
    """
    offers = before.pending if before else ()
    mode = next((approval.mode for approval in offers if approval.proposal.id == ruled.id), "")
    if ruled.decision == "accepted" and (ruled.ground == "operator" or mode == "veto"):
        return None
    tone: Tone = "bad" if ruled.ground == "deadline" else "plain"
    if ruled.decision == "rejected":
        level = f" {ruled.level}" if ruled.level else ""
        return f"The level stays{level} ({_ground(ruled, me)}).", tone
    return f"The next level is {ruled.level} ({_ground(ruled, me)}).", tone


def _ground(ruled: LevelDecided, me: str) -> str:
    if ruled.ground == "operator":
        return _who(ruled.actor, me)
    return {"deadline": "nobody decided in time", "no operator": "no operator"}.get(ruled.ground, "nobody decided")


def _level(changed: LevelChanged) -> tuple[str, Tone] | None:
    if changed.previous == changed.level:
        return None
    return f"Level {changed.previous} → {changed.level} ({_WHY_LEVEL.get(changed.reason, changed.reason)}).", "plain"


def _sensor(changed: SensorChanged) -> tuple[str, Tone] | None:
    words, tone = _SENSOR.get(changed.state, ("", "plain"))
    return (words, tone) if words else None  # type: ignore[return-value]


def _storage(changed: StorageChanged) -> tuple[str, Tone]:
    if changed.working:
        return "The disk works again.", "good"
    return f"The disk refuses to write: {changed.reason}", "bad"
