"""Log of acts: this operator's and those of others, each with the session's answer. Pure."""

from collections.abc import Callable
from typing import Any, NamedTuple

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
from sar_tui.operator.event_text import MAX_LINES, Line, in_brackets, short_name
from sar_tui.operator.text_charts import cut

_ACTS = (COMMAND, DECISION, REMARK, MODE, NOTE_ADDED)
_LONGEST = 36
"""Longest text of an act, in columns, so that there is room for its outcome."""
_MAX_KINDS = 500
_DOING = {
    "Approved": "Approving",
    "Cancelled": "Cancelling",
    "Edited": "Editing",
    "Ended": "Ending",
    "Marked": "Marking",
    "Noted": "Noting",
    "Paused": "Pausing",
    "Repeated": "Repeating",
    "Resumed": "Resuming",
    "Said": "Saying",
    "Skipped": "Skipping",
    "Stopped": "Stopping",
    "Took": "Taking",
    "Vetoed": "Vetoing",
}
_COMMANDS = {
    "skip": "Skipped the prompt",
    "repeat": "Repeated the prompt",
    "end": "Ended the session",
    "undo": "Took back the last act",
}


class Act(NamedTuple):
    """An act, and the session's answer to it.

    Attributes:
        text: for the log, once it is done: "Approved feedback".
        topic, message: as sent.
        by: who did it, if it was somebody else.
        when: what a remark waits for: "after the response".
        typed: text that the operator typed for it.
        answer: None until it comes.
        lost: why it may not come.
    """

    text: str
    topic: str
    message: Any
    by: str = ""
    when: str = ""
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

    def line(self) -> Line:
        """Return its line of the log. Only what is done is marked as good."""
        at, answer = self.message.at, self.answer
        if answer is None:
            if not self.message.id:  # nobody awaits an answer
                return Line(at, self._named(self.text))
            if self.lost:
                return Line(
                    at, f"{self._named(doing(self.text))}: not confirmed: {self.lost}", "bad"
                )
            when = f" {self.when}" if self.when else ""
            return Line(at, f"{self._named(doing(self.text))}{when} …")
        if answer.outcome == "done":
            is_removed = answer.why == "removed"
            text = self.text.replace("Marked", "Unmarked", 1) if is_removed else self.text
            link = "" if self.by else f" · link {max(0, answer.at - at) / MS:.0f} ms"
            return Line(at, f"{self._named(text)}{link}", "good")
        fate = "too late" if answer.outcome == "late" else "not done"
        parts = [f"{self._named(doing(self.text))}: {fate}", in_brackets(answer.why)]
        kept = "; the text is kept" if self.typed else ""
        return Line(at, f"{', '.join(filter(None, parts))}{kept}", "bad")

    def _named(self, text: str) -> str:
        return cut(f"{self.by}: {text}" if self.by else text, _LONGEST)


def doing(text: str) -> str:
    """Return the text of an act that is not done yet: "Approving feedback" for "Approved
    feedback".
    """
    first, _, rest = text.partition(" ")
    word = first.rstrip(":")
    return f"{_DOING.get(word, word)}{first[len(word) :]} {rest}".strip()


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
        """All lines. A stop that is done has a line of its own (`stop.Stop`)."""
        acts = [act for act in (*self.acts, *self.others) if not (act.is_done and _is_stop(act))]
        return [*(act.line() for act in acts), *self._reports]

    def report(self, at: int, text: str) -> Line:
        """Log why something was not done; return its line."""
        line = Line(at, text, "bad")
        self._reports = [*self._reports, line][-MAX_LINES:]
        return line

    def add(
        self, text: str, topic: Topic[Any], message: Message, when: str = "", typed: str = ""
    ) -> None:
        """Log an act that is sent."""
        act = Act(text, topic.name, message, when=when, typed=typed)
        self.acts = [*self.acts, act][-MAX_LINES:]

    def last_open(self, which: Callable[[Any], bool]) -> Act | None:
        """Return this operator's last act that the session has not answered, and for whose message
        ``which`` is true.
        """
        found = (act for act in reversed(self.acts) if act.is_open and which(act.message))
        return next(found, None)

    def deciding(self, action: str) -> str:
        """Return the decision on an action that is on its way; empty without one."""
        act = self.last_open(lambda act: isinstance(act, Decision) and act.action == action)
        return act.text if act else ""

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
        text = _text(message, me, self._kinds.get(getattr(message, "action", ""), "proposal"))
        if text:
            by = "you" if message.actor == me.name else short_name(message.actor)
            # the therapist's keys have no time stamp
            timed = replace(message, at=message.at or frame.at)
            # a note that is published is in the record
            answer = answer_to(message, frame.at) if frame.topic is NOTE_ADDED else None
            act = Act(text, frame.topic.name, timed, by=by, answer=answer)
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


def _text(message: Message, me: Welcome, kind: str) -> str:  # noqa: PLR0911
    """Return the text of an act of somebody else; empty for a pause, its end and a stop, which have
    lines of their own.

    Args:
        message: the act.
        me: this panel at the session.
        kind: of the action that it decides on.
    """
    match message:
        case Decision():
            return _decision(message, kind)
        case Remark():
            to = f" to {me.participants[message.seat]}" if len(me.participants) > 1 else ""
            return (
                f"Said{to} “{message.text}”"
                if message.text
                else f"Gesture: {message.gesture.replace('_', ' ')}"
            )
        case ModeChanged():
            return f"{message.kind.capitalize()}: {message.mode}"
        case NoteAdded():
            return f"Event: {message.label}" if message.label else f"Noted “{message.text}”"
        case SessionCommand(command="skip", reason="rest"):
            return "Ended the rest"
        case SessionCommand(command="skip", reason="step"):
            return "Skipped the question"
        case SessionCommand(command="level"):
            return f"Level {message.value}"
        case SessionCommand(command="mark"):
            titles = {mark.name: mark.title for mark in me.marks}
            return f"Marked: {titles.get(message.reason, message.reason).lower()}"
        case SessionCommand():
            return _COMMANDS.get(message.command, "")
    return ""


def _decision(decision: Decision, kind: str) -> str:
    if decision.verdict != "edit":
        return f"{'Approved' if decision.verdict == 'accept' else 'Vetoed'} {kind}"
    if decision.text is not None:
        return f"Edited {kind}: “{decision.text}”"
    if decision.valence is not None:
        return f"{decision.valence.capitalize()} face, same words: {kind}"
    return f"Edited {kind}" + (f": level {decision.level}" if decision.level is not None else "")
