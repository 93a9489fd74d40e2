"""Log line for each message of the session that an operator should know about."""

import functools
import re
import string
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
    PROTOCOL,
    PROTOCOL_TICKED,
    REASON,
    REFUSED,
    REMARK,
    SENSOR,
    SETTING,
    STORAGE,
    TRIAL,
    TRUNK_SENSOR,
)
from sar_tui.model.language import ENGLISH, Language
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
    TrialEnded,
)

MAX_LINES = 40
Tone = Literal["plain", "good", "bad"]


class Line(NamedTuple):
    """Line of the log: time (ns, session clock; 0 if unknown), text, tone, how often in a row it
    happened, and the language of the panel.
    """

    at: int
    text: str
    tone: Tone = "plain"
    times: int = 1
    tr: Language = ENGLISH

    @property
    def text_with_count(self) -> str:
        """The text, with the count if it happened more than once."""
        if self.times == 1:
            return self.text
        return self.tr("{count} times: {text}").format(count=self.times, text=self.text)


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
_SENSOR = {
    "attached": "The motion sensor is connected.",
    "detached": "The motion sensor is disconnected.",
    "stalled": "The motion sensor sends no data.",
    "flowing": "The motion sensor sends data again.",
    "ended": "The recording that replaces the sensor has ended.",
}
_TRUNK_SENSOR = {
    "attached": "The trunk sensor is connected.",
    "detached": "The trunk sensor is disconnected; reaches count all the same.",
    "stalled": "The trunk sensor sends no data; reaches count all the same.",
    "flowing": "The trunk sensor sends data again.",
    "ended": "The recording that replaces the trunk sensor has ended.",
}
_SENSORS = {SENSOR.name: _SENSOR, TRUNK_SENSOR.name: _TRUNK_SENSOR}
_SENSOR_TONES: dict[str, Tone] = {"attached": "good", "flowing": "good", "ended": "plain"}
"""Tones of a sensor's states; of all others: bad."""
PAUSE_REASONS = {"tired": "tired", "pain": "in pain", "finished": "wants to end"}
"""Reasons for which a participant pauses."""
_ACTS = {
    COMMAND.name: "a command",
    DECISION.name: "a decision",
    REMARK.name: "a phrase or gesture",
    MODE.name: "a change of mode",
    NOTE_ADDED.name: "a note",
    PROPOSAL_SEEN.name: "a report that a proposal was seen",
    PROTOCOL.name: "a protocol",
    PROTOCOL_TICKED.name: "a tick",
    REASON.name: "a reason",
}
_REQUESTS = {
    **_ACTS,
    "an act": "an act",
    "a connection": "a connection",
    "a heartbeat": "a heartbeat",
    "a message": "a message",
    "the link": "the link",
}
"""Requests of peers that are refused, with those that are answered each by itself."""
_PRESENCE = {
    "baton": ("You have control.", "{who} has control."),  # stored spelling of "took control"
    "joined": ("You joined.", "{who} joined."),
    "watching": ("You joined to watch.", "{who} joined to watch."),
    "left": ("You left.", "{who} left."),
    "unproven": (
        "Your presence is not proven: {why}",
        "{who}'s presence is not proven: {why}",
    ),
    "lost": ("You lost the connection.", "{who} lost the connection."),
    "lost because": ("You lost the connection: {why}.", "{who} lost the connection: {why}."),
}
"""Texts of a change for the one who changed, and for all others."""
_SETTINGS = {
    "threshold": "The therapist set the goal to {value} from the next attempt on.",
    "feedback_every": (
        "The therapist set the number of attempts between feedback to {value} from the next "
        "attempt on."
    ),
}
_LEVEL_REASONS = {
    "success": "goal reached",
    "failure": "goal missed",
    "operator": "an operator",
    "mark": "a mark",
}
_WITH_VALUES = (
    "Goal reached.",
    "Goal missed.",
    "Goal reached {count} times in a row.",
    "Goal missed {count} times in a row.",
    "Goal reached; the target is {target} % of attempts.",
    "Goal missed; the target is {target} % of attempts.",
    "{reached} of {count} prompts reached the goal; the target is {target} %.",
    "Number {place} of {count} in the list.",
    "The goal is the last result at this level.",
    "The goal is number {rank} of the last {count} results at this level.",
    "An output failed: {names}.",
    "No heartbeat for {ms} ms.",
    "Its terminal did not answer for {ms} ms.",
    "It sends more than {count} messages a second.",
    "It is longer than {count} bytes.",
    "A text is longer than {count} characters.",
)
"""Sentences that a session writes with values in them."""
_GROUNDS = {"deadline": "nobody decided in time", "no operator": "no operator"}


def short_name(name: str) -> str:
    """Return a peer's name without its role: ``op1`` for ``operator.op1``."""
    return name.partition(".")[2] or name


def actor_name(actor: str, me: Welcome | None, tr: Language) -> str:
    """Return the name of somebody who acts: an operator's own, "therapist", or the code of the
    participant if there is one.
    """
    if actor == "therapist":
        return tr("therapist")
    if actor != "participant":
        return short_name(actor)
    if me is None:
        return tr("The participant")
    if len(me.participants) == 1:
        return next(iter(me.participants.values()))
    return tr("A participant")


def stopper(actor: str, me: Welcome | None, tr: Language) -> str:
    """Return who stopped the agent, for the log: the participant does so by F2."""
    if actor == "participant":
        return tr("{who} pressed F2").format(who=actor_name(actor, me, tr))
    if me and actor == me.name:
        return tr("You stopped the agent")
    return tr("{who} stopped the agent").format(who=actor_name(actor, me, tr))


def session_text(sentence: str, tr: Language) -> str:
    """Return a sentence that the session wrote in English, in the language of the panel if it is
    known there.
    """
    for known in _WITH_VALUES:
        if values := _pattern(known).fullmatch(sentence):
            return tr(known, **values.groupdict())
    return tr(sentence)


@functools.cache
def _pattern(text: str) -> re.Pattern[str]:
    """Return a pattern that matches a text with anything in its slots."""
    parts = string.Formatter().parse(text)
    return re.compile(
        "".join(
            f"{re.escape(words)}(?P<{slot}>.+)" if slot else re.escape(words)
            for words, slot, _, _ in parts
        )
    )


def in_line(sentence: str, tr: Language) -> str:
    """Return a sentence of the session or a title as part of a line: without full stop, and in
    English without capital.
    """
    own = session_text(sentence, tr).rstrip(".")
    return own[:1].lower() + own[1:] if tr.code.partition("-")[0] == "en" else own


def capitalized(text: str) -> str:
    """Return a text with its first letter as a capital, and the others as they are."""
    return text[:1].upper() + text[1:]


def event_line(
    frame: Frame, me: Welcome | None, before: ArbiterState | None, tr: Language = ENGLISH
) -> Line | None:
    """Return the log line of a message, or None if it needs none.

    Args:
        frame: the message.
        me: this panel at the session; its operator is called "you".
        before: the arbiter's state until then.
        tr: language of the panel.
    """
    if isinstance(frame.message, SessionCommand):
        text = _pause_or_resume(frame.message, me, tr)
    else:
        text = _text(frame.topic.name, frame.message, me.name if me else "", before, tr)
    return Line(frame.at, *text, tr=tr) if text else None


def _text(
    topic: str, message: Any, me: str, before: ArbiterState | None, tr: Language
) -> _Text | None:
    text: _Text | None = None
    if topic == REFUSED.name:
        # this operator's acts are answered each by itself
        is_answered = message.actor == me and message.what in _ACTS
        text = None if is_answered else (_refused(message, me, tr), "bad")
    elif topic == PRESENCE.name:
        text = _presence(message, me, tr)
    elif topic == DROPPED.name:
        text = _dropped(message, before, tr)
    elif topic == LEVEL_DECIDED.name:
        text = _level_decided(message, me, before, tr)
    elif topic == ACTION.name:
        text = _unapproved(message, tr)
    elif topic == LEVEL.name:
        text = _level_changed(message, tr)
    elif topic == GOAL.name:
        text = _goal_changed(message, tr)
    elif topic in _SENSORS and message.state in _SENSORS[topic]:
        text = tr(_SENSORS[topic][message.state]), _SENSOR_TONES.get(message.state, "bad")
    elif topic == STORAGE.name:
        text = _storage(message, tr)
    elif topic == MARKERS.name:
        text = _markers(message, tr)
    elif topic == TRIAL.name and message.is_unsure:
        text = _unsure(message, tr), "bad"
    elif topic == SETTING.name:
        text = _setting_changed(message, tr), "plain"
    return text


def _unsure(trial: TrialEnded, tr: Language) -> str:
    confidence = trial.details.get("confidence")
    if not isinstance(confidence, int | float):
        return tr(
            "Attempt {attempt}, trial {number} is unsure: it is not scored without a mark.",
            attempt=trial.attempt,
            number=trial.trial,
        )
    return tr(
        "Attempt {attempt}, trial {number} is unsure ({share} %): it is not scored without a mark.",
        attempt=trial.attempt,
        number=trial.trial,
        share=f"{100 * confidence:.0f}",
    )


# Names, addresses and texts of others are put in by `format`: `tr` would change their numbers.


def _setting_changed(change: SettingChanged, tr: Language) -> str:
    value = f"{change.value:g}"
    if change.name in _SETTINGS:
        return tr(_SETTINGS[change.name], value=value)
    return tr(
        "The therapist set {name} to {value} from the next attempt on.",
        name=change.name,
        value=value,
    )


def _markers(change: MarkersChanged, tr: Language) -> _Text | None:
    where = change.destination
    if change.state == "failing":
        text = tr("No markers go to {where}: {why}")
        return text.format(where=where, why=session_text(change.detail, tr)), "bad"
    if change.state == "working":
        return tr("Markers go to {where} again.").format(where=where), "good"
    return None


def _pause_or_resume(act: SessionCommand, me: Welcome | None, tr: Language) -> _Text | None:
    """Describe a pause, its end or a skipped attempt, unless this operator did it: the log has that
    already.
    """
    is_skipped = act.command == "skip" and act.reason == "attempt"
    if me is None or act.actor == me.name or not (is_skipped or act.command in ("pause", "resume")):
        return None
    is_theirs = act.actor == "participant"
    who = actor_name(act.actor, me, tr)
    if is_skipped:
        return tr("{who} skipped the attempt.").format(who=who), "bad"
    if act.command == "resume":
        return tr("{who} resumed.").format(who=who), "plain"
    if act.reason in PAUSE_REASONS:
        why = tr(PAUSE_REASONS[act.reason])
        return tr("{who} paused: {why}.").format(who=who, why=why), "bad"
    return tr("{who} paused.").format(who=who), "bad" if is_theirs else "plain"


def _refused(refused: PeerRequestRefused, me: str, tr: Language) -> str:
    what, why = tr(_REQUESTS.get(refused.what, refused.what)), session_text(refused.why, tr)
    if refused.count > 1:
        what = tr("{what} ({count} times)").format(what=what, count=refused.count)
    if refused.actor == me:
        return tr("Refused: {what}. {why}").format(what=what, why=why)
    who = short_name(refused.actor)
    return tr("Refused for {who}: {what}. {why}").format(who=who, what=what, why=why)


def _presence(changed: OperatorChanged, me: str, tr: Language) -> _Text:
    state, is_me = changed.state, changed.actor == me
    watches = state == "joined" and changed.role == "observer"
    is_explained = state == "lost" and changed.detail
    mine, theirs = _PRESENCE["watching" if watches else "lost because" if is_explained else state]
    why = (
        session_text(changed.detail, tr).rstrip(".")
        if is_explained
        else session_text(changed.detail, tr)
    )
    text = tr(mine if is_me else theirs).format(who=short_name(changed.actor), why=why)
    if state in ("unproven", "lost"):
        return text, "bad"
    return text, "good" if state == "baton" and is_me else "plain"


def _dropped(dropped: Dropped, before: ArbiterState | None, tr: Language) -> _Text | None:
    """Describe a dropped proposal, except a veto, one left to the operator, and a filler."""
    waiting = (
        (*(approval.proposal for approval in before.pending), *before.queued) if before else ()
    )
    kind = next((each.kind for each in waiting if each.id == dropped.id), "proposal")
    if dropped.reason not in _DROPPED or kind == "filler":
        return None
    text = tr(_DROPPED[dropped.reason], kind=tr(kind))
    return text, "bad" if dropped.reason in ("late", "expired") else "plain"


def _unapproved(action: Action, tr: Language) -> _Text | None:
    """Describe an action that was done because nobody decided on it; the others can be seen and
    heard.
    """
    if action.ground == "deadline" and action.mode == "approve":
        text = tr("Nobody decided in time: the {kind} was sent unchanged.", kind=tr(action.kind))
        return text, "bad"
    return None


def _level_decided(
    decided: LevelDecided, me: str, before: ArbiterState | None, tr: Language
) -> _Text | None:
    """Describe a decision on the level, unless an operator approved it (logged as an act) or did
    not veto it.
    """
    pending = before.pending if before else ()
    mode = next((approval.mode for approval in pending if approval.proposal.id == decided.id), "")
    if decided.decision == "accepted" and (decided.ground == "operator" or mode == "veto"):
        return None
    tone: Tone = "bad" if decided.ground == "deadline" else "plain"
    level, why = decided.level, _ground(decided, me, tr)
    if decided.decision != "rejected":
        return tr("The next level is {level} ({why}).", level=level, why=why), tone
    if level:
        return tr("The level stays {level} ({why}).", level=level, why=why), tone
    return tr("The level stays ({why}).", why=why), tone


def _ground(decided: LevelDecided, me: str, tr: Language) -> str:
    if decided.ground == "operator":
        return tr("you") if decided.actor == me else short_name(decided.actor)
    return tr(_GROUNDS.get(decided.ground, "nobody decided"))


def _level_changed(changed: LevelChanged, tr: Language) -> _Text | None:
    if changed.previous == changed.level:
        return None
    why = "" if changed.reason in ("operator", "mark") else in_line(changed.why, tr)
    text = tr(
        "Level {previous} → {level} ({why}).",
        previous=changed.previous,
        level=changed.level,
        why=why or tr(_LEVEL_REASONS.get(changed.reason, changed.reason)),
    )
    return text, "plain"


def _goal_changed(changed: GoalChanged, tr: Language) -> _Text:
    values = f"{changed.previous:.4g} → {changed.goal:.4g} {changed.unit}".rstrip()
    return tr("Goal {values} ({why}).", values=values, why=in_line(changed.why, tr)), "plain"


def _storage(changed: StorageChanged, tr: Language) -> _Text:
    if changed.working and changed.reason:
        return session_text(changed.reason, tr), "bad"
    if changed.working:
        return tr("The disk works again."), "good"
    return tr("Cannot write to the disk: {why}").format(why=session_text(changed.reason, tr)), "bad"
