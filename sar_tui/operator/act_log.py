"""Log of acts: this operator's and those of others, each with the session's answer. Pure."""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from msgspec.structs import replace

from sar_tui.link.peer import Frame, Welcome
from sar_tui.loop.answers import answer_to
from sar_tui.loop.bus import Topic
from sar_tui.loop.topics import COMMAND, DECISION, MODE, NOTE_ADDED, REMARK
from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.messages import (
    ActAnswered,
    Action,
    Decision,
    Message,
    ModeChanged,
    NoteAdded,
    PendingApproval,
    Proposal,
    Remark,
    SessionCommand,
)
from sar_tui.model.units import MS
from sar_tui.operator.event_text import (
    MAX_LINES,
    Line,
    actor_name,
    capitalized,
    in_line,
)
from sar_tui.operator.text_charts import cut

_ACTS = (COMMAND, DECISION, REMARK, MODE, NOTE_ADDED)
_LONGEST = 36
"""Longest text of an act, in columns, so that there is room for its outcome."""
_MAX_KINDS = 500
Wait = Literal["", "response", "pause"]
"""Events that a remark waits for: the end of a response or of a pause."""
_COMMANDS = {
    "stop": ("Stopped", "Stopping"),
    "pause": ("Paused", "Pausing"),
    "resume": ("Resumed", "Resuming"),
    "skip": ("Skipped the prompt", "Skipping the prompt"),
    "skip rest": ("Ended the rest", "Ending the rest"),
    "skip step": ("Skipped the question", "Skipping the question"),
    "repeat": ("Repeated the prompt", "Repeating the prompt"),
    "end": ("Ended the session", "Ending the session"),
    "undo": ("Took back the last act", "Taking back the last act"),
}
"""Texts of commands, by name, of a skip also by what is skipped: done, and under way."""
_TOLD_AS_EVENTS = {"stop", "pause", "resume"}
"""Commands of others that have lines of their own (see `event_text`, `session_state.Stop`)."""
_FACES = {
    "positive": "Positive face, same words: {kind}",
    "neutral": "Neutral face, same words: {kind}",
    "negative": "Negative face, same words: {kind}",
}
_UNDER_WAY = {
    "": "{act} …",
    "response": "{act} after the response …",
    "pause": "{act} after the pause …",
}
"""Texts of acts that are not done yet, by what they wait for."""


class Wording(NamedTuple):
    """Texts of an act for the log, in the language of the panel.

    Attributes:
        done: once it is done: "Approved feedback".
        doing: until then, and if it is not done: "Approving feedback".
        removed: if it took away what was there, as a mark does: "Unmarked: assisted".
    """

    done: str
    doing: str
    removed: str = ""


def same(text: str) -> Wording:
    """Return the wording of an act whose text is the same before and after it is done."""
    return Wording(text, text)


class Act(NamedTuple):
    """An act, and the session's answer to it.

    Attributes:
        wording: its texts.
        topic, message: as sent.
        by: who did it, if it was somebody else.
        when: what a remark waits for.
        typed: text that the operator typed for it.
        answer: None until it comes.
        lost: why it may not come.
    """

    wording: Wording
    topic: str
    message: Any
    by: str = ""
    when: Wait = ""
    typed: str = ""
    answer: ActAnswered | None = None
    lost: str = ""

    @property
    def is_open(self) -> bool:
        """True while the session is expected to answer."""
        return bool(self.message.id) and self.answer is None and not self.lost

    @property
    def is_done(self) -> bool:
        """True if the session has answered so."""
        return self.answer is not None and self.answer.outcome == "done"

    def is_typed_for(self, topic: str, action: str) -> bool:
        """Return True if its text was typed for a topic, or for a decision on an action.

        A decision that came too late can still be said, if it has words.
        """
        if not self.typed:
            return False
        if topic == REMARK.name and self.topic == DECISION.name:
            is_late = self.answer is not None and self.answer.outcome == "late"
            return is_late and self.message.text is not None
        return self.topic == topic and getattr(self.message, "action", "") == action

    def line(self, tr: Language) -> Line:
        """Return its line of the log. Only what is done is marked as good."""
        at, answer, doing = self.message.at, self.answer, self._named(self.wording.doing)
        if answer is None:
            if not self.message.id:  # nobody awaits an answer
                return Line(at, self._named(self.wording.done))
            if self.lost:
                text = tr("{act}: not confirmed: {why}")
                return Line(at, text.format(act=doing, why=self.lost), "bad")
            return Line(at, tr(_UNDER_WAY[self.when]).format(act=doing))
        if answer.outcome == "done":
            is_removed = answer.why == "removed" and self.wording.removed
            done = self._named(self.wording.removed if is_removed else self.wording.done)
            if self.by:
                return Line(at, done, "good")
            ms = round(max(0, answer.at - at) / MS)
            return Line(at, tr("{act} · link {ms} ms").format(act=done, ms=ms), "good")
        why, is_late = in_line(answer.why, tr), answer.outcome == "late"
        if why:
            text = tr("{act}: too late, {why}" if is_late else "{act}: not done, {why}")
        else:
            text = tr("{act}: too late" if is_late else "{act}: not done")
        text = text.format(act=doing, why=why)
        if self.typed:
            text = tr("{outcome}; the text is kept").format(outcome=text)
        return Line(at, text, "bad")

    def _named(self, text: str) -> str:
        return cut(f"{self.by}: {text}" if self.by else text, _LONGEST)


class ActLog:
    """Acts, oldest first, and why others were not sent.

    Args:
        tr: language of the panel.

    Attributes:
        acts: of this operator, as sent.
        others: of other operators and of the therapist, as the session published them.
    """

    def __init__(self, tr: Language = ENGLISH) -> None:
        self._tr = tr
        self.acts: list[Act] = []
        self.others: list[Act] = []
        self._reports: list[Line] = []
        self._kinds: dict[str, str] = {}

    @property
    def lines(self) -> list[Line]:
        """All lines. A stop that is done has a line of its own (`session_state.Stop`)."""
        acts = [act for act in (*self.acts, *self.others) if not (act.is_done and _is_stop(act))]
        return [*(act.line(self._tr) for act in acts), *self._reports]

    def report(self, at: int, text: str) -> Line:
        """Log why something was not done; return its line."""
        line = Line(at, text, "bad")
        self._reports = [*self._reports, line][-MAX_LINES:]
        return line

    def add(
        self,
        wording: Wording,
        topic: Topic[Any],
        message: Message,
        when: Wait = "",
        typed: str = "",
    ) -> None:
        """Log an act that is sent."""
        act = Act(wording, topic.name, message, when=when, typed=typed)
        self.acts = [*self.acts, act][-MAX_LINES:]

    def last_open(self, which: Callable[[Any], bool]) -> Act | None:
        """Return this operator's last act that the session has not answered, and for whose message
        ``which`` is true.
        """
        found = (act for act in reversed(self.acts) if act.is_open and which(act.message))
        return next(found, None)

    def deciding(self, action: str) -> str:
        """Return the text of the decision on an action that is on its way; empty without one."""
        act = self.last_open(lambda act: isinstance(act, Decision) and act.action == action)
        return act.wording.doing if act else ""

    def unused_text(self, topic: Topic[Any], action: str = "") -> str:
        """Return the text typed last for a topic, or for a decision on an action, if that was not
        carried out; else empty.
        """
        typed = (act for act in reversed(self.acts) if act.is_typed_for(topic.name, action))
        last = next(typed, None)
        return last.typed if last and last.answer and not last.is_done else ""

    def lose_answers(self, why: str) -> None:
        """Note that answers may not come. If one comes later after all, it counts."""
        self.acts = [act._replace(lost=why) if act.is_open else act for act in self.acts]

    def rejoined(self) -> None:
        """Forget what the session will send again."""
        self.others = []

    def receive(self, frame: Frame, me: Welcome) -> None:
        """Note answers, and log the acts of others."""
        self._note_kind(frame.message)
        if isinstance(frame.message, ActAnswered):
            self.acts = [_answered(act, frame.message) for act in self.acts]
            self.others = [_answered(act, frame.message) for act in self.others]
        elif frame.topic in _ACTS:
            self._published(frame, me)

    def _published(self, frame: Frame, me: Welcome) -> None:
        """Log another's act; or one of this operator's from before this panel was opened."""
        message: Any = frame.message
        if message.id and any(act.message.id == message.id for act in self.acts):
            return
        kind = self._kinds.get(getattr(message, "action", ""), "proposal")
        if wording := _wording(message, me, kind, self._tr):
            is_mine = message.actor == me.name
            by = self._tr("you") if is_mine else actor_name(message.actor, me, self._tr)
            # the therapist's keys have no time stamp
            timed = replace(message, at=message.at or frame.at)
            # a note that is published is in the record
            answer = answer_to(message, frame.at) if frame.topic is NOTE_ADDED else None
            act = Act(wording, frame.topic.name, timed, by=by, answer=answer)
            self.others = [*self.others, act][-MAX_LINES:]

    def _note_kind(self, message: Message) -> None:
        """Note the kind of a proposal or an action, which a decision on it does not name."""
        if isinstance(message, PendingApproval):
            message = message.proposal
        if isinstance(message, Proposal | Action):
            self._kinds[message.id] = message.kind
            if len(self._kinds) > _MAX_KINDS:
                del self._kinds[next(iter(self._kinds))]


def _answered(act: Act, answer: ActAnswered) -> Act:
    return act._replace(answer=answer) if act.message.id == answer.id else act


def _is_stop(act: Act) -> bool:
    return isinstance(act.message, SessionCommand) and act.message.command == "stop"


def _wording(  # noqa: PLR0911
    message: Message, me: Welcome, kind: str, tr: Language
) -> Wording | None:
    """Return the wording of an act of somebody else; None for a pause, its end and a stop, which
    have lines of their own.

    Args:
        message: the act.
        me: this panel at the session.
        kind: of the action that it decides on.
        tr: language of the panel.
    """
    match message:
        case Decision():
            return decision_wording(message, kind, tr, tells_change=True)
        case Remark(text=""):
            return gesture_wording(message.gesture, tr)
        case Remark():
            to = me.participants[message.seat] if len(me.participants) > 1 else ""
            return said_wording(message.text, to, tr)
        case ModeChanged():
            return mode_wording(message, tr)
        case NoteAdded():
            return note_wording(message, tr)
        case SessionCommand(command="mark"):
            titles = {mark.name: mark.title for mark in me.marks}
            return mark_wording(titles.get(message.reason, message.reason), tr)
        case SessionCommand(command="level"):
            return same(tr("Level {level}", level=message.value))
        case SessionCommand() if _key(message) in _COMMANDS.keys() - _TOLD_AS_EVENTS:
            return command_wording(message, tr)
    return None


# --- the wording of acts; names and typed texts are put in by `format`: `tr` would change their
# numbers


def decision_wording(
    decision: Decision, kind: str, tr: Language, *, tells_change: bool = False
) -> Wording:
    """Return the wording of a decision on an action of a kind. ``tells_change``: with the new text
    or level.
    """
    kind = tr(kind)
    if decision.verdict == "accept":
        wording = Wording(tr("Approved {kind}"), tr("Approving {kind}"))
    elif decision.verdict == "veto":
        wording = Wording(tr("Vetoed {kind}"), tr("Vetoing {kind}"))
    elif decision.text is not None and tells_change:
        wording = Wording(tr("Edited {kind}: “{text}”"), tr("Editing {kind}: “{text}”"))
    elif decision.valence is not None:
        wording = same(tr(_FACES[decision.valence]))
    elif decision.level is not None and tells_change:
        wording = Wording(tr("Edited {kind}: level {level}"), tr("Editing {kind}: level {level}"))
    else:
        wording = Wording(tr("Edited {kind}"), tr("Editing {kind}"))
    return _filled(wording, kind=kind, text=decision.text, level=decision.level)


def cancelled_wording(kind: str, tr: Language) -> Wording:
    """Return the wording of a veto on an action of a kind that is under way or queued."""
    wording = Wording(tr("Cancelled {kind}"), tr("Cancelling {kind}"))
    return _filled(wording, kind=tr(kind))


def said_wording(text: str, to: str, tr: Language) -> Wording:
    """Return the wording of a remark. ``to``: the addressee, if there are several participants."""
    if to:
        wording = Wording(tr("Said to {who} “{text}”"), tr("Saying to {who} “{text}”"))
    else:
        wording = Wording(tr("Said “{text}”"), tr("Saying “{text}”"))
    return _filled(wording, who=to, text=text)


def gesture_wording(gesture: str, tr: Language) -> Wording:
    """Return the wording of a gesture, by its name in the theme."""
    return same(tr("Gesture: {gesture}").format(gesture=gesture.replace("_", " ")))


def mode_wording(changed: ModeChanged, tr: Language) -> Wording:
    """Return the wording of a change of mode."""
    return same(f"{capitalized(tr(changed.kind))}: {tr(changed.mode)}")


def note_wording(note: NoteAdded, tr: Language) -> Wording:
    """Return the wording of a note or an event mark."""
    if note.label:
        return same(tr("Event: {label}").format(label=note.label))
    return _filled(Wording(tr("Noted “{text}”"), tr("Noting “{text}”")), text=note.text)


def mark_wording(title: str, tr: Language) -> Wording:
    """Return the wording of a mark on a trial."""
    wording = Wording(tr("Marked: {mark}"), tr("Marking: {mark}"), tr("Unmarked: {mark}"))
    return _filled(wording, mark=in_line(title, tr))


def command_wording(act: SessionCommand, tr: Language) -> Wording:
    """Return the wording of a command, unless it is about a level or a mark."""
    done, doing = _COMMANDS[_key(act)]
    return Wording(tr(done), tr(doing))


def _key(act: SessionCommand) -> str:
    return f"skip {act.reason}".strip() if act.command == "skip" else act.command


def _filled(wording: Wording, **slots: object) -> Wording:
    return Wording(*(text.format(**slots) for text in wording))
