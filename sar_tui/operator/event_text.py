"""Log line for each message of the session that an operator should know about."""

from typing import Any, Literal, NamedTuple

from sar_tui.link.peer import Frame, Welcome
from sar_tui.loop.topics import (
    ACTION,
    COMMAND,
    DECISION,
    DROPPED,
    GOAL,
    LEVEL,
    LEVEL_DECIDED,
    MARKERS,
    MODE,
    NOTE_ADDED,
    PRESENCE,
    PROPOSAL_SEEN,
    REFUSED,
    REMARK,
    SENSOR,
    SETTING,
    STORAGE,
    TRUNK_SENSOR,
)
from sar_tui.model.messages import (
    Action,
    ArbiterState,
    Dropped,
    GoalChanged,
    LevelChanged,
    LevelDecided,
    MarkersChanged,
    OperatorChanged,
    PeerRequestRefused,
    SessionCommand,
    SettingChanged,
    StorageChanged,
)

MAX_LINES = 40
Tone = Literal["plain", "good", "bad"]


class Line(NamedTuple):
    """Line of the log: time (ns, session clock; 0 if unknown), text, tone, and how often in a row
    it happened.
    """

    at: int
    text: str
    tone: Tone = "plain"
    times: int = 1

    @property
    def text_with_count(self) -> str:
        """The text, with the count if it happened more than once."""
        return f"{self.times} times: {self.text}" if self.times > 1 else self.text


def append(lines: tuple[Line, ...], line: Line) -> tuple[Line, ...]:
    """Return the log with one more line. A repetition is counted instead, so that it pushes nothing
    else out.
    """
    if lines and (lines[-1].text, lines[-1].tone) == (line.text, line.tone):
        return (*lines[:-1], line._replace(times=lines[-1].times + 1))
    return (*lines, line)[-MAX_LINES:]


_Text = tuple[str, Tone]

_DROPPED = {
    "late": "The {kind} came too late: the session had moved on.",
    "stopped": "The waiting {kind} was stopped.",
    "amended": "The {kind} was dropped: the attempt was scored again.",
    "expired": "The {kind} expired: nobody decided in time.",
    "no operator": "The {kind} was dropped: there was no operator.",
}
_SENSOR: dict[str, _Text] = {
    "attached": ("The motion sensor is connected.", "good"),
    "detached": ("The motion sensor is disconnected.", "bad"),
    "stalled": ("The motion sensor sends no data.", "bad"),
    "flowing": ("The motion sensor sends data again.", "good"),
    "ended": ("The recording that replaces the sensor has ended.", "plain"),
}
_TRUNK_SENSOR: dict[str, _Text] = {
    "attached": ("The trunk sensor is connected.", "good"),
    "detached": ("The trunk sensor is disconnected; reaches count all the same.", "bad"),
    "stalled": ("The trunk sensor sends no data; reaches count all the same.", "bad"),
    "flowing": ("The trunk sensor sends data again.", "good"),
    "ended": ("The recording that replaces the trunk sensor has ended.", "plain"),
}
PAUSE_REASONS = {"tired": "tired", "pain": "in pain", "finished": "wants to end"}
"""Reasons for which a participant pauses."""
_ACTS = {
    COMMAND.name: "a command",
    DECISION.name: "a decision",
    REMARK.name: "a phrase or gesture",
    MODE.name: "a change of mode",
    NOTE_ADDED.name: "a note",
    PROPOSAL_SEEN.name: "a report that a proposal was seen",
}
_SETTINGS = {"threshold": "the goal", "feedback_every": "the number of attempts between feedback"}
_LEVEL_REASONS = {
    "success": "goal reached",
    "failure": "goal missed",
    "operator": "an operator",
    "mark": "a mark",
}


def short_name(name: str) -> str:
    """Return a peer's name without its role: ``op1`` for ``operator.op1``."""
    return name.partition(".")[2] or name


def participant_name(me: Welcome) -> str:
    """Return the code of the participant, or "A participant" if there are several."""
    return next(iter(me.participants.values())) if len(me.participants) == 1 else "A participant"


def stopper(actor: str, me: Welcome | None) -> str:
    """Return who stopped the agent, for the log: the participant does so by F2."""
    if actor == "participant":
        return f"{participant_name(me) if me else 'The participant'} pressed F2"
    return (
        "You stopped the agent"
        if me and actor == me.name
        else f"{short_name(actor)} stopped the agent"
    )


def event_line(frame: Frame, me: Welcome | None, before: ArbiterState | None) -> Line | None:
    """Return the log line of a message, or None if it needs none.

    Args:
        frame: the message.
        me: this panel at the session; its operator is called "you".
        before: the arbiter's state until then.
    """
    if isinstance(frame.message, SessionCommand):
        text = _pause_or_resume(frame.message, me)
    else:
        text = _text(frame.topic.name, frame.message, me.name if me else "", before)
    return Line(frame.at, *text) if text else None


def _text(topic: str, message: Any, me: str, before: ArbiterState | None) -> _Text | None:
    text: _Text | None = None
    if topic == REFUSED.name:
        # this operator's acts are answered each by itself
        is_answered = message.actor == me and message.what in _ACTS
        text = None if is_answered else (_refused(message, me), "bad")
    elif topic == PRESENCE.name:
        text = _presence(message, me)
    elif topic == DROPPED.name:
        text = _dropped(message, before)
    elif topic == LEVEL_DECIDED.name:
        text = _level_decided(message, me, before)
    elif topic == ACTION.name:
        text = _unapproved(message)
    elif topic == LEVEL.name:
        text = _level_changed(message)
    elif topic == GOAL.name:
        text = _goal_changed(message)
    elif topic == SENSOR.name:
        text = _SENSOR.get(message.state)
    elif topic == TRUNK_SENSOR.name:
        text = _TRUNK_SENSOR.get(message.state)
    elif topic == STORAGE.name:
        text = _storage(message)
    elif topic == MARKERS.name:
        text = _markers(message)
    elif topic == SETTING.name:
        text = _setting_changed(message), "plain"
    return text


def _setting_changed(change: SettingChanged) -> str:
    name = _SETTINGS.get(change.name, change.name)
    return (
        f"The {short_name(change.actor)} set {name} to {change.value:g} from the next attempt on."
    )


def _markers(change: MarkersChanged) -> _Text | None:
    if change.state == "failing":
        return f"No markers go to {change.destination}: {change.detail}", "bad"
    if change.state == "working":
        return f"Markers go to {change.destination} again.", "good"
    return None


def _pause_or_resume(act: SessionCommand, me: Welcome | None) -> _Text | None:
    """Describe a pause, its end or a skipped attempt, unless this operator did it: the log has that
    already.
    """
    is_skipped = act.command == "skip" and act.reason == "attempt"
    if me is None or act.actor == me.name or not (is_skipped or act.command in ("pause", "resume")):
        return None
    who = participant_name(me) if act.actor == "participant" else short_name(act.actor)
    if is_skipped:
        return f"{who} skipped the attempt.", "bad"
    if act.command == "resume":
        return f"{who} resumed.", "plain"
    why = f": {PAUSE_REASONS[act.reason]}" if act.reason in PAUSE_REASONS else ""
    return f"{who} paused{why}.", "bad" if why or act.actor == "participant" else "plain"


def _refused(refused: PeerRequestRefused, me: str) -> str:
    times = f" ({refused.count} times)" if refused.count > 1 else ""
    whose = "" if refused.actor == me else f" for {short_name(refused.actor)}"
    return f"Refused{whose}: {_ACTS.get(refused.what, refused.what)}{times}. {refused.why}"


def _presence(changed: OperatorChanged, me: str) -> _Text:
    you = changed.actor == me
    who = "You" if you else short_name(changed.actor)
    match changed.state:
        case "baton":  # stored spelling of "took control"
            return f"{who} {'have' if you else 'has'} control.", "good" if you else "plain"
        case "joined":
            return f"{who} joined{' to watch' if changed.role == 'observer' else ''}.", "plain"
        case "left":
            return f"{who} left.", "plain"
        case "unproven":
            whose = "Your" if you else f"{who}'s"
            return f"{whose} presence is not proven: {changed.detail}", "bad"
    why = f": {changed.detail.rstrip('.')}" if changed.detail else ""
    return f"{who} lost the connection{why}.", "bad"


def _dropped(dropped: Dropped, before: ArbiterState | None) -> _Text | None:
    """Describe a dropped proposal, except a veto, one left to the operator, and a filler."""
    waiting = (
        (*(approval.proposal for approval in before.pending), *before.queued) if before else ()
    )
    kind = next((each.kind for each in waiting if each.id == dropped.id), "proposal")
    text = _DROPPED.get(dropped.reason)
    if not text or kind == "filler":
        return None
    return text.format(kind=kind), "bad" if dropped.reason in ("late", "expired") else "plain"


def _unapproved(action: Action) -> _Text | None:
    """Describe an action that was done because nobody decided on it; the others can be seen and
    heard.
    """
    if action.ground == "deadline" and action.mode == "approve":
        return f"Nobody decided in time: the {action.kind} was sent unchanged.", "bad"
    return None


def _level_decided(decided: LevelDecided, me: str, before: ArbiterState | None) -> _Text | None:
    """Describe a decision on the level, unless an operator approved it (logged as an act) or did
    not veto it.
    """
    pending = before.pending if before else ()
    mode = next((approval.mode for approval in pending if approval.proposal.id == decided.id), "")
    if decided.decision == "accepted" and (decided.ground == "operator" or mode == "veto"):
        return None
    tone: Tone = "bad" if decided.ground == "deadline" else "plain"
    if decided.decision == "rejected":
        level = f" {decided.level}" if decided.level else ""
        return f"The level stays{level} ({_ground(decided, me)}).", tone
    return f"The next level is {decided.level} ({_ground(decided, me)}).", tone


def _ground(decided: LevelDecided, me: str) -> str:
    if decided.ground == "operator":
        return "you" if decided.actor == me else short_name(decided.actor)
    return {"deadline": "nobody decided in time", "no operator": "no operator"}.get(
        decided.ground, "nobody decided"
    )


def _level_changed(changed: LevelChanged) -> _Text | None:
    if changed.previous == changed.level:
        return None
    why = "" if changed.reason in ("operator", "mark") else in_brackets(changed.why)
    reason = why or _LEVEL_REASONS.get(changed.reason, changed.reason)
    return f"Level {changed.previous} → {changed.level} ({reason}).", "plain"


def _goal_changed(changed: GoalChanged) -> _Text:
    values = f"{changed.previous:.4g} → {changed.goal:.4g} {changed.unit}".rstrip()
    return f"Goal {values} ({in_brackets(changed.why)}).", "plain"


def in_brackets(sentence: str) -> str:
    """Return a sentence as it reads in brackets: without capital and full stop."""
    return sentence[:1].lower() + sentence[1:].rstrip(".")


def _storage(changed: StorageChanged) -> _Text:
    if changed.working and changed.reason:
        return changed.reason, "bad"
    if changed.working:
        return "The disk works again.", "good"
    return f"Cannot write to the disk: {changed.reason}", "bad"
